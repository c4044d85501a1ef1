"""Implicit exchange of momentum between particles by viscosity and strength.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, coupling_weight, fluid_pair
from debrisflow.neighbors.wall_access import stick_at, stick_count
from debrisflow.physics.images import image_weight
from debrisflow.physics.rheology import (
    harmonic_mean,
    power_law_viscosity,
    ramp,
    yield_strength,
    yielding_viscosity,
)

Floats = NDArray[np.float64]
ASIDE = 0.01
"""Share of the squared shear rate around two particles that is added to both squares of what they
see of it, see :func:`pair_shear_rate`.  Films of ten rows are as exact with 0.1, and with 0.3 have
plugs that are 2 % faster."""


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
        All but that of the rheological law: Newtonian, of colliding grains, of eddies.
    eddies : (n,) float64 array, Pa s
        That of eddies, which exchange nothing with a rough wall: that is the law of the wall, see
        :mod:`debrisflow.physics.wall_friction`.
    strength : (n,) float64 array, Pa
        Yield strength where grains are packed.
    deepening : (n,) float64 array, Pa/m
        Growth of the strength with the depth, by the weight of the grains.
    ramp : (n,) float64 array
        Share of the strength that the concentration leaves.
    shear_rate : (n,) float64 array, 1/s
    gradient : (n, 9) float32 array, 1/s, or None
        Velocity gradient by rows; None where a pair yields at the mean shear rate of its two
        particles, see :func:`rate_between`.
    least_viscosity : float, Pa s
        A lower bound on the pair viscosity: the artificial one of a weakly compressible fluid.
    """

    density: Floats
    concentration: Floats
    consistency: Floats | None
    viscosity: Floats
    eddies: Floats
    strength: Floats
    deepening: Floats
    ramp: Floats
    shear_rate: Floats
    gradient: NDArray[np.float32] | None
    least_viscosity: float


@kernel
def resist_at(i, pressure, deeper, spacing, law, flow):
    """Write strength, deepening and ramp of particle i."""
    c, shear_rate = flow.concentration[i], flow.shear_rate[i]
    flow.ramp[i] = ramp(c, law)
    flow.strength[i] = yield_strength(pressure, c, shear_rate, law)
    flow.deepening[i] = (yield_strength(deeper, c, shear_rate, law) - flow.strength[i]) / spacing


@kernel
def _resist(first, last, pressure, weight, spacing, law, flow):
    for i in range(first, last):
        resist_at(i, pressure[i], pressure[i] + spacing * weight[i], spacing, law, flow)


