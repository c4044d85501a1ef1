"""Releases and zones on the cells of a grid: depths of cells, and where a zone is."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid
from debrisflow.case.released import depths, greatest_depth, is_in_zone, outline
from debrisflow.case.releases import PolygonRelease, RasterRelease, Zone

Floats = NDArray[np.float64]


def depth_on(release: PolygonRelease | RasterRelease, grid: MapGrid) -> Floats:
    """Return the mean depth of a release in the cells of a grid, (columns, rows), m.

    Its sum over the cells, times their area, is the volume of the release on the grid.
    """
    if isinstance(release, PolygonRelease):
        return greatest_depth(release) * coverage(outline(release), grid)
    given = depths(release)
    i, j = np.nonzero(given.plan > 0.0)
    found = np.zeros((grid.columns, grid.rows))
    if not i.size:
        return found
    cell = given.grid.cell
    west = given.grid.west + i.astype(np.float64) * cell
    south = given.grid.south + j.astype(np.float64) * cell
    columns = _shares_along(west, cell, grid.west, grid.cell, grid.columns)
    rows = _shares_along(south, cell, grid.south, grid.cell, grid.rows)
    volume = given.plan[i, j] / grid.cell**2
    for column, wide in columns:
        for row, high in rows:
            np.add.at(found, (column, row), volume * wide * high)
    return found


def _shares_along(
    start: Floats, length: float, origin: float, cell: float, count: int
) -> list[tuple[NDArray[np.int64], Floats]]:
    """Return the cells along an axis that intervals of a length overlap, and by what, m.

    First for the first cell of each interval, then for the second, and so on.  Cells beyond the
    grid have an overlap of 0.
    """
    first = np.floor((start - origin) / cell).astype(np.int64)
    found = []
    for k in range(int(np.ceil(length / cell)) + 1):
        low = origin + (first + k) * cell
        overlap = np.minimum(start + length, low + cell) - np.maximum(start, low)
        inside = (first + k >= 0) & (first + k < count)
        share = np.where(inside, np.maximum(overlap, 0.0), 0.0)
        found.append((np.clip(first + k, 0, count - 1), share))
    return found


def holds_middles(zone: Zone, grid: MapGrid) -> NDArray[np.bool_]:
    """Return which cells have their middle in a zone, (columns, rows)."""
    x = grid.west + (np.arange(grid.columns) + 0.5) * grid.cell
    y = grid.south + (np.arange(grid.rows) + 0.5) * grid.cell
    return is_in_zone(zone, *np.meshgrid(x, y, indexing="ij"))


def coverage(area: shapely.Polygon | shapely.MultiPolygon, grid: MapGrid) -> Floats:
    """Return the share of each cell that polygons cover, (columns, rows), along x and y.

    Examples
    --------
    >>> grid = MapGrid(100.0, 200.0, 10.0, 3, 2)
    >>> print(coverage(shapely.box(105.0, 205.0, 120.0, 210.0), grid))
    [[0.25 0.  ]
     [0.5  0.  ]
     [0.   0.  ]]
    """
    share = np.zeros((grid.columns, grid.rows))
    columns, rows = _cells_around(area, grid)
    i, j = (index.ravel() for index in np.meshgrid(columns, rows, indexing="ij"))
    west, south = grid.west + i * grid.cell, grid.south + j * grid.cell
    shapely.prepare(area)
    cells = shapely.box(west, south, west + grid.cell, south + grid.cell)
    whole = shapely.contains(area, cells)
    share[i[whole], j[whole]] = 1.0
    part = shapely.intersects(area, cells) & ~whole
    cut = shapely.area(shapely.intersection(area, cells[part]))
    share[i[part], j[part]] = cut / grid.cell**2
    return share


def _cells_around(
    area: shapely.Geometry, grid: MapGrid
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the columns and rows of the cells in the box around a shape."""
    if area.is_empty:
        return np.arange(0), np.arange(0)
    west, south, east, north = area.bounds
    found = []
    for start, end, origin, count in (
        (west, east, grid.west, grid.columns),
        (south, north, grid.south, grid.rows),
    ):
        first = max(int(np.floor((start - origin) / grid.cell)), 0)
        last = min(int(np.ceil((end - origin) / grid.cell)), count)
        found.append(np.arange(first, max(last, first)))
    return found[0], found[1]
