"""Tables of hazard classes: which thresholds of which layers make a class, and their source.

A table is a TOML file.  Classes stand in it from the worst on; a cell belongs to the first class of
which an alternative holds, and an alternative holds where all its conditions do::

    title = "..."
    source = "..."

    [[class]]
    name = "high"
    color = "#d7191c"
    any = [
      { peak_depth = "> 1.0", peak_speed = "> 1.0" },
      { peak_pressure = "> strength" },
    ]

    [[class]]  # without conditions: wherever else the flow comes
    name = "medium"
    color = "#3f6fd0"

    [limit.strength]  # linear between points over a layer, beyond them as at the last
    of = "peak_depth"
    at = [0.5, 1.0, 2.0]
    is = [13.8, 7.7, 4.9]
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.toml_text import MOST_BYTES, WrongTomlError, tables_of
from debrisflow.case.words import did_you_mean, either
from debrisflow.errors import CaseError, steers
from debrisflow.files import text_of
from debrisflow.run.layers import LAYERS

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
SHIPPED = Path(__file__).parent / "classes"
OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
}
CONDITION = re.compile(r"\s*([<>=!]+)\s*(.*?)\s*")
COLOR = re.compile(r"#[0-9a-fA-F]{6}")
FEWEST_POINTS = 2


class Condition(NamedTuple):
    """A layer against a number, or against a limit by its name."""

    layer: str
    operator: str
    limit: float | str


class HazardClass(NamedTuple):
    """A class.

    Attributes
    ----------
    name, color : str
        The color as ``#rrggbb``.
    alternatives : tuple of tuple of Condition
        Each a group of conditions that hold together; none for wherever the flow comes.
    """

    name: str
    color: str
    alternatives: tuple[tuple[Condition, ...], ...]


class Limit(NamedTuple):
    """A threshold that depends on a layer, linear between points."""

    layer: str
    at: tuple[float, ...]
    values: tuple[float, ...]


class Classes(NamedTuple):
    """A table of classes, from the worst on.

    Attributes
    ----------
    name : str
        Of the file.
    title, source : str
    classes : tuple of HazardClass
    limits : mapping of Limit by name
    """

    name: str
    title: str
    source: str
    classes: tuple[HazardClass, ...]
    limits: Mapping[str, Limit]

    @property
    def layers(self) -> list[str]:
        """Return the names of the layers that the conditions need."""
        asked = [c.layer for one in self.classes for group in one.alternatives for c in group]
        return sorted({*asked, *(limit.layer for limit in self.limits.values())})

    def number(self, place: int) -> int:
        """Return the number of a class in a raster: 1 for the last, more for those before it."""
        return len(self.classes) - place

    def classified(self, reached: Flags, layers: Mapping[str, Floats]) -> Floats:
        """Return the number of the class of each cell; nan where it has none.

        Parameters
        ----------
        reached : bool array
            Where the flow comes.
        layers : mapping of str to float64 array
            The layers of the conditions, nan where they have no data.
        """
        found = np.full(reached.shape, np.nan)
        for place in reversed(range(len(self.classes))):
            groups = self.classes[place].alternatives
            holds = np.zeros(reached.shape, dtype=bool) if groups else reached
            for group in groups:
                holds = holds | self._all_hold(group, layers)
            found[holds & reached] = self.number(place)
        return found

    def _all_hold(self, group: Iterable[Condition], layers: Mapping[str, Floats]) -> Flags:
        holds = [
            OPERATORS[c.operator](layers[c.layer], self._threshold(c.limit, layers)) for c in group
        ]
        found: Flags = np.logical_and.reduce(holds)
        return found

    def _threshold(self, limit: float | str, layers: Mapping[str, Floats]) -> Any:
        if isinstance(limit, float):
            return limit
        known = self.limits[limit]
        return np.interp(layers[known.layer], known.at, known.values)


def shipped() -> dict[str, Path]:
    """Return the tables that come with the package by their names."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def read_classes(asked: str) -> Classes:
    """Return a table of classes by the name of one that is shipped, or by its file.

    Raises
    ------
    CaseError
        If it is neither, or something is wrong with it.
    """
    known = shipped()
    path = known.get(asked, Path(asked))
    if path.suffix != ".toml":
        hint = did_you_mean(asked, known)
        raise CaseError(f"{asked} is no table of classes: give {either(known)}, or a .toml{hint}")
    try:
        data = tables_of(text_of(path, MOST_BYTES))
        return _classes(path.stem, data)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise CaseError(f"{path} cannot be read: {reason}") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path} is not a text file in UTF-8") from error
    except WrongTomlError as error:
        raise CaseError(f"{path} {error}") from error
    except _WrongError as error:
        raise CaseError(f"{path}: {error}") from error


class _WrongError(ValueError):
    """What is wrong with a table, and where."""


