"""Checks of the law of strength: what it needs, what has no effect with it, and a dry mass."""

from __future__ import annotations

from collections.abc import Callable

from debrisflow.case.materials import Strength
from debrisflow.case.problems import Problem, Problems, locate, unit_of, was_set
from debrisflow.case.tables import AnyFill, Inflow
from debrisflow.case.words import either

Fill = tuple[AnyFill, ...]
FRICTIONAL = "coulomb", "mu-i"
USED = {
    "coulomb": ("friction_angle",),
    "mu-i": ("friction_angle", "dynamic_friction_angle", "inertia_number"),
    "bingham": ("yield_stress",),
    "herschel-bulkley": ("yield_stress", "consistency", "exponent"),
    "obrien-julien": ("yield_stress", "yield_growth", "consistency", "viscosity_growth"),
}
"""The fields of each law, of those that not all of them have."""


def fields_of_law(strength: Strength) -> Problems:
    """Check that a law has all of its fields, and no field that it does not use."""
    if strength.law == "none":
        return
    used = USED[strength.law]
    for name in used:
        if getattr(strength, name) is None:
            place = locate(["strength", name])
            assert place.field is not None
            unit = unit_of(place.field).strip()
            meaning = f"{place.field.description}" + (f" ({unit})" if unit else "")
            message = f"missing: {meaning}"
            yield Problem(f"strength.{name}", message)
    special = dict.fromkeys(name for fields in USED.values() for name in fields)
    unused = [name for name in special if name not in used]
    if strength.law == "obrien-julien":
        unused.append("concentration_ramp")
    for name in unused:
        if was_set(strength, name):
            message = f"has no effect with the law '{strength.law}'; leave it out"
            yield Problem(f"strength.{name}", message, getattr(strength, name))


def friction_grows(strength: Strength) -> Problems:
    """Check that fast shear has the greater friction."""
    fast = strength.dynamic_friction_angle
    if strength.law == "mu-i" and fast is not None and fast <= strength.friction_angle:
        message = f"must be greater than strength.friction_angle = {strength.friction_angle:g}"
        yield Problem("strength.dynamic_friction_angle", message, fast)


def dry_mass(strength: Strength, fill: Fill, inflow: Inflow | None) -> Problems:
    """Check that a dry mass rubs, and that no water is filled or supplied beside it."""
    if strength.saturated:
        return
    key = "strength.saturated"
    if strength.law not in FRICTIONAL:
        message = f"a dry mass needs friction: strength.law must be {either(FRICTIONAL)}"
        yield Problem(key, message, strength.saturated)
    if any(part.material != "mixture" for part in fill) or inflow is not None:
        message = "a dry mass has no water in it; fill with 'mixture' only, without an inflow"
        yield Problem(key, message, strength.saturated)


CHECKS: tuple[Callable[..., Problems], ...] = (fields_of_law, friction_grows, dry_mass)
