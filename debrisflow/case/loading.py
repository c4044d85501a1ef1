"""From a case file to a checked and completed case, and back."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path, PurePath
from typing import Any

import tomli_w
from pydantic import BaseModel, ValidationError, create_model
from pydantic_core import ErrorDetails

from debrisflow.case.checks import cross_check
from debrisflow.case.defaults import complete
from debrisflow.case.fields import NONE, Table
from debrisflow.case.former_names import use_present_names
from debrisflow.case.hydrograph import inline_hydrograph
from debrisflow.case.magnitudes import faults_of_size
from debrisflow.case.map_files import find_map_files
from debrisflow.case.meshes import find_meshes
from debrisflow.case.motion_files import inline_motions
from debrisflow.case.overrides import apply_overrides
from debrisflow.case.problems import Problem, by_name, locate, translate
from debrisflow.case.resolved import ResolvedCase
from debrisflow.case.tables import Case, follow_dimension
from debrisflow.case.text_checks import plain_texts
from debrisflow.case.toml_text import (
    MOST_BYTES,
    WrongTomlError,
    fault_of_structure,
    tables_of,
)
from debrisflow.errors import CaseError
from debrisflow.files import text_of

# Two or three numbers, which the writer spreads over as many lines and two.
_FEW_NUMBERS = re.compile(r"\[\n((?: *[-+.\w]+,\n){2,3}) *\]")
MOST_TOLD = 100  # problems of a case
_HEAD = """\
# Resolved case: every default is written out, so that the run can be repeated from this file.
# A value that followed from another when it was left out does not follow it any more.

