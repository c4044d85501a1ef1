"""The law mu(I) of Jop, Forterre & Pouliquen: friction that grows with the inertia of the shear."""

from __future__ import annotations

from math import radians, tan
from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel


class MuI(NamedTuple):
    """Grains whose strength is ``tau_y = mu(I) p`` at the pressure p between them.

    Attributes
    ----------
    friction : float
        mu_s, the tangent of the friction angle of the slowest shear.
    friction_span : float
        What friction gains up to the fastest shear.
    inertia : float
        I0, the inertia number at which half of the span is gained.
    grain_diameter, grain_density : float, m, kg/m3
        d and rho_s.
    ramp_start, ramp_end : float
        Concentrations between which the strength grows from nothing to full.
    smallest_shear_rate : float, 1/s
        Shear rate below which the strength is viscous.
    largest_viscosity : float, Pa s
        At which the strength is capped.
    """

    friction: float
    friction_span: float
    inertia: float
    grain_diameter: float
    grain_density: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


def law(
    friction_angle: float,
    dynamic_friction_angle: float,
    inertia_number: float,
    grain_diameter: float,
    grain_density: float,
    ramp_start: float,
    ramp_end: float,
    smallest_shear_rate: float,
    largest_viscosity: float,
) -> MuI:
    """Return the record of two friction angles, degree, and the other numbers."""
    slow, fast = tan(radians(friction_angle)), tan(radians(dynamic_friction_angle))
    return MuI(
        friction=slow,
        friction_span=fast - slow,
        inertia=inertia_number,
        grain_diameter=grain_diameter,
        grain_density=grain_density,
        ramp_start=ramp_start,
        ramp_end=ramp_end,
        smallest_shear_rate=smallest_shear_rate,
        largest_viscosity=largest_viscosity,
    )


@kernel
def friction(pressure, shear_rate, law):
    """Return ``mu(I) = mu_s + span / (1 + I0 / I)``, ``I = rate d / sqrt(p / rho_s)``.

    It holds for dry grains, and for grains in water where their inertia, not its viscosity, rules.

    References
    ----------
    Jop, Forterre & Pouliquen 2006, doi:10.1038/nature04801.
    """
    inertia = shear_rate * law.grain_diameter * np.sqrt(law.grain_density / pressure)
    return law.friction + law.friction_span * inertia / (law.inertia + inertia)
