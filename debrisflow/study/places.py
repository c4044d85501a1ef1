"""The places of a case that a study sets, each of them once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from debrisflow.case.former_names import present_key
from debrisflow.case.overrides import ENTRY
from debrisflow.case.problems import Problem, Problems, by_name
from debrisflow.errors import CaseError
from debrisflow.study.tables import Study

Keys = tuple[str, ...]
"""From table to table, the path to a value."""


def overlaps(study: Study, path_of: Callable[[str], Keys]) -> Problems:
    """Yield the keys of parameters that set a place, or a part of one, that is set already.

    Parameters
    ----------
    study : Study
    path_of : callable
        Returns the path of a key through the tables of the case.
    """
    known: list[tuple[Keys, str, str]] = []
    for k, parameter in enumerate(study.parameter):
        for key in parameter.keys:
            path = path_of(key)
            for other, other_key, owner in known:
                if message := _overlap(path, other, key, other_key, owner):
                    yield Problem(f"parameter.{k}.key", message, key)
            known.append((path, key, parameter.name))


def _overlap(path: Keys, other: Keys, key: str, other_key: str, owner: str) -> str:
    """Return what is wrong with a path beside another one, nothing if they are apart."""
    if path == other:
        spelled = "" if key == other_key else f", as {other_key}"
        return f"'{owner}' sets it too{spelled}; leave one out"
    common = min(len(path), len(other))
    if path[:common] != other[:common]:
        return ""
    whole = "is a part of" if len(path) > common else "holds"
    return f"{whole} {other_key}, which '{owner}' sets; leave one out"


def expect_apart(study: Study, complete: Mapping[str, Any]) -> None:
    """Refuse parameters that set one place of the case under several keys, or parts of it.

    What ``[set]`` gives to a place is a start, which a parameter multiplies or replaces; but it is
    lost within a table that a parameter sets as a whole.

    Parameters
    ----------
    study : Study
    complete : mapping
        The tables of the base case, all of them.

    Raises
    ------
    CaseError
        With every such key, one a line.
    """

    def path_of(key: str) -> Keys:
        return tuple(resolved(key, complete))

    problems = [*overlaps(study, path_of), *_lost(study, path_of)]
    if problems:
        arrays = {"parameter": study.parameter}
        raise CaseError("\n".join(by_name(problem, arrays) for problem in problems))


def _lost(study: Study, path_of: Callable[[str], Keys]) -> Problems:
    """Yield the parameters that set a whole table of which ``[set]`` changes a part."""
    changes = {key: path_of(key) for key, _ in flat(study.set)}
    for k, parameter in enumerate(study.parameter):
        for key in () if parameter.is_factor else parameter.keys:
            path = path_of(key)
            for changed, inner in changes.items():
                if len(inner) > len(path) and inner[: len(path)] == path:
                    message = f"holds {changed}, which [set] changes; leave one out"
                    yield Problem(f"parameter.{k}.key", message, key)


def flat(tables: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables by their dotted keys.

    Examples
    --------
    >>> list(flat({"particles": {"spacing": 2.0}, "time.end": 1.0}))
    [('particles.spacing', 2.0), ('time.end', 1.0)]
    """
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{before}{key}.")
        else:
            yield before + key, value


def resolved(key: str, complete: Mapping[str, Any]) -> Iterator[str]:
    """Yield the parts of a key as it is called now, entries of arrays by their number.

    Examples
    --------
    >>> case = {"release": [{"name": "torrent"}, {"name": "gully"}]}
    >>> list(resolved("release.gully.x", case)), list(resolved("release.01.x", case))
    (['release', '1', 'x'], ['release', '1', 'x'])
    >>> list(resolved("strength.law", case))
    ['rheology', 'type']
    """
    geometry = complete.get("geometry", {})
    node: Any = complete
    for part in present_key(key, geometry.get("type")).split("."):
        if isinstance(node, list):
            names = [entry.get("name") if isinstance(entry, Mapping) else None for entry in node]
            if ENTRY.fullmatch(part):
                part = str(int(part))
            elif part in names:
                part = str(names.index(part))
            node = node[int(part)] if part.isdecimal() and int(part) < len(node) else None
        else:
            node = node.get(part) if isinstance(node, Mapping) else None
        yield part
