"""Stress of colliding grains, equations (10) and (19): pressure, viscosity, force, time step."""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import (
    BLOCK,
    fluid_pair,
    gradient_factor,
    laplacian_factor,
    weight,
)
from debrisflow.neighbors.wall_access import grain_pull_at
from debrisflow.physics.granular_temperature import is_grain
from debrisflow.physics.kinetic_theory import (
    Grains,
    granular_pressure,
    granular_viscosity,
    radial_distribution,
)
from debrisflow.physics.rheology import harmonic_mean

Floats = NDArray[np.float64]
LIMIT = 0.2  # of the time step, in spacings over the speed of the grains' pressure waves


@kernel
def _collide_grains(first, last, c, grains, n0, n, temperature, pressure, viscosity):
    for i in range(first, last):
        clipped = min(c[i], grains.largest_concentration)
        inside = min(max(5.0 * (n[i] / n0 - 0.8), 0.0), 1.0)
        pressure[i] = inside * granular_pressure(clipped, temperature[i], grains)
        viscosity[i] += granular_viscosity(clipped, temperature[i], grains)


@loop
def collide_grains(c, grains, n0, n, temperature, pressure, viscosity):
    """Write the pressure, Pa, of colliding grains and add their viscosity, Pa s, to what is there.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles,
    which then hang as sheets.

    Parameters
    ----------
    c : (n,) float64 array
        Concentration; taken no greater than that at which it is clipped.
    grains : Grains
    n0 : float
    n, temperature : (n,) float64 array, -, m2/s2
    pressure, viscosity : (n,) float64 array, Pa, Pa s
        Written.
    """
    for block in prange((n.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n.size)
        _collide_grains(first, last, c, grains, n0, n, temperature, pressure, viscosity)


@kernel
def collision_force_at(i, velocity, fraction, pressure, viscosity, near, solid):
    """Return ``-div P_s`` of particle i, N/m3, what equation (3) of the solid has beyond (2).

    Pressure in the conservative sum form, shear as a Laplacian with the harmonic mean viscosity of
    the pair; both act between particles that hold sediment and are opposite on the two.  A no-slip
    wall shears the grains as if its bumps were grains; their pressure on it is left to the fluid's.
    """
    push, pull = gradient_factor(near), laplacian_factor(near)
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    p_i, mu_i = pressure[i], viscosity[i]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        weighed = is_grain(j, fraction, near) * weight(inverse, near)
        f = push * (p_i + pressure[j]) * weighed * inverse * inverse
        s = pull * harmonic_mean(mu_i, viscosity[j]) * weighed
        x += s * (velocity[j, 0] - u) - f * dx
        y += s * (velocity[j, 1] - v) - f * dy
        z += s * (velocity[j, 2] - w) - f * dz
    wall_x, wall_y, wall_z = grain_pull_at(i, velocity, near, solid)
    s = pull * mu_i
    return x + s * wall_x, y + s * wall_y, z + s * wall_z


@kernel
def _collision_acceleration(
    first, last, velocity, density, fraction, pressure, viscosity, near, solid, acceleration
):
    for i in range(first, last):
        x, y, z = 0.0, 0.0, 0.0
        if fraction[i] > 0.0:
            x, y, z = collision_force_at(i, velocity, fraction, pressure, viscosity, near, solid)
        acceleration[i, 0] = x / density[i]
        acceleration[i, 1] = y / density[i]
        acceleration[i, 2] = z / density[i]


@loop
def collision_acceleration(
    velocity, density, fraction, pressure, viscosity, near, solid, acceleration
):
    """Write the acceleration by collisions, ``-div P_s / rho``, (n, 3) float64 array, m/s2.

    ``pressure`` and ``viscosity`` have a row for fluid and supply.
    """
    n = acceleration.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _collision_acceleration(
            first, last, velocity, density, fraction, pressure, viscosity, near, solid, acceleration
        )


def largest_pressure_step(
    c: Floats, density: Floats, pressure: Floats, spacing: float, grains: Grains
) -> float:
    """Return the greatest time step, s, that the pressure of colliding grains allows.

    ``0.2 d0 / c_s`` with ``c_s^2 = (P / rho) (2 + g0 / 3)``; infinite where nothing collides.

    Parameters
    ----------
    c, density, pressure : (n,) float64 array, -, kg/m3, Pa
    spacing : float, m
    grains : Grains
    """
    g0 = radial_distribution(np.minimum(c, grains.largest_concentration), grains.packing_limit)
    speed = float(np.sqrt(np.max(pressure / density * (2.0 + g0 / 3.0), initial=0.0)))
    return LIMIT * spacing / speed if speed > 0.0 else np.inf
