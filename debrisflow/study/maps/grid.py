"""The one grid on which the maps of a study lie, and the layers of its members on it."""

from __future__ import annotations

from math import ceil, floor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from debrisflow.case import ResolvedCase
from debrisflow.case.fields import Interval
from debrisflow.case.rasters import MOST_CELLS, MapGrid, Raster
from debrisflow.case.reference_systems import differ
from debrisflow.errors import CaseError, OutputError
from debrisflow.results.layers import read_layer
from debrisflow.study.names import ARRIVAL
from debrisflow.study.tables import MapArea

Floats = NDArray[np.float64]
AMOUNTS = ("peak_depth", "peak_momentum_flux", "deposit", "final_depth", "release")
"""Layers that are amounts over an area: where cells are merged, their means count."""
TERRAIN = "terrain"
DIGITS = 9  # of borders, in cells, so that grids that fit each other do so to the last digit


def grid_of(case: ResolvedCase, area: MapArea) -> MapGrid:
    """Return the grid of the maps of a study: that of the map of its base case, or as asked for.

    An extent without a cell is widened to whole cells of the map of the case, so that no layer has
    to be put onto other cells.

    Parameters
    ----------
    case : ResolvedCase
        That all members start from.
    area : MapArea

    Raises
    ------
    CaseError
        If the case is on no terrain, or the grid does not lie on it or has too many cells.
    """
    if not case.is_terrain:
        raise CaseError(
            "maps are made of runs on a terrain only, and the case of the study has none"
        )
    own = case.terrain.levels.grid
    cell = own.cell if area.cell is None else area.cell
    is_own = cell == own.cell
    west, columns = _side(area.x, (own.west, own.east), cell, own.west if is_own else None)
    south, rows = _side(area.y, (own.south, own.north), cell, own.south if is_own else None)
    grid = MapGrid(west, south, cell, columns, rows, own.crs)
    if columns * rows > MOST_CELLS:
        raise CaseError(
            f"area.cell = {cell:g} m: the maps would have {columns} x {rows} cells; take larger "
            "cells or a smaller area"
        )
    if min(grid.east, own.east) <= max(west, own.west) or (
        min(grid.north, own.north) <= max(south, own.south)
    ):
        raise CaseError(
            "area: does not lie on the map of the case, which reaches from "
            f"{own.west:g} to {own.east:g} m east and from {own.south:g} to {own.north:g} m north"
        )
    return grid


def _side(
    wanted: Interval | None, own: Interval, cell: float, aligned_to: float | None
) -> tuple[float, int]:
    """Return the start, m, and the number of cells that hold an interval, along an axis.

    Examples
    --------
    >>> _side((12.0, 39.0), (0.0, 100.0), 10.0, 0.0), _side((12.0, 39.0), (0.0, 100.0), 10.0, None)
    ((10.0, 3), (12.0, 3))
    """
    low, high = own if wanted is None else wanted
    start = low if aligned_to is None else aligned_to
    first = floor(round((low - start) / cell, DIGITS))
    last = ceil(round((high - start) / cell, DIGITS))
    return start + first * cell, last - first


def layer_on(folder: Path, grid: MapGrid, name: str) -> Floats:
    """Return a layer of a member on the cells of a grid.

    A cell that the flow did not reach, and one beyond the terrain of the member, has none of it: 0,
    or inf of the arrival.  The edges of a terrain are open and what leaves it is not followed, so a
    member with a smaller terrain than the grid counts as dry beyond it.

    Where the cells of the member are others, an amount over an area, such as a depth, is the mean
    over the area of the cell with the dry parts as 0, so that volumes stay what they are.  The
    mean of greatest depths is not less than the greatest mean depth, since parts of a cell may be
    deepest at different times.  Of speed, pressure and duration the greatest of the cells that
    overlap counts, since a mean with dry parts is none that any part has; of the arrival the first.

    Parameters
    ----------
    folder : Path
        Of the run.
    grid : MapGrid
    name : str
        Of :data:`debrisflow.run.layers.LAYERS` but the terrain, see :func:`terrain_on`.

    Returns
    -------
    (rows, columns) float64 array
        The northernmost row first.

    Raises
    ------
    OutputError
        If the run has no such layer, or it lies in another coordinate reference system.
    """
    raster = _read(folder, grid, name)
    values = np.where(np.isfinite(raster.values), raster.values, np.inf if name == ARRIVAL else 0.0)
    if raster.grid[:5] == grid[:5]:
        return values
    if name in AMOUNTS:
        return _mean(values, raster.grid, grid)
    if name == ARRIVAL:
        return -_greatest(-values, raster.grid, grid, -np.inf)
    return _greatest(values, raster.grid, grid, 0.0)


