"""A page on a run on a terrain: a map for the browser, maps for print, figures, parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from debrisflow.results.answers import Answer
from debrisflow.results.hazard import class_names, read_class_map
from debrisflow.results.layers import layer_file, read_layer
from debrisflow.results.maps.layers import Layers
from debrisflow.results.maps.web import web_map
from debrisflow.results.page import Picture, as_it_stands, picture, warnings_of, write_page
from debrisflow.results.reader import Run
from debrisflow.results.words import ENGLISH, Words
from debrisflow.run.folder import LEDGER, MAPS
from debrisflow.run.ledger import COLUMNS
from debrisflow.run.tables import read_table

GREATEST = {
    "peak_depth": ("greatest flow depth", "m"),
    "peak_speed": ("greatest flow speed", "m/s"),
    "peak_momentum_flux": ("greatest momentum flux", "m³/s²"),
    "peak_pressure": ("greatest dynamic pressure", "kPa"),
    "deposit": ("greatest deposit thickness", "m"),
    "arrival": ("latest arrival", "s"),
}
PARTS = {
    "moving": "moving at the end",
    "at_rest": "at rest at the end",
    "left": "left over an edge of the terrain",
    "through_ground": "lost through the ground",
}


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


def terrain_report(run: Run, language: str = ENGLISH) -> Path:
    """Write ``report.html`` of a run on a terrain, and return it.

    Pictures that ``debrisflow maps`` and ``debrisflow render`` have made before are on it.

    Raises
    ------
    OutputError
        If a table or a layer is missing or damaged, or the folder cannot be written.
    """
    words = Words(language)
    contents: dict[str, Any] = {
        "warnings": warnings_of(run),
        "map": web_map(run, words),
        "script": as_it_stands("map.js"),
        "style": as_it_stands("map.css"),
        "sheets": sheets(run),
        "answers": {
            "Volumes": volumes(run),
            "Flow": flow_figures(run, words),
            "Run-out": runout(run),
        },
        "classes": [class_areas(run, name) for name in class_names(run.folder)],
    }
    return write_page(run, "terrain.html", words, contents)


def sheets(run: Run) -> list[Picture]:
    """Return the maps for print that there are, in the order of the layers."""
    files = [run.folder / MAPS / f"{name}.png" for name in Layers(run).names]
    return [picture(file) for file in files if file.is_file()]


def volumes(run: Run) -> list[Answer]:
    """Return the volumes of the ledger at the end of the results."""
    table = read_table(run.folder / LEDGER, needed=COLUMNS)
    last = {name: float(values[-1]) for name, values in table.items()}
    each = last["volume_released"] / max(last["released"], 1.0)
    rows = [Answer("released", last["volume_released"], "m³", "with pores, of the particles")]
    return rows + [Answer(word, each * last[key], "m³", "") for key, word in PARTS.items()]


def flow_figures(run: Run, words: Words) -> list[Answer]:
    """Return the area that was reached, the extremes of the layers and the area of the deposit."""
    depth = read_layer(run.folder, "peak_depth")
    cell, least = depth.grid.cell**2, run.case.output.layer_depth
    reached = cell * float(np.sum(depth.values >= least))
    told = words("where the depth exceeded {least} m", least=f"{least:g}")
    rows = [Answer("affected area", reached, "m²", told)]
    for name, (word, unit) in GREATEST.items():
        if layer_file(run.folder, name) is not None:
            values = read_layer(run.folder, name).values
            greatest = float(np.nanmax(values)) if np.isfinite(values).any() else np.nan
            rows.append(Answer(word, greatest, unit, "of a cell"))
    if layer_file(run.folder, "deposit") is not None:
        area = cell * float(np.sum(read_layer(run.folder, "deposit").values >= least))
        told = words("at rest and deeper than {least} m", least=f"{least:g}")
        rows.append(Answer("deposit area", area, "m²", told))
    return rows


def runout(run: Run) -> list[Answer]:
    """Return fall and distance from the highest released cell to the farthest that was reached."""
    if layer_file(run.folder, "release") is None:
        return []
    terrain, release, depth = (
        read_layer(run.folder, name) for name in ("terrain", "release", "peak_depth")
    )
    level = np.where(release.values > 0.0, terrain.values, np.nan)
    reached = np.argwhere(depth.values >= run.case.output.layer_depth)
    if not (np.isfinite(level).any() and reached.size):
        return []
    top = np.array(np.unravel_index(np.nanargmax(level), level.shape))
    distance = terrain.grid.cell * np.linalg.norm(reached - top, axis=1)
    end = tuple(reached[np.argmax(distance)])
    length, fall = float(distance.max()), float(level[tuple(top)] - terrain.values[end])
    told = "horizontal, from the highest released cell to the farthest reached one"
    return [
        Answer("travel distance", length, "m", f"L, {told}"),
        Answer("fall height", fall, "m", "H, between these cells"),
        Answer("equivalent friction", fall / length if length else np.nan, "", "H / L"),
    ]


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
