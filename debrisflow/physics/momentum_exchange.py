"""Implicit exchange of momentum between particles by viscosity and strength.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, coupling_weight, fluid_pair, laplacian_factor, weight
from debrisflow.neighbors.wall_access import height_over, velocity_of, wall_factor, wall_pair
from debrisflow.physics.images import image_weight
from debrisflow.physics.rheology import (
    consistency_viscosity,
    harmonic_mean,
    power_law_viscosity,
    ramp,
    yield_strength,
    yielding_viscosity,
)
from debrisflow.physics.turbulence import turbulent_viscosity

Floats = NDArray[np.float64]
ASIDE = 0.01
"""Share of the squared shear rate around two particles that is added to both squares of what they
see of it, see :func:`pair_shear_rate`.  Films of ten rows are as exact with 0.1, and with 0.3 have
plugs that are 2 % faster."""


class Matter(NamedTuple):
    """What the particles are and how they move, as far as the exchange of momentum needs it.

    Attributes
    ----------
    velocity : (n, 3) float64 array, m/s
        Of the mixture: that of the particle's phase less its slip.
    density : (n,) float64 array, kg/m3
    viscosity : (n,) float64 array, Pa s
        Newtonian viscosity of the particle's phase.
    turbulent_viscosity : (fluid particles,) float64 array, Pa s
    concentration : (fluid particles,) float64 array
        C at the level of the particle, which decides whether grains touch.
    shear_rate : (fluid particles,) float64 array, 1/s
    grain_pressure : (n,) float64 array, Pa
        Effective pressure between the grains of the bed.
    """

    velocity: Floats
    density: Floats
    viscosity: Floats
    turbulent_viscosity: Floats
    concentration: Floats
    shear_rate: Floats
    grain_pressure: Floats


@kernel
def strength_viscosity(pressure, c, shear_rate, law):
    """Return the viscosity of what yields at the strength of the law, with its ramp, Pa s."""
    share = ramp(c, law)
    if share == 0.0:
        return 0.0
    strength = yield_strength(pressure, c, shear_rate, law)
    return share * yielding_viscosity(strength, shear_rate, law)


@kernel
def smooth_viscosity(i, eddies, matter, law):
    """Return the viscosity of particle i but for its strength, Pa s: Newtonian, eddies, slurry."""
    c, newtonian = matter.concentration[i], matter.viscosity[i] + eddies
    return newtonian + ramp(c, law) * consistency_viscosity(c, matter.shear_rate[i], law)


@kernel
def exchange_row_at(i, dt, matter, law, near, solid, system, right):
    """Write row i of the implicit exchange of momentum after the pressure projection.

    rho_i u_i + dt sum of K_ij (u_i - u_j) = rho_i u**_i
        K_ij = (2 Ds / (lambda n0)) w eta_ij

    eta_ij is the harmonic mean of :func:`smooth_viscosity` plus :func:`strength_viscosity` at the
    pair's mean pressure, shear rate and lesser concentration.  K is symmetric:
    what one particle loses the other gains.
    Coefficients are taken at the velocities given, one pass.  Walls and inflow have their own
    velocity; a wall's is mirrored as in
    :func:`debrisflow.neighbors.wall_access.wall_velocity_difference`, and with a free-slip wall
    nothing is exchanged.  With a rough wall turbulence exchanges nothing here: that is the law of
    the wall, see :mod:`debrisflow.physics.wall_friction`.  Between the lowest two rows the pairs
    that would reach into the wall are missing, so that a profile of even viscosity rises there by
    half more than it should.
    """
    factor = laplacian_factor(near)
    velocity, density, c = matter.velocity, matter.density, matter.concentration
    shear_rate, grain_pressure = matter.shear_rate, matter.grain_pressure
    mu_i = smooth_viscosity(i, matter.turbulent_viscosity[i], matter, law)
    bare = smooth_viscosity(i, 0.0, matter, law)
    diagonal, entries = density[i], 0
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        if j < near.supply_from:
            mu_j = smooth_viscosity(j, matter.turbulent_viscosity[j], matter, law)
            p = 0.5 * (grain_pressure[i] + grain_pressure[j])
            rate = 0.5 * (shear_rate[i] + shear_rate[j])
            eta = harmonic_mean(mu_i, mu_j) + strength_viscosity(p, min(c[i], c[j]), rate, law)
            coupling = dt * factor * weight(inverse, near) * eta
            system.columns[i, entries], system.value[i, entries] = j, coupling
            entries += coupling > 0.0
        else:
            coupling = dt * factor * weight(inverse, near) * mu_i
            x += coupling * velocity[j, 0]
            y += coupling * velocity[j, 1]
            z += coupling * velocity[j, 2]
        diagonal += coupling
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        p = grain_pressure[i]
        if k < near.pressed_count[i]:
            p = 0.5 * (p + grain_pressure[near.wall_from + j])
        eta = bare if solid.roughness[j] > 0.0 else mu_i
        eta += strength_viscosity(p, c[i], shear_rate[i], law)
        eta *= wall_factor(height_over(dx, dy, dz, j, solid), j, solid, near)
        coupling = dt * factor * weight(inverse, near) * eta * (1.0 - solid.slip[j])
        wall_u, wall_v, wall_w = velocity_of(j, solid.velocity)
        x, y, z = x + coupling * wall_u, y + coupling * wall_v, z + coupling * wall_w
        diagonal += coupling
    system.entries[i] = entries
    system.diagonal[i] = diagonal
    right[i, 0] = density[i] * velocity[i, 0] + x
    right[i, 1] = density[i] * velocity[i, 1] + y
    right[i, 2] = density[i] * velocity[i, 2] + z


@kernel
def _assemble(first, last, dt, matter, law, near, solid, system, right):
    for i in range(first, last):
        exchange_row_at(i, dt, matter, law, near, solid, system, right)


@loop
def assemble_exchange(dt, matter, law, near, solid, system, right):
    """Write the implicit exchange of momentum for every fluid particle.

    A neighbor whose velocity is given has a part in the right side, (n, 3) float64 array.
    """
    n = near.supply_from
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _assemble(first, last, dt, matter, law, near, solid, system, right)


class Flow(NamedTuple):
    """What resists the shear of the particles.

    Attributes
    ----------
    density : (n,) float64 array, kg/m3
    concentration : (n,) float64 array
        C at the level of the particle.
    consistency : (n,) float64 array, Pa s^n, or None
        None where the law has none, for which kernels are compiled that are faster.
    viscosity : (n,) float64 array, Pa s
        All but that of the law of strength.
    strength : (n,) float64 array, Pa
        Yield strength where grains are packed.
    deepening : (n,) float64 array, Pa/m
        Growth of the strength with the depth, by the weight of the grains.
    ramp : (n,) float64 array
        Share of the strength that the concentration leaves.
    shear_rate : (n,) float64 array, 1/s
    gradient : (n, 9) float32 array, 1/s
        Velocity gradient by rows.
    least_viscosity : float, Pa s
        Between two particles: the artificial one, which adds nothing to what is more viscous.
    """

    density: Floats
    concentration: Floats
    consistency: Floats | None
    viscosity: Floats
    strength: Floats
    deepening: Floats
    ramp: Floats
    shear_rate: Floats
    gradient: NDArray[np.float32]
    least_viscosity: float


@kernel
def resist_at(i, pressure, deeper, spacing, mixing_length, law, flow):
    """Write strength, deepening and ramp of particle i, and add the viscosity of its eddies."""
    c, shear_rate = flow.concentration[i], flow.shear_rate[i]
    flow.ramp[i] = ramp(c, law)
    flow.strength[i] = yield_strength(pressure, c, shear_rate, law)
    flow.deepening[i] = (yield_strength(deeper, c, shear_rate, law) - flow.strength[i]) / spacing
    flow.viscosity[i] += turbulent_viscosity(flow.density[i], mixing_length, shear_rate)


@loop
def resist(pressure, weight, spacing, mixing_length, law, flow):
    """Write what resists the shear of every particle into a flow that holds the other viscosities.

    ``pressure``, Pa, is that between grains, ``weight``, N/m3, what they carry.
    """
    for i in prange(pressure.size):
        deeper = pressure[i] + spacing * weight[i]
        resist_at(i, pressure[i], deeper, spacing, mixing_length, law, flow)


@kernel
def gradient_of(i, gradient):
    """Return the velocity gradient of particle i by rows, 1/s."""
    return (
        gradient[i, 0],
        gradient[i, 1],
        gradient[i, 2],
        gradient[i, 3],
        gradient[i, 4],
        gradient[i, 5],
        gradient[i, 6],
        gradient[i, 7],
        gradient[i, 8],
    )


@kernel
def pair_shear_rate(one, other, dx, dy, dz, inverse, du, dv, dw):
    """Return the shear rate between two particles, 1/s.

        rate = G sqrt[(|d|^2 + 0.01 G^2) / (|g a|^2 + 0.01 G^2)]

    with the mean g of their velocity gradients, its shear rate G, the unit vector a from one to the
    other, and d, the difference of their velocities over the distance: as much above G as the
    difference is above that of the mean gradient, exact in a linear shear.  The gradient alone, a
    mean over the influence radius, smears the edge of a plug over four rows, and is blind to a
    velocity that goes up and down from row to row.  Two particles beside each other in the shear,
    whose difference says nothing of it, keep G if d is less than a tenth of it; more scatter makes
    such pairs, which pass on no stress of the shear, softer.  Strays whose neighbors tell no
    gradient have |d|.

    Parameters
    ----------
    one, other : nine floats, 1/s
        Their gradients by rows.
    dx, dy, dz, inverse : float, m, 1/m
        Separation and the inverse of its length.
    du, dv, dw : float, m/s
        Difference of the velocities.
    """
    ux, uy, uz = one[0] + other[0], one[1] + other[1], one[2] + other[2]
    vx, vy, vz = one[3] + other[3], one[4] + other[4], one[5] + other[5]
    wx, wy, wz = one[6] + other[6], one[7] + other[7], one[8] + other[8]
    square = 0.5 * (ux * ux + vy * vy + wz * wz)
    square += 0.25 * ((uy + vx) ** 2 + (uz + wx) ** 2 + (vz + wy) ** 2)
    ax = ux * dx + uy * dy + uz * dz
    ay = vx * dx + vy * dy + vz * dz
    az = wx * dx + wy * dy + wz * dz
    least = ASIDE * square
    own = inverse * inverse * (du * du + dv * dv + dw * dw) + least
    mean = 0.25 * inverse * inverse * (ax * ax + ay * ay + az * az) + least
    return np.sqrt(square / mean * own if mean > 1e-300 else own)


@kernel
def mean_power_law_viscosity(i, j, consistency, rate, law):
    """Return the viscosity of the mean consistency of two particles, Pa s."""
    if consistency is None:
        return 0.0
    return power_law_viscosity(0.5 * (consistency[i] + consistency[j]), rate, law)


@kernel
def pair_viscosity(i, j, rate, flow, law):
    """Return the viscosity between two particles at their shear rate, Pa s.

    The mean of their viscosities, and the mean strength and consistency at the lesser ramp: the
    mean of the strengths, not of apparent viscosities, makes that of the plane between two rows
    exact.  Friction that grows with the shear, and eddies, are those at the particles' own rates.
    """
    share = min(flow.ramp[i], flow.ramp[j])
    strength = share * 0.5 * (flow.strength[i] + flow.strength[j])
    viscosity = 0.5 * (flow.viscosity[i] + flow.viscosity[j])
    viscosity += share * mean_power_law_viscosity(i, j, flow.consistency, rate, law)
    return max(viscosity + yielding_viscosity(strength, rate, law), flow.least_viscosity)


@kernel
def wall_drag_at(i, velocity, near, solid, flow, law, down):
    """Return the sum of ``(2 Ds/n0) w/r^2 mu_ij`` over the no-slip walls of particle i.

    Times the factor by which the velocity is mirrored, in kg/(m3 s).  The strength on the wall is
    that at the depth between the two, at the shear rate of a straight profile down to the wall.
    """
    drag = 0.0
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    gradient = gradient_of(i, flow.gradient)
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        height = height_over(dx, dy, dz, j, solid)
        per_height = 1.0 / max(height, 0.5 * near.spacing)
        du, dv, dw = per_height * u, per_height * v, per_height * w
        nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
        rate = pair_shear_rate(gradient, gradient, nx, ny, nz, 1.0, du, dv, dw)
        depth = 0.5 * (down[0] * dx + down[1] * dy + down[2] * dz)
        strength = max(flow.strength[i] + depth * flow.deepening[i], 0.0)
        mu = yielding_viscosity(flow.ramp[i] * strength, rate, law)
        mu += flow.ramp[i] * mean_power_law_viscosity(i, i, flow.consistency, rate, law)
        mu += flow.viscosity[i]
        mu *= wall_factor(height, j, solid, near) * (1.0 - solid.slip[j])
        drag += coupling_weight(inverse, near) * mu
    return drag


@kernel
def _add_images(i, near, mirrors, value):
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        w = coupling_weight(inverse, near)
        if w > 0.0:
            value[i, k] *= np.float32(1.0 + image_weight(i, j, dx, dy, dz, mirrors, near) / w)


@kernel
def _couple_momentum(
    first, last, dt, velocity, near, solid, flow, mirrors, law, down, value, diagonal
):
    for i in range(first, last):
        u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        gradient = gradient_of(i, flow.gradient)
        for k in range(near.fluid_count[i]):
            j, dx, dy, dz, inverse = fluid_pair(i, k, near)
            du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
            other = gradient_of(j, flow.gradient)
            rate = pair_shear_rate(gradient, other, dx, dy, dz, inverse, du, dv, dw)
            mu = pair_viscosity(i, j, rate, flow, law)
            value[i, k] = np.float32(dt * coupling_weight(inverse, near) * mu)
        if mirrors.height[i] < near.effective_radius:
            _add_images(i, near, mirrors, value)
        total = 0.0
        for k in range(near.fluid_count[i]):
            total += value[i, k]
        drag = wall_drag_at(i, velocity, near, solid, flow, law, down)
        diagonal[i] = flow.density[i] + total + dt * drag


@loop
def couple_momentum(dt, velocity, near, solid, flow, mirrors, law, down, couplings):
    """Write the rows of the implicit exchange of momentum.

        rho_i u_i + dt sum of K_ij (u_i - u_j) = rho_i u*_i,
        K_ij = (2 Ds/n0) w/r^2 mu_ij

    K is symmetric: what one particle loses the other gains.  Coefficients are those of the
    velocities before the step, one pass.  A no-slip wall is at rest, its velocity mirrored; behind
    a free-slip wall stand images of the fluid.
    """
    n = couplings.diagonal.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _couple_momentum(
            first,
            last,
            dt,
            velocity,
            near,
            solid,
            flow,
            mirrors,
            law,
            down,
            couplings.value,
            couplings.diagonal,
        )
