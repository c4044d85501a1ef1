"""Coulomb's friction between grains."""

from __future__ import annotations

from math import radians, tan
from typing import NamedTuple

from debrisflow._jit import kernel


class Coulomb(NamedTuple):
    """Grains whose strength is ``tau_y = mu p`` at the pressure p between them.

    Attributes
    ----------
    friction : float
        mu, the tangent of the friction angle.
    ramp_start, ramp_end : float
        Concentrations between which the strength grows from nothing to full.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which the strength is capped.
    """

    friction: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


def law(
    friction_angle: float,
    ramp_start: float,
    ramp_end: float,
    smallest_shear_rate: float,
    largest_viscosity: float,
) -> Coulomb:
    """Return the record of a friction angle, degree, and the other numbers."""
    return Coulomb(
        friction=tan(radians(friction_angle)),
        ramp_start=ramp_start,
        ramp_end=ramp_end,
        smallest_shear_rate=smallest_shear_rate,
        largest_viscosity=largest_viscosity,
    )


@kernel
def friction(pressure, shear_rate, law):
    """Return mu, whatever pressure and shear rate are.

    Examples
    --------
    >>> round(friction(100.0, 2.0, law(35.0, 0.2, 0.35, 0.001, 1e6)), 4)
    0.7002
    """
    return law.friction