def _classes(name: str, data: Mapping[str, Any]) -> Classes:
    _expect_keys("the table", data, ("title", "source", "class"), ("limit",))
    given = data.get("limit", {})
    if not isinstance(given, dict):
        raise _WrongError("limit: must be tables, [limit.NAME]")
    limits = {key: _limit(f"limit.{key}", table) for key, table in given.items()}
    entries = data["class"]
    if not isinstance(entries, list) or not entries:
        raise _WrongError("class: must be tables, [[class]], one at least")
    found = tuple(_class(f"class {k}", entry, limits) for k, entry in enumerate(entries, 1))
    names = [one.name for one in found]
    for k, one in enumerate(names):
        if one in names[:k]:
            before = names.index(one) + 1
            raise _WrongError(f"class {k + 1}: the name '{one}' is that of class {before}")
    title, source = (_text(key, data[key]) for key in ("title", "source"))
    return Classes(name, _line(title), _line(source), found, limits)


def _class(where: str, entry: Any, limits: Mapping[str, Limit]) -> HazardClass:
    _expect_keys(where, entry, ("name", "color"), ("any",))
    name, color = _line(_text(f"{where}: name", entry["name"])), entry["color"]
    where = f"{where} '{name}'"
    if not isinstance(color, str) or not COLOR.fullmatch(color):
        raise _WrongError(f"{where}: color = {color!r} must be text like '#d7191c'")
    groups = entry.get("any", [])
    if "any" in entry and (not isinstance(groups, list) or not groups):
        raise _WrongError(
            f"{where}: any must be a list of tables of conditions, one at least; leave it out for "
            "all other cells that the flow reaches"
        )
    return HazardClass(name, color, tuple(_group(where, group, limits) for group in groups))


def _group(where: str, group: Any, limits: Mapping[str, Limit]) -> tuple[Condition, ...]:
    if not isinstance(group, dict) or not group:
        raise _WrongError(f"{where}: {group!r} must be a table like {{ peak_depth = '> 1.0' }}")
    return tuple(_condition(where, layer, text, limits) for layer, text in group.items())


def _condition(where: str, layer: str, text: Any, limits: Mapping[str, Limit]) -> Condition:
    _expect_layer(where, layer)
    match = CONDITION.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise _WrongError(f"{where}: {layer} = {text!r} must be text like '> 1.0'")
    if match[1] not in OPERATORS:
        raise _WrongError(f"{where}: {layer} = {text!r}: '{match[1]}' must be {either(OPERATORS)}")
    if match[2] in limits:
        return Condition(layer, match[1], match[2])
    try:
        value = float(match[2])
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        hint = did_you_mean(match[2], limits)
        raise _WrongError(
            f"{where}: {layer} = {text!r}: '{match[2]}' is neither a number nor a [limit]{hint}"
        )
    return Condition(layer, match[1], value)


def _limit(where: str, table: Any) -> Limit:
    _expect_keys(where, table, ("of", "at", "is"), ())
    _expect_layer(f"{where}: of", table["of"])
    at, values = (_numbers(f"{where}: {key}", table[key]) for key in ("at", "is"))
    if len(at) != len(values):
        raise _WrongError(f"{where}: at has {len(at)} numbers and is {len(values)}")
    if any(a >= b for a, b in pairwise(at)):
        raise _WrongError(f"{where}: at must increase")
    return Limit(table["of"], at, values)


def _numbers(where: str, given: Any) -> tuple[float, ...]:
    is_list = isinstance(given, list) and len(given) >= FEWEST_POINTS
    if not is_list or not all(type(value) in (int, float) for value in given):
        raise _WrongError(f"{where} must be a list of {FEWEST_POINTS} numbers or more")
    found = tuple(map(float, given))
    if not all(map(isfinite, found)):
        raise _WrongError(f"{where} must hold finite numbers")
    return found


def _text(where: str, given: Any) -> str:
    if not isinstance(given, str) or not given.strip():
        raise _WrongError(f"{where} = {given!r} must be text")
    if steers(given):
        raise _WrongError(f"{where} = {given!r} must be text without control characters")
    return given


def _line(text: str) -> str:
    return " ".join(text.split())


def _expect_layer(where: str, name: Any) -> None:
    if not isinstance(name, str) or name not in LAYERS:
        hint = did_you_mean(name, LAYERS) or f"; there are {', '.join(LAYERS)}"
        raise _WrongError(f"{where}: unknown layer '{name}'{hint}")


def _expect_keys(where: str, table: Any, needed: Iterable[str], others: Iterable[str]) -> None:
    if not isinstance(table, dict):
        raise _WrongError(f"{where} must be a table")
    known = [*needed, *others]
    for key in table:
        if key not in known:
            raise _WrongError(f"{where}: unknown key '{key}'{did_you_mean(key, known)}")
    for key in needed:
        if key not in table:
            raise _WrongError(f"{where}: lacks '{key}'")
