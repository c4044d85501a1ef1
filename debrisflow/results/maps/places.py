"""Where the probes of a run stand on the map, and their curves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.probes import AnyProbe
from debrisflow.case.rasters import MapGrid
from debrisflow.results.data_table import DataTable
from debrisflow.results.reader import Run
from debrisflow.results.words import Words

Floats = NDArray[np.float64]
MOST_SAMPLES = 400  # of a curve
DIGITS = 4  # of a sample
DRAWN = ("point", "height", "pressure", "section")  # types that have a place and curves over time


def places(run: Run, grid: MapGrid, words: Words) -> list[dict[str, Any]]:
    """Return probes with their place, in cells from the west and the north, and their curves.

    Parameters
    ----------
    run : Run
    grid : MapGrid
        Of the part that is shown.
    words : Words
    """
    origin = getattr(run.case.geometry, "origin", None) or (0.0, 0.0, 0.0)
    found = []
    for probe in run.case.probe:
        if probe.type not in DRAWN:
            continue
        line = line_of(probe, grid, (float(origin[0]), float(origin[1])))
        if line is not None:
            curves = curves_of(run.probe(probe.name), words)
            found.append({"name": probe.name, "line": line, "curves": curves})
    return found


def line_of(
    probe: AnyProbe, grid: MapGrid, origin: tuple[float, float]
) -> list[list[float]] | None:
    """Return the place of a probe: one point, or the two ends of a section; None if it has none."""
    x, y = getattr(probe, "x", None), getattr(probe, "y", None)
    if not isinstance(x, float):
        return None
    column = (origin[0] + x - grid.west) / grid.cell
    if isinstance(y, float):
        return [[column, (grid.north - origin[1] - y) / grid.cell]]
    return [[column, 0.0], [column, float(grid.rows)]] if probe.type == "section" else None


def curves_of(table: DataTable, words: Words) -> list[dict[str, Any]]:
    """Return the columns of a probe over the time, thinned out."""
    time = table["time"]
    step = max(-(-time.size // MOST_SAMPLES), 1)
    curves = []
    for name in table:
        values = table[name]
        if name != "time" and np.isfinite(values).any():
            curves.append(
                {
                    "title": words(name.replace("_", " ")),
                    "unit": table.units.get(name, ""),
                    "time": [_short(value) for value in time[::step]],
                    "values": [_short(value) for value in values[::step]],
                }
            )
    return curves


def _short(value: float) -> float | None:
    """Return a number with few digits, as JSON has them: None for none."""
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
