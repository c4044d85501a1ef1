"""From a case file to a checked and completed case, and back."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import ValidationError, create_model

from debrisflow.case.checks import cross_check
from debrisflow.case.defaults import complete
from debrisflow.case.fields import NONE, Table
from debrisflow.case.hydrograph import inline_hydrograph
from debrisflow.case.meshes import find_meshes
from debrisflow.case.motion_files import inline_motions
from debrisflow.case.overrides import apply_overrides
from debrisflow.case.problems import Problem, locate, translate
from debrisflow.case.resolved import ResolvedCase
from debrisflow.case.tables import Case, follow_dimension
from debrisflow.errors import CaseError

# Two or three numbers, which the writer spreads over as many lines and two.
_FEW_NUMBERS = re.compile(r"\[\n((?: *[-+.\w]+,\n){2,3}) *\]")
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
    data = _read(path)
    problems = apply_overrides(data, overrides)
    unread = find_meshes(data, path.parent)
    if supply := inline_hydrograph(data, path.parent):
        unread["inflow"] = supply
    if moves := inline_motions(data, path.parent):
        unread.setdefault("obstacle", []).extend(moves)
    tables, wrong = _build(data)
    for name, reasons in unread.items():
        tables.pop(name, None)
        problems += reasons
    problems += wrong + cross_check(tables)
    if problems:
        count = f"{len(problems)} error" + ("s" if len(problems) > 1 else "")
        raise CaseError("\n".join([f"{path}: {count}", *(f"  {problem}" for problem in problems)]))
    return complete(Case.model_validate(data))


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
    schema = Case.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "debrisflow case"
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


def _read(path: Path) -> dict[str, Any]:
    """Return the contents of a TOML file, with the comment at its head as its notes."""
    try:
        text = path.read_text(encoding="utf-8")
        return {"notes": _head_comment(text)} | tomllib.loads(text)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise CaseError(f"{path}: cannot be read: {reason}") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path}: is not a text file in UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: is not valid TOML: {error}") from error


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
        errors = error.errors(include_url=False)
    problems = [problem for item in errors if (problem := translate(item))]
    unknown = [locate(item["loc"]).keys for item in errors if item["type"] == "extra_forbidden"]
    return _buildable(_without(data, unknown)), problems


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
