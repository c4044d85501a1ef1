"""A page on a run, to hand to somebody: one HTML file that needs nothing else."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from debrisflow import __version__
from debrisflow.results.answers import answers_by_heading
from debrisflow.results.maps.layers import has_layers
from debrisflow.results.maps.web import web_map
from debrisflow.results.parameters import Parameter, parameters, summary
from debrisflow.results.plots import DESCRIPTIONS
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import told_span
from debrisflow.results.references import Reference, distances_to_all
from debrisflow.results.station_figures import cells, figure
from debrisflow.results.stations import VOLUME
from debrisflow.results.survey import Survey
from debrisflow.results.words import ENGLISH, Words
from debrisflow.run.atomic import replaced
from debrisflow.run.folder import MAPS, PICTURES, POSTPROCESS

FILE = "report.html"
RUNNING = "still running, or interrupted"
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


def report(found: Survey, given: Sequence[Reference] = (), language: str = ENGLISH) -> Path:
    """Write tables, plots and ``report.html`` of a survey, and return the page.

    Pictures that ``debrisflow render`` and ``debrisflow maps`` have made before are on it, and a
    map that needs no network if the run has layers.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    written, _ = postprocess(found, given)
    words, folder = Words(language), found.run.folder
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("debrisflow.results", "templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figure"] = figure
    page = environment.get_template("report.html").render(
        **_contents(found, given),
        words=words,
        map=web_map(found.run, words) if has_layers(found.run) else None,
        script=_own("map.js"),
        style=_own("map.css"),
        plots=[_picture(file) for file in written if file.suffix == ".png"],
        sheets=_pictures(folder / MAPS),
        pictures=_pictures(folder / PICTURES),
    )
    path = folder / POSTPROCESS / FILE
    with replaced(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    return path


def _own(name: str) -> Markup:
    """Return a file of the templates as it stands."""
    return Markup(files("debrisflow.results").joinpath("templates", name).read_text("utf-8"))


def _warnings(found: Survey) -> list[str]:
    """Return what a reader of the page must know before its figures."""
    run, end = found.run, found.run.case.time.end
    told = [f"of the run: {line}" for line in run.warnings]
    if run.times[-1] < end * (1.0 - 1e-9):
        told.append(f"the results end at t = {run.times[-1]:g} s of {end:g} s")
    if found.mobility is not None and found.mobility.bound:
        told.append(f"the run-out is {found.mobility.bound}")
    return told


def _contents(found: Survey, given: Sequence[Reference]) -> dict[str, Any]:
    run, last = found.run, float(found.run.times[-1])
    return {
        "title": run.case.title,
        "name": run.name,
        "status": run.summary.get("end_reason", RUNNING),
        "time": last,
        "end": run.case.time.end,
        "dimension": run.case.dimension,
        "notes": run.case.notes.split("\n\n") if run.case.notes else [],
        "summary": summary(run.case),
        "answers": answers_by_heading(found),
        "parameters": _tables(parameters(run.case)),
        "timing": _timing(run.summary),
        "versions": run.summary.get("versions", {}),
        "warnings": _warnings(found),
        "stations": cells(found.station_figures, VOLUME[run.case.dimension]),
        "probes": found.probe_figures,
        "span": told_span(found.smoothing),
        "distances": [row for row in distances_to_all(found, given) if row.points],
        "version": __version__,
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "window": found.window,
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


def _pictures(folder: Path) -> list[Picture]:
    files = sorted([*folder.glob("*.png"), *folder.glob("*.gif")])
    return [_picture(file) for file in files if file.stat().st_size <= LARGEST_PICTURE]


def _picture(file: Path) -> Picture:
    data = b64encode(file.read_bytes()).decode("ascii")
    name = file.stem.replace("_", " by ", 1) if file.parent.name == PICTURES else file.stem
    name = name.replace("_", " ")
    source = f"data:image/{file.suffix[1:]};base64,{data}"
    return Picture(name, DESCRIPTIONS.get(file.stem, name), source)
