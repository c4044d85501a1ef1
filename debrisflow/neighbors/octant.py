"""Sums over a wall that fills an octant of space, by a table, and over boxes, which are made of it.

Lengths are in spacings.  The table holds integrals over ``y_k > q_k`` about a particle at the
origin; a box is a signed sum of at most eight octants.  Where only one face of a box is in reach it
is a half space, whose sums have a closed form.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel
from debrisflow.dispatch import by_record
from debrisflow.neighbors.beyond import Beyond
from debrisflow.neighbors.half_space import (
    across_beyond,
    number_density_beyond,
    push_beyond,
    smooth_density_beyond,
)

Floats = NDArray[np.float64]
STEPS = 48  # of the table along each axis, from -R to R
HALVES = 2  # cells of the quadrature in a step
SUMS = 11
"""N, M, the vector G, and T as xx, yy, zz, xy, xz, yz."""


class Octants(NamedTuple):
    """The table of one influence radius.

    Attributes
    ----------
    radius : float
        R, in spacings.
    sums : (STEPS + 1, STEPS + 1, STEPS + 1, SUMS) float32 array
        Of the octants ``y_k > -R + 2 R s_k / STEPS``.
    """

    radius: float
    sums: NDArray[np.float32]


@lru_cache(maxsize=4)
def octants(radius: float) -> Octants:
    """Return the table of an influence radius, in spacings.

    By the midpoint rule on cells of 1/96 of the reach, summed from the far corner along one axis
    after the other.
    """
    cells = STEPS * HALVES
    middle = (np.arange(cells) + 0.5) * (2.0 * radius / cells) - radius
    x, y, z = np.meshgrid(middle, middle, middle, indexing="ij")
    r = np.sqrt(x * x + y * y + z * z)
    w = np.maximum(radius / r - 1.0, 0.0)
    smooth = np.where(w > 0.0, (1.0 - r / radius) ** 2, 0.0)
    f = w / (r * r)
    integrands = [w, smooth, f * x, f * y, f * z]
    integrands += [f * x * x, f * y * y, f * z * z, f * x * y, f * x * z, f * y * z]
    sums = np.zeros((STEPS + 1, STEPS + 1, STEPS + 1, SUMS), dtype=np.float32)
    volume = (2.0 * radius / cells) ** 3
    for k, integrand in enumerate(integrands):
        total = integrand
        for axis in range(3):
            total = np.flip(np.cumsum(np.flip(total, axis), axis=axis), axis)
        sums[:-1, :-1, :-1, k] = volume * total[::HALVES, ::HALVES, ::HALVES]
    return Octants(radius, sums)


@by_record
def beyond_of(table):
    """Return what lies beyond a face that has no end in reach."""
    return Beyond(table.radius, 3.0)


@kernel
def step_below(q, radius, steps):
    """Return the step of a table below q, not the last one, and the share of the way to the next.

    The table has a number of steps from -R to R.  Beyond the reach it is that at its end.
    """
    at = (min(max(q, -radius), radius) + radius) * steps / (2.0 * radius)
    below = min(int(at), steps - 1)
    return below, at - below


@kernel
def add_octant(qx, qy, qz, sign, total, table):
    """Add the sums of an octant, times a sign, to ``total``, (SUMS,) float64 array."""
    i, x = step_below(qx, table.radius, STEPS)
    j, y = step_below(qy, table.radius, STEPS)
    k, z = step_below(qz, table.radius, STEPS)
    for di in range(2):
        wx = sign * (x if di else 1.0 - x)
        for dj in range(2):
            wxy = wx * (y if dj else 1.0 - y)
            for dk in range(2):
                weight = wxy * (z if dk else 1.0 - z)
                if weight == 0.0:  # at the end of the reach, or beyond it
                    continue
                for s in range(SUMS):
                    total[s] += weight * table.sums[i + di, j + dj, k + dk, s]


@kernel
def half_space_sums(q, axis, radius, total):
    """Write the sums of the half space beyond q along an axis."""
    n, across = number_density_beyond(q, radius), across_beyond(q, radius)
    for s in range(SUMS):
        total[s] = 0.0
    total[0] = n
    total[1] = smooth_density_beyond(q, radius)
    total[2 + axis] = push_beyond(q, radius)
    for other in range(3):
        total[5 + other] = 0.5 * (n - across)
    total[5 + axis] = across


@kernel
def turned(lower, upper):
    """Return near and far end of a box along an axis, as seen from the side of it, and that side.

    The side is -1 where the box lies to the negative.
    """
    if upper < -lower:
        return -upper, -lower, -1.0
    return lower, upper, 1.0


@by_record
def box_sums(lower, upper, total, table):
    """Write the sums of a box about a particle at the origin; return whether it is a half space.

    Parameters
    ----------
    lower, upper : (3,) float64 array
        Its ends along the axes, in spacings; infinite where it has none.
    total : (SUMS,) float64 array
        Written; 0 where the box is out of reach.
    table : Octants or Quadrants
    """
    radius, faces, face, nearest = table.radius, 0, 0, -np.inf
    for s in range(SUMS):
        total[s] = 0.0
    for k in range(3):
        near, far, _ = turned(lower[k], upper[k])
        if near >= radius:
            return False
        if near > -radius or far < radius:
            faces, face, nearest = faces + 1 + int(far < radius), k, near
    x_near, x_far, x_side = turned(lower[0], upper[0])
    y_near, y_far, y_side = turned(lower[1], upper[1])
    z_near, z_far, z_side = turned(lower[2], upper[2])
    if faces == 1:
        half_space_sums(nearest, face, radius, total)
    else:
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    qx = x_far if a else x_near
                    qy = y_far if b else y_near
                    qz = z_far if c else z_near
                    if max(qx, qy, qz) < radius:
                        add_octant(qx, qy, qz, 1.0 - 2.0 * ((a + b + c) % 2), total, table)
    total[2] *= x_side
    total[3] *= y_side
    total[4] *= z_side
    total[8] *= x_side * y_side
    total[9] *= x_side * z_side
    total[10] *= y_side * z_side
    return faces == 1
