"""Parts that all reports share: a self-contained page, its pictures and its warnings."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from hashlib import sha256
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from debrisflow import __version__
from debrisflow.results.parameters import Parameter, parameters, summary
from debrisflow.results.plots import DESCRIPTIONS
from debrisflow.results.reader import Run
from debrisflow.results.station_figures import figure
from debrisflow.results.words import Words
from debrisflow.run.atomic import made, replaced
from debrisflow.run.names import PICTURES, POSTPROCESS

FILE = "report.html"
RUNNING = "still running, or interrupted"
WHOLE_FROM = 1000.0  # figures without decimals
LARGEST_PICTURE = 8 * 2**20  # bytes, of one that a page still carries
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


class Picture(NamedTuple):
    """An image of the page, in its text.

    Attributes
    ----------
    name, text : str
        Of the file, and what it shows.
    source : str
        A data URL.
    """

    name: str
    text: str
    source: str


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
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("debrisflow.results", "templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figure"] = figure
    environment.filters["rounded"] = rounded
    looks = as_it_stands("page.css") + (as_it_stands(style) if style else Markup())
    program = as_it_stands(script) if script else Markup()
    parts = {"style": looks, "script": program, "policy": policy(looks, program)}
    known = _common(run) | parts | {"words": words, "pictures": pictures(run.folder / PICTURES)}
    page = environment.get_template(template).render(**known, **contents)
    path = made(run.folder / POSTPROCESS) / FILE
    with replaced(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    return path


def rounded(value: float) -> str:
    """Return a figure of four digits, large ones whole and in groups of three digits.

    Examples
    --------
    >>> rounded(12000.4), rounded(0.31124)
    ('12,000', '0.3112')
    """
    return f"{value:,.0f}" if abs(value) >= WHOLE_FROM else figure(value)


def as_it_stands(name: str) -> Markup:
    """Return the text of a file of the templates."""
    return Markup(files("debrisflow.results").joinpath("templates", name).read_text("utf-8"))


def policy(style: str, script: str) -> str:
    """Return what a browser lets a page do: no network, and no style or script but these.

    Whatever stands in a title or a name is text; if it ever came to be more, it would not run.

    Examples
    --------
    >>> policy("", "").partition("; style")[0]
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:"
    """
    known = {
        kind: "'sha256-" + b64encode(sha256(text.encode()).digest()).decode() + "'"
        for kind, text in (("style", style), ("script", script))
        if text
    }
    rules = ["default-src 'none'", "base-uri 'none'", "form-action 'none'", "img-src data:"]
    return "; ".join([*rules, *(f"{kind}-src {digest}" for kind, digest in known.items())])


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


def is_picture(file: Path) -> bool:
    """Return whether a file is a picture that a page can carry, by its first bytes and its size."""
    if not file.is_file() or file.stat().st_size > LARGEST_PICTURE:
        return False
    with file.open("rb") as stream:
        return stream.read(6).startswith((b"\x89PNG", b"GIF8"))


def picture(file: Path, known: Mapping[str, str] = DESCRIPTIONS) -> Picture:
    """Return a picture with what it shows, of what is known by the names of files."""
    data = b64encode(file.read_bytes()).decode("ascii")
    name = file.stem.replace("_", " by ", 1) if file.parent.name == PICTURES else file.stem
    name = name.replace("_", " ")
    source = f"data:image/{file.suffix[1:]};base64,{data}"
    return Picture(name, known.get(file.stem, name), source)
