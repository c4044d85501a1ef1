"""The particle models: number density, gradient, higher-order forms and velocity gradient.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import (
    BLOCK,
    fluid_pair,
    gradient_factor,
    weight,
)
from debrisflow.neighbors.wall_access import wall_density_at, wall_moments_at, wall_pair

LEAST_SPREAD = 4e-3
"""Below this the neighbors stand too nearly on a line or plane for a gradient across it."""


@kernel
def number_density_at(i, near, solid):
    """Return ``n_i = sum of w`` and the length of ``sum of w r_ij / r``, 0 in an interior."""
    n, x, y, z = 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        _, dx, dy, dz, inverse = fluid_pair(i, k, near)
        w = weight(inverse, near)
        n += w
        x, y, z = x + w * inverse * dx, y + w * inverse * dy, z + w * inverse * dz
    wall_n, wall_x, wall_y, wall_z = wall_density_at(i, near, solid)
    x, y, z = x + wall_x, y + wall_y, z + wall_z
    return n + wall_n, np.sqrt(x * x + y * y + z * z)


@kernel
def _number_density(first, last, near, solid, n):
    for i in range(first, last):
        n[i], _ = number_density_at(i, near, solid)


@loop
def number_density(near, solid, n):
    """Write the number density of the first particles, (m,) float64 array."""
    for block in prange((n.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n.size)
        _number_density(first, last, near, solid, n)


@kernel
def fluid_gradient_at(i, values, near):
    """Return the part of :func:`gradient_at` that is over the fluid."""
    x, y, z, f_i = 0.0, 0.0, 0.0, values[i]
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        f = (f_i + values[j]) * weight(inverse, near) * inverse * inverse
        x, y, z = x + f * dx, y + f * dy, z + f * dz
    factor = gradient_factor(near)
    return factor * x, factor * y, factor * z


@kernel
def gradient_at(i, values, with_walls, near, solid):
    """Return the conservative gradient ``(Ds/n0) sum of (f_i + f_j) r_ij w / r^2``.

    Exact for a linear field on the full lattice, and its pair terms are equal and opposite, so a
    pressure force conserves momentum.  It stands in the place of the study's equation (14),
    ``(Ds/n0) sum of (p_j - p_min) r_ij w / r^2``, with which still water does not hold.  Walls
    without a value of their own take that of i, or are left out unless ``with_walls``.

    Parameters
    ----------
    i : int
    values : (m,) float64 array
        Of fluid, supply, and the walls that have a row.
    with_walls : bool
    near : Near
    solid : Solid
    """
    x, y, z, f_i = 0.0, 0.0, 0.0, values[i]
    for k in range(near.pressed_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        f = (f_i + values[near.wall_from + j]) * weight(inverse, near) * inverse * inverse
        x, y, z = x + f * dx, y + f * dy, z + f * dz
    if with_walls:
        for k in range(near.pressed_count[i], near.wall_count[i]):
            _, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
            f = 2.0 * f_i * weight(inverse, near) * inverse * inverse
            x, y, z = x + f * dx, y + f * dy, z + f * dz
    factor = gradient_factor(near)
    fluid_x, fluid_y, fluid_z = fluid_gradient_at(i, values, near)
    return fluid_x + factor * x, fluid_y + factor * y, fluid_z + factor * z


@kernel
def least_neighbor_value_at(i, values, near, solid):
    """Return ``min over j with w != 0 of (f_i, f_j)``, p_min of equations (4) and (14)."""
    least = values[i]
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        least = min(least, values[j] if weight(inverse, near) > 0.0 else least)
    for k in range(near.pressed_count[i]):
        j, _, _, _, inverse = wall_pair(i, k, near, solid)
        least = min(least, values[near.wall_from + j] if weight(inverse, near) > 0.0 else least)
    return least


@kernel
def fluid_moments_at(i, velocity, near):
    """Return the moments of :func:`solve_gradient` over the fluid neighbors of particle i.

    ``M = sum of r_ij (x) r_ij w / r^2`` as (xx, xy, yy, xz, yz, zz), ``B = sum of u_ij (x) r_ij
    w / r^2`` by rows.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        f = weight(inverse, near) * inverse * inverse
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    return xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz


