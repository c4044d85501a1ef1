"""The members of a study: cases that differ in some values, addressed by their content."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from debrisflow.case import ResolvedCase, dump_case, load_case
from debrisflow.case.content import content_of, digest_of
from debrisflow.case.loading import tables_of_file
from debrisflow.case.overrides import apply_overrides
from debrisflow.errors import CaseError
from debrisflow.study.distributions import AnyParameter, Value, Values
from debrisflow.study.places import expect_apart, flat, resolved
from debrisflow.study.tables import Study

DIGITS = 16  # of the digest in the name of a folder
WORDS = ("title", "notes")  # which change no result


class Member(NamedTuple):
    """One run of a study.

    Attributes
    ----------
    number : int
        In the order of the design, from 0 on.
    values : dict
        Of the parameters, by name.
    case : ResolvedCase
    digest : str
        SHA-256 of what its results depend on.
    folder : Path
        Of the run.
    """

    number: int
    values: Values
    case: ResolvedCase
    digest: str
    folder: Path


class Cases:
    """Makes the cases of a study.

    Parameters
    ----------
    study : Study

    Attributes
    ----------
    base : ResolvedCase
        The case with the changes that all members have.

    Raises
    ------
    CaseError
        If the case is wrong, or has nothing to multiply where a factor is asked for.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._changes = [f"{key}={toml_of(value)}" for key, value in flat(study.set)]
        self._path = Path(study.case)
        self.base = load_case(self._path, self._changes)
        self._given = tables_of_file(self._path)
        apply_overrides(self._given, self._changes)
        self._complete = tomllib.loads(dump_case(self.base))
        expect_apart(study, self._complete)

    def at(self, values: Values) -> ResolvedCase:
        """Return the case with the given values of the parameters.

        Raises
        ------
        CaseError
            If a value is none that a case may have.
        """
        changes: dict[str, Any] = {}
        for parameter in self._study.parameter:
            self._set(parameter, values[parameter.name], changes)
        given = [f"{key}={toml_of(value)}" for key, value in changes.items()]
        try:
            return load_case(self._path, [*self._changes, *given])
        except CaseError as error:
            raise CaseError(f"with {shown_values(values)}: {error}") from error

    def _set(self, parameter: AnyParameter, value: Value, changes: dict[str, Any]) -> None:
        """Add to the changes, by key, those that give a parameter its value."""
        for key in parameter.keys:
            parts = key.split(".")
            new: Any = value
            if parameter.is_factor:
                new = _scaled(_at(self._complete, parts), value)
            if new is None:
                raise CaseError(
                    f"parameter.{parameter.name}.key = {key}: {self._path} has no number there, "
                    "nor a list of numbers, that a factor could multiply"
                )
            table = self._named_by_file(parts)
            if table is None:
                changes[key] = new
                continue
            name = ".".join(resolved(".".join(table), self._complete))
            whole = changes.setdefault(name, deepcopy(_at(self._complete, table)))
            _at(whole, parts[len(table) : -1])[parts[-1]] = new

    def _named_by_file(self, parts: Sequence[str]) -> list[str] | None:
        """Return the path of the table for which the case names a file, on the way to a value."""
        for k in range(1, len(parts)):
            if isinstance(_at(self._given, parts[:k]), str):
                return list(parts[:k])
        return None


def members_of(cases: Cases, store: Path, points: Sequence[Values], program: str) -> list[Member]:
    """Return the members at some points.

    Parameters
    ----------
    cases : Cases
    store : Path
        Folder of all runs.
    points : sequence of dict
        Values of the parameters by name.
    program : str
        The program and what its machine code comes from: another one has other results.

    Raises
    ------
    CaseError
        If a case is wrong.
    """
    made = []
    for number, values in enumerate(points):
        case = cases.at(values)
        digest = address(case, program)
        made.append(Member(number, values, case, digest, store / digest[:DIGITS]))
    return made


def address(case: ResolvedCase, program: str) -> str:
    """Return the SHA-256 of what the results of a case depend on: its content and the program.

    Raises
    ------
    CaseError
        If a file that the case names cannot be read.
    """
    content = {key: value for key, value in content_of(case).items() if key not in WORDS}
    system = case.terrain.levels.grid.crs if case.is_terrain else ""  # may come from a .prj
    return sha256(f"{program}\n{system}\n{digest_of(content)}".encode()).hexdigest()


def toml_of(value: Any) -> str:
    """Return a value as TOML, in one line; whole numbers without a decimal point.

    A number that is whole is one for the fields that want either.

    Examples
    --------
    >>> toml_of(2.0), toml_of([0.5, "x"]), toml_of({"time": [0.0, 1.5]})
    ('2', '[0.5, "x"]', '{time = [0, 1.5]}')
    """
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {toml_of(part)}" for key, part in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_of, value)) + "]"
    if isinstance(value, float) and value.is_integer() and abs(value) < 2.0**53:
        return str(int(value))
    return json.dumps(value, ensure_ascii=False)


def shown_values(values: Values) -> str:
    """Return the values of a member as people read them.

    Examples
    --------
    >>> shown_values({"friction": 0.123456, "dem": "a.asc"})
    'friction = 0.1235, dem = a.asc'
    """
    return ", ".join(
        f"{name} = {value:.4g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in values.items()
    )


def _at(part: Any, keys: Sequence[str]) -> Any:
    """Return what stands at a path of keys, None if nothing; entries by name or number."""
    for key in keys:
        if isinstance(part, list):
            named = [
                entry for entry in part if isinstance(entry, dict) and entry.get("name") == key
            ]
            counted = part[int(key) : int(key) + 1] if key.isdecimal() else []
            part = (named or counted or [None])[0]
        elif isinstance(part, Mapping):
            part = part.get(key)
        else:
            return None
    return part


def _scaled(value: Any, factor: Value) -> Any:
    """Return a number, or a list of numbers, times a factor; None for anything else."""
    if isinstance(factor, str):
        return None
    if isinstance(value, list) and value:
        parts = [_scaled(part, factor) for part in value]
        return None if None in parts else parts
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value * factor
    return None
