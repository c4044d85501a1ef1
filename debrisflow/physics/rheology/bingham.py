"""Bingham's law: a slurry that holds up to a yield stress."""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import kernel


class Bingham(NamedTuple):
    """A slurry whose strength is ``tau_y = tau0``; above it flows by the viscosity of its phase.

    Attributes
    ----------
    yield_stress : float, Pa
        tau0.
    ramp_start, ramp_end : float
        Concentrations between which the strength grows from nothing to full.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which the strength is capped.
    """

    yield_stress: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


law = Bingham


@kernel
def yield_strength(pressure, concentration, shear_rate, law):
    """Return tau0, Pa, whatever the pressure between the grains is."""
    return law.yield_stress