@loop
def resist(pressure, weight, spacing, law, flow):
    """Write what resists the shear of every particle into a flow that holds the other viscosities.

    ``pressure``, Pa, is that between grains, ``weight``, N/m3, what they carry.
    """
    for block in prange((pressure.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, pressure.size)
        _resist(first, last, pressure, weight, spacing, law, flow)


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
    such pairs, which pass on no stress of the shear, softer.  For
    isolated particles without a usable velocity gradient |d| is used.

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
def rate_between(i, j, dx, dy, dz, inverse, du, dv, dw, gradient, shear_rate):
    """Return the shear rate at which two particles yield, 1/s.

    That of :func:`pair_shear_rate`; without gradients the mean of the shear rates around the two,
    which does not see the scatter of single particles.  A bed of grains under the pressure of an
    incompressible fluid needs that: one degree below its limit slope of 18 degrees it moved by
    0.5 d0 in 2 s where pairs yielded at their own rate, which that scatter raises, and by 0.01 d0
    at the mean rate.
    """
    if gradient is None:
        return 0.5 * (shear_rate[i] + shear_rate[j])
    else:
        one, other = gradient_of(i, gradient), gradient_of(j, gradient)
        return pair_shear_rate(one, other, dx, dy, dz, inverse, du, dv, dw)


@kernel
def mean_power_law_viscosity(i, j, consistency, rate, law):
    """Return the viscosity of the mean consistency of two particles, Pa s."""
    if consistency is None:
        return 0.0
    return power_law_viscosity(0.5 * (consistency[i] + consistency[j]), rate, law)


@kernel
def pair_viscosity(i, j, rate, flow, law):
    """Return the viscosity between two particles at their shear rate, Pa s.

    The harmonic mean of their viscosities, which is that of the plane between two layers whether
    the viscosity changes there smoothly or by a jump, and the mean strength and consistency at the
    lesser ramp: the mean of the strengths, not of apparent viscosities, makes that of the plane
    between two rows exact.  Friction that grows with the shear, and eddies, are those at the
    particles' own rates.
    """
    share = min(flow.ramp[i], flow.ramp[j])
    strength = share * 0.5 * (flow.strength[i] + flow.strength[j])
    viscosity = harmonic_mean(flow.viscosity[i], flow.viscosity[j])
    viscosity += share * mean_power_law_viscosity(i, j, flow.consistency, rate, law)
    return max(viscosity + yielding_viscosity(strength, rate, law), flow.least_viscosity)


@kernel
def wall_drag_at(i, velocity, near, solid, flow, law, down):
    """Return the sum of ``(2 Ds/n0) w/r^2 mu_ij`` over the no-slip walls of particle i.

    Times the factor by which the velocity is mirrored, in kg/(m3 s); and the same sum of the
    velocities of the walls, N/m3.  The strength on the wall is
    that at the depth between the two, at the shear rate of a straight profile down to the wall.
    """
    drag, x, y, z = 0.0, 0.0, 0.0, 0.0
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    for k in range(stick_count(i, near, solid)):
        pull, height, nx, ny, nz, dx, dy, dz, roughness, wall_u, wall_v, wall_w = stick_at(
            i, k, near, solid
        )
        per_height = 1.0 / height
        du, dv, dw = u - wall_u, v - wall_v, w - wall_w
        du, dv, dw = per_height * du, per_height * dv, per_height * dw
        rate = rate_between(i, i, nx, ny, nz, 1.0, du, dv, dw, flow.gradient, flow.shear_rate)
        depth = 0.5 * (down[0] * dx + down[1] * dy + down[2] * dz)
        strength = max(flow.strength[i] + depth * flow.deepening[i], 0.0)
        mu = yielding_viscosity(flow.ramp[i] * strength, rate, law)
        mu += flow.ramp[i] * mean_power_law_viscosity(i, i, flow.consistency, rate, law)
        mu += flow.viscosity[i] - (flow.eddies[i] if roughness > 0.0 else 0.0)
        pull *= mu
        drag += pull
        x, y, z = x + pull * wall_u, y + pull * wall_v, z + pull * wall_w
    return drag, x, y, z


@kernel
def _add_images(i, near, mirrors, value):
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        w = coupling_weight(inverse, near)
        if w > 0.0:
            value[i, k] *= np.float32(1.0 + image_weight(i, j, dx, dy, dz, mirrors, near) / w)


@kernel
def _couple_momentum(
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
    value,
    diagonal,
    right,
    drags,
):
    for i in range(first, last):
        u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        for k in range(near.fluid_count[i]):
            j, dx, dy, dz, inverse = fluid_pair(i, k, near)
            du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
            rate = rate_between(
                i, j, dx, dy, dz, inverse, du, dv, dw, flow.gradient, flow.shear_rate
            )
            mu = pair_viscosity(i, j, rate, flow, law)
            value[i, k] = np.float32(dt * coupling_weight(inverse, near) * mu)
        if mirrors.height[i] < near.effective_radius:
            _add_images(i, near, mirrors, value)
        total = 0.0
        for k in range(near.fluid_count[i]):
            total += value[i, k]
        drag, x, y, z = wall_drag_at(i, velocity, near, solid, flow, law, down)
        diagonal[i] = flow.density[i] + total + dt * drag
        drags[i] = dt * drag
        right[i, 0] += dt * x
        right[i, 1] += dt * y
        right[i, 2] += dt * z


@loop
def couple_momentum(dt, velocity, near, solid, flow, mirrors, law, down, couplings, right, drags):
    """Write the rows of the implicit exchange of momentum, and add the walls to the right side.

        rho_i u_i + dt sum of K_ij (u_i - u_j) = rho_i u*_i,
        K_ij = (2 Ds/n0) w/r^2 mu_ij

    K is symmetric: what one particle loses the other gains.  Coefficients are those of the
    velocities before the step, one pass.  A no-slip wall has its own velocity, mirrored; behind
    a free-slip wall stand images of the fluid.  ``drags``, (n,) array, kg/m3, is what the no-slip
    walls have of the diagonal.
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
            right,
            drags,
        )
