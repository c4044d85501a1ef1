"""The particle models: number density, gradient and shear rate.

Letters as in :mod:`debrisflow.neighbors.stencil`.
"""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.wall_access import velocity_difference

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
# Below this the neighbors stand too nearly on a line or plane for a gradient across it.
LEAST_SPREAD = 4e-3


@kernel
def number_density_at(i, stencil):
    """Return ``n_i = sum of w`` and the length of ``sum of w r_ij / r``, 0 in an interior."""
    r_e = stencil.effective_radius
    n = 0.0
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        inverse = stencil.inverse[i, k]
        w = r_e * inverse - 1.0
        n += w
        x += w * stencil.dx[i, k] * inverse
        y += w * stencil.dy[i, k] * inverse
        z += w * stencil.dz[i, k] * inverse
    return n, np.sqrt(x * x + y * y + z * z)


@loop
def number_density(stencil, n, asymmetry):
    """Write number density and asymmetry of every particle with a row, (m,) float64 arrays."""
    for i in prange(n.size):
        n[i], asymmetry[i] = number_density_at(i, stencil)


@kernel
def gradient_at(i, values, with_walls, stencil):
    """Return the conservative gradient ``(Ds/n0) sum of (f_i + f_j) r_ij w / r^2``.

    Exact for a linear field on the full lattice, and its pair terms are equal and opposite, so a
    pressure force conserves momentum.  Dummy walls take the value of i, or are left out unless
    ``with_walls``.
    """
    r_e = stencil.effective_radius
    x, y, z = 0.0, 0.0, 0.0
    f_i = values[i]
    for k in range(stencil.unknown_count[i]):
        inverse = stencil.inverse[i, k]
        f = (f_i + values[stencil.neighbors[i, k]]) * (r_e * inverse - 1.0) * inverse * inverse
        x += f * stencil.dx[i, k]
        y += f * stencil.dy[i, k]
        z += f * stencil.dz[i, k]
    if with_walls:
        for k in range(stencil.unknown_count[i], stencil.neighbor_count[i]):
            inverse = stencil.inverse[i, k]
            f = 2.0 * f_i * (r_e * inverse - 1.0) * inverse * inverse
            x += f * stencil.dx[i, k]
            y += f * stencil.dy[i, k]
            z += f * stencil.dz[i, k]
    factor = stencil.dimension / stencil.number_density
    return factor * x, factor * y, factor * z


@kernel
def least_neighbor_value_at(i, values, stencil):
    """Return ``min over j with w != 0 of (f_i, f_j)``."""
    least = values[i]
    for k in range(stencil.unknown_count[i]):
        least = min(least, values[stencil.neighbors[i, k]])
    return least


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
def shear_rate_at(i, velocity, walls, stencil):
    """Return ``sqrt(2 D : D)`` with ``D`` the symmetric part of the velocity gradient, 1/s.

    The gradient is ``B M^-1``, ``B = sum of u_ij (x) r_ij w / r^2`` and
    ``M = sum of r_ij (x) r_ij w / r^2``: exact for a linear profile on any arrangement, up to a
    wall and to a free surface.  The usual ``M = n0 I / Ds`` holds on the lattice alone; in a layer
    whose rows pass each other it reads 1.5 % too little.  Neighbors on a line, or none, give 0.
    """
    r_e = stencil.effective_radius
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        du, dv, dw = velocity_difference(i, k, velocity, walls, stencil)
        dx, dy, dz = stencil.dx[i, k], stencil.dy[i, k], stencil.dz[i, k]
        inverse = stencil.inverse[i, k]
        f = (r_e * inverse - 1.0) * inverse * inverse
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    if stencil.dimension < 3.0:
        zz = 0.5 * (xx + yy)  # nothing varies along z
    found = solve_gradient(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz)
    return strain_rate(*found)


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
