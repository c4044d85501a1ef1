"""The law of O'Brien and Julien: a mud that thickens exponentially with its concentration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow._jit import allocating_kernel, kernel

ANY_CONCENTRATION = 1.0e-9
"""Concentration from which on all of the strength is there."""


class OBrienJulien(NamedTuple):
    """A mud that resists by ``tau0 exp(a C) + K exp(b C) rate``.

    The quadratic term of turbulence and dispersion is left out.

    Attributes
    ----------
    yield_stress, yield_growth : float, Pa, dimensionless
        tau0 and a.
    consistency, viscosity_growth : float, Pa s, dimensionless
        K and b.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which strength and viscosity are capped.

    References
    ----------
    O'Brien & Julien 1988, doi:10.1061/(ASCE)0733-9429(1988)114:8(877).
    """

    yield_stress: float
    yield_growth: float
    consistency: float
    viscosity_growth: float
    smallest_shear_rate: float
    largest_viscosity: float


law = OBrienJulien


@kernel
def ramp(concentration, law):
    """Return 1, and 0 of clear water."""
    return min(max(concentration / ANY_CONCENTRATION, 0.0), 1.0)


@kernel
def yield_strength(pressure, concentration, shear_rate, law):
    """Return ``tau0 exp(a C)``, Pa, whatever the pressure between the grains is."""
    return law.yield_stress * np.exp(law.yield_growth * concentration)


@allocating_kernel
def consistency_at(concentration, law):
    """Return ``K exp(b C)``, Pa s."""
    return law.consistency * np.exp(law.viscosity_growth * concentration)


@kernel
def power_law_viscosity(consistency, shear_rate, law):
    """Return a viscosity, Pa s, capped."""
    return min(consistency, law.largest_viscosity)
