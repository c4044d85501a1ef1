"""Implicit exchange of momentum by viscosity and strength, and the static balance of grains.

Both are linear systems over the pairs of a weakly compressible fluid, kept as one coefficient per
listed neighbor.  Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import (
    BLOCK,
    coupling_weight,
    height_over,
    inverse_distance,
    separation,
    wall_factor,
    weight,
)
from debrisflow.physics.images import image_weight
from debrisflow.physics.rheology import (
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


class Couplings(NamedTuple):
    """Rows ``diagonal_i x_i - sum of value_ij x_j`` over the fluid neighbors of each particle.

    Attributes
    ----------
    value : (n, capacity) float32 array
        In the order of the list of neighbors.
    diagonal : (n,) float64 array
    is_free : (n,) bool array
        False where x is given.
    """

    value: NDArray[np.float32]
    diagonal: Floats
    is_free: NDArray[np.bool_]


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
def wall_drag_at(i, fluid, solid, near, flow, law, down, numbers):
    """Return the sum of ``(2 Ds/n0) w/r^2 mu_ij`` over the no-slip walls of particle i.

    Times the factor by which the velocity is mirrored, in kg/(m3 s).  The strength on the wall is
    that at the depth between the two, at the shear rate of a straight profile down to the wall.
    """
    drag = 0.0
    u, v, w = fluid.velocity[i, 0], fluid.velocity[i, 1], fluid.velocity[i, 2]
    gradient = gradient_of(i, flow.gradient)
    for k in range(near.wall_count[i]):
        j = np.uint32(near.wall[near.wall_row[i], k])
        dx, dy, dz = separation(i, j, fluid.position, solid.position, near.period)
        height = height_over(dx, dy, dz, j, solid)
        per_height = 1.0 / max(height, 0.5 * numbers.spacing)
        du, dv, dw = per_height * u, per_height * v, per_height * w
        nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
        rate = pair_shear_rate(gradient, gradient, nx, ny, nz, 1.0, du, dv, dw)
        depth = 0.5 * (down[0] * dx + down[1] * dy + down[2] * dz)
        strength = max(flow.strength[i] + depth * flow.deepening[i], 0.0)
        mu = yielding_viscosity(flow.ramp[i] * strength, rate, law)
        mu += flow.ramp[i] * mean_power_law_viscosity(i, i, flow.consistency, rate, law)
        mu += flow.viscosity[i]
        mu *= wall_factor(height, j, solid, numbers) * (1.0 - solid.slip[j])
        drag += coupling_weight(inverse_distance(dx, dy, dz, numbers), numbers) * mu
    return drag


@kernel
def _add_images(i, fluid, near, mirrors, numbers, value):
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, fluid.position, fluid.position, near.period)
        w = coupling_weight(inverse_distance(dx, dy, dz, numbers), numbers)
        if w > 0.0:
            value[i, k] *= np.float32(1.0 + image_weight(i, j, dx, dy, dz, mirrors, numbers) / w)


@kernel
def _couple_momentum(
    first, last, dt, fluid, solid, near, flow, mirrors, law, down, numbers, value, diagonal
):
    velocity = fluid.velocity
    for i in range(first, last):
        u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        gradient = gradient_of(i, flow.gradient)
        for k in range(near.fluid_count[i]):
            j = np.uint32(near.fluid[i, k])
            dx, dy, dz = separation(i, j, fluid.position, fluid.position, near.period)
            inverse = inverse_distance(dx, dy, dz, numbers)
            du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
            other = gradient_of(j, flow.gradient)
            rate = pair_shear_rate(gradient, other, dx, dy, dz, inverse, du, dv, dw)
            mu = pair_viscosity(i, j, rate, flow, law)
            value[i, k] = np.float32(dt * coupling_weight(inverse, numbers) * mu)
        if mirrors.height[i] < numbers.effective_radius:
            _add_images(i, fluid, near, mirrors, numbers, value)
        total = 0.0
        for k in range(near.fluid_count[i]):
            total += value[i, k]
        drag = wall_drag_at(i, fluid, solid, near, flow, law, down, numbers)
        diagonal[i] = flow.density[i] + total + dt * drag


@loop
def couple_momentum(dt, fluid, solid, near, flow, mirrors, law, down, numbers, couplings):
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
            fluid,
            solid,
            near,
            flow,
            mirrors,
            law,
            down,
            numbers,
            couplings.value,
            couplings.diagonal,
        )


@kernel
def _couple_grains(first, last, fluid, near, c, gravity, numbers, couplings, right):
    for i in range(first, last):
        diagonal, pushed = 0.0, 0.0
        for k in range(near.fluid_count[i]):
            j = np.uint32(near.fluid[i, k])
            dx, dy, dz = separation(i, j, fluid.position, fluid.position, near.period)
            inverse = inverse_distance(dx, dy, dz, numbers)
            inside = 1.0 if weight(inverse, numbers) > 0.0 else 0.0
            a = inside * numbers.spacing**3 * inverse * inverse * inverse
            couplings.value[i, k] = np.float32(a)
            diagonal += couplings.value[i, k]
            fall = gravity[0] * dx + gravity[1] * dy + gravity[2] * dz
            pushed -= couplings.value[i, k] * 0.5 * (c[i] + c[j]) * fall
        couplings.diagonal[i] = max(diagonal, 1e-6)
        right[i, 0] = pushed


@loop
def couple_grains(fluid, near, c, submerged_gravity, numbers, couplings, right):
    """Write the static balance of the buoyant grains, and its right side, (n, 1) float64 array.

        sum of a_ij [ (p_j - p_i) - b_ij . r_ij ] = 0,   a_ij = (d0 / r)^3,
        b_ij = (C_i + C_j)/2 (rho_s - rho_l) g

    As :func:`debrisflow.physics.grain_pressure.grain_pressure_row_at` says.  Walls are left out:
    the pressure of what the wall would hold is that which the balance asks for.
    """
    n = couplings.diagonal.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _couple_grains(first, last, fluid, near, c, submerged_gravity, numbers, couplings, right)


@kernel
def _apply(first, last, couplings, near, p, q):
    """Write ``q = A p``, 0 where x is given, and return the inner product of both."""
    inner = 0.0
    for i in range(first, last):
        if p.shape[1] == 3:
            x, y, z = 0.0, 0.0, 0.0
            for k in range(near.fluid_count[i]):
                j = np.uint32(near.fluid[i, k])
                a = couplings.value[i, k]
                x, y, z = x + a * p[j, 0], y + a * p[j, 1], z + a * p[j, 2]
            q[i, 0] = couplings.diagonal[i] * p[i, 0] - x
            q[i, 1] = couplings.diagonal[i] * p[i, 1] - y
            q[i, 2] = couplings.diagonal[i] * p[i, 2] - z
        else:
            x = 0.0
            for k in range(near.fluid_count[i]):
                x += couplings.value[i, k] * p[np.uint32(near.fluid[i, k]), 0]
            q[i, 0] = couplings.diagonal[i] * p[i, 0] - x
        for a in range(p.shape[1]):
            q[i, a] = q[i, a] if couplings.is_free[i] else 0.0
            inner += p[i, a] * q[i, a]
    return inner


@loop
def _multiply(couplings, near, p, q, partial):
    n = p.shape[0]
    for block in prange(partial.shape[0]):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        partial[block, 0] = _apply(first, last, couplings, near, p, q)


@loop
def _begin(couplings, right, x, rest, p):
    """Write the residual, from ``rest = A x``, and the step p of Jacobi's iteration."""
    for i in prange(x.shape[0]):
        for a in range(x.shape[1]):
            r = right[i, a] - rest[i, a] if couplings.is_free[i] else 0.0
            rest[i, a] = r
            p[i, a] = r / couplings.diagonal[i]


