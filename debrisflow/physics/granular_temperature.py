"""Granular temperature T of the grains around a particle, by three laws.

In two dimensions grains are particles of sediment, in three all that holds some.
"""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, fluid_pair, weight
from debrisflow.physics.kinetic_theory import algebraic_temperature, granular_pressure
from debrisflow.physics.operators import LEAST_SPREAD, cofactors, spread

CAP = 0.1  # of the study's granular temperature, see :func:`capped_temperature`


@kernel
def is_grain(j, fraction, near):
    """Return 1 if particle j holds sediment and is no waiting supply, else 0."""
    return 1.0 if fraction[j] > 0.0 and j < near.supply_from else 0.0


@kernel
def _algebraic(first, last, rate, fraction, grains, temperature):
    for i in range(first, last):
        found = algebraic_temperature(rate[i], grains)
        temperature[i] = found if fraction[i] > 0.0 else 0.0


@loop
def algebraic_temperatures(rate, fraction, grains, temperature):
    """Write the temperature of grains at the shear rate around them, (n,) array, m2/s2.

    See :func:`debrisflow.physics.kinetic_theory.algebraic_temperature`; 0 where there is no grain.
    Independent of the spacing but for how well the shear is resolved.
    """
    for block in prange((temperature.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, temperature.size)
        _algebraic(first, last, rate, fraction, grains, temperature)


@kernel
def neighborhood_temperature_at(i, velocity, fraction, near):
    """Return the variance of the velocity of the grains in reach, over Ds, m2/s2.

        T = (1/Ds) [ mean of |u_j|^2 - |mean of u_j|^2 ]

    Equation (20), about the mean of equation (21).

    The study's form.  The variance contains the resolved shear, ``shear_rate^2 r_e^2 / 8`` in two
    dimensions and ``/ 15`` in three, and so vanishes with the spacing squared.  The deviation of
    the one particle, as equation (20) reads, feeds back on itself and gains energy.
    """
    count, su, sv, sw, square = 1.0, 0.0, 0.0, 0.0, 0.0
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        counted = is_grain(j, fraction, near) if weight(inverse, near) > 0.0 else 0.0
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        count += counted
        su, sv, sw = su + counted * du, sv + counted * dv, sw + counted * dw
        square += counted * (du * du + dv * dv + dw * dw)
    mean = (su * su + sv * sv + sw * sw) / count
    return max(square - mean, 0.0) / count / near.dimension


@kernel
def capped_temperature(temperature, c, density, sound_speed, grains):
    """Return the granular temperature, m2/s2, not above ``(z c rho0 / K)^2 / 3``, z = 0.1.

    ``K = 2 rho_s C^2 g0 (1 + e)``, the granular pressure of T = 1.  The variance of the velocity is
    mostly scatter of the particles; above the limit the pressure made of it makes more of it than
    the artificial viscosity takes away, and at C = 0.5 a weakly compressible fluid blows up.  An
    incompressible fluid has an infinite speed of sound and no limit.
    """
    pushed = max(granular_pressure(c, 1.0, grains), 1e-9)
    limit = CAP * sound_speed * density / pushed
    return min(temperature, limit * limit / 3.0)


@kernel
def _neighborhood(first, last, velocity, fraction, c, density, sound_speed, grains, near, found):
    for i in range(first, last):
        temperature = 0.0
        if fraction[i] > 0.0:
            temperature = neighborhood_temperature_at(i, velocity, fraction, near)
        found[i] = capped_temperature(temperature, c[i], density, sound_speed, grains)


@loop
def neighborhood_temperatures(
    velocity, fraction, c, density, sound_speed, grains, near, temperature
):
    """Write the study's granular temperature of every particle, (n,) float64 array, m2/s2.

    ``density``, kg/m3, and ``sound_speed``, m/s, are those of :func:`capped_temperature`.
    """
    for block in prange((temperature.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, temperature.size)
        _neighborhood(
            first, last, velocity, fraction, c, density, sound_speed, grains, near, temperature
        )


@kernel
def fluctuation_temperature_at(i, velocity, fraction, near):
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
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        if weight(inverse, near) == 0.0 or is_grain(j, fraction, near) == 0.0:
            continue
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
    freedom = count - 1.0 - near.dimension
    if freedom <= 0.0:
        return 0.0
    xx, xy, yy = xx - sx * sx / count, xy - sx * sy / count, yy - sy * sy / count
    xz, yz, zz = xz - sx * sz / count, yz - sy * sz / count, zz - sz * sz / count
    if near.dimension < 3.0:
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
    return max(rest, 0.0) / (near.dimension * freedom)


@kernel
def _fluctuation(first, last, velocity, fraction, near, temperature):
    for i in range(first, last):
        temperature[i] = 0.0
        if fraction[i] > 0.0:
            temperature[i] = fluctuation_temperature_at(i, velocity, fraction, near)


@loop
def fluctuation_temperatures(velocity, fraction, near, temperature):
    """Write :func:`fluctuation_temperature_at` of the grains, (n,) float64 array, m2/s2."""
    for block in prange((temperature.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, temperature.size)
        _fluctuation(first, last, velocity, fraction, near, temperature)
