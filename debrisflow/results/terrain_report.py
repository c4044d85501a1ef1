"""A page on a run on a terrain: a map for the browser, maps for print, figures, parameters."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from debrisflow.results.hazard import class_names, read_class_map
from debrisflow.results.html import Picture, is_picture
from debrisflow.results.maps.layers import Layers
from debrisflow.results.maps.web import web_map
from debrisflow.results.page import picture, warnings_of, write_page
from debrisflow.results.plots import DESCRIPTIONS, ON_TERRAIN
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import format_span
from debrisflow.results.reader import Run
from debrisflow.results.references import Reference, distances_to_all
from debrisflow.results.terrain_answers import terrain_answers
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.results.words import ENGLISH, Words
from debrisflow.run.names import MAPS


class Area(NamedTuple):
    """A class with its color and its area, m2, and share of the area of all."""

    name: str
    color: str
    area: float
    share: float


class ClassAreas(NamedTuple):
    """The areas of a map of classes, from the worst on."""

    title: str
    source: str
    areas: list[Area]


def terrain_report(
    found: TerrainSurvey, given: Sequence[Reference] = (), language: str = ENGLISH
) -> Path:
    """Write tables, plots and ``report.html`` of a run on a terrain, and return the page.

    Pictures that ``debrisflow maps`` and ``debrisflow render`` have made before are on it.

    Raises
    ------
    OutputError
        If a table or a layer is missing or damaged, or the folder cannot be written.
    """
    written, _ = postprocess(found, given)
    words, run = Words(language), found.run
    known = DESCRIPTIONS | ON_TERRAIN
    contents: dict[str, Any] = {
        "warnings": _warnings(found),
        "map": web_map(run, words),
        "sheets": sheets(run),
        "answers": terrain_answers(found, words),
        "classes": [class_areas(run, name) for name in class_names(run.folder)],
        "probes": found.probe_figures,
        "span": format_span(found.smoothing),
        "distances": [row for row in distances_to_all(found, given) if row.points],
        "window": found.window,
        "plots": [picture(file, known) for file in written if file.suffix == ".png"],
    }
    return write_page(run, "terrain.html", words, contents, style="map.css", script="map.js")


def _warnings(found: TerrainSurvey) -> list[str]:
    """Return what a reader of the page must know before its figures."""
    messages = warnings_of(found.run)
    if found.mobility.bound:
        messages.append(f"the run-out is {found.mobility.bound}")
    if found.ledger_error:
        messages.append(f"the ledger fails to add up by {found.ledger_error:g} particles")
    return messages


def sheets(run: Run) -> list[Picture]:
    """Return the maps for print that there are, in the order of the layers."""
    files = [run.folder / MAPS / f"{name}.png" for name in Layers(run).names]
    return [picture(file) for file in files if is_picture(file)]


def class_areas(run: Run, name: str) -> ClassAreas:
    """Return the areas of a map of classes."""
    found = read_class_map(run.folder, name)
    values, cell = found.raster.values, found.raster.grid.cell**2
    all_cells = max(int(np.isfinite(values).sum()), 1)
    areas = []
    for number, (word, color) in enumerate(zip(found.names, found.colors, strict=True), 1):
        cells = int((values == number).sum())
        areas.append(Area(word, color, cells * cell, cells / all_cells))
    return ClassAreas(found.title, found.source, areas[::-1])