"""


def load_case(path: Path | str, overrides: Sequence[str] = ()) -> ResolvedCase:
    """Return the case of a file, checked completely and with its defaults resolved.

    Parameters
    ----------
    path : Path or str
        The case file.
    overrides : sequence of str
        Changes to it, each ``a.b.c=VALUE``.

    Raises
    ------
    CaseError
        With every problem of the file, one a line.
    """
    path = Path(path)
    return _checked(tables_of_file(path), overrides, path.parent, f"{path}")


def build_case(
    tables: Mapping[str, Any], overrides: Sequence[str] = (), folder: Path | str = "."
) -> ResolvedCase:
    """Return a case that is given as nested dicts, checked and resolved as a case file is.

    Parameters
    ----------
    tables : mapping
        What a case file would hold: numbers, text, lists and dicts by the names of its keys;
        ``fill``, ``obstacle`` and ``probe`` are lists of dicts.  Tuples and arrays stand for lists,
        and what is None is left out.  It is not changed.
    overrides : sequence of str
        Changes to it, each ``a.b.c=VALUE``.
    folder : Path or str
        Where meshes and hydrographs are looked up.

    Raises
    ------
    CaseError
        With every problem of the tables, one a line, in the words that a file would get.

    Examples
    --------
    >>> water = {"type": "block", "x": (0, 0.2), "y": (0, 0.1), "material": "water"}
    >>> case = build_case({
    ...     "title": "a column of water",
    ...     "particles": {"spacing": 0.01},
    ...     "geometry": {"type": "tank", "length": 0.4, "height": 0.3},
    ...     "fill": [water],
    ...     "time": {"end": 1.0},
    ...     "output": {"interval": 0.1},
    ... }, ["time.end=0.5"])
    >>> case.time.end, case.fill[0].x
    (0.5, (0.0, 0.2))
    """
    if not isinstance(tables, Mapping):
        kind = type(tables).__name__
        raise CaseError(
            f"a case is built of a dict of tables, not of {kind}; load_case reads files"
        )
    return _checked(_as_read(tables), overrides, Path(folder), "the case")


def _checked(
    data: dict[str, Any], overrides: Sequence[str], folder: Path, name: str
) -> ResolvedCase:
    """Return the case of data as read from TOML, which are changed in place.

    Parameters
    ----------
    data : dict
    overrides : sequence of str
    folder : Path
        Where the files that it names are looked up.
    name : str
        Of the case, at the head of a list of errors.
    """
    _expect_sound(data, name)
    former_names, problems = use_present_names(data)
    renamed, wrong_ones = apply_overrides(data, overrides)
    _expect_sound(data, name)
    also_former, given_twice = use_present_names(data)  # in the values of the overrides
    former_names += [*renamed, *also_former]
    problems += [*wrong_ones, *given_twice]
    unread = find_meshes(data, folder)
    for table, reasons in find_map_files(data, folder).items():
        unread.setdefault(table, []).extend(reasons)
    if supply := inline_hydrograph(data, folder):
        unread["inflow"] = supply
    if moves := inline_motions(data, folder):
        unread.setdefault("obstacle", []).extend(moves)
    for fault in faults_of_size(data):
        unread.setdefault(fault.key.partition(".")[0], []).append(fault)
    tables, wrong = _build(data)
    for table, reasons in unread.items():
        tables.pop(table, None)
        problems += reasons
    problems += wrong + cross_check(tables)
    faulty = {problem.key for problem in wrong}
    problems += [problem for problem in plain_texts(data) if problem.key not in faulty]
    if problems:
        count = f"{len(problems)} error" + ("s" if len(problems) > 1 else "")
        if len(problems) > MOST_TOLD:
            count = f"more than {MOST_TOLD} errors, of which the first are"
        lines = [f"  {by_name(problem, data)}" for problem in problems[:MOST_TOLD]]
        raise CaseError("\n".join([f"{name}: {count}", *lines]))
    case = complete(Case.model_validate(data))
    return case.keep(case.asked, tuple(former_names))


def _expect_sound(data: dict[str, Any], name: str) -> None:
    """Refuse tables that are nested too deep, or hold what no file of a case may hold."""
    if fault := fault_of_structure(data):
        raise CaseError(f"{name}: {fault}")


def _as_read(value: Any) -> Any:
    """Return a copy of a value as a TOML file would give it.

    Examples
    --------
    >>> _as_read({"x": (0, 1), "file": Path("hill.stl"), "z": None})
    {'x': [0, 1], 'file': 'hill.stl'}
    """
    if isinstance(value, Mapping):
        return {str(key): _as_read(part) for key, part in value.items() if part is not None}
    if isinstance(value, list | tuple):
        return [_as_read(part) for part in value]
    if isinstance(value, PurePath):
        return str(value)
    if hasattr(value, "tolist"):  # arrays and numbers of NumPy, columns of pandas
        return value.tolist()
    return value


def dump_case(case: Case) -> str:
    """Return a case as TOML that loads as the same case.

    What another field stands for is left out: acceleration and slope beside a gravity vector,
    the concentration of a supply beside its hydrograph.  A mesh stays in its file, named by its
    absolute path.
    """
    data = case.model_dump(exclude_none=True)
    if case.gravity.vector is not None:
        del data["gravity"]["acceleration"], data["gravity"]["slope"]
    if case.inflow is not None and case.inflow.hydrograph is not None:
        del data["inflow"]["concentration"]
    text = tomli_w.dumps(data, multiline_strings=True)
    return _HEAD + _FEW_NUMBERS.sub(lambda few: f"[{' '.join(few[1].split()).rstrip(',')}]", text)


def case_schema() -> str:
    """Return the JSON schema of a case file, with the unit of every quantity in its description."""
    return schema_of(Case, "debrisflow case")


def schema_of(tables: type[BaseModel], title: str) -> str:
    """Return the JSON schema of a file by the tables that it may have, as text."""
    schema = tables.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = title
    return json.dumps(_with_units(schema), indent=2) + "\n"


def _with_units(node: Any) -> Any:
    """Return a part of the schema for people: units told, and no null, which TOML does not have."""
    if isinstance(node, list):
        return [_with_units(item) for item in node]
    if not isinstance(node, dict):
        return node
    node = {key: _with_units(value) for key, value in node.items()}
    unit = node.get("unit", NONE)
    if unit != NONE:
        node["description"] = f"{node['description']} [{unit}]"
    options = [option for option in node.get("anyOf", ()) if option != {"type": "null"}]
    if len(options) == 1:
        del node["anyOf"]
        node = options[0] | node
    elif options:
        node["anyOf"] = options
    if isinstance(node.get("default"), dict | None):
        node.pop("default", None)  # a table states the defaults of its fields itself
    return node


def tables_of_file(path: Path) -> dict[str, Any]:
    """Return the contents of a TOML file, unchecked, with the comment at its head as its notes.

    Raises
    ------
    CaseError
        If it cannot be read, or is no TOML.
    """
    try:
        text = text_of(path, MOST_BYTES)
        return {"notes": _head_comment(text)} | tables_of(text)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise CaseError(f"{path}: cannot be read: {reason}") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path}: is not a text file in UTF-8") from error
    except WrongTomlError as error:
        raise CaseError(f"{path}: {error}") from error


def _head_comment(text: str) -> str:
    """Return the lines of comment with which a file begins, without their signs.

    Examples
    --------
    >>> _head_comment("# A flume." + chr(10) + "# Calibrated: nothing.").splitlines()
    ['A flume.', 'Calibrated: nothing.']
    """
    lines: list[str] = []
    if text.startswith(_HEAD):
        return ""
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith("#:"):
            lines.append(line[1:].strip())
    return "\n".join(lines).strip()


def _build(data: dict[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return the tables of a case that can be built, by name, and the problems of the others."""
    try:
        return dict(Case.model_validate(data)), []
    except ValidationError as error:
        errors = _first_faults(error.errors(include_url=False))
    problems = [problem for item in errors[: MOST_TOLD + 1] if (problem := translate(item, data))]
    unknown = [locate(item["loc"]).keys for item in errors if item["type"] == "extra_forbidden"]
    return _buildable(_without(data, unknown)), problems


def _first_faults(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """Return errors without lists that are short only because some of their numbers are wrong."""
    around = {item["loc"][:k] for item in errors for k in range(len(item["loc"]))}
    return [item for item in errors if item["type"] != "too_short" or item["loc"] not in around]


def _buildable(data: dict[str, Any]) -> dict[str, Any]:
    """Return the tables that are right in themselves."""
    failed: set[str | int] = set()
    try:
        return dict(Case.model_validate(data))
    except ValidationError as error:
        failed = {item["loc"][0] for item in error.errors()}
    fields: Mapping[str, Any] = {
        name: (field.annotation, field)
        for name, field in Case.model_fields.items()
        if name not in failed
    }
    part = create_model("Part", __base__=Table, **fields)
    data = follow_dimension(data)
    return dict(part.model_validate({name: data[name] for name in fields if name in data}))


def _without(data: dict[str, Any], unknown: Sequence[Sequence[str | int]]) -> dict[str, Any]:
    """Return a copy of the data without the given keys."""
    data = deepcopy(data)
    for *path, last in unknown:
        node: Any = data
        for step in path:
            node = node[step]
        del node[last]
    return data
