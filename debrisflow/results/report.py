"""A page on a run in a flume or a tank: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from debrisflow.results.answers import answers_by_heading
from debrisflow.results.page import picture, warnings_of, write_page
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import format_span
from debrisflow.results.references import Reference, distances_to_all
from debrisflow.results.station_figures import cells
from debrisflow.results.stations import VOLUME
from debrisflow.results.survey import Survey
from debrisflow.results.words import ENGLISH, Words


def report(found: Survey, given: Sequence[Reference] = (), language: str = ENGLISH) -> Path:
    """Write tables, plots and ``report.html`` of a survey, and return the page.

    Pictures that ``debrisflow render`` has made before are on it.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    written, _ = postprocess(found, given)
    plots = [picture(file) for file in written if file.suffix == ".png"]
    contents = _contents(found, given) | {"plots": plots}
    return write_page(found.run, "report.html", Words(language), contents)


def _contents(found: Survey, given: Sequence[Reference]) -> dict[str, Any]:
    messages = warnings_of(found.run)
    if found.mobility is not None and found.mobility.bound:
        messages.append(f"the run-out is {found.mobility.bound}")
    return {
        "answers": answers_by_heading(found),
        "warnings": messages,
        "stations": cells(found.station_figures, VOLUME[found.run.case.dimension]),
        "probes": found.probe_figures,
        "span": format_span(found.smoothing),
        "distances": [row for row in distances_to_all(found, given) if row.points],
        "window": found.window,
    }
