"""Grains: local concentration, collision stress of kinetic theory, effective grain pressure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.operators import number_density_at, shear_rate_at

Floats = NDArray[np.float64]


class Grains(NamedTuple):
    """What the grain stress needs to know of the sediment.

    Attributes
    ----------
    density : float, kg/m3
        rho_s.
    diameter : float, m
        d_m.
    restitution : float
        e.
    packing_limit : float
        C*.
    largest_concentration : float
        Concentration at which C is clipped, below C*.
    algebraic : bool
        Granular temperature from the balance of production and dissipation, else the variance of
        the velocity in the neighborhood.
    """

    density: float
    diameter: float
    restitution: float
    packing_limit: float
    largest_concentration: float
    algebraic: bool


@kernel
def radial_distribution(c, packing_limit):
    """Return ``g0 = 1 / (1 - (C / C*)^(1/3))`` of equation (11).

    Ding & Gidaspow (doi:10.1002/aic.690360404) have a factor 3/5 in front, which the study leaves
    out.

    Examples
    --------
    >>> round(radial_distribution(0.5, 0.55), 1)
    32.0
    """
    return 1.0 / (1.0 - (c / packing_limit) ** (1.0 / 3.0))


@kernel
def granular_pressure(c, temperature, grains):
    """Return ``2 rho_s C^2 g0 (1 + e) T``, the isotropic part of equation (10), Pa."""
    g0 = radial_distribution(c, grains.packing_limit)
    return 2.0 * grains.density * c * c * g0 * (1.0 + grains.restitution) * temperature


@kernel
def granular_viscosity(c, temperature, grains):
    """Return ``0.8 C^2 d_m rho_s g0 (1 + e) sqrt(T / pi)``, half the factor of S in (10), Pa s."""
    g0 = radial_distribution(c, grains.packing_limit)
    return (
        0.8
        * c
        * c
        * grains.diameter
        * grains.density
        * g0
        * (1.0 + grains.restitution)
        * np.sqrt(temperature / np.pi)
    )


@kernel
def algebraic_temperature(shear_rate, grains):
    """Return ``d_m^2 shear_rate^2 / (15 (1 - e))``: production equals dissipation, m2/s2.

    Independent of the resolution.  In plane shear the stress then has the ratio
    ``tau / p = 0.4 sqrt(15 (1 - e) / pi)``.
    """
    return (grains.diameter * shear_rate) ** 2 / (15.0 * (1.0 - grains.restitution))


@kernel
def neighborhood_temperature_at(i, fluid_count, velocity, fraction, stencil):
    """Return the variance of the velocity of the grains in reach, over Ds, m2/s2.

    The variance contains the resolved shear and vanishes with the spacing squared.  The deviation
    of the one particle, as equation (20) reads, feeds back on itself and gains energy.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    square = u * u + v * v + w * w
    grains = 1.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count and fraction[j] > 0.0:
            u += velocity[j, 0]
            v += velocity[j, 1]
            w += velocity[j, 2]
            square += velocity[j, 0] ** 2 + velocity[j, 1] ** 2 + velocity[j, 2] ** 2
            grains += 1.0
    mean = (u * u + v * v + w * w) / grains
    return max(square - mean, 0.0) / grains / stencil.dimension


@kernel
def concentration_at(i, fluid_count, fraction, stencil):
    """Return the weighted share of sediment in reach, the particle itself counted twice."""
    share, total = 2.0 * fraction[i], 2.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count:
            w = stencil.effective_radius * stencil.inverse[i, k] - 1.0
            share += w * fraction[j]
            total += w
    return share / total


@loop
def concentration(fluid_count, fraction, stencil, c):
    """Write the weighted share of ``fraction`` around the first ``fluid_count`` particles.

    Applied to its own result it smooths the concentration.
    """
    for i in prange(fluid_count):
        c[i] = concentration_at(i, fluid_count, fraction, stencil)


