"""No strength: nothing beyond the Newtonian viscosity."""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import kernel


class NoStrength(NamedTuple):
    """The record of no law, which has no numbers."""


law = NoStrength


@kernel
def ramp(concentration, law):
    """Return 0, the share of no strength."""
    return 0.0


@kernel
def yielding_viscosity(strength, shear_rate, law):
    """Return 0 Pa s."""
    return 0.0
