"""Parts that the reports on runs share: their page, its pictures and its warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from typing import Any

from debrisflow import __version__
from debrisflow.results.html import Picture, is_picture, picture_of, write_html
from debrisflow.results.parameters import Parameter, parameters, summary
from debrisflow.results.plots import DESCRIPTIONS
from debrisflow.results.reader import Run
from debrisflow.results.words import Words
from debrisflow.run.atomic import made
from debrisflow.run.names import PICTURES, POSTPROCESS

FILE = "report.html"
RUNNING = "still running, or interrupted"
TIMING = (
    ("wall_seconds", "wall time, without compiling", "{:.0f} s"),
    ("compile_seconds", "compiling kernels, once", "{:.0f} s"),
    ("steps", "steps", "{}"),
    ("seconds_per_step", "seconds a step", "{:.3g}"),
    ("particles", "particles at the end, walls included", "{}"),
    ("particle_steps_per_second", "particle steps a second", "{:.3g}"),
    ("threads", "threads", "{}"),
    ("threading_layer", "threading layer", "{}"),
)


def write_page(
    run: Run,
    template: str,
    words: Words,
    contents: Mapping[str, Any],
    style: str = "",
    script: str = "",
) -> Path:
    """Write ``report.html`` of a run by a template, and return it.

    Parameters
    ----------
    run : Run
    template : str
    words : Words
    contents : mapping
        What the template names, beside what all pages have.
    style, script : str
        Files of the templates that only this kind of page has.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    known = _common(run) | {
        "words": words,
        "language": words.language,
        "pictures": pictures(run.folder / PICTURES),
    }
    path = made(run.folder / POSTPROCESS) / FILE
    write_html(path, template, {**known, **contents}, style=style, script=script)
    return path


def warnings_of(run: Run) -> list[str]:
    """Return the warnings that stand before the figures of any run."""
    messages = [f"of the run: {line}" for line in run.warnings]
    if run.times[-1] < run.case.time.end * (1.0 - 1e-9):
        messages.append(f"the results end at t = {run.times[-1]:g} s of {run.case.time.end:g} s")
    return messages


def _common(run: Run) -> dict[str, Any]:
    return {
        "title": run.case.title,
        "name": run.name,
        "status": run.summary.get("end_reason", RUNNING),
        "time": float(run.times[-1]),
        "end": run.case.time.end,
        "dimension": run.case.dimension,
        "notes": run.case.notes.split("\n\n") if run.case.notes else [],
        "summary": summary(run.case),
        "parameters": _tables(parameters(run.case)),
        "timing": _timing(run.summary),
        "versions": run.summary.get("versions", {}),
        "version": __version__,
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def _tables(fields: Sequence[Parameter]) -> list[tuple[str, list[Parameter]]]:
    """Return the fields of a case by their table, without the text that stands above."""
    kept = [one for one in fields if one.key not in ("title", "notes")]
    return [(name, list(part)) for name, part in groupby(kept, key=lambda one: _table_of(one.key))]


def _table_of(key: str) -> str:
    *path, _ = key.split(".")
    return ".".join(path[:2] if len(path) > 1 and path[1].isdigit() else path[:1])


def _timing(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    known = [(name, form.format(summary[key])) for key, name, form in TIMING if key in summary]
    phases = summary.get("wall_seconds_by_phase", {})
    whole = sum(phases.values())
    parts = phases.items() if whole else ()
    return known + [(f"of which {name}", f"{100 * part / whole:.0f} %") for name, part in parts]


def pictures(folder: Path) -> list[Picture]:
    """Return the pictures in a folder that are not too large for a page."""
    files = sorted([*folder.glob("*.png"), *folder.glob("*.gif")])
    return [picture(file) for file in files if is_picture(file)]


def picture(file: Path, known: Mapping[str, str] = DESCRIPTIONS) -> Picture:
    """Return a picture with what it shows, of what is known by the names of files."""
    name = file.stem.replace("_", " by ", 1) if file.parent.name == PICTURES else file.stem
    name = name.replace("_", " ")
    return picture_of(file, name, known.get(file.stem, name))
