"""Exchange of momentum between particles by viscosity and friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.wall_access import contact, velocity_difference, wall_distance
from debrisflow.physics.operators import shear_rate_at
from debrisflow.physics.rheology import (
    consistency_viscosity,
    harmonic_mean,
    ramp,
    yield_strength,
    yielding_viscosity,
)
from debrisflow.physics.turbulence import mixing_length, turbulent_viscosity, wall_friction

Floats = NDArray[np.float64]


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


@loop
def survey_shear(
    velocity, density, height, roughness, greatest_length, walls, stencil, rate, viscosity
):
    """Write shear rate, 1/s, and turbulent viscosity, Pa s, of the fluid, (n,) float64 arrays.

    The viscosity is Prandtl's with the mixing length over the floor; ``height`` and ``roughness``,
    m, are those over and of the floor under every particle.  In the lowest row the shear rate is
    that of a linear profile down to the floor, up to twice that of the law of the wall; it makes up
    for part of what :func:`exchange_row_at` lacks there.
    """
    # In one loop: a short one of its own is vectorized, and its rounding depends on the threads.
    for i in prange(viscosity.size):
        rate[i] = shear_rate_at(i, velocity, walls, stencil)
        length = mixing_length(greatest_length, height[i], roughness[i])
        viscosity[i] = turbulent_viscosity(density[i], length, rate[i])


@kernel
def viscous_force_at(i, velocity, viscosity, walls, stencil):
    """Return ``div(mu grad u)`` of particle i with the pair's harmonic mean viscosity, N/m3.

    The lambda form of the Laplacian, exact for r^2 on the lattice.
    """
    r_e = stencil.effective_radius
    factor = 2.0 * stencil.dimension / (stencil.laplacian_lambda * stencil.number_density)
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        du, dv, dw = velocity_difference(i, k, velocity, walls, stencil)
        is_wall = j >= stencil.wall_from
        mu = viscosity[i] if is_wall else harmonic_mean(viscosity[i], viscosity[j])
        f = factor * mu * (r_e * stencil.inverse[i, k] - 1.0)
        x += f * du
        y += f * dv
        z += f * dw
    return x, y, z


@loop
def predict(dt, gravity, velocity, matter, thrown, is_viscous, walls, stencil, predicted):
    """Write ``u* = u + dt (g + viscous force / rho - div P_s / rho)`` of the fluid particles.

    Viscosity acts on the velocity of the mixture, which ``matter`` holds; ``velocity`` is that of
    each phase.  ``thrown`` is the acceleration by collisions, without rows where there are none.
    """
    for i in prange(predicted.shape[0]):
        x, y, z = gravity[0], gravity[1], gravity[2]
        if is_viscous:
            fx, fy, fz = viscous_force_at(i, matter.velocity, matter.viscosity, walls, stencil)
            x += fx / matter.density[i]
            y += fy / matter.density[i]
            z += fz / matter.density[i]
        if thrown.shape[0] > 0:
            x += thrown[i, 0]
            y += thrown[i, 1]
            z += thrown[i, 2]
        predicted[i, 0] = velocity[i, 0] + dt * x
        predicted[i, 1] = velocity[i, 1] + dt * y
        predicted[i, 2] = velocity[i, 2] + dt * z


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
def exchange_row_at(i, dt, fluid_count, matter, law, walls, stencil, system, right):
    """Write row i of the implicit exchange of momentum after the pressure projection.

        rho_i u_i + dt sum of K_ij (u_i - u_j) = rho_i u**_i
        K_ij = (2 Ds / (lambda n0)) w eta_ij

    eta_ij is the harmonic mean of :func:`smooth_viscosity` plus :func:`strength_viscosity` at the
    pair's mean pressure, shear rate and lesser concentration.  K is symmetric:
    what one particle loses the other gains.
    Coefficients are taken at the velocities given, one pass.  Walls and inflow have their own
    velocity; a wall's is mirrored as in :func:`velocity_difference`, and with a free-slip wall
    nothing is exchanged.  With a rough wall turbulence exchanges nothing here: that is the law of
    the wall, see :func:`rub_at`.  Between the lowest two rows the pairs that would reach into the
    wall are missing, so that a profile of even viscosity rises there by half more than it should.
    Before the projection the same friction would leave the noise of the pressure in the bed and
    fluidize it.
    """
    r_e = stencil.effective_radius
    factor = 2.0 * stencil.dimension / (stencil.laplacian_lambda * stencil.number_density)
    velocity, density, c = matter.velocity, matter.density, matter.concentration
    shear_rate, grain_pressure = matter.shear_rate, matter.grain_pressure
    eddies = matter.turbulent_viscosity
    mu_i = smooth_viscosity(i, eddies[i], matter, law)
    diagonal = density[i]
    x, y, z = (
        density[i] * velocity[i, 0],
        density[i] * velocity[i, 1],
        density[i] * velocity[i, 2],
    )
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        w = r_e * stencil.inverse[i, k] - 1.0
        if k < stencil.unknown_count[i]:
            system.value[i, k] = 0.0
        if j >= stencil.wall_from:
            if walls.slip[j] > 0.0:
                continue
            p = (
                0.5 * (grain_pressure[i] + grain_pressure[j])
                if k < stencil.unknown_count[i]
                else grain_pressure[i]
            )
            is_rough = walls.roughness[j] > 0.0
            mu = smooth_viscosity(i, 0.0, matter, law) if is_rough else mu_i
            eta = mu + strength_viscosity(p, c[i], shear_rate[i], law)
            mirror = 1.0 + walls.depth[j] / wall_distance(i, k, walls, stencil)
            coupling = dt * factor * w * eta * mirror
        elif j >= fluid_count:
            coupling = dt * factor * w * mu_i
        else:
            eta = harmonic_mean(
                mu_i, smooth_viscosity(j, eddies[j], matter, law)
            ) + strength_viscosity(
                0.5 * (grain_pressure[i] + grain_pressure[j]),
                min(c[i], c[j]),
                0.5 * (shear_rate[i] + shear_rate[j]),
                law,
            )
            coupling = dt * factor * w * eta
        diagonal += coupling
        if j < fluid_count:
            system.value[i, k] = coupling
        else:
            x += coupling * velocity[j, 0]
            y += coupling * velocity[j, 1]
            z += coupling * velocity[j, 2]
    system.entries[i] = stencil.unknown_count[i]
    system.diagonal[i] = diagonal
    right[i, 0] = x
    right[i, 1] = y
    right[i, 2] = z


@loop
def assemble_exchange(dt, fluid_count, matter, law, walls, stencil, system, right):
    """Write the implicit exchange of momentum for every fluid particle.

    The system must take its columns from the stencil's neighbors; a neighbor whose velocity is
    given has the value 0 in its row and a part in the right side.
    """
    for i in prange(fluid_count):
        exchange_row_at(i, dt, fluid_count, matter, law, walls, stencil, system, right)


@kernel
def rub_at(i, dt, velocity, walls, stencil):
    """Return the velocity of particle i slowed by the rough walls that it touches.

    In the layer next to a wall the stress ``rho f |u| u`` of the law of the wall, spread over one
    spacing, acts on the part of the velocity along the wall; implicit, so that it never reverses.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    nearest, touched = stencil.spacing, -1
    nx, ny, nz = 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        height, ax, ay, az = contact(i, k, walls, stencil)
        if height < nearest and walls.roughness[stencil.neighbors[i, k]] > 0.0:
            nearest, touched = height, k
            nx, ny, nz = ax, ay, az
    if touched >= 0:
        j = stencil.neighbors[i, touched]
        du, dv, dw = u - velocity[j, 0], v - velocity[j, 1], w - velocity[j, 2]
        normal = du * nx + dv * ny + dw * nz
        du, dv, dw = du - normal * nx, dv - normal * ny, dw - normal * nz
        speed = np.sqrt(du * du + dv * dv + dw * dw)
        f = wall_friction(max(nearest, 0.5 * stencil.spacing), walls.roughness[j])
        kept = 1.0 / (1.0 + dt * f * speed / stencil.spacing)
        u -= (1.0 - kept) * du
        v -= (1.0 - kept) * dv
        w -= (1.0 - kept) * dw
    return u, v, w


@loop
def rub(dt, velocity, walls, stencil, slowed):
    """Write the velocities of the fluid particles after the friction of rough walls."""
    for i in prange(slowed.shape[0]):
        slowed[i, 0], slowed[i, 1], slowed[i, 2] = rub_at(i, dt, velocity, walls, stencil)
