"""Sums over rows of wall of any direction, in closed form, in two dimensions.

The rows of :mod:`debrisflow.neighbors.half_plane`, of finite length: those that fill a polygon.
Lengths are in spacings; the order of the sums is that of :mod:`debrisflow.neighbors.quadrant`.
"""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel
from debrisflow.neighbors.half_plane import NEAREST
from debrisflow.neighbors.quadrant import GX, GY, HX, HY, TXX, TXY, TYY, VX, VY, N

IN_LINE = 1e-3
"""Distance from the line of a row, in spacings, below which rounding spoils the sums beyond its
end."""


@kernel
def along_row(y, h, radius):
    """Return N, V, G and H, each along x and y, of a row at x = h up to y, up to constants.

    With r = sqrt(h^2 + y^2), ``a = atan(y / h)`` and ``s = asinh(y / h)``

        N = R s - y,  V = (R a - h s, R ln r - r),
        H = (R y / (h r), -R / r),  G = (H_x - a, -R / r - ln r)
    """
    r = np.sqrt(h * h + y * y)
    angle, stretch, logarithm = np.arctan(y / h), np.arcsinh(y / h), np.log(r)
    hx, hy = radius * y / (h * r), -radius / r
    return (
        radius * stretch - y,
        radius * angle - h * stretch,
        radius * logarithm - r,
        hx - angle,
        hy - logarithm,
        hx,
        hy,
    )


@kernel
def add_row(ax, ay, bx, by, nx, ny, radius, total):
    """Add the sums of a row from a to b, seen from the origin, with the normal n of its surface.

    A place nearer to the row than :data:`debrisflow.neighbors.half_plane.NEAREST` counts as that
    far from it; one in its line, beyond its end, as a little beside that.
    """
    side = -1.0 if ax * nx + ay * ny > 0.0 else 1.0
    ix, iy = -side * nx, -side * ny  # to the row
    tx, ty = -iy, ix
    h = ax * ix + ay * iy
    if h >= radius:
        return
    first, last = ax * tx + ay * ty, bx * tx + by * ty
    if first > last:
        first, last = last, first
    beyond = max(first, -last, 0.0)
    h = max(h, np.sqrt(max(NEAREST * NEAREST - beyond * beyond, IN_LINE * IN_LINE)))
    half = np.sqrt(radius * radius - h * h)
    first, last = max(first, -half), min(last, half)
    if first >= last:
        return
    n, vx, vy, gx, gy, hx, hy = along_row(last, h, radius)
    n0, vx0, vy0, gx0, gy0, hx0, hy0 = along_row(first, h, radius)
    n, vx, vy, gx, gy, hx, hy = n - n0, vx - vx0, vy - vy0, gx - gx0, gy - gy0, hx - hx0, hy - hy0
    across, mixed = h * gx, h * gy
    along = n - across
    total[N] += n
    total[GX] += gx * ix + gy * tx
    total[GY] += gx * iy + gy * ty
    total[TXX] += across * ix * ix + 2.0 * mixed * ix * tx + along * tx * tx
    total[TYY] += across * iy * iy + 2.0 * mixed * iy * ty + along * ty * ty
    total[TXY] += across * ix * iy + mixed * (ix * ty + iy * tx) + along * tx * ty
    total[VX] += vx * ix + vy * tx
    total[VY] += vx * iy + vy * ty
    total[HX] += hx * ix + hy * tx
    total[HY] += hx * iy + hy * ty


@kernel
def add_rows(x, y, listed, count, elements, radius, spacing, total):
    """Add the sums over the listed rows within reach of a place.

    Parameters
    ----------
    x, y : float, m
    listed : (capacity,) int32 array
        Elements near the place, of which the first ``count`` count; those are rows that are no
        faces.
    elements : Elements
    radius : float
        R, in spacings.
    spacing : float, m
    total : (17,) float64 array
        In spacings; changed.
    """
    for k in range(count):
        e = listed[k]
        if not elements.is_face[e]:
            c = elements.corners[e]
            add_row(
                (c[0, 0] - x) / spacing,
                (c[0, 1] - y) / spacing,
                (c[1, 0] - x) / spacing,
                (c[1, 1] - y) / spacing,
                elements.normal[e, 0],
                elements.normal[e, 1],
                radius,
                total,
            )
