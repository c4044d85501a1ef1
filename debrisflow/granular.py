"""Grains: local concentration, collision stress of kinetic theory, effective grain pressure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.operators import (
    LEAST_SPREAD,
    cofactors,
    number_density_at,
    shear_rate_at,
    spread,
    velocity_difference,
)

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
    """

    density: float
    diameter: float
    restitution: float
    packing_limit: float
    largest_concentration: float


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


@loop
def algebraic_temperatures(fluid_count, velocity, fraction, walls, grains, stencil, temperature):
    """Write :func:`algebraic_temperature` of the grains at the shear rate around them.

    Independent of the spacing but for how well the shear is resolved.
    """
    for i in prange(fluid_count):
        temperature[i] = 0.0
        if fraction[i] > 0.0:
            rate = shear_rate_at(i, velocity, walls, stencil)
            temperature[i] = algebraic_temperature(rate, grains)


@kernel
def neighborhood_temperature_at(i, fluid_count, velocity, fraction, stencil):
    """Return the variance of the velocity of the grains in reach, over Ds, m2/s2.

    The study's form.  The variance contains the resolved shear, ``shear_rate^2 r_e^2 / 8`` in two
    dimensions and ``/ 15`` in three, and so vanishes with the spacing squared.  The deviation of
    the one particle, as equation (20) reads, feeds back on itself and gains energy.
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


@loop
def neighborhood_temperatures(fluid_count, velocity, fraction, walls, grains, stencil, temperature):
    """Write :func:`neighborhood_temperature_at` of the grains."""
    for i in prange(fluid_count):
        temperature[i] = 0.0
        if fraction[i] > 0.0:
            temperature[i] = neighborhood_temperature_at(
                i, fluid_count, velocity, fraction, stencil
            )


@kernel
def fluctuation_temperature_at(i, fluid_count, velocity, fraction, stencil):
    """Return the variance of the grains in reach about a linear velocity field, over Ds, m2/s2.

        sum of |u_j - ubar - grad u . (r_j - rbar)|^2 / (Ds (N - 1 - Ds))

    The field is that of least squares, so that no uniform shear or strain counts.  N - 1 - Ds
    are the degrees of freedom it leaves: the mean of the estimate is the T of independent
    fluctuations; with no more grains than that, or all on a line, T is 0.  What the spacing does
    not resolve as linear still counts, and falls with d0^4 where the flow is smooth; what stays is
    the scatter of the particles themselves, which is numerical and does not converge to a T.
    """
    count, sx, sy, sz, su, sv, sw, square = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j >= fluid_count or fraction[j] == 0.0:
            continue
        dx, dy, dz = stencil.dx[i, k], stencil.dy[i, k], stencil.dz[i, k]
        du = velocity[j, 0] - velocity[i, 0]
        dv = velocity[j, 1] - velocity[i, 1]
        dw = velocity[j, 2] - velocity[i, 2]
        count += 1.0
        sx, sy, sz, su, sv, sw = sx + dx, sy + dy, sz + dz, su + du, sv + dv, sw + dw
        square += du * du + dv * dv + dw * dw
        xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
        xz, yz, zz = xz + dx * dz, yz + dy * dz, zz + dz * dz
        ux, uy, uz = ux + du * dx, uy + du * dy, uz + du * dz
        vx, vy, vz = vx + dv * dx, vy + dv * dy, vz + dv * dz
        wx, wy, wz = wx + dw * dx, wy + dw * dy, wz + dw * dz
    freedom = count - 1.0 - stencil.dimension
    if freedom <= 0.0:
        return 0.0
    xx, xy, yy = xx - sx * sx / count, xy - sx * sy / count, yy - sy * sy / count
    xz, yz, zz = xz - sx * sz / count, yz - sy * sz / count, zz - sz * sz / count
    if stencil.dimension < 3.0:
        zz = 0.5 * (xx + yy)  # nothing varies along z
    a, b, c, d, e, f, determinant = cofactors(xx, xy, yy, xz, yz, zz)
    if spread(xx, yy, zz, determinant) <= LEAST_SPREAD:
        return 0.0
    ux, uy, uz = ux - su * sx / count, uy - su * sy / count, uz - su * sz / count
    vx, vy, vz = vx - sv * sx / count, vy - sv * sy / count, vz - sv * sz / count
    wx, wy, wz = wx - sw * sx / count, wy - sw * sy / count, wz - sw * sz / count
    linear = 0.0
    for p, q, r in ((ux, uy, uz), (vx, vy, vz), (wx, wy, wz)):
        linear += a * p * p + c * q * q + f * r * r + 2.0 * (b * p * q + d * p * r + e * q * r)
    rest = square - (su * su + sv * sv + sw * sw) / count - linear / determinant
    return max(rest, 0.0) / (stencil.dimension * freedom)


@loop
def fluctuation_temperatures(fluid_count, velocity, fraction, walls, grains, stencil, temperature):
    """Write :func:`fluctuation_temperature_at` of the grains."""
    for i in prange(fluid_count):
        temperature[i] = 0.0
        if fraction[i] > 0.0:
            temperature[i] = fluctuation_temperature_at(i, fluid_count, velocity, fraction, stencil)


TEMPERATURES = {
    "algebraic": algebraic_temperatures,
    "neighborhood": neighborhood_temperatures,
    "fluctuation": fluctuation_temperatures,
}


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


@kernel
def level_concentration_at(i, fluid_count, fraction, down, stencil):
    """Return the share of sediment around particle i at its level, i itself counted twice.

    Weights are ``w`` times the square of the sine between the way to the neighbor and ``down``, the
    unit vector of gravity, which may be zero.
    """
    share, total = 2.0 * fraction[i], 2.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count:
            inverse = stencil.inverse[i, k]
            below = inverse * (
                down[0] * stencil.dx[i, k] + down[1] * stencil.dy[i, k] + down[2] * stencil.dz[i, k]
            )
            w = (stencil.effective_radius * inverse - 1.0) * (1.0 - below * below)
            share += w * fraction[j]
            total += w
    return share / total


@loop
def level_concentration(fluid_count, fraction, down, stencil, c):
    """Write the share of sediment at the level of every fluid particle.

    It decides where grains touch and what they weigh.  The concentration C, a mean over the whole
    influence radius, goes over from a bed to the water on it within three rows, and at a free
    surface knows of one side only: a row of water on a bed has more than half of the bed's
    concentration, would have its strength and stick to it.  At its own level the change takes one
    row to either side of the surface, under deep water, a film or none.
    """
    for i in prange(fluid_count):
        c[i] = level_concentration_at(i, fluid_count, fraction, down, stencil)


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


@kernel
def covered_depth_at(i, fluid_count, gravity, stencil):
    """Return what a free-surface particle has to carry of the rows above its center, m.

    Half of its own row, and what its row lies nearer than d0 to the row below: the pressure of the
    fluid lets the uppermost row sink by about a quarter of a spacing, and that much of the weight
    would be missing in every row below.

    Along gravity, since the normal of a row as uneven as that of a bed is known to some ten degrees
    only, and loads along it come out a third of a row too small.  On an even surface at an angle
    theta this is ``1.5 d0 (1 - cos theta)`` too much, 0.05 d0 at 15 degrees.
    """
    d0 = stencil.spacing
    g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
    nearest = d0
    for k in range(stencil.neighbor_count[i]):
        if stencil.neighbors[i, k] >= fluid_count or g == 0.0:
            continue
        below = (
            gravity[0] * stencil.dx[i, k]
            + gravity[1] * stencil.dy[i, k]
            + gravity[2] * stencil.dz[i, k]
        ) / g
        if below * stencil.inverse[i, k] > 0.7:
            nearest = min(nearest, below)
    return 1.5 * d0 - nearest


@kernel
def grain_pressure_row_at(
    i,
    fluid_count,
    c,
    least_concentration,
    on_free_surface,
    submerged_density,
    gravity,
    stencil,
    system,
):
    """Write row i of the static balance of the buoyant grains.

        sum of a_ij [ (p_j - p_i) - b_ij . r_ij ] = 0,   a_ij = r_e d0^2 / r^3,
        b_ij = (C_i + C_j)/2 (rho_s - rho_l) g

    Every linear pressure solves it exactly on any arrangement of particles; neither the time step
    nor the velocity enters, so the result carries no noise of the flow, and water above the bed
    adds nothing.  C is that at the level of the particle; p = 0 where it is less than the least; on
    the free surface of a bed p is the weight of half a row and of what that row has sunk.  Walls
    are natural boundaries: pairs of two wall particles and dummies are left out.
    It takes the pores as drained: no excess pore pressure, no dilatancy.
    """
    is_fluid = i < fluid_count
    system.entries[i] = 0
    system.diagonal[i] = 1.0
    system.right[i] = 0.0
    if is_fluid and c[i] < least_concentration:
        return
    if is_fluid and on_free_surface[i]:
        g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
        depth = covered_depth_at(i, fluid_count, gravity, stencil)
        system.right[i] = c[i] * submerged_density * g * depth
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
    fluid_count,
    c,
    least_concentration,
    on_free_surface,
    submerged_density,
    gravity,
    stencil,
    system,
):
    """Write the balance of the buoyant grains for every fluid, inflow and wall particle.

    The system must take its columns from the stencil's neighbors.
    """
    for i in prange(system.entries.size):
        grain_pressure_row_at(
            i,
            fluid_count,
            c,
            least_concentration,
            on_free_surface,
            submerged_density,
            gravity,
            stencil,
            system,
        )
