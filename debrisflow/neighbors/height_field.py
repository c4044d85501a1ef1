"""Ground whose level is known over a plan: a smooth surface, and what a particle feels of it.

The level is a quadratic B-spline through the values of a grid, with a continuous slope, and a
curvature that is constant in each cell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.beyond import seen_distance
from debrisflow.neighbors.boundary import beyond_of, insert_face
from debrisflow.neighbors.half_space import (
    across_beyond,
    lever_beyond,
    number_density_beyond,
    push_beyond,
    smooth_density_beyond,
    smooth_lever_beyond,
)
from debrisflow.neighbors.pairs import BLOCK

Floats = NDArray[np.float64]
PROJECTIONS = 4
"""Steps from a place to its foot on the surface.  Each leaves the share of the distance in the
radius of curvature: at half of it the distance is right to 0.1 %, the normal to 0.05."""
SHARPEST = 0.2
"""Mean curvature, over one spacing, beyond which it is not followed."""


class HeightField(NamedTuple):
    """The level of a ground.

    Attributes
    ----------
    lower : (2,) float64 array, m
        Corner of the grid.
    width : float, m
        Of a cell, along x and y.
    coefficients : (n, m) float64 array, m
        Of the spline, one a cell.
    zone_width : float, m
        Of a cell of the zones, which begin at the same corner.
    number : (k, l) int64 array
        Of the wall that the ground is, in each cell of the zones; those at the borders go on
        beyond.
    """

    lower: Floats
    width: float
    coefficients: Floats
    zone_width: float
    number: NDArray[np.int64]


def height_field(
    levels: Floats, width: float, lower: tuple[float, float], number: int
) -> HeightField:
    """Return the ground through the levels in the middles of cells; it is mirrored at its ends.

    It is one wall everywhere.

    Parameters
    ----------
    levels : (n, m) float64 array, m
        Along x and y.
    width : float, m
    lower : (float, float), m
        Corner of the first cell.
    number : int
    """
    from scipy.ndimage import spline_filter

    coefficients = spline_filter(np.asarray(levels, dtype=float), order=2, mode="mirror")
    everywhere = np.full((1, 1), number)
    return HeightField(
        np.array(lower), float(width), np.ascontiguousarray(coefficients), np.inf, everywhere
    )


@kernel
def _basis(t):
    """Return the three quadratic B-splines around a place, t cells from the middle of a cell."""
    return 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2


@kernel
def _mirrored(k, count):
    """Return the cell whose value stands for cell k, which may lie beyond the grid."""
    k = abs(k)
    k = min(k, 2 * (count - 1) - k)
    return min(max(k, 0), count - 1)


@kernel
def ground_at(x, y, field):
    """Return level, m, slope along x and y, and the second derivatives xx, xy, yy, 1/m."""
    a = (x - field.lower[0]) / field.width - 0.5
    b = (y - field.lower[1]) / field.width - 0.5
    i, j = int(np.floor(a + 0.5)), int(np.floor(b + 0.5))
    s, t = a - i, b - j
    rows, columns = field.coefficients.shape
    p, q = _basis(s), _basis(t)
    dp, dq = (s - 0.5, -2.0 * s, s + 0.5), (t - 0.5, -2.0 * t, t + 0.5)
    ddp = (1.0, -2.0, 1.0)
    z, zx, zy, zxx, zxy, zyy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        row = _mirrored(i + k - 1, rows)
        for m in range(3):
            c = field.coefficients[row, _mirrored(j + m - 1, columns)]
            z += c * p[k] * q[m]
            zx += c * dp[k] * q[m]
            zy += c * p[k] * dq[m]
            zxx += c * ddp[k] * q[m]
            zxy += c * dp[k] * dq[m]
            zyy += c * p[k] * ddp[m]
    w = 1.0 / field.width
    return z, zx * w, zy * w, zxx * w * w, zxy * w * w, zyy * w * w


@kernel
def number_under(x, y, field):
    """Return the number of the wall that the ground is at a place, m."""
    columns, rows = field.number.shape
    i = min(max((x - field.lower[0]) / field.zone_width, 0.0), columns - 1.0)
    j = min(max((y - field.lower[1]) / field.zone_width, 0.0), rows - 1.0)
    return field.number[int(i), int(j)]


@kernel
def foot_on(x, y, z, field):
    """Return distance to the ground, m, negative in it, its normal and mean curvature, 1/m.

    The curvature is positive in a valley.  The foot is found by going to the plane of the surface
    under the last foot, again and again.
    """
    a, b, distance, nx, ny, nz = x, y, 0.0, 0.0, 0.0, 1.0
    xx, xy, yy, zx, zy, size = 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
    for _ in range(PROJECTIONS):
        level, zx, zy, xx, xy, yy = ground_at(a, b, field)
        size = np.sqrt(1.0 + zx * zx + zy * zy)
        nx, ny, nz = -zx / size, -zy / size, 1.0 / size
        distance = (x - a) * nx + (y - b) * ny + (z - level) * nz
        a, b = x - distance * nx, y - distance * ny
    bent = (1.0 + zy * zy) * xx - 2.0 * zx * zy * xy + (1.0 + zx * zx) * yy
    return distance, nx, ny, nz, 0.5 * bent / (size * size * size)


@kernel
def add_ground_at(i, position, field, spacing, boundary):
    """Add what particle i, which has a row, feels of the ground.

    That of the half space under its foot, and to first order in the curvature kappa, > 0 in a
    valley, what lies between that plane and the surface: ``N += kappa H``, ``M += kappa H_M``,
    ``G *= 1 + kappa q``, and T along the surface ``+= kappa H / 2``, H and H_M being the integrals
    of ``w r_n`` and of ``(1 - r/R)^2 r_n`` over the half space.
    """
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    distance, nx, ny, nz, curvature = foot_on(x, y, z, field)
    radius = boundary.radius
    if distance >= radius * spacing:
        return
    row, total = boundary.row[i], boundary.sums[boundary.row[i]]
    q = seen_distance(distance / spacing, beyond_of(boundary))
    bent = min(max(curvature * spacing, -SHARPEST), SHARPEST)
    more = bent * lever_beyond(abs(q), radius)
    n, across = number_density_beyond(q, radius), across_beyond(q, radius)
    along = 0.5 * (n - across + more)
    push = push_beyond(q, radius) * (1.0 + bent * max(q, 0.0)) / spacing
    total[0] += n + more
    total[1] += smooth_density_beyond(q, radius) + bent * smooth_lever_beyond(abs(q), radius)
    total[2] -= push * nx
    total[3] -= push * ny
    total[4] -= push * nz
    rest = across - along
    total[5] += along + rest * nx * nx
    total[6] += along + rest * ny * ny
    total[7] += along + rest * nz * nz
    total[8] += rest * nx * ny
    total[9] += rest * nx * nz
    total[10] += rest * ny * nz
    insert_face(row, distance, (nx, ny, nz), number_under(x, y, field), push, False, boundary)


@kernel
def _add_ground(first, last, position, field, spacing, boundary):
    for i in range(first, last):
        if boundary.row[i] >= 0:
            add_ground_at(i, position, field, spacing, boundary)


@loop
def add_ground(position, field, spacing, boundary):
    """Add to sums and faces of all particles that have a row what they feel of a ground.

    Parameters
    ----------
    position : (n, 3) float64 array, m
    field : HeightField
    spacing : float, m
    boundary : Boundary
        Changed.
    """
    n = boundary.row.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _add_ground(first, last, position, field, spacing, boundary)


@kernel
def _find_near_ground(first, last, position, field, reach, near):
    for i in range(first, last):
        distance, _, _, _, _ = foot_on(position[i, 0], position[i, 1], position[i, 2], field)
        near[i] |= distance < reach


@loop
def find_near_ground(position, field, reach, near):
    """Add the particles that are nearer than ``reach``, m, to a ground to those near a wall."""
    for block in prange((near.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, near.size)
        _find_near_ground(first, last, position, field, reach, near)


@kernel
def _levels(first, last, x, y, field, level):
    for i in range(first, last):
        level[i] = ground_at(x[i], y[i], field)[0]


@loop
def levels_at(x, y, field, level):
    """Write the level of the ground, m, at places x, y, (n,) float64 arrays, m."""
    for block in prange((level.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, level.size)
        _levels(first, last, x, y, field, level)
