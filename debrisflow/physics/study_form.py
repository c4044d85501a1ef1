"""The explicit scheme of three dimensions as the study writes it, with walls of particles.

Equations (12) to (15) without what keeps them stable: no diffusion or relaxation of the density, no
artificial viscosity, no collisions.  Kept to be compared with; still water does not stay still.
Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import (
    BLOCK,
    fluid_pair,
    gradient_factor,
    is_inside,
    laplacian_factor,
    weight,
)
from debrisflow.physics.rheology import harmonic_mean


@kernel
def summed_density_at(i, near):
    """Return n of particle i over fluid and all layers of walls."""
    n = 0.0
    for k in range(near.fluid_count[i] + near.wall_count[i]):
        _, _, _, _, inverse = fluid_pair(i, k, near)
        n += weight(inverse, near)
    return n


@kernel
def pressure_of(n, near, density, sound_speed):
    """Return ``c^2 rho0 (n / n0 - 1)``, not negative: equation (12) from the lattice on, Pa."""
    return density * sound_speed * sound_speed * max(n / near.number_density - 1.0, 0.0)


@kernel
def study_gradient_at(i, pressure, near):
    """Return the gradient of equation (14), Pa/m.

        (Ds/n0) sum of (p_j - p_min) r_ij w / r^2,  p_min the least of p_i and of all p_j

    over fluid, supply and the first layer of walls, which have a pressure.
    """
    count, least = near.fluid_count[i] + near.pressed_count[i], pressure[i]
    for k in range(count):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        if is_inside(weight(inverse, near)) > 0.0:
            least = min(least, pressure[j])
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        f = (pressure[j] - least) * weight(inverse, near) * inverse * inverse
        x, y, z = x + f * dx, y + f * dy, z + f * dz
    factor = gradient_factor(near)
    return factor * x, factor * y, factor * z


@kernel
def study_laplacian_at(i, velocity, viscosity, near, slip):
    """Return ``mu`` times the Laplacian of equation (15), N/m3.

        (2 Ds/(lambda n0)) sum of mu_ij (u_j - u_i) w

    over fluid and all layers of no-slip walls, which rest, with the viscosity of the particle.
    ``slip``, (walls,) array, is 1 for a free-slip wall particle.
    """
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i] + near.wall_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        mu = viscosity[i]
        if j >= near.wall_from:
            mu *= 1.0 - slip[j - near.wall_from]
        else:
            mu = harmonic_mean(mu, viscosity[j])
        f = mu * weight(inverse, near)
        x += f * (velocity[j, 0] - velocity[i, 0])
        y += f * (velocity[j, 1] - velocity[i, 1])
        z += f * (velocity[j, 2] - velocity[i, 2])
    factor = laplacian_factor(near)
    return factor * x, factor * y, factor * z


@kernel
def _sum_densities(first, last, near, density, sound_speed, n, pressure):
    for i in range(first, last):
        n[i] = summed_density_at(i, near)
        pressure[i] = pressure_of(n[i], near, density, sound_speed)


@loop
def sum_densities(near, density, sound_speed, n, pressure):
    """Write n and the pressure of all particles that have a list of neighbors."""
    for block in prange((n.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n.size)
        _sum_densities(first, last, near, density, sound_speed, n, pressure)


@kernel
def _accelerate(first, last, dt, velocity, pressure, viscosity, density, gravity, near, slip, new):
    for i in range(first, last):
        x, y, z = study_gradient_at(i, pressure, near)
        u, v, w = study_laplacian_at(i, velocity, viscosity, near, slip)
        per = dt / density[i]
        new[i, 0] = velocity[i, 0] + per * (u - x) + dt * gravity[0]
        new[i, 1] = velocity[i, 1] + per * (v - y) + dt * gravity[1]
        new[i, 2] = velocity[i, 2] + per * (w - z) + dt * gravity[2]


@loop
def accelerate(dt, velocity, pressure, viscosity, density, gravity, near, slip, new):
    """Write the velocity of every fluid particle after a time step by equation (13), m/s.

    Parameters
    ----------
    dt : float, s
    velocity : (particles, 3) float64 array, m/s
        Of fluid, supply and walls.
    pressure : (rows,) float64 array, Pa
        Of what has a list of neighbors, that of colliding grains with it.
    viscosity, density : (moving particles,) float64 array, Pa s, kg/m3
    gravity : (3,) float64 array, m/s2
    near : Near
    slip : (walls,) float64 array
    new : (n, 3) float64 array, m/s
        Written.
    """
    n = new.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _accelerate(
            first, last, dt, velocity, pressure, viscosity, density, gravity, near, slip, new
        )