@loop
def collision_state(
    fluid_count, velocity, fraction, c, walls, grains, stencil, temperature, pressure, viscosity
):
    """Write granular temperature, pressure and viscosity of the particles that hold sediment.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles
    whose scatter then feeds it.
    """
    for i in prange(fluid_count):
        temperature[i] = 0.0
        pressure[i] = 0.0
        viscosity[i] = 0.0
        if fraction[i] > 0.0:
            clipped = min(c[i], grains.largest_concentration)
            if grains.algebraic:
                rate = shear_rate_at(i, velocity, walls, stencil)
                temperature[i] = algebraic_temperature(rate, grains)
            else:
                temperature[i] = neighborhood_temperature_at(
                    i, fluid_count, velocity, fraction, stencil
                )
            n, _ = number_density_at(i, stencil)
            inside = min(max(5.0 * (n / stencil.number_density - 0.8), 0.0), 1.0)
            pressure[i] = inside * granular_pressure(clipped, temperature[i], grains)
            viscosity[i] = granular_viscosity(clipped, temperature[i], grains)


@kernel
def collision_force_at(i, fluid_count, velocity, fraction, pressure, viscosity, stencil):
    """Return ``-div P_s`` of particle i, N/m3.

    Pressure in the conservative sum form, shear as a Laplacian with the mean viscosity of the
    pair; both act between particles that hold sediment and are opposite on the two.
    """
    r_e = stencil.effective_radius
    push = stencil.dimension / stencil.number_density
    pull = 2.0 * stencil.dimension / (stencil.laplacian_lambda * stencil.number_density)
    x, y, z = 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count and fraction[j] > 0.0:
            inverse = stencil.inverse[i, k]
            w = r_e * inverse - 1.0
            f = push * (pressure[i] + pressure[j]) * w * inverse * inverse
            s = pull * 0.5 * (viscosity[i] + viscosity[j]) * w
            x += s * (velocity[j, 0] - velocity[i, 0]) - f * stencil.dx[i, k]
            y += s * (velocity[j, 1] - velocity[i, 1]) - f * stencil.dy[i, k]
            z += s * (velocity[j, 2] - velocity[i, 2]) - f * stencil.dz[i, k]
    return x, y, z


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


@kernel
def grain_pressure_row_at(
    i, fluid_count, c, on_free_surface, submerged_density, gravity, stencil, system
):
    """Write row i of the static balance of the buoyant grains.

        sum of a_ij [ (p_j - p_i) - b_ij . r_ij ] = 0,   a_ij = r_e d0^2 / r^3,
        b_ij = (C_i + C_j)/2 (rho_s - rho_l) g

    Every linear pressure solves it exactly on any arrangement of particles; neither the time step
    nor the velocity enters, so the result carries no noise of the flow, and water above the bed
    adds nothing.  p = 0 where C < 0.08; on the free surface of a bed p is the weight of half a
    row.  Walls are natural boundaries: pairs of two wall particles and dummies are left out.
    It takes the pores as drained: no excess pore pressure, no dilatancy.
    """
    is_fluid = i < fluid_count
    weight = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2) * submerged_density
    system.entries[i] = 0
    system.diagonal[i] = 1.0
    system.right[i] = 0.0
    if is_fluid and c[i] < 0.08:
        return
    if is_fluid and on_free_surface[i]:
        system.right[i] = 0.5 * c[i] * weight * stencil.spacing
        return
    diagonal, right = 0.0, 0.0
    for k in range(stencil.unknown_count[i]):
        j = stencil.neighbors[i, k]
        system.value[i, k] = 0.0
        if not is_fluid and j >= fluid_count:
            continue
        a = stencil.effective_radius * stencil.spacing**2 * stencil.inverse[i, k] ** 3
        share = c[i] if j >= fluid_count else (c[j] if not is_fluid else 0.5 * (c[i] + c[j]))
        right -= (
            a
            * share
            * submerged_density
            * (
                gravity[0] * stencil.dx[i, k]
                + gravity[1] * stencil.dy[i, k]
                + gravity[2] * stencil.dz[i, k]
            )
        )
        diagonal += a
        system.value[i, k] = a
    if diagonal > 0.0:
        system.entries[i] = stencil.unknown_count[i]
        system.diagonal[i] = diagonal
        system.right[i] = right


@loop
def assemble_grain_pressure(
    fluid_count, c, on_free_surface, submerged_density, gravity, stencil, system
):
    """Write the balance of the buoyant grains for every fluid, inflow and wall particle.

    The system must take its columns from the stencil's neighbors.
    """
    for i in prange(system.entries.size):
        grain_pressure_row_at(
            i, fluid_count, c, on_free_surface, submerged_density, gravity, stencil, system
        )
