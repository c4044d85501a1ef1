"""Apparent viscosity: turbulence, friction of grains, slurries that yield; drag, rough walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel

KARMAN = 0.41


class Law(NamedTuple):
    """Strength and viscosity of grains and slurry beyond the Newtonian viscosity of their phase.

        tau = R [tau0 exp(a C) + mu(I) p + K exp(b C) rate^n],   mu(I) = mu_s + span / (1 + I0 / I)

    with the ramp R of the concentration and ``I = rate d / sqrt(p / rho_s)``.

    Attributes
    ----------
    friction : float
        mu_s, the tangent of the friction angle of the slowest shear; 0 switches friction off.
    friction_span : float
        What friction gains up to the fastest shear; 0 in Coulomb's law.
    inertia : float
        I0, the inertia number at which half of the span is gained.
    grain_diameter, grain_density : float, m, kg/m3
        d and rho_s.
    yield_stress, yield_growth : float, Pa, dimensionless
        tau0 and a.
    consistency, exponent, viscosity_growth : float, Pa s^n, dimensionless
        K, n and b.
    ramp_start, ramp_end : float
        Concentrations between which the strength grows from nothing to full.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which strength and consistency are capped.
    """

    friction: float
    friction_span: float
    inertia: float
    grain_diameter: float
    grain_density: float
    yield_stress: float
    yield_growth: float
    consistency: float
    exponent: float
    viscosity_growth: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


class DragLaw(NamedTuple):
    """Drag between water and grains: Wen & Yu, and Ergun in dense mixtures.

    Attributes
    ----------
    ergun_from : float
        Concentration from which Ergun's law holds: 0.2 in Gidaspow's drag, infinite in Wen & Yu's.
    diameter : float, m
        Grain diameter d_m.
    density, viscosity : float, kg/m3, Pa s
        Of water.
    packing_limit : float
        Concentrations are taken no greater.
    """

    ergun_from: float
    diameter: float
    density: float
    viscosity: float
    packing_limit: float


@kernel
def mixing_length(limit, height, roughness):
    """Return ``min(l, kappa (y + k_s / 30))``, m, the mixing length at a height y over a floor.

    ``limit`` is the l of the case.  Near a rough floor, where the stress is that on the floor, the
    length makes the profile of :func:`wall_friction`, so that the stress on the floor and that
    within the flow do not depend on the height of the lowest row.  An infinite roughness leaves l
    as it is.

    References
    ----------
    Escudier 1966, The distribution of mixing-length in turbulent flows near walls, Imperial
    College, London (the greatest length).

    Examples
    --------
    >>> mixing_length(0.01, 1.0, 0.03), round(mixing_length(0.01, 0.001, 0.03), 5)
    (0.01, 0.00082)
    """
    return min(limit, KARMAN * (height + roughness / 30.0))


@kernel
def turbulent_viscosity(density, length, shear_rate):
    """Return Prandtl's ``rho l^2 shear_rate``, Pa s."""
    return density * length**2 * shear_rate


@kernel
def harmonic_mean(a, b):
    """Return ``2 a b / (a + b)``, the viscosity of a plane between two layers.

    Examples
    --------
    >>> harmonic_mean(1.0, 3.0), harmonic_mean(0.0, 0.0)
    (1.5, 0.0)
    """
    total = a + b
    return 2.0 * a * b / total if total > 0.0 else 0.0


@kernel
def ramp(concentration, law):
    """Return 0 below the ramp of the concentration, 1 above it, linear between."""
    risen = (concentration - law.ramp_start) / (law.ramp_end - law.ramp_start)
    return min(max(risen, 0.0), 1.0)


@kernel
def friction(pressure, shear_rate, law):
    """Return ``mu(I) = mu_s + span / (1 + I0 / I)`` at a pressure between grains above 0.

    The law of dry grains, and of grains in water where their inertia, not its viscosity, rules.

    References
    ----------
    Jop, Forterre & Pouliquen 2006, doi:10.1038/nature04801.
    """
    if law.friction_span == 0.0:
        return law.friction
    inertia = shear_rate * law.grain_diameter * np.sqrt(law.grain_density / pressure)
    return law.friction + law.friction_span * inertia / (law.inertia + inertia)


