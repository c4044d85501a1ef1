"""Pairs of particles of a weakly compressible fluid: who is near whom, separation and weights.

Letters as in :mod:`debrisflow.neighbors.stencil`; ``s = rho / rho0 - 1`` is the compression, ``c``
the speed of sound.  Fluid and walls stand in two lists; walls do not move.  Loops over fluid
neighbors are free of branches, so that they vectorize: a listed particle beyond the influence
radius has the weight 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel
from debrisflow.neighbors.wall_access import face_towards, mirrored

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
BLOCK = 256
"""Particles of a task in parallel loops.  A parallel loop over single particles, into which their
sums are compiled, was measured at 450 instead of 250 ns a particle."""


class Fluid(NamedTuple):
    """What is known of the fluid particles.

    Attributes
    ----------
    position, velocity : (n, 3) float64 array, m, m/s
    compression : (n,) float64 array
        s.
    pressure, total_pressure : (n,) float64 array, Pa
        Of the mixture, 0 at a free surface; with that of colliding grains.
    density : (n,) float64 array, kg/m3, or None
        Of matter that is not compressed; None where all have that of :class:`Numbers`, for which
        kernels are compiled that are a fifth faster.
    viscosity : (n,) float64 array, Pa s
        Newtonian and of colliding grains; 0 where momentum is exchanged implicitly instead.
    """

    position: Floats
    velocity: Floats
    compression: Floats
    pressure: Floats
    total_pressure: Floats
    density: Floats | None
    viscosity: Floats


class Solid(NamedTuple):
    """What is known of the wall particles.

    Attributes
    ----------
    position, normal : (m, 3) float64 array, m
        The normal points out of the wall.
    depth : (m,) float64 array, m
        Distance to the wall's surface.
    slip : (m,) float64 array
        1 where the wall is free-slip, 0 where it is no-slip.
    contact_height : (m,) float64 array, m
        Height over the surface below which contacts are looked for; -inf under the first layer.
    on_mesh : (m,) bool array
        Whether the surface is that of a mesh, of any direction, not along the axes.
    driving : (m, 3) float64 array, m/s2
        The part of gravity along a wall that drives the flow and that no pressure balances.
    """

    position: Floats
    normal: Floats
    depth: Floats
    slip: Floats
    contact_height: Floats
    on_mesh: NDArray[np.bool_]
    driving: Floats


class Near(NamedTuple):
    """Who is near whom: neighbors of every fluid particle in the fluid and in the walls.

    Attributes
    ----------
    fluid, wall : (n or less, capacity) int32 array
    wall_row : (n,) int32 array
        Row of ``wall`` that holds the neighbors of a particle.
    fluid_count, wall_count : (n,) int32 array
    period : (2, 3) float64 array, m, 1/m, or None
        Period along each axis and its inverse, 0 where there is none; None where nothing repeats,
        for which kernels are compiled that are a twentieth faster.
    """

    fluid: Indices
    fluid_count: Indices
    wall: Indices
    wall_row: Indices
    wall_count: Indices
    period: Floats | None


class Numbers(NamedTuple):
    """Constants of the scheme.

    Attributes
    ----------
    spacing, effective_radius : float, m
        d0 and r_e.
    dimension, number_density : float
        Ds and n0.
    gradient, laplacian : float, -, 1/m2
        ``Ds / n0`` and ``2 Ds / (lambda n0)``.
    smooth_density, smooth_steepness : float
        m0 and its growth with the density, see :class:`debrisflow.neighbors.lattice.Reference`.
    density, sound_speed : float, kg/m3, m/s
        rho0, that of the heaviest matter, and c, its speed of sound.
    gravity : (3,) float64 array, m/s2
    diffusion, relaxation : float, -, s
        delta, and the time in which s follows n.
    artificial_viscosity : float
        alpha.
    collision_distance, restitution : float, m, -
    """

    spacing: float
    effective_radius: float
    dimension: float
    number_density: float
    gradient: float
    laplacian: float
    smooth_density: float
    smooth_steepness: float
    density: float
    sound_speed: float
    gravity: Floats
    diffusion: float
    relaxation: float
    artificial_viscosity: float
    collision_distance: float
    restitution: float


@kernel
def separation(i, j, position, other, period):
    """Return the components of ``r_j - r_i`` through the nearest image, m."""
    dx = other[j, 0] - position[i, 0]
    dy = other[j, 1] - position[i, 1]
    dz = other[j, 2] - position[i, 2]
    if period is not None:
        dx -= period[0, 0] * np.rint(dx * period[1, 0])
        dy -= period[0, 1] * np.rint(dy * period[1, 1])
        dz -= period[0, 2] * np.rint(dz * period[1, 2])
    return dx, dy, dz


@kernel
def density_of(i, density, numbers):
    """Return the density of particle i without its compression, kg/m3."""
    return numbers.density if density is None else density[i]


@kernel
def inverse_distance(dx, dy, dz, numbers):
    """Return ``1 / r``; two particles at one place are taken 1e-6 d0 apart, in no direction."""
    r2 = dx * dx + dy * dy + dz * dz
    return 1.0 / np.sqrt(max(r2, 1e-12 * numbers.spacing * numbers.spacing))


@kernel
def weight(inverse, numbers):
    """Return ``w = r_e / r - 1``, 0 beyond the influence radius."""
    return max(numbers.effective_radius * inverse - 1.0, 0.0)


@kernel
def coupling_weight(inverse, numbers):
    """Return ``(2 Ds/n0) w/r^2``, 1/m2, by which a viscosity couples two particles.

    The sum of ``w/r^2`` times the square of the distance is n, which the scheme keeps near n0.
    That of w alone, as in the usual ``(2 Ds/(lambda n0)) w``, is not that of the lattice once rows
    pass each other: in a film on a slope it was 2.2 % above it, and the stress with it.  Nearer
    than a tenth of a spacing it grows no further, or two particles at one place would outweigh, in
    the last digit, all others.
    """
    inverse = min(inverse, 10.0 / numbers.spacing)
    return 2.0 * numbers.gradient * weight(inverse, numbers) * inverse * inverse


@kernel
def smooth_weight(weighed, r2, inverse, numbers):
    """Return ``(1 - q)^2``, q = r / r_e, from ``w = 1 / q - 1``.

    See :mod:`debrisflow.neighbors.lattice`.
    """
    rest = weighed * r2 * inverse / numbers.effective_radius
    return rest * rest


@kernel
def height_over(dx, dy, dz, j, solid):
    """Return the height over the surface at wall particle j, m, from the separation to it."""
    normal = solid.normal
    return -(dx * normal[j, 0] + dy * normal[j, 1] + dz * normal[j, 2]) - solid.depth[j]


@kernel
def across_wall(dx, dy, dz, j, solid):
    """Return a separation from wall particle j; from one that is free-slip the part across it."""
    normal, slip = solid.normal, solid.slip[j]
    across = slip * (dx * normal[j, 0] + dy * normal[j, 1] + dz * normal[j, 2])
    along = 1.0 - slip
    return (
        along * dx + across * normal[j, 0],
        along * dy + across * normal[j, 1],
        along * dz + across * normal[j, 2],
    )


@kernel
def wall_factor(height, j, solid, numbers):
    """Return by how much the velocity difference to wall particle j exceeds that to its surface."""
    return 1.0 + solid.depth[j] / max(height, 0.5 * numbers.spacing)


@kernel
def wall_velocity_difference(u, v, w, height, j, solid, numbers):
    """Return ``u_j - u_i`` for wall particle j, as :func:`operators.velocity_difference`."""
    nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
    factor = wall_factor(height, j, solid, numbers)
    return mirrored(-u, -v, -w, nx, ny, nz, factor, solid.slip[j])


@kernel
def contact(dx, dy, dz, j, solid, numbers):
    """Return height over and normal of the surface that first-layer wall particle j stands for.

    Infinite if the surface is not below; that of a mesh is the plane at the particle, up to a
    spacing aside, since the particles stand on the lattice and not along the surface.
    """
    nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
    if not solid.on_mesh[j]:
        return face_towards(dx, dy, dz, nx, ny, nz, numbers.spacing)
    above = -(dx * nx + dy * ny + dz * nz)
    aside2 = dx * dx + dy * dy + dz * dz - above * above
    if above <= 0.0 or aside2 > numbers.spacing * numbers.spacing:
        return np.inf, 0.0, 0.0, 0.0
    return above - solid.depth[j], nx, ny, nz
