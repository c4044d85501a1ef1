"""Apparent viscosity of grains and slurries that yield."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel


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
