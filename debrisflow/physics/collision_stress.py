"""Stress of colliding grains in the semi-implicit scheme: state, force, stable time step."""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.wall_access import velocity_difference
from debrisflow.physics.kinetic_theory import Grains, granular_pressure, granular_viscosity
from debrisflow.physics.operators import (
    number_density_at,
)

Floats = NDArray[np.float64]


@loop
def collision_state(fraction, c, temperature, grains, stencil, pressure, viscosity):
    """Write pressure and viscosity of the colliding grains of the particles that hold sediment.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles
    whose scatter then feeds it.
    """
    for i in prange(pressure.size):
        pressure[i] = 0.0
        viscosity[i] = 0.0
        if fraction[i] > 0.0:
            clipped = min(c[i], grains.largest_concentration)
            n, _ = number_density_at(i, stencil)
            inside = min(max(5.0 * (n / stencil.number_density - 0.8), 0.0), 1.0)
            pressure[i] = inside * granular_pressure(clipped, temperature[i], grains)
            viscosity[i] = granular_viscosity(clipped, temperature[i], grains)


@kernel
def collision_force_at(i, fluid_count, velocity, fraction, pressure, viscosity, walls, stencil):
    """Return ``-div P_s`` of particle i, N/m3.

    Pressure in the conservative sum form, shear as a Laplacian with the mean viscosity of the
    pair; both act between particles that hold sediment and are opposite on the two.  A no-slip
    wall shears the grains as if its bumps were grains; their pressure on it is left to the fluid's.
    """
    r_e = stencil.effective_radius
    push = stencil.dimension / stencil.number_density
    pull = 2.0 * stencil.dimension / (stencil.laplacian_lambda * stencil.number_density)
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        inverse = stencil.inverse[i, k]
        w = r_e * inverse - 1.0
        if j < fluid_count and fraction[j] > 0.0:
            f = push * (pressure[i] + pressure[j]) * w * inverse * inverse
            s = pull * 0.5 * (viscosity[i] + viscosity[j]) * w
            x += s * (velocity[j, 0] - velocity[i, 0]) - f * stencil.dx[i, k]
            y += s * (velocity[j, 1] - velocity[i, 1]) - f * stencil.dy[i, k]
            z += s * (velocity[j, 2] - velocity[i, 2]) - f * stencil.dz[i, k]
        elif j >= stencil.wall_from and walls.slip[j] == 0.0:
            du, dv, dw = velocity_difference(i, k, velocity, walls, stencil)
            s = pull * viscosity[i] * w
            x += s * du
            y += s * dv
            z += s * dw
    return x, y, z


@loop
def throw(velocity, density, fraction, pressure, viscosity, walls, stencil, thrown):
    """Write the acceleration by collisions, ``-div P_s / rho``, (n, 3) float64 array, m/s2."""
    n = thrown.shape[0]
    for i in prange(n):
        x, y, z = 0.0, 0.0, 0.0
        if fraction[i] > 0.0:
            x, y, z = collision_force_at(
                i, n, velocity, fraction, pressure, viscosity, walls, stencil
            )
        thrown[i, 0] = x / density[i]
        thrown[i, 1] = y / density[i]
        thrown[i, 2] = z / density[i]


def largest_collision_step(
    c: Floats,
    density: Floats,
    pressure: Floats,
    viscosity: Floats,
    grains: Grains,
    spacing: float,
) -> float:
    """Return the greatest stable time step of the explicit collision stress, s.

    0.2 d0 / c_s with ``c_s^2 = (P / rho) (2 + g0 / 3)``, and 0.2 d0^2 rho / mu_s.
    """
    g0 = 1.0 / (
        1.0 - (np.minimum(c, grains.largest_concentration) / grains.packing_limit) ** (1 / 3)
    )
    speed = np.sqrt(np.max(pressure / density * (2.0 + g0 / 3.0), initial=0.0))
    diffusivity = np.max(viscosity / density, initial=0.0)
    limits = [0.2 * spacing / speed if speed > 0.0 else np.inf]
    limits.append(0.2 * spacing**2 / diffusivity if diffusivity > 0.0 else np.inf)
    return float(min(limits))