def terrain_on(folder: Path, grid: MapGrid) -> Raster:
    """Return the elevation of the terrain of a member on a grid, m: means; nan where none is known.

    Raises
    ------
    OutputError
        If the run has no terrain, or it lies in another coordinate reference system.
    """
    raster = _read(folder, grid, TERRAIN)
    if raster.grid[:5] == grid[:5]:
        return raster
    known = np.isfinite(raster.values)
    share = _mean(known.astype(float), raster.grid, grid)
    total = _mean(np.where(known, raster.values, 0.0), raster.grid, grid)
    mean = np.full(grid.shape, np.nan)
    np.divide(total, share, out=mean, where=share > 0.0)
    return Raster(grid, mean)


def _read(folder: Path, grid: MapGrid, name: str) -> Raster:
    raster = read_layer(folder, name)
    if differ(raster.grid.crs, grid.crs):
        raise OutputError(
            f"{folder}: the layer '{name}' is in another coordinate reference system than the maps "
            "of the study; project the DEM of this member to that of the others"
        )
    return raster


def _mean(values: Floats, own: MapGrid, grid: MapGrid) -> Floats:
    """Return means over the cells of a grid, by overlap; 0 where there is none.

    Examples
    --------
    >>> fine, coarse = MapGrid(0.0, 0.0, 1.0, 4, 2), MapGrid(0.0, 0.0, 2.0, 3, 1)
    >>> _mean(np.array([[1.0, 3.0, 2.0, 0.0], [0.0, 0.0, 2.0, 0.0]]), fine, coarse)
    array([[1., 1., 0.]])
    """
    down = _overlaps(own.north, own.rows, own.cell, grid.north, grid.rows, grid.cell, -1)
    along = _overlaps(own.west, own.columns, own.cell, grid.west, grid.columns, grid.cell, 1)
    return np.asarray(down @ (along @ values.T).T)


def _overlaps(
    own_start: float, own: int, own_cell: float, start: float, count: int, cell: float, sign: int
) -> sparse.csr_array:
    """Return the share of each interval of a grid that each of another one covers, along an axis.

    Parameters
    ----------
    own_start, own_cell : float, m
    own : int
        Number of intervals that cover.
    start, cell : float, m
    count : int
        Number of intervals that are covered.
    sign : int
        1 if they follow each other along the axis of the map, -1 if against it.

    Returns
    -------
    (count, own) array
    """
    first, last, edges = _covered(own_start, own, own_cell, start, count, cell, sign)
    row = np.repeat(np.arange(count), last - first)
    column = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])
    share = np.minimum(edges[column + 1], row + 1) - np.maximum(edges[column], row)
    return sparse.csr_array((share, (row, column)), shape=(count, own))


def _covered(
    own_start: float, own: int, own_cell: float, start: float, count: int, cell: float, sign: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Return the first interval that overlaps each, the one past the last, and all edges."""
    edges = np.round((sign * (own_start - start) + own_cell * np.arange(own + 1)) / cell, DIGITS)
    places = np.arange(count)
    first = np.clip(np.searchsorted(edges, places, "right") - 1, 0, own)
    last = np.clip(np.searchsorted(edges, places + 1, "left"), first, own)
    return first, last, edges


def _greatest(values: Floats, own: MapGrid, grid: MapGrid, none: float) -> Floats:
    """Return the greatest values of the cells that overlap each cell of a grid.

    Examples
    --------
    >>> fine, coarse = MapGrid(0.0, 0.0, 1.0, 4, 1), MapGrid(0.0, 0.0, 2.0, 3, 1)
    >>> _greatest(np.array([[1.0, 5.0, 2.0, 0.0]]), fine, coarse, 0.0)
    array([[5., 2., 0.]])
    """
    down = _covered(own.north, own.rows, own.cell, grid.north, grid.rows, grid.cell, -1)
    along = _covered(own.west, own.columns, own.cell, grid.west, grid.columns, grid.cell, 1)
    for first, last, _ in (down, along):  # rows, and after turning columns
        padded = np.concatenate([values, np.full((1, values.shape[1]), none)])
        pairs = np.column_stack([first, last]).ravel()
        values = np.maximum.reduceat(padded, pairs, axis=0)[::2]
        values[first == last] = none
        values = values.T
    return values
