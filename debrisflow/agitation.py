"""Grains that collide in a weakly compressible mixture: granular temperature and stress.

Letters as in :mod:`debrisflow.pairs`.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.granular import algebraic_temperature, granular_pressure, granular_viscosity
from debrisflow.operators import strain_rate
from debrisflow.pairs import (
    BLOCK,
    height_over,
    inverse_distance,
    separation,
    wall_velocity_difference,
    weight,
)

CAP = 0.1  # of the study's granular temperature, see :func:`capped_temperature`


@kernel
def shear_rate_at(i, fluid, solid, near, numbers):
    """Return ``sqrt(2 D : D)``, 1/s, exact for a linear profile on any arrangement.

    The same moments as in :func:`debrisflow.operators.shear_rate_at`.
    """
    position, velocity = fluid.position, fluid.velocity
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near.period)
        inverse = inverse_distance(dx, dy, dz, numbers)
        f = weight(inverse, numbers) * inverse * inverse
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    for k in range(near.wall_count[i]):
        j = np.uint32(near.wall[near.wall_row[i], k])
        dx, dy, dz = separation(i, j, position, solid.position, near.period)
        inverse = inverse_distance(dx, dy, dz, numbers)
        f = weight(inverse, numbers) * inverse * inverse
        height = height_over(dx, dy, dz, j, solid)
        du, dv, dw = wall_velocity_difference(u, v, w, height, j, solid, numbers)
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    return strain_rate(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz)


@kernel
def agitation_at(i, fluid, near, numbers):
    """Return the variance of the velocity in reach, over Ds: T of equations (20), (21), m2/s2."""
    position, velocity = fluid.position, fluid.velocity
    count, su, sv, sw, square = 1.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near.period)
        inverse = inverse_distance(dx, dy, dz, numbers)
        inside = 1.0 if weight(inverse, numbers) > 0.0 else 0.0
        du = velocity[j, 0] - velocity[i, 0]
        dv = velocity[j, 1] - velocity[i, 1]
        dw = velocity[j, 2] - velocity[i, 2]
        count += inside
        su, sv, sw = su + inside * du, sv + inside * dv, sw + inside * dw
        square += inside * (du * du + dv * dv + dw * dw)
    mean = (su * su + sv * sv + sw * sw) / count
    return max(square - mean, 0.0) / count / numbers.dimension


@kernel
def capped_temperature(temperature, c, grains, numbers):
    """Return the granular temperature, m2/s2, not above ``(z c rho0 / K)^2 / 3``, z = 0.1.

    ``K = 2 rho_s C^2 g0 (1 + e)``, the granular pressure of T = 1.  The variance of the velocity is
    mostly scatter of the particles; above the limit the pressure made of it makes more of it than
    the artificial viscosity takes away, and at C = 0.5 the fluid blows up.
    """
    pushed = granular_pressure(c, 1.0, grains)
    limit = CAP * numbers.sound_speed * numbers.density / pushed
    return min(temperature, limit * limit / 3.0)


@kernel
def _stir(first, last, is_algebraic, fluid, solid, near, c, grains, numbers, temperature):
    for i in range(first, last):
        if is_algebraic:
            rate = shear_rate_at(i, fluid, solid, near, numbers)
            temperature[i] = algebraic_temperature(rate, grains)
        else:
            agitation = agitation_at(i, fluid, near, numbers)
            temperature[i] = capped_temperature(agitation, c, grains, numbers)


@loop
def stir(is_algebraic, fluid, solid, near, c, grains, numbers, temperature):
    """Write the granular temperature of every fluid particle, (n,) float64 array, m2/s2."""
    for block in prange((temperature.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, temperature.size)
        _stir(first, last, is_algebraic, fluid, solid, near, c, grains, numbers, temperature)


@loop
def collide_grains(c, viscosity, grains, numbers, n, temperature, grain_pressure, total_viscosity):
    """Write pressure, Pa, and kinematic viscosity, m2/s, of the fluid with its colliding grains.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles,
    which then hang as sheets.  ``viscosity`` is the Newtonian part.
    """
    for i in prange(n.size):
        inside = min(max(5.0 * (n[i] / numbers.number_density - 0.8), 0.0), 1.0)
        grain_pressure[i] = inside * granular_pressure(c, temperature[i], grains)
        collisions = granular_viscosity(c, temperature[i], grains)
        total_viscosity[i] = viscosity + collisions / numbers.density
