"""The figures that a study wants of a run: answers of its report, and layers at places."""

from __future__ import annotations

from math import floor, isnan, nan
from pathlib import Path

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.case.words import format_extent
from debrisflow.errors import OutputError
from debrisflow.results.layers import read_layer
from debrisflow.run.layers import LAYERS
from debrisflow.study.names import ARRIVAL
from debrisflow.study.outcome import Figure, Outcome
from debrisflow.study.tables import Quantity, Study

USUAL = (
    "runout_length",
    "affected_area",
    "affected_length",
    "depth_greatest",
    "speed_greatest",
    "deposit_volume",
    "front_farthest",
)
"""Answers that are shown of each run where a study names no quantities."""
EARLY = ("_arrival", "_overtopping_time")
"""Ends of the names of answers that are times at which something comes."""
WITHOUT_ZERO = (ARRIVAL, "terrain")
"""Layers of which no data does not mean zero: where nothing flowed there is no arrival."""


def quantities_of(study: Study, folder: Path, outcome: Outcome) -> dict[str, Figure]:
    """Return the figures of a finished member by the names that the study gives them.

    Parameters
    ----------
    study : Study
    folder : Path
        Of the run.
    outcome : Outcome

    Raises
    ------
    OutputError
        If the run has no such layer.
    """
    if not study.quantity:
        return {name: outcome.answers[name] for name in USUAL if name in outcome.answers}
    return {one.called: _figure(one, folder, outcome) for one in study.quantity}


def _figure(wanted: Quantity, folder: Path, outcome: Outcome) -> Figure:
    if wanted.answer is not None:
        return outcome.answers.get(wanted.answer, Figure(nan, ""))
    name, place = wanted.layer or "", wanted.at or (nan, nan)
    value = raster_at(read_layer(folder, name), place)
    is_dry = isnan(value) and name not in WITHOUT_ZERO
    return Figure(0.0 if is_dry else value, LAYERS[name].unit)


def raster_at(raster: Raster, place: tuple[float, float]) -> float:
    """Return the value of the cell in which a place on the map, east and north, m, lies.

    Raises
    ------
    OutputError
        If it lies outside.

    Examples
    --------
    >>> import numpy as np
    >>> raster_at(Raster(MapGrid(0.0, 0.0, 1.0, 2, 1), np.array([[3.0, 4.0]])), (1.5, 0.5))
    4.0
    """
    grid, cell = raster.grid, cell_of(raster.grid, place)
    if cell is None:
        extent = format_extent((grid.west, grid.south, grid.east, grid.north))
        raise OutputError(f"the place {place} lies outside the map of the run, {extent}")
    return float(raster.values[cell])


def cell_of(grid: MapGrid, place: tuple[float, float]) -> tuple[int, int] | None:
    """Return row and column of the cell in which a place lies; None outside the grid."""
    column = floor((place[0] - grid.west) / grid.cell)
    row = floor((grid.north - place[1]) / grid.cell)
    is_inside = 0 <= column < grid.columns and 0 <= row < grid.rows
    return (row, column) if is_inside else None


def is_early(quantity: Quantity) -> bool:
    """Return whether a quantity is a time at which something comes, so that the least is worst.

    Examples
    --------
    >>> is_early(Quantity(answer="road_arrival")), is_early(Quantity(answer="arrival_latest"))
    (True, False)
    """
    return quantity.layer == ARRIVAL or (quantity.answer or "").endswith(EARLY)
