"""Grains that collide in a weakly compressible mixture: granular temperature and stress.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import (
    BLOCK,
    across_wall,
    height_over,
    inverse_distance,
    separation,
    wall_velocity_difference,
    weight,
)
from debrisflow.physics.kinetic_theory import (
    algebraic_temperature,
    granular_pressure,
    granular_viscosity,
)
from debrisflow.physics.operators import solve_gradient, strain_rate

CAP = 0.1  # of the study's granular temperature, see :func:`capped_temperature`


@kernel
def velocity_gradient_at(i, fluid, solid, near, numbers):
    """Return the velocity gradient by rows, 1/s, exact for a linear profile on any arrangement.

    The same moments as in :func:`debrisflow.physics.operators.shear_rate_at`; of the way to a
    free-slip wall only what leads across it counts, since the fluid shears along it as it does
    inside.
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
        dx, dy, dz = across_wall(dx, dy, dz, j, solid)
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    return solve_gradient(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz)


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
    pushed = max(granular_pressure(c, 1.0, grains), 1e-9)
    limit = CAP * numbers.sound_speed * numbers.density / pushed
    return min(temperature, limit * limit / 3.0)


@kernel
def _velocity_gradients(first, last, fluid, solid, near, numbers, gradient, rate):
    for i in range(first, last):
        found = velocity_gradient_at(i, fluid, solid, near, numbers)
        for k in range(9):
            gradient[i, k] = found[k]
        rate[i] = strain_rate(*found)


@loop
def velocity_gradients(fluid, solid, near, numbers, gradient, rate):
    """Write velocity gradient by rows, (n, 9) array, and shear rate, (n,) array, 1/s."""
    for block in prange((rate.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, rate.size)
        _velocity_gradients(first, last, fluid, solid, near, numbers, gradient, rate)


@loop
def algebraic_temperatures(rate, grains, temperature):
    """Write the granular temperature that the shear rate makes, (n,) float64 array, m2/s2."""
    for i in prange(temperature.size):
        temperature[i] = algebraic_temperature(rate[i], grains)


@kernel
def _neighborhood_temperatures(first, last, fluid, near, c, grains, numbers, temperature):
    for i in range(first, last):
        agitation = agitation_at(i, fluid, near, numbers)
        temperature[i] = capped_temperature(agitation, c[i], grains, numbers)


@loop
def neighborhood_temperatures(fluid, near, c, grains, numbers, temperature):
    """Write the study's granular temperature of every particle, (n,) float64 array, m2/s2."""
    for block in prange((temperature.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, temperature.size)
        _neighborhood_temperatures(first, last, fluid, near, c, grains, numbers, temperature)


@kernel
def _concentrations(first, last, fraction, level, down, fluid, near, numbers, around, at_level):
    position = fluid.position
    for i in range(first, last):
        total, share, level_total, level_share = 2.0, 2.0 * fraction[i], 2.0, 2.0 * level[i]
        for k in range(near.fluid_count[i]):
            j = np.uint32(near.fluid[i, k])
            dx, dy, dz = separation(i, j, position, position, near.period)
            inverse = inverse_distance(dx, dy, dz, numbers)
            w = weight(inverse, numbers)
            below = inverse * (down[0] * dx + down[1] * dy + down[2] * dz)
            aside = w * (1.0 - below * below)
            total, share = total + w, share + w * fraction[j]
            level_total, level_share = level_total + aside, level_share + aside * level[j]
        around[i] = share / total
        at_level[i] = level_share / level_total


@loop
def concentrations(fraction, level, down, fluid, near, numbers, around, at_level):
    """Write the share of sediment around and at the level of every particle, (n,) float64 arrays.

    Of ``fraction`` and of ``level``, both at first that of the particles; applied to its own
    results it smooths them.  The weights of
    :func:`debrisflow.physics.concentration.concentration` and of
    :func:`debrisflow.physics.concentration.level_concentration`, which says what each is for.
    """
    for block in prange((around.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, around.size)
        _concentrations(first, last, fraction, level, down, fluid, near, numbers, around, at_level)


@loop
def collide_grains(c, grains, n0, n, temperature, pressure, viscosity):
    """Write the pressure, Pa, of colliding grains and add their viscosity, Pa s, to what is there.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles,
    which then hang as sheets.
    """
    for i in prange(n.size):
        inside = min(max(5.0 * (n[i] / n0 - 0.8), 0.0), 1.0)
        pressure[i] = inside * granular_pressure(c[i], temperature[i], grains)
        viscosity[i] += granular_viscosity(c[i], temperature[i], grains)
