"""The particle models: number density, gradient, divergence and Laplacian.

Inside kernels stand the paper's letters: ``d0`` particle spacing, ``r_e`` effective radius,
``w = r_e / r - 1`` weight, ``n`` and ``n0`` particle number density and its reference, ``lambda_``
Laplacian coefficient, ``dx, dy, dz`` the components of ``r_ij = r_j - r_i``.  Every ``..._at``
function computes the row of one particle and writes nothing else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors import separation

Floats = NDArray[np.float64]


class Stencil(NamedTuple):
    """Where the particles are, who is near whom, and the lattice constants.

    Attributes
    ----------
    position : (n, 3) float64 array, m
    index : (m, capacity) int32 array
        Neighbors of the first m particles.
    count : (m,) int32 array
        Number of neighbors in each row.
    period : (3,) float64 array, m
        Period along each axis; 0 where there is none.
    dimension : float
        Ds.
    spacing, effective_radius : float, m
        d0 and r_e.
    number_density : float
        n0.
    laplacian_lambda : float, m^2
        lambda.
    """

    position: Floats
    index: NDArray[np.int32]
    count: NDArray[np.int32]
    period: Floats
    dimension: float
    spacing: float
    effective_radius: float
    number_density: float
    laplacian_lambda: float


class WallSurface(NamedTuple):
    """What viscous terms need to know of walls; rows of other particles hold zeros.

    Attributes
    ----------
    normal : (n, 3) float64 array
        Unit normal out of the wall.
    depth : (n,) float64 array, m
        Distance of the wall particle to the surface.
    slip : (n,) float64 array
        1 where the wall is free-slip, 0 where it is no-slip.
    roughness : (n,) float64 array, m
        Equivalent sand roughness; 0 where the law of the wall does not act.
    """

    normal: Floats
    depth: Floats
    slip: Floats
    roughness: Floats


@kernel
def neighbor(i, k, stencil):
    """Return number, separation and distance of the k-th listed neighbor of particle i."""
    j = stencil.index[i, k]
    dx, dy, dz = separation(stencil.position, i, j, stencil.period)
    return j, dx, dy, dz, np.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def velocity_difference(i, j, dx, dy, dz, velocity, walls, d0):
    """Return ``u_j - u_i``, where a wall particle has the velocity that keeps its surface still.

    A wall particle at depth ``s`` under its surface takes the velocity on the line through
    ``u_i`` at the height ``h`` of particle i and the wall's velocity at the surface, so that

        u_j - u_i = -(1 + s / h) (u_i - u_wall)

    which makes a linear profile exact; along a free-slip wall the tangential part is 0.  ``h`` is
    not taken below d0/2, its value on the lattice.

    References
    ----------
    Morris, Fox & Zhu 1997, doi:10.1006/jcph.1997.5776.
    """
    du = velocity[j, 0] - velocity[i, 0]
    dv = velocity[j, 1] - velocity[i, 1]
    dw = velocity[j, 2] - velocity[i, 2]
    s = walls.depth[j]
    if s > 0.0:
        nx, ny, nz = walls.normal[j, 0], walls.normal[j, 1], walls.normal[j, 2]
        h = max(-(dx * nx + dy * ny + dz * nz) - s, 0.5 * d0)
        factor = 1.0 + s / h
        normal = du * nx + dv * ny + dw * nz
        stick = 1.0 - walls.slip[j]
        du = factor * (normal * nx + stick * (du - normal * nx))
        dv = factor * (normal * ny + stick * (dv - normal * ny))
        dw = factor * (normal * nz + stick * (dw - normal * nz))
    return du, dv, dw


@kernel
def number_density_at(i, stencil):
    """Return ``n_i = sum of w`` and the length of ``sum of w r_ij / r``, which an interior lacks."""
    r_e = stencil.effective_radius
    n = 0.0
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.count[i]):
        _, dx, dy, dz, r = neighbor(i, k, stencil)
        if r < r_e:
            w = r_e / r - 1.0
            n += w
            x += w * dx / r
            y += w * dy / r
            z += w * dz / r
    return n, np.sqrt(x * x + y * y + z * z)


@loop
def number_density(stencil, n, asymmetry):
    """Write number density and asymmetry of every listed particle, (m,) float64 arrays."""
    for i in prange(n.size):
        n[i], asymmetry[i] = number_density_at(i, stencil)


@kernel
def gradient_at(i, values, mirrored_from, reach, stencil):
    """Return the conservative gradient ``(Ds/n0) sum of (f_i + f_j) r_ij w / r^2``.

    Exact for a linear field on the full lattice, and its pair terms are equal and opposite, so a
    pressure force conserves momentum.  Neighbors from ``mirrored_from`` on take the value of i;
    those from ``reach`` on are left out.
    """
    r_e = stencil.effective_radius
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.count[i]):
        j, dx, dy, dz, r = neighbor(i, k, stencil)
        if r < r_e and j < reach:
            f = values[i] + (values[j] if j < mirrored_from else values[i])
            f *= (r_e / r - 1.0) / (r * r)
            x += f * dx
            y += f * dy
            z += f * dz
    factor = stencil.dimension / stencil.number_density
    return factor * x, factor * y, factor * z


@kernel
def least_neighbor_value_at(i, values, reach, stencil):
    """Return ``min over j with w != 0 of (f_i, f_j)``."""
    least = values[i]
    for k in range(stencil.count[i]):
        j, _, _, _, r = neighbor(i, k, stencil)
        if r < stencil.effective_radius and j < reach:
            least = min(least, values[j])
    return least


@kernel
def divergence_at(i, velocity, stencil):
    """Return ``(1/n0) sum of (r_e / r^3) r_ij . u_ij``, the HS form of -(1/n0) Dn/Dt.

    On a lattice of r it gives 2.4755 (r_e 3.1) or 2.8349 (r_e 2.1) in two dimensions instead of 2,
    as does the HL Laplacian by the same factor, 1.5 times larger.

    References
    ----------
    Khayyer & Gotoh 2009, doi:10.1016/j.coastaleng.2008.10.004.
    """
    r_e = stencil.effective_radius
    total = 0.0
    for k in range(stencil.count[i]):
        j, dx, dy, dz, r = neighbor(i, k, stencil)
        if r < r_e:
            du = velocity[j, 0] - velocity[i, 0]
            dv = velocity[j, 1] - velocity[i, 1]
            dw = velocity[j, 2] - velocity[i, 2]
            total += r_e / (r * r * r) * (dx * du + dy * dv + dz * dw)
    return total / stencil.number_density


@kernel
def laplacian_at(i, values, stencil):
    """Return ``(2 Ds / (lambda n0)) sum of (f_j - f_i) w``, exact for r^2 on the lattice."""
    r_e = stencil.effective_radius
    total = 0.0
    for k in range(stencil.count[i]):
        j, _, _, _, r = neighbor(i, k, stencil)
        if r < r_e:
            total += (values[j] - values[i]) * (r_e / r - 1.0)
    return 2.0 * stencil.dimension / (stencil.laplacian_lambda * stencil.number_density) * total


@kernel
def higher_order_laplacian_at(i, values, stencil):
    """Return the HL Laplacian ``(1/n0) sum of (5 - Ds) (f_j - f_i) r_e / r^3``.

    3 in two dimensions, 2 in three; of r^2 on the lattice it gives 7.4265 (2D, r_e 3.1), 8.5048
    (2D, 2.1), 6.910 (3D, 2.4) and 6.439 (3D, 2.1): use it where only its ratio to
    :func:`divergence_at` counts, that is in the pressure equation.

    References
    ----------
    Khayyer & Gotoh 2010, doi:10.1016/j.apor.2010.01.001.
    """
    r_e = stencil.effective_radius
    total = 0.0
    for k in range(stencil.count[i]):
        j, _, _, _, r = neighbor(i, k, stencil)
        if r < r_e:
            total += (values[j] - values[i]) * r_e / (r * r * r)
    return (5.0 - stencil.dimension) * total / stencil.number_density


@kernel
def shear_rate_at(i, velocity, walls, stencil):
    """Return ``sqrt(2 D : D)`` with ``D`` the symmetric part of the velocity gradient, 1/s.

    The gradient is ``(Ds/n0) sum of u_ij r_ij w / r^2``, exact for a linear profile on the
    lattice, up to a wall too.
    """
    r_e = stencil.effective_radius
    xx, yy, zz = 0.0, 0.0, 0.0
    xy, xz, yz = 0.0, 0.0, 0.0
    for k in range(stencil.count[i]):
        j, dx, dy, dz, r = neighbor(i, k, stencil)
        if r < r_e:
            du, dv, dw = velocity_difference(i, j, dx, dy, dz, velocity, walls, stencil.spacing)
            f = (r_e / r - 1.0) / (r * r)
            xx += f * du * dx
            yy += f * dv * dy
            zz += f * dw * dz
            xy += f * (du * dy + dv * dx)
            xz += f * (du * dz + dw * dx)
            yz += f * (dv * dz + dw * dy)
    factor = stencil.dimension / stencil.number_density
    return factor * np.sqrt(2.0 * (xx * xx + yy * yy + zz * zz) + xy * xy + xz * xz + yz * yz)


@loop
def shear_rate(velocity, walls, stencil, rate):
    """Write the shear rate of the first ``rate.size`` particles, (m,) float64 array, 1/s."""
    for i in prange(rate.size):
        rate[i] = shear_rate_at(i, velocity, walls, stencil)
