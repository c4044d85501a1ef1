"""Strength and viscosity of grains and slurry beyond the Newtonian viscosity of their phase.

    tau = R (tau_y + K rate^n)

with the ramp R of the concentration, the yield strength tau_y and the consistency K.  A law is a
file of this folder: the record of its numbers and those of its formulas that are not the usual ones
below.  The functions here take the record as their last argument and run the formulas of its law.
"""

from __future__ import annotations

from debrisflow._jit import kernel
from debrisflow.dispatch import by_record

Law = tuple[float, ...]
"""The record of a law: a NamedTuple of its numbers."""


@kernel
def harmonic_mean(a, b):
    """Return ``2 a b / (a + b)``, the viscosity of a plane between two layers.

    Examples
    --------
    >>> harmonic_mean(1.0, 3.0), harmonic_mean(0.0, 0.0)
    (1.5, 0.0)
    """
    return 2.0 * a * b / max(a + b, 1e-300)  # without a branch


@by_record
def ramp(concentration, law):
    """Return R: 0 below the ramp of the concentration, 1 above it, linear between."""
    risen = (concentration - law.ramp_start) / (law.ramp_end - law.ramp_start)
    return min(max(risen, 0.0), 1.0)


@by_record
def friction(pressure, shear_rate, law):
    """Return mu, the friction of grains under a pressure between them above 0; 0 in a slurry."""
    return 0.0


@by_record
def yield_strength(pressure, concentration, shear_rate, law):
    """Return tau_y, Pa, without the ramp; of grains it is ``mu p``.

    ``pressure``, Pa, is that between the grains.  Pass a pair's mean pressure, which makes the
    strength of the plane between two rows exact.
    """
    return friction(pressure, shear_rate, law) * pressure if pressure > 0.0 else 0.0


@by_record
def consistency_at(concentration, law):
    """Return K, Pa s^n, of a concentration or an array of them; None of a law that has none."""
    return


@by_record
def power_law_viscosity(consistency, shear_rate, law):
    """Return ``K rate^(n - 1)``, Pa s, of a consistency, capped; 0 of a law that has none."""
    return 0.0


@by_record
def yielding_viscosity(strength, shear_rate, law):
    """Return ``min(strength / max(rate, smallest), largest)``, Pa s.

    Sharp yield, very viscous below it.
    """
    return min(strength / max(shear_rate, law.smallest_shear_rate), law.largest_viscosity)
