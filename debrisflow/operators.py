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
from debrisflow.lattice import Reference
from debrisflow.neighbors import nearest_image

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]


# Below this the neighbors stand too nearly on a line or plane for a gradient across it.
LEAST_SPREAD = 4e-3
EDGE = 0.9  # greatest component of a unit normal at an edge of two axis-parallel faces


class Stencil(NamedTuple):
    """Who is within the influence radius of whom at this step, and the lattice constants.

    Pair geometry is computed once a step and read by every term.

    Attributes
    ----------
    neighbors : (m, capacity) int32 array
        Neighbors of the first m particles; those that carry a pressure stand first.
    neighbor_count : (m,) int32 array
        Number of neighbors in each row.
    unknown_count : (m,) int32 array
        Number of neighbors in each row that carry a pressure.
    dx, dy, dz : (m, capacity) float64 array, m
        Components of ``r_j - r_i``, through the nearest image where the domain repeats.
    inverse : (m, capacity) float64 array, 1/m
        ``1 / r``.
    wall_from : int
        Particles from this one on are walls.
    dimension : float
        Ds.
    spacing, effective_radius : float, m
        d0 and r_e.
    number_density : float
        n0.
    laplacian_lambda : float, m^2
        lambda.
    """

    neighbors: Indices
    neighbor_count: Indices
    unknown_count: Indices
    dx: Floats
    dy: Floats
    dz: Floats
    inverse: Floats
    wall_from: int
    dimension: float
    spacing: float
    effective_radius: float
    number_density: float
    laplacian_lambda: float


def empty_stencil(rows: int, capacity: int, lattice: Reference) -> Stencil:
    """Return a stencil with room for ``capacity`` neighbors of ``rows`` particles."""
    return Stencil(
        np.zeros((rows, capacity), dtype=np.int32),
        np.zeros(rows, dtype=np.int32),
        np.zeros(rows, dtype=np.int32),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        rows,
        float(lattice.dimension),
        lattice.spacing,
        lattice.effective_radius,
        lattice.number_density,
        lattice.laplacian_lambda,
    )


@kernel
def survey_at(i, position, period, listed, listed_count, stencil):
    """Write row i of the stencil from the particles listed near i.

    Two particles at one place have no direction: they are kept apart by 1e-6 d0 along x, whose
    sign follows their order, so that the pair stays opposite.
    """
    rows = stencil.neighbor_count.size
    reach2 = stencil.effective_radius**2
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    found, last = 0, stencil.neighbors.shape[1]
    for k in range(listed_count[i]):
        j = listed[i, k]
        dx = nearest_image(position[j, 0] - x, period[0])
        dy = nearest_image(position[j, 1] - y, period[1])
        dz = nearest_image(position[j, 2] - z, period[2])
        r2 = dx * dx + dy * dy + dz * dz
        if r2 >= reach2:
            continue
        if r2 == 0.0:
            dx = 1e-6 * stencil.spacing if j > i else -1e-6 * stencil.spacing
            r2 = dx * dx
        if j < rows:
            place = found
            found += 1
        else:
            last -= 1
            place = last
        stencil.neighbors[i, place] = j
        stencil.dx[i, place] = dx
        stencil.dy[i, place] = dy
        stencil.dz[i, place] = dz
        stencil.inverse[i, place] = 1.0 / np.sqrt(r2)
    stencil.unknown_count[i] = found
    for place in range(last, stencil.neighbors.shape[1]):
        stencil.neighbors[i, found] = stencil.neighbors[i, place]
        stencil.dx[i, found] = stencil.dx[i, place]
        stencil.dy[i, found] = stencil.dy[i, place]
        stencil.dz[i, found] = stencil.dz[i, place]
        stencil.inverse[i, found] = stencil.inverse[i, place]
        found += 1
    stencil.neighbor_count[i] = found