@kernel
def yield_strength(pressure, concentration, shear_rate, law):
    """Return ``tau0 exp(a C) + mu(I) p``, Pa, without the ramp.

    ``pressure`` is that between the grains.  Pass a pair's mean pressure, which makes the strength
    of the plane between two rows exact.

    References
    ----------
    O'Brien & Julien 1988, doi:10.1061/(ASCE)0733-9429(1988)114:8(877) (the growth with C).
    """
    strength = 0.0
    if law.yield_stress > 0.0:
        strength = law.yield_stress * np.exp(law.yield_growth * concentration)
    if pressure > 0.0:
        strength += friction(pressure, shear_rate, law) * pressure
    return strength


@kernel
def consistency_viscosity(concentration, shear_rate, law):
    """Return ``K exp(b C) rate^(n - 1)``, Pa s, without the ramp; capped, as is the strength.

    What comes on top of the Newtonian viscosity.
    """
    if law.consistency == 0.0:
        return 0.0
    return power_law_viscosity(consistency_at(concentration, law), shear_rate, law)


@kernel
def consistency_at(concentration, law):
    """Return ``K exp(b C)``, Pa s^n."""
    return law.consistency * np.exp(law.viscosity_growth * concentration)


@kernel
def power_law_viscosity(consistency, shear_rate, law):
    """Return ``K rate^(n - 1)``, Pa s, of a consistency, capped."""
    rate = max(shear_rate, law.smallest_shear_rate)
    return min(consistency * rate ** (law.exponent - 1.0), law.largest_viscosity)


@kernel
def yielding_viscosity(strength, shear_rate, law):
    """Return ``min(strength / max(rate, smallest), largest)``, Pa s.

    Sharp yield, very viscous below it.
    """
    return min(strength / max(shear_rate, law.smallest_shear_rate), law.largest_viscosity)


@kernel
def drag_coefficient(c, speed, drag):
    """Return ``K = beta / (C (1 - C))``, kg/(m3 s).

    beta is the force on either phase per unit volume of mixture and slip velocity; divided by the
    shares of both phases it is the coefficient between a volume of sediment and one of water.
    Wen & Yu with the drag coefficient of Schiller & Naumann; Ergun from ``drag.ergun_from`` on.

    Grains of 3 mm settle in water by Wen & Yu at 0.99, 0.94 and 0.88 of the speed of Richardson &
    Zaki at C = 0.1, 0.2 and 0.3.  By Gidaspow, whose change of law suits fine grains, the drag
    jumps by 3.2 at C = 0.2, and the settling speed falls from 0.21 to 0.11 m/s.

    References
    ----------
    Gidaspow 1994, Multiphase Flow and Fluidization, Academic Press; Wen & Yu 1966, Chemical
    Engineering Progress Symposium Series 62; Richardson & Zaki 1954, Transactions of the
    Institution of Chemical Engineers 32.
    """
    c = min(c, drag.packing_limit)
    d, rho, mu = drag.diameter, drag.density, drag.viscosity
    if c > drag.ergun_from:
        return 150.0 * c * mu / ((1.0 - c) ** 2 * d * d) + 1.75 * rho * speed / ((1.0 - c) * d)
    reynolds = (1.0 - c) * rho * speed * d / mu
    if reynolds < 1000.0:
        inertia = 24.0 * mu / ((1.0 - c) * d) * (1.0 + 0.15 * reynolds**0.687)
    else:
        inertia = 0.44 * rho * speed
    return 0.75 * inertia * (1.0 - c) ** -2.65 / d


@kernel
def freedom(value, limit):
    """Return 1, falling linearly from 0.9 of the limit on to 1e-4 at the limit.

    Of the concentration and the packing limit: what the contacts of the grains leave of their slip.

    Examples
    --------
    >>> [round(freedom(c, 0.5), 4) for c in (0.3, 0.45, 0.475, 0.5)]
    [1.0, 1.0, 0.5, 0.0001]
    """
    return min(max(10.0 * (1.0 - value / limit), 1e-4), 1.0)


@kernel
def wall_friction(height, roughness):
    """Return ``[kappa / ln(1 + 30 y / k_s)]^2``, wall stress over ``rho u^2`` at a height y.

    The law of the wall over a floor of equivalent sand roughness k_s at y > 0, with its origin at
    the height k_s / 30 where the usual form, ``kappa / ln(30 y / k_s)``, has no speed left.  Below
    y = k_s it is an extension that is smooth, not one that is measured.

    Examples
    --------
    >>> round(wall_friction(0.01, 0.001), 5)
    0.00516
    """
    return (KARMAN / np.log(1.0 + 30.0 * height / roughness)) ** 2
