"""Names and words of former case files: they still load, and the present ones are told.

This is the one place that knows them; the tables and their schema have the present names only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from debrisflow.case.problems import Problem, show
from debrisflow.case.words import ABSENT

TANK_WIDTH = "geometry.width"
NAMES = (
    ("strength.law", "strength.type"),  # before its table, by whose name it is known
    ("strength", "rheology"),
    (TANK_WIDTH, "geometry.length"),  # of a tank in two dimensions; others have a width across
    ("time.relaxation", "time.settling"),
)
MATERIALS = {"mix": "two-phase"}


def use_present_names(data: dict[str, Any]) -> tuple[list[str], list[Problem]]:
    """Replace the former names in a case as read from TOML, in place.

    Parameters
    ----------
    data : dict
        The case; changed in place.

    Returns
    -------
    notes : list of str
        What is called otherwise now, a line each.
    problems : list of Problem
        Names that are given beside the present ones, which take their place.

    Examples
    --------
    >>> case = {"strength": {"law": "coulomb"}, "fill": [{"material": "mix"}]}
    >>> for note in use_present_names(case)[0]:
    ...     print(note)
    strength.law: now called rheology.type
    strength: now called rheology
    fill.0.material = "mix": now called "two-phase"
    >>> case
    {'fill': [{'material': 'two-phase'}], 'rheology': {'type': 'coulomb'}}
    """
    notes: list[str] = []
    problems: list[Problem] = []
    for former, present in NAMES:
        *table, old = former.split(".")
        node = data.get(table[0]) if table else data
        if not isinstance(node, dict) or old not in node:
            continue
        if former == TANK_WIDTH and node.get("type") != "tank":
            continue
        value, new = node.pop(old), present.split(".")[-1]
        name = present_key(present, "tank")
        if new in node:
            message = f"the former name of '{name}', which is given as well; leave it out"
            problems.append(Problem(former, message, ABSENT if isinstance(value, dict) else value))
        else:
            node[new] = value
            notes.append(f"{former}: now called {name}")
    return notes + _use_present_materials(data), problems


def _use_present_materials(data: Mapping[str, Any]) -> list[str]:
    fills, notes = data.get("fill"), []
    for k, part in enumerate(fills if isinstance(fills, list) else ()):
        old = part.get("material") if isinstance(part, dict) else None
        if isinstance(old, str) and old in MATERIALS:
            part["material"] = MATERIALS[old]
            notes.append(f"fill.{k}.material = {show(old)}: now called {show(MATERIALS[old])}")
    return notes


def present_key(key: str, shape: object) -> str:
    """Return a dotted key by its present name.

    Parameters
    ----------
    key : str
    shape : object
        ``geometry.type`` of the case.

    Examples
    --------
    >>> present_key("strength.law", "tank"), present_key("fill.0.x", "tank")
    ('rheology.type', 'fill.0.x')
    >>> present_key("geometry.width", "tank"), present_key("geometry.width", "tank3d")
    ('geometry.length', 'geometry.width')
    """
    for former, present in NAMES:
        if former == TANK_WIDTH and shape != "tank":
            continue
        if key == former or key.startswith(f"{former}."):
            key = present + key.removeprefix(former)
    return key
