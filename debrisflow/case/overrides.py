"""Changes to a case from the command line: ``--set particles.spacing=0.01``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from debrisflow.case.former_names import present_key
from debrisflow.case.problems import Problem
from debrisflow.case.toml_text import WrongTomlError, tables_of
from debrisflow.case.words import did_you_mean, either

ENTRY = re.compile(r"[0-9]{1,9}")  # of an array, by its number
# Fields of which one stands for the others: setting it takes the others out of the file.
_ALTERNATIVES = (
    ({"inflow.discharge"}, {"inflow.velocity"}, {"inflow.hydrograph"}),
    ({"gravity.vector"}, {"gravity.acceleration", "gravity.slope"}),
)


def apply_overrides(
    data: dict[str, Any], overrides: Sequence[str]
) -> tuple[list[str], list[Problem]]:
    """Set the given keys of a case as read from TOML, in place.

    Parameters
    ----------
    data : dict
        The case; changed in place.
    overrides : sequence of str
        Each ``a.b.c=VALUE``, an array entry by its index (``fill.0.x=[0, 1]``) or, if it has one,
        its name (``probe.gauge.size=0.1``).  The value is TOML; what is not, is taken as text, so
        that words need no quotes.

    Returns
    -------
    notes : list of str
        Keys that are called otherwise now, a line each.
    problems : list of Problem
        Overrides that could not be made.  An unknown key is set and found with all the others.
    """
    notes: list[str] = []
    problems: list[Problem] = []
    made: set[str] = set()
    shape = _shape(data, overrides)
    for override in overrides:
        given, equals, text = (part.strip() for part in override.partition("="))
        key = present_key(given, shape)
        if key != given:
            notes.append(f"{given}: now called {key}")
        if not key or not equals:
            problems.append(Problem(f"--set {override}", "must be KEY=VALUE"))
            continue
        problem = _assign(data, key.split("."), parse_value(text))
        if problem:
            problems.append(problem)
        made.add(key)
    _drop_alternatives(data, made)
    return notes, problems


def _shape(data: dict[str, Any], overrides: Sequence[str]) -> object:
    """Return the type of the geometry after the overrides."""
    geometry = data.get("geometry")
    shape = geometry.get("type") if isinstance(geometry, dict) else None
    for override in overrides:
        key, _, text = override.partition("=")
        if key.strip() == "geometry.type":
            shape = parse_value(text)
    return shape


def parse_value(text: str) -> Any:
    """Return a TOML value, or the text itself where it is none.

    Examples
    --------
    >>> parse_value("0.01"), parse_value("[0, 1]"), parse_value("study")
    (0.01, [0, 1], 'study')
    """
    try:
        parsed = tables_of(f"value = {text}")
    except WrongTomlError:
        return text.strip()
    return parsed["value"] if len(parsed) == 1 else text


def _assign(data: dict[str, Any], parts: list[str], value: Any) -> Problem | None:
    """Set one value, making the tables on its way that are not there yet."""
    node: Any = data
    for k, part in enumerate(parts):
        key = ".".join(parts[: k + 1])
        step: str | int = part
        if isinstance(node, list):
            names = [item.get("name") if isinstance(item, dict) else None for item in node]
            if ENTRY.fullmatch(part) and int(part) < len(node):
                step = int(part)
            elif part in names:
                step = names.index(part)
            else:
                named = [name for name in names if isinstance(name, str)]
                by_name = (
                    f", or by name {either(named)}{did_you_mean(part, named)}" if named else ""
                )
                return Problem(
                    key, f"no such entry; there are {len(node)}, counted from 0{by_name}"
                )
        elif not isinstance(node, dict):
            return Problem(key, "unknown key", value)
        if k == len(parts) - 1:
            node[step] = value
        elif isinstance(node, dict):
            node = node.setdefault(part, {})
        else:
            node = node[step]
    return None


def _drop_alternatives(data: dict[str, Any], made: set[str]) -> None:
    """Take out of the file what an override stands for, unless it was overridden too."""
    for ways in _ALTERNATIVES:
        chosen = [way for way in ways if way & made]
        if not chosen:
            continue
        for key in set().union(*ways) - set().union(*chosen):
            table, name = key.split(".")
            if isinstance(data.get(table), dict):
                data[table].pop(name, None)
