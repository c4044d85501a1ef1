"""The weakly compressible fluid: density, equation of state and forces of each particle.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.boundary import (
    face_count,
    flow_of_walls_at,
    rebounded,
    viscous_pull_at,
    wall_sums_at,
)
from debrisflow.neighbors.pairs import (
    BLOCK,
    fluid_pair,
    gradient_factor,
    laplacian_factor,
    weight,
)
from debrisflow.physics.contact import hit_between
from debrisflow.physics.rheology import harmonic_mean
from debrisflow.physics.wall_push import wall_push_at

Floats = NDArray[np.float64]
SURFACE = 0.85  # n/n0 below which a particle is called one of the free surface
BENEATH, ON_TOP = 0.05, 0.10
"""Asymmetry up to which a particle is inside the fluid, and from which on it is at its surface.

Between rows under a surface, 0.01 on the lattice and 0.06 in a heap, and the surface, 0.16."""
LEAST_COMPRESSION, GREATEST_COMPRESSION = -0.02, 0.5


class Fluid(NamedTuple):
    """What is known of the fluid particles.

    Attributes
    ----------
    velocity : (n, 3) float64 array, m/s
    compression : (n,) float64 array
        s.
    pressure, total_pressure : (n,) float64 array, Pa
        Of the mixture; with that of colliding grains.
    density : (n,) float64 array, kg/m3, or None
        Of matter that is not compressed; None where all have that of :class:`Numbers`, for which
        kernels are compiled that are a fifth faster.
    viscosity : (n,) float64 array, Pa s, or None
        Newtonian and of colliding grains; None where all have that of :class:`Numbers`.
    """

    velocity: Floats
    compression: Floats
    pressure: Floats
    total_pressure: Floats
    density: Floats | None
    viscosity: Floats | None


class Numbers(NamedTuple):
    """Constants of the explicit scheme.

    Attributes
    ----------
    smooth_density, smooth_steepness : float
        m0 and its growth with the density, see :class:`debrisflow.neighbors.lattice.Reference`.
    density, sound_speed : float, kg/m3, m/s
        rho0, that of the heaviest matter, and c, its speed of sound.
    viscosity : float, Pa s
        Of all matter, where it is the same; 0 where momentum is exchanged implicitly instead.
    gravity : (3,) float64 array, m/s2
    diffusion, relaxation : float, -, s
        delta, and the time in which s follows n.
    artificial_viscosity : float
        alpha.
    collision_distance : float, m, or None
        Within which particles collide; None where they do not, for which kernels are compiled that
        are faster.
    restitution : float
        Of collisions, and of bounces off walls.
    """

    smooth_density: float
    smooth_steepness: float
    density: float
    sound_speed: float
    viscosity: float
    gravity: Floats
    diffusion: float
    relaxation: float
    artificial_viscosity: float
    collision_distance: float | None
    restitution: float


@kernel
def density_of(i, density, numbers):
    """Return the density of particle i without its compression, kg/m3."""
    return numbers.density if density is None else density[i]


@kernel
def smooth_weight(weighed, r2, inverse, near):
    """Return ``(1 - q)^2``, q = r / r_e, from ``w = 1 / q - 1``.

    See :mod:`debrisflow.neighbors.lattice`.
    """
    rest = weighed * r2 * inverse / near.effective_radius
    return rest * rest


@kernel
def density_rate_at(i, fluid, near, solid, numbers):
    """Return n / n0, the compression that the summed density tells, ds/dt, 1/s, and the asymmetry.

        ds/dt = -(1 + s) (Ds/n0) sum of u_ij . r_ij w / r^2
                + delta c d0 (2 Ds/(lambda n0)) sum of [s_j - s_i - (rho_ij/rho0) g . r_ij / c^2] w

    The first sum, continuity, is over fluid and walls; the second, over fluid, evens out noise
    but not the hydrostatic part, which would make the fluid sink; rho_ij is the mean density of the
    pair.  Behind a wall the fluid moves against it as it does before it,
    ``-2 (u_i - u_wall) . G``: the
    adjoint of :func:`debrisflow.physics.wall_push.wall_push_at`.  The asymmetry is that of what
    surrounds the particle, solid among it: ``d0 |sum of r_ij w / r^2 + G| / n0``.

    References
    ----------
    Antuono, Colagrossi, Marrone & Molteni 2010, doi:10.1016/j.cpc.2009.11.002 (diffusion of
    density in SPH).
    """
    velocity, s = fluid.velocity, fluid.compression
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    stiff = 2.0 * numbers.density * numbers.sound_speed * numbers.sound_speed
    gx, gy, gz = (
        numbers.gravity[0] / stiff,
        numbers.gravity[1] / stiff,
        numbers.gravity[2] / stiff,
    )
    s_i, rho_i = s[i], density_of(i, fluid.density, numbers)
    n, m, flow, difference, x, y, z = 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        weighed = weight(inverse, near)
        n += weighed
        r2 = dx * dx + dy * dy + dz * dz
        m += smooth_weight(weighed, r2, inverse, near)
        along = (velocity[j, 0] - u) * dx + (velocity[j, 1] - v) * dy + (velocity[j, 2] - w) * dz
        steep = weighed * inverse * inverse
        flow += along * steep
        x += steep * dx
        y += steep * dy
        z += steep * dz
        heavy = density_of(j, fluid.density, numbers) + rho_i
        difference += (s[j] - s_i - heavy * (gx * dx + gy * dy + gz * dz)) * weighed
    wall_n, wall_m, gx, gy, gz, _, _, _, _, _, _ = wall_sums_at(i, solid)
    n += wall_n
    m += wall_m
    flow += 2.0 * (flow_of_walls_at(i, solid) - u * gx - v * gy - w * gz)
    x += gx
    y += gy
    z += gz
    asymmetry = near.spacing * np.sqrt(x * x + y * y + z * z) / near.number_density
    spread = numbers.diffusion * numbers.sound_speed * near.spacing * laplacian_factor(near)
    rate = -(1.0 + s_i) * gradient_factor(near) * flow + spread * difference
    summed = (m / numbers.smooth_density - 1.0) / numbers.smooth_steepness
    return n / near.number_density, summed, rate, asymmetry


@kernel
def new_compression(s, rate, asymmetry, summed, relaxation, dt):
    """Return the compression after a time step.

    Inside the fluid it follows the summed density within the relaxation time, so that what
    continuity loses does not add up.  At a free surface, where the sums miss what is not there, it
    follows continuity alone, so that a film of one row is carried by its pressure.  What tells
    them apart is the asymmetry, not n: grains that a collapse has loosened are inside, and settle.
    A lone particle is inside too, and so keeps no pressure.

    Examples
    --------
    >>> [new_compression(0.0, 1.0, asymmetry, 0.02, 0.1, 0.01) for asymmetry in (0.0, 0.2)]
    [0.012, 0.01]
    """
    inside = min(max((ON_TOP - asymmetry) / (ON_TOP - BENEATH), 0.0), 1.0)
    rate += inside * (summed - s) / relaxation
    return min(max(s + dt * rate, LEAST_COMPRESSION), GREATEST_COMPRESSION)


@kernel
def state_pressure(s, numbers):
    """Return ``p = rho0 c^2 max(s, 0)``, the integral of equation (12), Pa.

    All matter is as stiff, whatever its density, so that s is continuous where p is.
    """
    return numbers.density * numbers.sound_speed * numbers.sound_speed * max(s, 0.0)


@kernel
def _advance_density(first, last, dt, fluid, near, solid, numbers, n, compression, pressure):
    for i in range(first, last):
        ratio, summed, rate, asymmetry = density_rate_at(i, fluid, near, solid, numbers)
        before = fluid.compression[i]
        s = new_compression(before, rate, asymmetry, summed, numbers.relaxation, dt)
        n[i] = ratio * near.number_density
        compression[i] = s
        pressure[i] = state_pressure(s, numbers)


@loop
def advance_density(dt, fluid, near, solid, numbers, n, compression, pressure):
    """Write n, the compression after a time step and its pressure, of every fluid particle."""
    for block in prange((n.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n.size)
        _advance_density(first, last, dt, fluid, near, solid, numbers, n, compression, pressure)


@kernel
def viscosity_of(i, viscosity, numbers):
    """Return the viscosity of particle i, Pa s."""
    return numbers.viscosity if viscosity is None else viscosity[i]


@kernel
def mean_viscosity(mu_i, j, viscosity):
    """Return the harmonic mean of a viscosity and that of particle j, Pa s."""
    return mu_i if viscosity is None else harmonic_mean(mu_i, viscosity[j])


@kernel
def pair_forces_at(i, fluid, near, numbers):
    """Return force of the fluid, N/m3, and change of velocity by collisions, m/s, of particle i.

        -(Ds/n0) sum of (P_i + P_j) r_ij w / r^2
        + (2 Ds/(lambda n0)) sum of [alpha c d0 rho_ij (u_ij . e) e + mu_ij u_ij] w

    with P the pressure of fluid and grains and mu_ij the harmonic mean of the pair's viscosities.
    The sum form of the pressure conserves momentum, and is never attractive since P >= 0; the
    study's form (14) is not needed then.  Grains nearer than the collision distance that approach
    exchange the impulse of a collision, from the same velocities for both; water is kept apart by
    its pressure alone, which acts at the free surface too.
    """
    velocity = fluid.velocity
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    push, pull = gradient_factor(near), laplacian_factor(near)
    rho, mu_i = density_of(i, fluid.density, numbers), viscosity_of(i, fluid.viscosity, numbers)
    damping = 0.5 * pull * numbers.artificial_viscosity * numbers.sound_speed * near.spacing
    total_i, rebound = fluid.total_pressure[i], 1.0 + numbers.restitution
    x, y, z, cx, cy, cz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        weighed = weight(inverse, near)
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        along = du * dx + dv * dy + dw * dz
        p = total_i + fluid.total_pressure[j]
        rho_j = density_of(j, fluid.density, numbers)
        line = (damping * (rho + rho_j) * along - push * p) * weighed * inverse * inverse
        drag = pull * mean_viscosity(mu_i, j, fluid.viscosity) * weighed
        x += line * dx + drag * du
        y += line * dy + drag * dv
        z += line * dz + drag * dw
        hit = hit_between(along, inverse, rho, rho_j, j, numbers.collision_distance, near)
        cx += hit * dx
        cy += hit * dy
        cz += hit * dz
    return x, y, z, rebound * cx, rebound * cy, rebound * cz


@kernel
def wall_forces_at(i, fluid, near, solid, numbers):
    """Return what the walls do to particle i by pressure and by viscosity, N/m3.

    See :func:`debrisflow.physics.wall_push.wall_push_at` and
    :func:`debrisflow.neighbors.boundary.viscous_pull_at`; the artificial viscosity does not act on
    walls, where it would be a drag that depends on the spacing.
    """
    if face_count(i, solid) == 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g, rho = numbers.gravity, density_of(i, fluid.density, numbers)
    x, y, z = wall_push_at(i, fluid.total_pressure, rho, g, g[0], g[1], g[2], 0.0, near, solid)
    drag = laplacian_factor(near) * viscosity_of(i, fluid.viscosity, numbers)
    u, v, w = viscous_pull_at(i, fluid.velocity, near, solid)
    return x, y, z, drag * u, drag * v, drag * w


@kernel
def _advance_by_pairs(first, last, dt, fluid, near, numbers, velocity):
    g = numbers.gravity
    for i in range(first, last):
        x, y, z, cx, cy, cz = pair_forces_at(i, fluid, near, numbers)
        per = dt / density_of(i, fluid.density, numbers)
        velocity[i, 0] = fluid.velocity[i, 0] + per * x + dt * g[0] + cx
        velocity[i, 1] = fluid.velocity[i, 1] + per * y + dt * g[1] + cy
        velocity[i, 2] = fluid.velocity[i, 2] + per * z + dt * g[2] + cz


@kernel
def _advance_by_walls(
    first, last, dt, fluid, near, solid, numbers, velocity, push, reaction, bounced
):
    for i in range(first, last):
        for axis in range(3):
            push[i, axis], reaction[i, axis] = 0.0, 0.0
        bounced[i] = False
        if face_count(i, solid) == 0:
            continue
        x, y, z, sx, sy, sz = wall_forces_at(i, fluid, near, solid, numbers)
        per = 1.0 / density_of(i, fluid.density, numbers)
        before_u, before_v, before_w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        if near.fluid_count[i] == 0 and x * before_u + y * before_v + z * before_w > 0.0:
            x, y, z = 0.0, 0.0, 0.0  # a wall does not throw back what falls on it alone
        u = before_u + dt * per * (x + sx)
        v = before_v + dt * per * (y + sy)
        w = before_w + dt * per * (z + sz)
        after_u, after_v, after_w = rebounded(i, u, v, w, 0.0, numbers.restitution, solid)
        bounced[i] = after_u != u or after_v != v or after_w != w
        u, v, w = after_u, after_v, after_w
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = u, v, w
        push[i, 0], push[i, 1], push[i, 2] = per * x, per * y, per * z
        reaction[i, 0] = (u - before_u) / dt
        reaction[i, 1] = (v - before_v) / dt
        reaction[i, 2] = (w - before_w) / dt


@loop
def advance_velocity(dt, fluid, near, solid, numbers, velocity, push, reaction, bounced):
    """Write the velocity of every fluid particle after a time step, (n, 3) float64 array, m/s.

    The right side of equation (13), momentum of a weakly compressible mixture, over rho: what the
    fluid does, collisions and gravity, then the walls, and bounces of what has come into one, in a
    loop of their own, since few particles are near a wall.  Also what the walls push a particle by
    with their pressure, and all that they do to it, viscosity and bounces among it, (n, 3) float64
    arrays, m/s2, and which particles bounced, (n,) bool array.
    """
    for block in prange((velocity.shape[0] + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, velocity.shape[0])
        _advance_by_pairs(first, last, dt, fluid, near, numbers, velocity)
        _advance_by_walls(
            first, last, dt, fluid, near, solid, numbers, velocity, push, reaction, bounced
        )
