"""Slip between sediment and water: drag, velocity of the mixture, exchange of places.

Particles of both phases fill one lattice-like arrangement.  A particle of rock that sank through
it by its own velocity would have to push its neighbors aside: the pressure between particles holds
it like a cage, and a column of 10 % of sediment settles at a sixth of the right speed and less and
less, whatever the drag.  So the arrangement moves with the mixture, ``v_i = u_i - s_i``, whose
pressure equation this is, and the displacement that a particle still lacks is made up by swapping
places with a particle of the other phase.  Nothing is pushed aside: volume, masses and momentum are
conserved to the particle, and the place of a particle is that of its own path but for at most two
spacings, unless a packing holds it: what it is owed beyond is dropped.

The slip ``s_i = (f_i - C_i) u_r`` follows from the velocity u_r of the sediment relative to the
water, which the particles carry (f is 1 in sediment, 0 in water): its volume mean is zero, but for
the edges of the fluid.

    du_r/dt = (1/rho_l - 1/rho_s) <grad p> + <-div P_s / rho_s> - K [(1 - C)/rho_s + C/rho_l] u_r

with means over the influence radius, K = beta / (C (1 - C)) of the drag law.  At rest this is the
balance of drag and buoyant weight, which with Wen & Yu's drag is nearly the settling of Richardson
& Zaki.

What it cannot do: grains that touch, from 0.9 of the packing limit on, hardly slip, so that the
water of a packed bed stays in it; neither drainage nor excess pore pressure is resolved.  The
relative velocity starts at zero and answers to pressure and collisions of grains alone: phases that
differ in velocity for another reason are brought together by the arrangement, faster than by drag.
The buoyancy is that of the sum-form gradient in every scheme, for the study's is zero on a lattice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, fluid_pair, weight
from debrisflow.physics.concentration import SELF_WEIGHT
from debrisflow.physics.drag import drag_coefficient, freedom
from debrisflow.physics.operators import fluid_gradient_at, gradient_at
from debrisflow.physics.wall_push import wall_push_at

Floats = NDArray[np.float64]
PLACES_WITHIN = 1.6  # spacings between particles that exchange places
ROOM_OF_HELD = 0.2  # share of the packing limit by which room has to open for what was held
MOST_OWED = 2.0  # spacings; what is owed this much is held by its neighbors


class Surroundings(NamedTuple):
    """What stands around the fluid particles, (n,) float64 arrays.

    Attributes
    ----------
    share : share of sediment among the others in reach, by weight
    weight : sum of weights of the fluid in reach
    concentration : C of the drag law, smoothed once, without the bias of the particle itself
    """

    share: Floats
    weight: Floats
    concentration: Floats


@kernel
def surroundings_at(i, fraction, near):
    """Return share and weight of :class:`Surroundings`, and how much of C_i is i's own.

    The smoothed concentration counts the particle itself ``(4 + sum of w^2) / (2 + sum of w)^2``,
    where all in reach have the same sum of weights.
    """
    share, total, squares = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        w = weight(inverse, near) if j < near.supply_from else 0.0
        total += w
        squares += w * w
        share += w * fraction[j]
    own = (SELF_WEIGHT**2 + squares) / (SELF_WEIGHT + total) ** 2
    return (share / total if total > 0.0 else fraction[i]), total, own


@kernel
def _survey_surroundings(first, last, fraction, smoothed, near, share, weights, c):
    for i in range(first, last):
        share[i], weights[i], own = surroundings_at(i, fraction, near)
        own = min(own, 0.5)
        c[i] = min(max((smoothed[i] - own * fraction[i]) / (1.0 - own), 0.0), 1.0)


@loop
def survey_surroundings(fraction, smoothed, near, share, weights, c):
    """Write the arrays of :class:`Surroundings` from phases and smoothed concentration."""
    n = share.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _survey_surroundings(first, last, fraction, smoothed, near, share, weights, c)


@kernel
def _pressure_gradient(first, last, pressure, near, solid, gradient):
    for i in range(first, last):
        gradient[i, 0], gradient[i, 1], gradient[i, 2] = gradient_at(i, pressure, True, near, solid)


@loop
def pressure_gradient(pressure, near, solid, gradient):
    """Write the sum-form gradient of the pressure, (n, 3) float64 array, Pa/m."""
    n = gradient.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _pressure_gradient(first, last, pressure, near, solid, gradient)


@kernel
def _pressure_gradient_before_surfaces(first, last, pressure, density, g, near, solid, gradient):
    for i in range(first, last):
        x, y, z = fluid_gradient_at(i, pressure, near)
        a, b, c = wall_push_at(i, pressure, density[i], g, g[0], g[1], g[2], 0.0, near, solid)
        gradient[i, 0], gradient[i, 1], gradient[i, 2] = x - a, y - b, z - c


@loop
def pressure_gradient_before_surfaces(pressure, density, gravity, near, solid, gradient):
    """Write the same before walls that are surfaces, in which the fluid is as at rest."""
    n = gradient.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _pressure_gradient_before_surfaces(
            first, last, pressure, density, gravity, near, solid, gradient
        )


@kernel
def mean_at(i, values, chosen, near):
    """Return the weighted mean of vectors over the chosen particles in reach, i itself twice."""
    total = SELF_WEIGHT * chosen[i]
    x, y, z = total * values[i, 0], total * values[i, 1], total * values[i, 2]
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        if j < near.supply_from:
            w = weight(inverse, near) * chosen[j]
            total += w
            x += w * values[j, 0]
            y += w * values[j, 1]
            z += w * values[j, 2]
    if total == 0.0:
        return 0.0, 0.0, 0.0
    return x / total, y / total, z / total


@kernel
def room_at(i, part, owed, spacing, u_r):
    """Return 1, or less the more a particle is owed of the way that it slips, down to 1e-4.

    A grain that lies on a packed bed finds no room to go; its slip has to end, smoothly, since a
    slip that comes and goes would shake the bed until it creeps.
    """
    along = owed[i, 0] * u_r[i, 0] + owed[i, 1] * u_r[i, 1] + owed[i, 2] * u_r[i, 2]
    if along * part[i] <= 0.0:
        return 1.0
    length = np.sqrt(owed[i, 0] ** 2 + owed[i, 1] ** 2 + owed[i, 2] ** 2)
    return freedom(length, MOST_OWED * spacing)


@kernel
def advance_at(i, dt, drive, resistance, c, drag, u_r):
    """Advance u_r of particle i by a step.

    Implicit in u_r with the coefficient at the old speed, so that no step is too long for it.
    """
    rate = resistance * ((1.0 - c) / drag.grain_density + c / drag.density)
    kept = 1.0 / (1.0 + dt * rate)
    for axis in range(3):
        u_r[i, axis] = kept * (u_r[i, axis] + dt * drive[axis])


@kernel
def drive_at(i, gradient, everywhere, thrown, fraction, drag, near):
    """Return what accelerates the grains against the water, m/s2.

    ``thrown`` is the acceleration of the grains by collisions, without rows where there are none.
    """
    x, y, z = mean_at(i, gradient, everywhere, near)
    buoyancy = 1.0 / drag.density - 1.0 / drag.grain_density
    x, y, z = buoyancy * x, buoyancy * y, buoyancy * z
    if thrown.shape[0] > 0:
        gx, gy, gz = mean_at(i, thrown, fraction, near)
        x += gx
        y += gy
        z += gz
    return x, y, z


@kernel
def _advance(
    first,
    last,
    dt,
    gradient,
    thrown,
    fraction,
    c,
    part,
    owed,
    drag,
    near,
    u_r,
    force,
    everywhere,
):
    for i in range(first, last):
        drive = drive_at(i, gradient, everywhere, thrown, fraction, drag, near)
        speed = np.sqrt(u_r[i, 0] ** 2 + u_r[i, 1] ** 2 + u_r[i, 2] ** 2)
        resistance = drag_coefficient(c[i], speed, drag) / (
            freedom(c[i], drag.packing_limit) * room_at(i, part, owed, near.spacing, u_r)
        )
        advance_at(i, dt, drive, resistance, c[i], drag, u_r)
        force[i, 0] = resistance * u_r[i, 0]
        force[i, 1] = resistance * u_r[i, 1]
        force[i, 2] = resistance * u_r[i, 2]


@loop
def advance(dt, gradient, thrown, fraction, c, part, owed, drag, near, u_r, force):
    """Advance the relative velocity of all fluid particles and write ``K u_r``, N/m3.

    Where the grains touch or are held, K is divided by what freedom they have.
    """
    everywhere = np.ones(c.size)
    n = c.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _advance(
            first,
            last,
            dt,
            gradient,
            thrown,
            fraction,
            c,
            part,
            owed,
            drag,
            near,
            u_r,
            force,
            everywhere,
        )


@kernel
def drag_at(i, force, fraction, weights, near):
    """Return the drag on particle i, N/m3: minus ``(1 - C) K u_r`` on sediment.

        sum over the other phase of (w / W) (K_i u_r,i + K_j u_r,j) (f_j - f_i)

    W is the sum of the weights of both, at least n0; what one gains the other loses.
    """
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        if j < near.supply_from and abs(fraction[i] - fraction[j]) == 1.0:
            w = weight(inverse, near)
            share = w / max(weights[i] + weights[j], near.number_density)
            share *= fraction[j] - fraction[i]
            x += share * (force[i, 0] + force[j, 0])
            y += share * (force[i, 1] + force[j, 1])
            z += share * (force[i, 2] + force[j, 2])
    return x, y, z


@kernel
def _drag_phases(first, last, dt, force, density, fraction, weights, near, velocity):
    for i in range(first, last):
        x, y, z = drag_at(i, force, fraction, weights, near)
        velocity[i, 0] += dt * x / density[i]
        velocity[i, 1] += dt * y / density[i]
        velocity[i, 2] += dt * z / density[i]


@loop
def drag_phases(dt, force, density, fraction, weights, near, velocity):
    """Add ``dt / rho`` times the drag to the velocity of the fluid particles."""
    n = weights.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _drag_phases(first, last, dt, force, density, fraction, weights, near, velocity)


@kernel
def concentration_ahead(i, j, dx, dy, dz, fraction, near):
    """Return C at the place of j for sediment that comes from i, itself counted.

    Of the half of the surroundings that lies ahead or beside: what it leaves behind does not count,
    else the top of a bed, which sees clear water above, would pack to more than the limit.
    """
    share, total = 0.5 * SELF_WEIGHT, 0.5 * SELF_WEIGHT
    beside = -0.25 * near.spacing * np.sqrt(dx * dx + dy * dy + dz * dz)
    for k in range(near.fluid_count[j]):
        other, ox, oy, oz, inverse = fluid_pair(j, k, near)
        if other >= near.supply_from or other == i:
            continue
        if ox * dx + oy * dy + oz * dz > beside:
            w = weight(inverse, near)
            total += w
            share += w * fraction[other]
    return share / total


@kernel
def pair_up(owed, fraction, c, packing_limit, near, partner):
    """Write who exchanges places with whom, -1 for who stays, and settle what they are owed.

    ``fraction`` is brought up to the exchanges, so that the next ones know of them.

    Sediment exchanges places with the water particle that brings both nearest to their own paths,
    that is the greatest ``(owed_i - owed_j - r_ij) . r_ij > 0``, where it finds room; each particle
    at most once.  Grains that touch others do not, nor does the water between them, so that a bed
    rests and packs no further.  For a grain that is held (see :func:`room_at`) more room has to
    open, as static friction would have it.  One after the other in the order of the rows, so that
    the result does not depend on threads.
    """
    partner[:] = -1
    for i in range(partner.size):
        if fraction[i] != 1.0 or partner[i] >= 0 or freedom(c[i], packing_limit) < 1.0:
            continue
        length = np.sqrt(owed[i, 0] ** 2 + owed[i, 1] ** 2 + owed[i, 2] ** 2)
        held = 1.0 - freedom(length, MOST_OWED * near.spacing)
        limit = (1.0 - ROOM_OF_HELD * held) * packing_limit
        found, gain = -1, 0.0
        for k in range(near.fluid_count[i]):
            j, dx, dy, dz, inverse = fluid_pair(i, k, near)
            if (
                inverse * PLACES_WITHIN * near.spacing < 1.0
                or j >= near.supply_from
                or fraction[j] != 0.0
                or partner[j] >= 0
                or freedom(c[j], packing_limit) < 1.0
            ):
                continue
            nearer = (
                (owed[i, 0] - owed[j, 0] - dx) * dx
                + (owed[i, 1] - owed[j, 1] - dy) * dy
                + (owed[i, 2] - owed[j, 2] - dz) * dz
            )
            if nearer <= gain:
                continue
            there = concentration_ahead(i, j, dx, dy, dz, fraction, near)
            if there < limit:
                found, gain = k, nearer
        if found >= 0:
            j, dx, dy, dz, _ = fluid_pair(i, found, near)
            partner[i], partner[j] = j, i
            fraction[i], fraction[j] = 0.0, 1.0
            for axis, step in enumerate((dx, dy, dz)):
                owed[i, axis] -= step
                owed[j, axis] += step
