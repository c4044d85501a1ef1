"""The files of a run that two computations of the same case must have in common."""

from __future__ import annotations

import json
from pathlib import Path

LEFT_OUT = {
    "run.log",
    "status.json",
    "run.lock",
    "checkpoint.h5",
    "checkpoint_before.h5",
    "filler",
    "member.json",
}
MEASURED = ("wall_", "compile_", "particle_steps_per", "seconds_per")  # of the machine, not the run


def result_files(folder: Path) -> set[str]:
    """Return the names of the files of a run that are compared."""
    found = (f for f in folder.rglob("*") if f.is_file() and f.name not in LEFT_OUT)
    return {f.relative_to(folder).as_posix() for f in found}


def differing_files(one: Path, other: Path) -> list[str]:
    """Return the names of the files that only one of two runs has, or that have other contents."""
    ours, theirs = result_files(one), result_files(other)
    both = sorted(ours & theirs)
    return sorted(ours ^ theirs) + [name for name in both if not _is_same(one / name, other / name)]


def _is_same(one: Path, other: Path) -> bool:
    if one.name == "summary.json":
        return _figures(one) == _figures(other)
    return one.read_bytes() == other.read_bytes()


def _figures(summary: Path) -> dict[str, object]:
    """Return the figures of a summary that do not depend on wall time."""
    figures = json.loads(summary.read_text(encoding="utf-8"))
    return {name: value for name, value in figures.items() if not name.startswith(MEASURED)}