@loop
def survey(position, period, listed, listed_count, stencil):
    """Write the stencil of the step from the neighbor list."""
    for i in prange(listed_count.size):
        survey_at(i, position, period, listed, listed_count, stencil)


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
def velocity_difference(i, k, velocity, walls, stencil):
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
    j = stencil.neighbors[i, k]
    du = velocity[j, 0] - velocity[i, 0]
    dv = velocity[j, 1] - velocity[i, 1]
    dw = velocity[j, 2] - velocity[i, 2]
    if j < stencil.wall_from:
        # returned from here, the loop over fluid neighbors is ten times faster
        return du, dv, dw
    nx, ny, nz = walls.normal[j, 0], walls.normal[j, 1], walls.normal[j, 2]
    factor = 1.0 + walls.depth[j] / wall_distance(i, k, walls, stencil)
    return mirrored(du, dv, dw, nx, ny, nz, factor, walls.slip[j])


@kernel
def mirrored(du, dv, dw, nx, ny, nz, factor, slip):
    """Return a velocity difference times a factor; of the part along a free-slip wall nothing.

    Examples
    --------
    >>> mirrored(1.0, 2.0, 0.0, 0.0, 1.0, 0.0, 1.5, 1.0)
    (0.0, 3.0, 0.0)
    """
    normal = du * nx + dv * ny + dw * nz
    stick = 1.0 - slip
    return (
        factor * (normal * nx + stick * (du - normal * nx)),
        factor * (normal * ny + stick * (dv - normal * ny)),
        factor * (normal * nz + stick * (dw - normal * nz)),
    )


@kernel
def height_over(i, k, walls, stencil):
    """Return the height of particle i over the surface of the wall of neighbor k, m."""
    j = stencil.neighbors[i, k]
    below = (
        stencil.dx[i, k] * walls.normal[j, 0]
        + stencil.dy[i, k] * walls.normal[j, 1]
        + stencil.dz[i, k] * walls.normal[j, 2]
    )
    return -below - walls.depth[j]


@kernel
def contact(i, k, walls, stencil):
    """Return height over and normal of the wall face that neighbor k shows to particle i.

    Infinite if the neighbor is no wall or lies deeper than the first layer, and where
    :func:`face_towards` is.
    """
    j = stencil.neighbors[i, k]
    d0 = stencil.spacing
    if j < stencil.wall_from or walls.depth[j] > 0.75 * d0:
        return np.inf, 0.0, 0.0, 0.0
    return face_towards(
        stencil.dx[i, k],
        stencil.dy[i, k],
        stencil.dz[i, k],
        walls.normal[j, 0],
        walls.normal[j, 1],
        walls.normal[j, 2],
        d0,
    )


@kernel
def face_towards(dx, dy, dz, nx, ny, nz, d0):
    """Return height over and normal of the face of a first-layer wall particle at a separation.

    Infinite if the wall particle is not under the particle that looks at it: it answers for the d0
    of surface in front of it, in three dimensions for its square, so that no corner between four
    wall particles is open.  At an edge of two axis-parallel faces its normal (nx, ny, nz) halves
    their angle, and the face that looks at the particle counts.

    Examples
    --------
    >>> face_towards(0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    (0.5, 0.0, 1.0, 0.0)
    """
    if max(abs(nx), abs(ny), abs(nz)) < EDGE:
        ax, ay, az = abs(dx), abs(dy), abs(dz)
        nx = -np.sign(dx) if ax >= ay and ax >= az else 0.0
        ny = -np.sign(dy) if ay > ax and ay >= az else 0.0
        nz = -np.sign(dz) if az > ax and az > ay else 0.0
    above = -(dx * nx + dy * ny + dz * nz)
    aside = max(abs(dx + above * nx), abs(dy + above * ny), abs(dz + above * nz))
    if above <= 0.0 or aside > 0.5001 * d0:
        return np.inf, 0.0, 0.0, 0.0
    return above - 0.5 * d0, nx, ny, nz


@kernel
def wall_distance(i, k, walls, stencil):
    """Return the height over the wall, not below d0/2, the height of the first row, m."""
    return max(height_over(i, k, walls, stencil), 0.5 * stencil.spacing)


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
