"""How quantities and parameters are called in pictures, with their units."""

from __future__ import annotations

import re

from debrisflow.case.problems import locate, unit_of
from debrisflow.study.distributions import AnyParameter, Choice, Value

POWERS = str.maketrans("23", "²³")
POWER = re.compile(r"(?<=[A-Za-z])[23](?!\d)")  # right after a unit


def label_of(name: str, unit: str) -> str:
    """Return the name of a quantity with its unit.

    Examples
    --------
    >>> label_of("affected_area", "m2"), label_of("equivalent_friction", "-")
    ('affected area, m²', 'equivalent friction')
    """
    words = name.replace("_", " ")
    return words if unit in ("", "-") else f"{words}, {raised(unit)}"


def raised(unit: str) -> str:
    """Return a unit with its simple exponents raised.

    Examples
    --------
    >>> raised("kg/m3"), raised("s/m^(1/3)")
    ('kg/m³', 's/m^(1/3)')
    """
    return POWER.sub(lambda power: power[0].translate(POWERS), unit)


def parameter_label(parameter: AnyParameter) -> str:
    """Return the name of a parameter with the unit of its key in a case; a factor has none."""
    if parameter.is_factor:
        return f"{parameter.name}, factor"
    place = locate(parameter.keys[0].split("."))
    name = place.keys[-1]
    # several laws may have a field of the same name, in units of their own
    fields = [own for one in place.owners if (own := one.model_fields.get(str(name)))]
    units = {unit_of(field).strip() for field in fields}
    unit = units.pop() if len(units) == 1 else ""
    return f"{parameter.name}, {raised(unit)}" if unit else parameter.name


def shown_value(value: Value) -> str:
    """Return a value of a parameter, of a file without its folder.

    Examples
    --------
    >>> shown_value(0.123456), shown_value("terrain/a.asc")
    ('0.123', 'a.asc')
    """
    return f"{value:.3g}" if isinstance(value, float) else value.rpartition("/")[2]


def is_of_words(parameter: AnyParameter) -> bool:
    """Return whether the values of a parameter are words, of which none is lower or higher."""
    return isinstance(parameter, Choice) and isinstance(parameter.values[0], str)
