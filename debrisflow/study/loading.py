"""From the file of a study to a checked study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from debrisflow.case.loading import MOST_TOLD, schema_of, tables_of_file
from debrisflow.case.problems import Problem, by_name, translate
from debrisflow.case.text_checks import plain_texts
from debrisflow.case.toml_text import fault_of_structure
from debrisflow.errors import CaseError
from debrisflow.study.checks import problems_of
from debrisflow.study.tables import Study


def load_study(path: Path | str) -> Study:
    """Return the study of a file, checked, with the names of its files as absolute paths.

    Raises
    ------
    CaseError
        With every problem of the file, one a line.
    """
    path = Path(path)
    data = tables_of_file(path)
    if fault := fault_of_structure(data):
        raise CaseError(f"{path}: {fault}")
    unread = _find_files(data, path.parent)
    try:
        study = Study.model_validate(data)
    except ValidationError as error:
        faults = [translate(one, data, Study) for one in error.errors(include_url=False)]
        raise _refused(path, data, [*filter(None, faults), *unread]) from error
    if problems := [*unread, *plain_texts(data), *problems_of(study)]:
        raise _refused(path, data, problems)
    return study


def study_schema() -> str:
    """Return the JSON schema of a study file, with the unit of every quantity."""
    return schema_of(Study, "debrisflow study")


def _refused(path: Path, data: dict[str, Any], problems: list[Problem]) -> CaseError:
    count = f"{len(problems)} error" + ("s" if len(problems) > 1 else "")
    lines = [f"  {by_name(problem, data)}" for problem in problems[:MOST_TOLD]]
    return CaseError("\n".join([f"{path}: {count}", *lines]))


def _find_files(data: dict[str, Any], folder: Path) -> list[Problem]:
    """Make the names of files absolute, in place, and return those that there are not."""
    named = [(data, "case", "case")]
    if isinstance(data.get("design"), dict):
        named.append((data["design"], "file", "design.file"))
    observed = data.get("observation")
    for number, entry in enumerate(observed if isinstance(observed, list) else []):
        if isinstance(entry, dict):
            named.append((entry, "file", f"observation.{number}.file"))
    problems = []
    for table, name, key in named:
        if not isinstance(table.get(name), str):
            continue
        file = folder.absolute() / table[name]
        if not file.is_file():
            problems.append(Problem(key, f"no such file in {folder}", table[name]))
        table[name] = str(file)
    return problems
