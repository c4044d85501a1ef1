"""The part of a raster that a map shows, and how finely."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid, Raster

Floats = NDArray[np.float64]
MARGIN, LEAST_MARGIN = 0.08, 4.0  # of the longer side of the flow, and cells
SHEET = (0.5, 1.5)  # the least and the greatest height of a map over its width


def part_around(
    grid: MapGrid, touched: NDArray[np.bool_], aspects: tuple[float, float] = SHEET
) -> tuple[float, float, float, float]:
    """Return the part of a grid around some cells, with a margin, neither flat nor tall.

    Parameters
    ----------
    grid : MapGrid
    touched : (rows, columns) bool array
    aspects : (float, float)
        The least and the greatest height over width, where the grid reaches so far.

    Returns
    -------
    (west, south, east, north) : tuple of float, m

    Examples
    --------
    >>> cells = np.zeros((100, 100), dtype=bool)
    >>> cells[40:60, 50] = True
    >>> part_around(MapGrid(0.0, 0.0, 1.0, 100, 100), cells)
    (41.0, 36.0, 60.0, 64.0)
    """
    rows, columns = np.nonzero(touched)
    if not rows.size:
        return grid.west, grid.south, grid.east, grid.north
    height, width = float(np.ptp(rows) + 1), float(np.ptp(columns) + 1)
    margin = np.ceil(max(MARGIN * max(height, width), LEAST_MARGIN))
    height, width = height + 2.0 * margin, width + 2.0 * margin
    height, width = max(height, aspects[0] * width), max(width, height / aspects[1])
    sides = []
    for cells, extent, count in ((columns, width, grid.columns), (rows, height, grid.rows)):
        middle = 0.5 * (cells.min() + cells.max() + 1)
        extent = min(float(np.ceil(extent)), float(count))
        first = np.clip(np.round(middle - 0.5 * extent), 0, count - extent)
        sides.append((float(first), float(first + extent)))
    (west, east), (top, bottom) = sides
    cell = grid.cell
    return (
        grid.west + west * cell,
        grid.north - bottom * cell,
        grid.west + east * cell,
        grid.north - top * cell,
    )


def coarsened(raster: Raster, factor: int, reduced: Callable[..., Floats]) -> Raster:
    """Return a raster whose cells are blocks of cells; what makes no whole block is left out.

    Parameters
    ----------
    raster : Raster
    factor : int
        Cells along the side of a block.
    reduced : function
        Reduces an array along an axis, as ``numpy.mean`` does.

    Examples
    --------
    >>> raster = Raster(MapGrid(0.0, 0.0, 1.0, 2, 2), np.array([[1.0, 2.0], [np.nan, 4.0]]))
    >>> coarsened(raster, 2, np.fmax.reduce).values
    array([[4.]])
    """
    if factor <= 1:
        return raster
    grid, values = raster.grid, raster.values
    rows, columns = grid.rows // factor, grid.columns // factor
    blocks = values[: rows * factor, : columns * factor].reshape(rows, factor, columns, factor)
    cell = factor * grid.cell
    kept = MapGrid(grid.west, grid.north - rows * cell, cell, columns, rows, grid.crs)
    return Raster(kept, reduced(reduced(blocks, axis=3), axis=1))
