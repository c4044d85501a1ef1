"""The strength of a case, as the kernels take it."""

from __future__ import annotations

from math import radians, tan

from debrisflow.case import tables
from debrisflow.physics.rheology import Law

ANY_CONCENTRATION = 0.0, 1.0e-9
FRICTIONAL = "coulomb", "mu-i"


def law_of(case: tables.Case) -> Law:
    """Return the law of a checked case; one that resists nothing where the case has none."""
    strength, sediment = case.strength, case.sediment
    static = tan(radians(strength.friction_angle)) if strength.law in FRICTIONAL else 0.0
    dynamic = static
    if strength.law == "mu-i":
        assert strength.dynamic_friction_angle is not None  # the checks see to it
        dynamic = tan(radians(strength.dynamic_friction_angle))
    grows_with_any = strength.law == "obrien-julien"
    start, end = ANY_CONCENTRATION if grows_with_any else strength.concentration_ramp
    is_slurry = strength.law not in ("none", *FRICTIONAL)
    return Law(
        friction=static,
        friction_span=dynamic - static,
        inertia=strength.inertia_number,
        grain_diameter=sediment.grain_diameter,
        grain_density=sediment.density,
        yield_stress=(strength.yield_stress or 0.0) if is_slurry else 0.0,
        yield_growth=(strength.yield_growth or 0.0) if is_slurry else 0.0,
        consistency=(strength.consistency or 0.0) if is_slurry else 0.0,
        exponent=strength.exponent or 1.0,
        viscosity_growth=(strength.viscosity_growth or 0.0) if is_slurry else 0.0,
        ramp_start=start,
        ramp_end=end,
        smallest_shear_rate=strength.smallest_shear_rate,
        largest_viscosity=strength.largest_viscosity,
    )