@loop
def _advance(couplings, alpha, p, q, x, rest, partial):
    """Go on by alpha along p, q = A p; write the sums of ``rest^2`` and of ``rest z`` by blocks."""
    n = x.shape[0]
    for block in prange(partial.shape[0]):
        square, inner = 0.0, 0.0
        for i in range(block * BLOCK, min(block * BLOCK + BLOCK, n)):
            for a in range(x.shape[1]):
                x[i, a] += alpha * p[i, a]
                r = rest[i, a] - alpha * q[i, a]
                rest[i, a] = r
                square += r * r
                inner += r * r / couplings.diagonal[i]
        partial[block, 0] = square
        partial[block, 1] = inner


@loop
def _turn(couplings, rest, beta, p):
    for i in prange(p.shape[0]):
        for a in range(p.shape[1]):
            p[i, a] = rest[i, a] / couplings.diagonal[i] + beta * p[i, a]


@kernel
def solve(couplings, near, right, goal, most, x):
    """Solve for x, (n, m) float64 array, by conjugate gradients from the start that it holds.

    A first step of Jacobi's iteration takes a particle that touches nothing to its solution,
    however few such there are; the criterion, a mean, would not see them.  Then until the sum of
    the squared residual is not above the goal.  Sums run over blocks of a fixed size, so that the
    result has the same bits on any number of threads.

    Returns
    -------
    int
        Iterations, or -1 if ``most`` did not suffice.
    """
    partial = np.zeros(((x.shape[0] + BLOCK - 1) // BLOCK, 2))
    rest, p, q = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    _multiply(couplings, near, x, rest, partial)
    _begin(couplings, right, x, rest, p)
    _multiply(couplings, near, p, q, partial)
    _advance(couplings, 1.0, p, q, x, rest, partial)
    square, inner, beta = partial[:, 0].sum(), partial[:, 1].sum(), 0.0
    for iteration in range(1, most + 1):
        if square <= goal:
            return iteration
        _turn(couplings, rest, beta, p)
        _multiply(couplings, near, p, q, partial)
        curvature = partial[:, 0].sum()
        if not curvature > 0.0:
            return -1
        _advance(couplings, inner / curvature, p, q, x, rest, partial)
        square, last = partial[:, 0].sum(), inner
        inner = partial[:, 1].sum()
        beta = inner / last
    return -1
