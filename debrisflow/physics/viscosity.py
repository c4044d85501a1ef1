"""Explicit viscosity, and the eddy viscosity of Prandtl's mixing length over a floor."""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, fluid_pair, laplacian_factor, weight
from debrisflow.neighbors.wall_access import viscous_pull_at
from debrisflow.physics.rheology import harmonic_mean
from debrisflow.physics.turbulence import mixing_length, turbulent_viscosity


@kernel
def viscous_force_at(i, velocity, viscosity, near, solid):
    """Return ``div(mu grad u)`` of particle i with the pair's harmonic mean viscosity, N/m3.

        (2 Ds / (lambda n0)) sum of mu_ij (u_j - u_i) w

    The lambda form of the Laplacian, equation (15), exact for r^2 on the lattice.

    Parameters
    ----------
    i : int
    velocity, viscosity : (n, 3), (n,) float64 array, m/s, Pa s
        Of fluid and supply.
    near : Near
    solid : Solid or Boundary
    """
    factor, mu_i = laplacian_factor(near), viscosity[i]
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        f = factor * harmonic_mean(mu_i, viscosity[j]) * weight(inverse, near)
        x += f * (velocity[j, 0] - u)
        y += f * (velocity[j, 1] - v)
        z += f * (velocity[j, 2] - w)
    wall_x, wall_y, wall_z = viscous_pull_at(i, velocity, near, solid)
    f = factor * mu_i
    return x + f * wall_x, y + f * wall_y, z + f * wall_z


@kernel
def _viscous_acceleration(first, last, velocity, density, viscosity, near, solid, acceleration):
    for i in range(first, last):
        x, y, z = viscous_force_at(i, velocity, viscosity, near, solid)
        acceleration[i, 0] = x / density[i]
        acceleration[i, 1] = y / density[i]
        acceleration[i, 2] = z / density[i]


@loop
def viscous_acceleration(velocity, density, viscosity, near, solid, acceleration):
    """Write ``div(mu grad u) / rho`` of the fluid particles, (n, 3) float64 array, m/s2."""
    n = acceleration.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _viscous_acceleration(first, last, velocity, density, viscosity, near, solid, acceleration)


@kernel
def _wall_shear(first, last, velocity, density, viscosity, near, solid, acceleration):
    for i in range(first, last):
        x, y, z = viscous_pull_at(i, velocity, near, solid)
        f = laplacian_factor(near) * viscosity[i] / density[i]
        acceleration[i, 0], acceleration[i, 1], acceleration[i, 2] = f * x, f * y, f * z


@loop
def wall_shear(velocity, density, viscosity, near, solid, acceleration):
    """Write what of an acceleration by viscosity the walls do, (n, 3) float64 array, m/s2."""
    n = acceleration.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _wall_shear(first, last, velocity, density, viscosity, near, solid, acceleration)


@kernel
def _eddy_viscosity(first, last, density, height, roughness, greatest_length, rate, viscosity):
    for i in range(first, last):
        length = mixing_length(greatest_length, height[i], roughness[i])
        viscosity[i] = turbulent_viscosity(density[i], length, rate[i])


@loop
def eddy_viscosity(density, height, roughness, greatest_length, rate, viscosity):
    """Write the turbulent viscosity of the fluid particles, (n,) float64 array, Pa s.

    Prandtl's, with the mixing length over the floor; ``height`` and ``roughness``, m, are those
    over and of the floor under every particle, ``rate``, 1/s, is the shear rate.
    """
    n = viscosity.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _eddy_viscosity(first, last, density, height, roughness, greatest_length, rate, viscosity)
