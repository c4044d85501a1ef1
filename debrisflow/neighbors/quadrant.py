"""Sums over a wall that fills a quadrant of the plane, by a table, and over boxes made of it.

The counterpart of :mod:`debrisflow.neighbors.octant` in two dimensions.  Lengths are in spacings.
At a corner the rows of :mod:`debrisflow.neighbors.half_plane` run along one face or the other: the
table holds the mean of both.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel
from debrisflow.neighbors.beyond import Beyond
from debrisflow.neighbors.half_plane import (
    across_beyond,
    flux_beyond,
    lean_beyond,
    number_density_beyond,
    push_beyond,
)
from debrisflow.neighbors.octant import step_below, turned

Floats = NDArray[np.float64]
STEPS = 128  # of the table along each axis, from -R to R
SUMS = 17
"""As in three dimensions, without m: N, nothing, G, and T as xx, yy, zz, xy, xz, yz; then V, the
sum of ``w r / r``, and H, that of ``R r / r^3``."""
N, GX, GY, TXX, TYY, TXY, VX, VY, HX, HY = 0, 2, 3, 5, 6, 8, 11, 12, 14, 15


class Quadrants(NamedTuple):
    """The table of one influence radius.

    Attributes
    ----------
    radius : float
        R, in spacings.
    sums : (STEPS + 1, STEPS + 1, SUMS) float64 array
        Of the quadrants ``x_k > -R + 2 R s_k / STEPS``.
    """

    radius: float
    sums: Floats


@lru_cache(maxsize=4)
def quadrants(radius: float) -> Quadrants:
    """Return the table of an influence radius, in spacings.

    Where the particle is beside a face of the quadrant, q < 0, it is the half plane less the
    quadrant on the other side, mirrored.
    """
    half = STEPS // 2
    q = np.linspace(0.0, radius, half + 1)
    one = _rows_along_y(q, radius)
    corner = 0.5 * (one + _swapped(one))
    sums = np.zeros((STEPS + 1, STEPS + 1, SUMS))
    sums[half:, half:] = corner
    planes = np.array([_half_plane(distance, radius) for distance in q])
    flat = _swapped(planes)  # with y > q instead of x > q
    sums[:half, half:] = (flat[None] - _mirrored(corner, 0))[:0:-1]
    sums[half:, :half] = (planes[:, None] - _mirrored(corner, 1))[:, :0:-1]
    whole = planes[0] + _mirrored(planes[0], 0)
    behind = whole - _mirrored(planes, 0)
    rest = behind[:, None] - _mirrored(flat[None] - _mirrored(corner, 0), 1)
    sums[:half, :half] = rest[:0:-1, :0:-1]
    return Quadrants(radius, sums)


def _half_plane(q: float, radius: float) -> Floats:
    total = np.zeros(SUMS)
    half_plane_sums(q, 0, radius, total)
    return total


def _rows_along_y(q: Floats, radius: float) -> Floats:
    """Return the sums of the rows ``x = q_1 + 1/2, ...`` from ``y = q_2`` on."""
    found = np.zeros((q.size, q.size, SUMS))
    with np.errstate(divide="ignore", invalid="ignore"):
        for below in np.arange(0.5, radius, 1.0):
            h = np.minimum(q[:, None] + below, radius)
            last = np.sqrt(radius * radius - h * h)
            first = np.minimum(q[None, :], last)
            found += _along_row(last, h, radius) - _along_row(first, h, radius)
    return found


def _along_row(y: Floats, h: Floats, radius: float) -> Floats:
    """Return the integrals of the sums along a row at x = h, up to constants."""
    h, y = np.broadcast_arrays(h, y)
    r, angle, stretch = np.hypot(y, h), np.arctan2(y, h), np.arcsinh(y / h)
    found = np.zeros((*h.shape, SUMS))
    found[..., N] = radius * stretch - y
    found[..., VX], found[..., VY] = radius * angle - h * stretch, radius * np.log(r) - r
    found[..., HX], found[..., HY] = radius * y / (h * r), -radius / r
    found[..., GX], found[..., GY] = found[..., HX] - angle, -radius / r - np.log(r)
    found[..., TXX], found[..., TXY] = h * found[..., GX], h * found[..., GY]
    found[..., TYY] = found[..., N] - found[..., TXX]
    return found


def _swapped(sums: Floats) -> Floats:
    """Return sums with x and y exchanged; a table with its axes exchanged, too."""
    order = np.arange(SUMS)
    for x, y in ((GX, GY), (TXX, TYY), (VX, VY), (HX, HY)):
        order[x], order[y] = y, x
    exchanged: Floats = sums[..., order]
    return exchanged.transpose(1, 0, 2) if exchanged.ndim == 3 else exchanged


def _mirrored(sums: Floats, axis: int) -> Floats:
    """Return sums of what is mirrored along an axis."""
    mirrored = sums.copy()
    for vector in (GX, VX, HX):
        mirrored[..., vector + axis] *= -1.0
    mirrored[..., TXY] *= -1.0
    return mirrored


@kernel
def half_plane_sums(q, axis, radius, total):
    """Write the sums of the half plane beyond q along an axis."""
    n, across = number_density_beyond(q, radius), across_beyond(q, radius)
    for s in range(SUMS):
        total[s] = 0.0
    total[N] = n
    total[GX + axis] = push_beyond(q, radius)
    total[TXX + axis] = across
    total[TYY - axis] = n - across
    total[VX + axis] = lean_beyond(q, radius)
    total[HX + axis] = flux_beyond(q, radius)


@kernel
def beyond_of(table):
    """Return what lies beyond a face that has no end in reach."""
    return Beyond(table.radius, 2.0)


@kernel
def add_quadrant(qx, qy, sign, total, table):
    """Add the sums of a quadrant, times a sign, to ``total``, (SUMS,) float64 array."""
    i, x = step_below(qx, table.radius, STEPS)
    j, y = step_below(qy, table.radius, STEPS)
    for di in range(2):
        wx = sign * (x if di else 1.0 - x)
        for dj in range(2):
            weight = wx * (y if dj else 1.0 - y)
            if weight == 0.0:  # at the end of the reach, or beyond it
                continue
            for s in range(SUMS):
                total[s] += weight * table.sums[i + di, j + dj, s]


@kernel
def box_sums(lower, upper, total, table):
    """Write the sums of a box about a particle at the origin; return whether it is a half plane.

    See :func:`debrisflow.neighbors.octant.box_sums`; along z the box has no ends.
    """
    radius, faces, face, nearest = table.radius, 0, 0, -np.inf
    for s in range(SUMS):
        total[s] = 0.0
    for k in range(2):
        near, far, _ = turned(lower[k], upper[k])
        if near >= radius:
            return False
        if near > -radius or far < radius:
            faces, face, nearest = faces + 1 + int(far < radius), k, near
    x_near, x_far, x_side = turned(lower[0], upper[0])
    y_near, y_far, y_side = turned(lower[1], upper[1])
    if faces == 1:
        half_plane_sums(nearest, face, radius, total)
    else:
        for a in range(2):
            for b in range(2):
                qx, qy = x_far if a else x_near, y_far if b else y_near
                if max(qx, qy) < radius:
                    add_quadrant(qx, qy, 1.0 - 2.0 * ((a + b) % 2), total, table)
    for vector in (GX, VX, HX):
        total[vector] *= x_side
        total[vector + 1] *= y_side
    total[TXY] *= x_side * y_side
    return faces == 1
