"""Granular temperature of the grains around a particle."""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.physics.kinetic_theory import algebraic_temperature
from debrisflow.physics.operators import (
    LEAST_SPREAD,
    cofactors,
    shear_rate_at,
    spread,
)


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
