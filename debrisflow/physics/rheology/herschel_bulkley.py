"""The law of Herschel and Bulkley: a slurry that yields, and flows by a power of the shear rate."""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import allocating_kernel, kernel


class HerschelBulkley(NamedTuple):
    """A slurry that resists by ``tau0 + K rate^n``.

    Attributes
    ----------
    yield_stress : float, Pa
        tau0.
    consistency, exponent : float, Pa s^n, dimensionless
        K and n.
    ramp_start, ramp_end : float
        Concentrations between which the strength grows from nothing to full.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which strength and consistency are capped.
    """

    yield_stress: float
    consistency: float
    exponent: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


law = HerschelBulkley


@kernel
def yield_strength(pressure, concentration, shear_rate, law):
    """Return tau0, Pa, whatever the pressure between the grains is."""
    return law.yield_stress


@allocating_kernel
def consistency_at(concentration, law):
    """Return K, Pa s^n, the same at each of the concentrations."""
    return law.consistency + 0.0 * concentration


@kernel
def power_law_viscosity(consistency, shear_rate, law):
    """Return ``K rate^(n - 1)``, Pa s, of a consistency, capped."""
    rate = max(shear_rate, law.smallest_shear_rate)
    return min(consistency * rate ** (law.exponent - 1.0), law.largest_viscosity)
