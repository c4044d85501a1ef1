"""Numbers and lists beyond all that is computed, found before anything is computed with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

from debrisflow.case.problems import Problem, locate

GREATEST = 1.0e15  # of any number; its powers of six lengths and more stay finite
LEAST = 1.0e-15  # of a number that must be greater than 0
Path = tuple[str | int, ...]
SEED = ("particles", "seed")
MOST_ENTRIES = 1000  # of a list of tables, each of which is compared with the others


def faults_of_size(data: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield what is too large or too small to compute with, in the tables of a case.

    Numbers that are not finite are left to the tables.

    Examples
    --------
    >>> [str(fault) for fault in faults_of_size({"time": {"end": 1e30}})]
    ['time.end = 1e+30 s: beyond what can be computed with, 1e+15']
    """
    waiting: list[tuple[Path, Any]] = [((), data)]
    while waiting:
        path, value = waiting.pop()
        is_table = isinstance(value, Mapping)
        if (
            not is_table
            and len(value) > MOST_ENTRIES
            and any(isinstance(v, Mapping) for v in value)
        ):
            yield Problem(_key(path), f"has {len(value)} entries, more than {MOST_ENTRIES}")
            continue
        for key, part in value.items() if is_table else enumerate(value):
            if isinstance(part, Mapping | list | tuple):
                waiting.append(((*path, key), part))
            elif isinstance(part, float | int) and (message := _fault((*path, key), part)):
                yield Problem(_key((*path, key)), message, part)


def _fault(path: Path, value: float) -> str:
    if not isfinite(value):
        return ""
    if abs(value) > GREATEST:
        return "" if path == SEED else f"beyond what can be computed with, {GREATEST:g}"
    if 0.0 < value < LEAST:
        field = locate(path).field
        if field is not None and any(getattr(limit, "gt", None) == 0 for limit in field.metadata):
            return f"too close to 0 to be computed with; at least {LEAST:g}"
    return ""


def _key(path: Path) -> str:
    return ".".join(map(str, path))
