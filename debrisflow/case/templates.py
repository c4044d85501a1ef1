"""The shipped cases as templates for new ones, comments kept."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from debrisflow.case.words import did_you_mean
from debrisflow.errors import CaseError, OutputError

SCHEMA = "case.schema.json"
EXPERIMENTS = "experiments"
"""Folder of the cases that have measurements to compare with beside them."""
DATA = "data"
"""Folder of what other cases are built from and compared with."""


def templates() -> dict[str, Path]:
    """Return the shipped case files by name, as ``flume2d`` or ``experiments/zhou``.

    A wheel carries them inside the package; in a source tree they stand beside it.
    """
    package = Path(__file__).parents[1]
    for folder in (package / "cases", package.parent / "cases"):
        if folder.is_dir():
            found = sorted(folder.glob("*.toml")) + sorted(folder.glob(f"{EXPERIMENTS}/*.toml"))
            return {path.relative_to(folder).with_suffix("").as_posix(): path for path in found}
    return {}


def titles() -> dict[str, str]:
    """Return the titles of the shipped cases by name."""
    return {
        name: str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        for name, path in templates().items()
    }


def start_case(target: Path, template: str) -> list[Path]:
    """Copy a shipped case, what belongs to it and its schema, and return what was written.

    To it belong the files that it names, in its comments too, and, of an experiment, the table of
    the measurements.

    Raises
    ------
    CaseError
        If there is no such template.
    OutputError
        If a file is there already.
    """
    known = templates()
    if template not in known:
        inside = f"{EXPERIMENTS}/{template}"
        hint = f"; did you mean '{inside}'?" if inside in known else did_you_mean(template, known)
        there = ", ".join(known) or "none were installed"
        raise CaseError(f"no template '{template}'{hint}\ntemplates: {there}")
    source = known[template]
    is_experiment = source.parent.name == EXPERIMENTS
    text = source.read_text(encoding="utf-8")
    copies = {target: text.replace("#:schema ../", "#:schema ./", 1)}
    named = _files_of(text)
    for name in (*named, f"{source.stem}.csv") if is_experiment else named:
        copies[target.parent / name] = (source.parent / name).read_text(encoding="utf-8")
    schema = (source.parents[1] if is_experiment else source.parent) / SCHEMA
    if schema.is_file() and not (target.parent / SCHEMA).exists():
        copies[target.parent / SCHEMA] = schema.read_text(encoding="utf-8")
    for copy in copies:
        if copy.exists():
            raise OutputError(f"{copy}: is there already; choose another name")
    for copy, content in copies.items():
        _write(copy, content)
    return list(copies)


def _files_of(text: str) -> list[str]:
    """Return the files that a shipped case names: its hydrograph, and what it has in its data."""
    supply = tomllib.loads(text).get("inflow", {}).get("hydrograph")
    data = sorted(set(re.findall(rf"\b{DATA}/[\w.]*\w", text)))
    return [supply, *data] if isinstance(supply, str) else data


def _write(path: Path, content: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8", newline="\n")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {(error.strerror or '').lower()}") from error
