"""The parameters of a case as people read them: in a line, in a table, or where two runs differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import phases
from debrisflow.case.fields import NONE, Table
from debrisflow.case.releases import DISCHARGE
from debrisflow.case.resolved import ResolvedInflow, UnsteadyInflow
from debrisflow.case.rheology import NoStrength

IN_METERS = 0.5  # m, of a particle whose size is told in meters


class Parameter(NamedTuple):
    """One field of a case.

    Attributes
    ----------
    key : str
        Dotted, as in ``--set``; of a list with its place, as in ``fill.0.x``.
    value : object
    unit, meaning : str
        As in the schema of a case file.
    """

    key: str
    value: Any
    unit: str
    meaning: str

    @property
    def told(self) -> str:
        """Return the value with its unit."""
        value = self.value or None if isinstance(self.value, tuple) else self.value
        if value is None or isinstance(value, bool):
            return {None: "none", True: "yes", False: "no"}[value]
        if isinstance(value, float):
            text = f"{value:.6g}"
        elif isinstance(value, tuple):
            text = ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in value)
        else:
            text = str(value) or "none"
        return text if self.unit == NONE else f"{text} {self.unit}"


def parameters(case: ResolvedCase) -> list[Parameter]:
    """Return all fields of a case, in the order of the file."""
    found = list(_walk(case, ""))
    rate = "m3/s" if case.dimension == 3 else "m2/s"
    return [one._replace(unit=rate) if one.unit == DISCHARGE else one for one in found]


def _walk(table: Table, prefix: str) -> Iterator[Parameter]:
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), f"{prefix}{name}"
        nested = value if isinstance(value, tuple) else (value,)
        if nested and all(isinstance(part, Table) for part in nested):
            for number, part in enumerate(nested):
                entry = getattr(part, "name", None) or number
                place = f"{key}.{entry}." if isinstance(value, tuple) else f"{key}."
                yield from _walk(part, place)
        else:
            extra = field.json_schema_extra
            unit = str(extra.get("unit", NONE)) if isinstance(extra, dict) else NONE
            yield Parameter(key, value, unit, field.description or "")


def differences(cases: Sequence[ResolvedCase]) -> list[tuple[Parameter | None, ...]]:
    """Return the parameters in which cases differ, a row a parameter, with one entry a case.

    An entry is None where a case does not have the parameter.  Titles do not count.
    """
    known = [{one.key: one for one in parameters(case)} for case in cases]
    keys = dict.fromkeys(key for found in known for key in found if key != "title")
    rows = (tuple(found.get(key) for found in known) for key in keys)
    return [row for row in rows if len({one and one.told for one in row}) > 1]


def summary(case: ResolvedCase) -> str:
    """Return the parameters that matter most in one line."""
    return ", ".join(_words(case))


def _words(case: ResolvedCase) -> Iterator[str]:
    d0, matter = case.particles.spacing, phases(case.fill, case.inflow, case.geometry, case.release)
    yield f"d0 = {format_length(d0)}"
    if case.gravity.vector is not None:
        yield "gravity ({:g}, {:g}) m/s²".format(*case.gravity.vector)
    elif case.gravity.slope:
        yield f"slope {case.gravity.slope:g}°"
    if "water" in matter:
        yield f"water {case.water.density:g} kg/m³, {case.water.viscosity:g} Pa s"
    if "sediment" in matter:
        yield f"sediment {case.sediment.density:g} kg/m³, {case.sediment.viscosity:g} Pa s"
    if "mixture" in matter:
        yield f"mixture C = {case.mixture.concentration:g}, {case.mixture.viscosity:g} Pa s"
    if matter - {"water"}:
        yield f"grains {1000.0 * case.sediment.grain_diameter:g} mm"
    yield from _laws(case)
    if case.is_terrain and case.walls.floor.friction is not None:
        yield _friction(case.walls.floor.friction)
    if case.inflow is not None:
        yield f"supply {_supply(case.inflow, case.dimension)}"


def format_length(length: float) -> str:
    """Return a length of particles in words, in m or mm.

    Examples
    --------
    >>> format_length(1.5), format_length(0.0125)
    ('1.5 m', '12.5 mm')
    """
    return f"{length:g} m" if length >= IN_METERS else f"{1000.0 * length:g} mm"


def _friction(friction: Table) -> str:
    """Return the law of the friction along the ground, with its numbers."""
    numbers = (f"{value:g}" for value in dict(friction).values() if isinstance(value, float))
    return " ".join([f"ground {dict(friction)['law']}", *numbers])


def _laws(case: ResolvedCase) -> Iterator[str]:
    if not isinstance(case.rheology, NoStrength):
        yield case.rheology.summary()
    yield (
        f"collision stress {case.collision_stress.granular_temperature}"
        if (case.collision_stress.enabled)
        else "no collision stress"
    )
    if case.drag.law != "none":
        yield f"drag {case.drag.law}"


def _supply(inflow: ResolvedInflow, dimension: int) -> str:
    unit = "m³/s" if dimension == 3 else "m²/s"
    if isinstance(inflow, UnsteadyInflow):
        return f"hydrograph up to {max(inflow.hydrograph.discharge):g} {unit}"
    return f"{inflow.discharge:g} {unit}, C = {inflow.concentration:g}"
