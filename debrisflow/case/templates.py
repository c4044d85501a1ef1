"""The shipped cases as templates for new ones, comments kept."""

from __future__ import annotations

import tomllib
from pathlib import Path

from debrisflow.case.words import did_you_mean
from debrisflow.errors import CaseError, OutputError

SCHEMA = "case.schema.json"


def templates() -> dict[str, Path]:
    """Return the shipped case files by name.

    A wheel carries them inside the package; in a source tree they stand beside it.
    """
    package = Path(__file__).parents[1]
    for folder in (package / "cases", package.parent / "cases"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def titles() -> dict[str, str]:
    """Return the titles of the shipped cases by name."""
    return {
        name: str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        for name, path in templates().items()
    }


def start_case(target: Path, template: str) -> list[Path]:
    """Copy a shipped case, what it names and its schema, and return what was written.

    Raises
    ------
    CaseError
        If there is no such template.
    OutputError
        If a file is there already.
    """
    known = templates()
    if template not in known:
        hint = did_you_mean(template, known)
        there = ", ".join(known) or "none were installed"
        raise CaseError(f"no template '{template}'{hint}\ntemplates: {there}")
    source = known[template]
    copies = {source: target}
    supply = tomllib.loads(source.read_text(encoding="utf-8")).get("inflow", {}).get("hydrograph")
    if isinstance(supply, str):
        copies[source.parent / supply] = target.parent / supply
    schema = source.parent / SCHEMA
    if schema.is_file() and not (target.parent / SCHEMA).exists():
        copies[schema] = target.parent / SCHEMA
    for copy in copies.values():
        if copy.exists():
            raise OutputError(f"{copy}: is there already; choose another name")
    for original, copy in copies.items():
        _write(copy, original.read_bytes())
    return list(copies.values())


def _write(path: Path, content: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {(error.strerror or '').lower()}") from error