@kernel
def velocity_gradient_at(i, velocity, near, solid):
    """Return the velocity gradient by rows, 1/s, exact for a linear profile on any arrangement.

    ``B M^-1`` with the moments of :func:`fluid_moments_at` and those of the walls, up to a wall
    and to a free surface; of the way to a free-slip wall only what leads across it counts, since
    the fluid shears along it as it does inside.  The usual ``M = n0 I / Ds`` holds on the lattice
    alone; in a layer whose rows pass each other it reads 1.5 % too little.  Neighbors on a line, or
    none, give 0.
    """
    xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz = fluid_moments_at(i, velocity, near)
    walls = wall_moments_at(i, velocity, near, solid)
    xx, xy, yy = xx + walls[0], xy + walls[1], yy + walls[2]
    xz, yz, zz = xz + walls[3], yz + walls[4], zz + walls[5]
    ux, uy, uz = ux + walls[6], uy + walls[7], uz + walls[8]
    vx, vy, vz = vx + walls[9], vy + walls[10], vz + walls[11]
    wx, wy, wz = wx + walls[12], wy + walls[13], wz + walls[14]
    if near.dimension < 3.0:
        zz = 0.5 * (xx + yy)  # nothing varies along z
    return solve_gradient(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz)


@kernel
def _velocity_gradients(first, last, velocity, near, solid, gradient, rate):
    for i in range(first, last):
        found = velocity_gradient_at(i, velocity, near, solid)
        for k in range(9):
            gradient[i, k] = found[k]
        rate[i] = strain_rate(*found)


@loop
def velocity_gradients(velocity, near, solid, gradient, rate):
    """Write velocity gradient by rows, (n, 9) array, and shear rate, (n,) array, 1/s."""
    for block in prange((rate.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, rate.size)
        _velocity_gradients(first, last, velocity, near, solid, gradient, rate)


@kernel
def cofactors(xx, xy, yy, xz, yz, zz):
    """Return the cofactors of a symmetric matrix, in the order of its entries, and its determinant.

    The inverse is the cofactors over the determinant.

    Examples
    --------
    >>> cofactors(2.0, 1.0, 3.0, 0.0, 0.0, 1.0)
    (3.0, -1.0, 2.0, 0.0, 0.0, 5.0, 5.0)
    """
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xx * zz - xz * xz
    d, e, f = xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy
    return a, b, c, d, e, f, xx * a + xy * b + xz * d


@kernel
def spread(xx, yy, zz, determinant):
    """Return the determinant of a matrix of moments over the cube of a third of its trace.

    1 where the neighbors stand alike in all directions, 0 where they stand on a line.  In two
    dimensions pass ``(xx + yy) / 2`` as zz, of the matrix too.

    Examples
    --------
    >>> spread(2.0, 2.0, 2.0, 8.0), spread(2.0, 0.0, 1.0, 0.0)
    (1.0, 0.0)
    """
    third = (xx + yy + zz) / 3.0
    return determinant / third**3 if third > 0.0 else 0.0


@kernel
def solve_gradient(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz):
    """Return the velocity gradient ``B M^-1`` by rows, 1/s; 0 where neighbors stand on a line.

    ``M = (xx, xy, ...)`` are the moments of the separations and ``B = (ux, uy, ...)`` those of the
    velocity differences.

    Examples
    --------
    >>> found = solve_gradient(2.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 6.0, *(0.0,) * 7)
    >>> found[:3]
    (0.0, 3.0, 0.0)
    """
    a, b, c, d, e, f, determinant = cofactors(xx, xy, yy, xz, yz, zz)
    if spread(xx, yy, zz, determinant) <= LEAST_SPREAD:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    q = 1.0 / determinant
    return (
        q * (a * ux + b * uy + d * uz),
        q * (b * ux + c * uy + e * uz),
        q * (d * ux + e * uy + f * uz),
        q * (a * vx + b * vy + d * vz),
        q * (b * vx + c * vy + e * vz),
        q * (d * vx + e * vy + f * vz),
        q * (a * wx + b * wy + d * wz),
        q * (b * wx + c * wy + e * wz),
        q * (d * wx + e * wy + f * wz),
    )


@kernel
def strain_rate(ux, uy, uz, vx, vy, vz, wx, wy, wz):
    """Return ``sqrt(2 D : D)`` of a velocity gradient, 1/s.

    Examples
    --------
    >>> strain_rate(0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    3.0
    """
    stretch = 2.0 * (ux * ux + vy * vy + wz * wz)
    return np.sqrt(stretch + (uy + vx) ** 2 + (uz + wx) ** 2 + (vz + wy) ** 2)
