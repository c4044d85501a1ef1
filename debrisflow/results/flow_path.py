"""The path of a flow over a terrain, along which run-out distances are measured."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.space.released import source_of

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
AROUND = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]


def centers(grid: MapGrid) -> tuple[Floats, Floats]:
    """Return the easting of each column and the northing of each row of a raster, m.

    Examples
    --------
    >>> centers(MapGrid(100.0, 0.0, 10.0, 2, 3))
    (array([105., 115.]), array([25., 15.,  5.]))
    """
    east = grid.west + (np.arange(grid.columns) + 0.5) * grid.cell
    north = grid.north - (np.arange(grid.rows) + 0.5) * grid.cell
    return np.asarray(east, dtype=float), np.asarray(north, dtype=float)


def path_of(case: ResolvedCase, terrain: Raster) -> shapely.LineString:
    """Return the path down a terrain from the first release of a case, see :func:`flow_path`.

    It starts in the middle of a mass, or of the line over which a flow enters.
    """
    x, y = source_of(case) + case.terrain.origin[:2]
    return flow_path(terrain, float(x), float(y))


def flow_path(terrain: Raster, x: float, y: float) -> shapely.LineString:
    """Return the path down a terrain from a place to the edge of what is known of it.

    From each cell it leads to the neighbor of the steepest descent, and in a hollow on the way that
    water takes to the outlet as it rises (priority flood).  Steps from cell to cell zigzag, so the
    path is simplified within a cell.

    Parameters
    ----------
    terrain : Raster
        Elevation, m.
    x, y : float, m
        On the map.

    References
    ----------
    Barnes, Lehman and Mulla 2014, Computers & Geosciences 62, doi:10.1016/j.cageo.2013.04.024.

    Examples
    --------
    >>> level = np.repeat([4.0, 3.0, 2.0, 1.0, 0.0], 3).reshape(5, 3)
    >>> flow_path(Raster(MapGrid(0.0, 0.0, 1.0, 3, 5), level), 1.5, 3.5).wkt
    'LINESTRING (1.5 3.5, 1.5 0.5)'
    """
    grid = terrain.grid
    column = min(max(int((x - grid.west) / grid.cell), 0), grid.columns - 1)
    row = min(max(int((grid.north - y) / grid.cell), 0), grid.rows - 1)
    east, north = centers(grid)
    edge = _edge(terrain.values)
    flooded = _flooded(terrain.values, edge, (row, column))
    cells = _descent(*flooded, edge, (row, column))
    places = [(x, y), *((east[j], north[i]) for i, j in cells)]
    if len(places) < 2:
        places.append((x, y))
    return shapely.simplify(shapely.LineString(places), grid.cell)


def _edge(level: Floats) -> Flags:
    """Return the known cells at the border or beside unknown ones."""
    rows, columns = level.shape
    known = np.pad(np.isfinite(level), 1)
    is_inside: Flags = np.logical_and.reduce(
        [known[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in AROUND]
    )
    return np.isfinite(level) & ~is_inside


def _flooded(
    level: Floats, edge: Flags, wanted: tuple[int, int]
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the level of cells with hollows filled, and in which order water from outside comes.

    From the edge of what is known inward, until a wanted cell is reached; what comes later, or is
    not known, has the greatest number.
    """
    width = level.shape[1] + 2  # with a rim, so that every cell has eight beside it
    height = np.pad(level, 1, constant_values=np.nan).ravel()
    is_seen = (~np.isfinite(height) | np.pad(edge, 1).ravel()).tolist()
    first = np.flatnonzero(np.pad(edge, 1))
    filled, order = height.tolist(), [level.size] * height.size
    waiting = list(zip(height[first].tolist(), first.tolist(), strict=True))
    heapq.heapify(waiting)
    around = [i * width + j for i, j in AROUND]
    place, last = 0, (wanted[0] + 1) * width + wanted[1] + 1
    while waiting:
        water, cell = heapq.heappop(waiting)
        order[cell] = place
        place += 1
        if cell == last:
            break
        for beside in [cell + step for step in around]:
            if not is_seen[beside]:
                is_seen[beside] = True
                filled[beside] = max(filled[beside], water)
                heapq.heappush(waiting, (filled[beside], beside))
    inner = (slice(1, -1), slice(1, -1))
    return np.reshape(filled, (-1, width))[inner], np.reshape(order, (-1, width))[inner]


def _descent(
    filled: Floats, order: NDArray[np.int64], edge: Flags, cell: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Yield the cells down from one: the steepest way, over what is filled that to the outlet."""
    while True:
        i, j = cell
        before = [one for one in _beside(i, j, filled.shape) if order[one] < order[cell]]
        if not before:
            return
        falls = [(filled[cell] - filled[a, b]) / np.hypot(a - i, b - j) for a, b in before]
        first = min(range(len(before)), key=lambda k: (-falls[k], order[before[k]]))
        if edge[cell] and falls[first] <= 0.0:
            return
        cell = before[first]
        yield cell


def _beside(i: int, j: int, shape: tuple[int, ...]) -> list[tuple[int, int]]:
    """Return the cells beside one."""
    rows, columns = shape
    return [(i + di, j + dj) for di, dj in AROUND if 0 <= i + di < rows and 0 <= j + dj < columns]


def along(path: shapely.LineString, grid: MapGrid, chosen: Flags) -> Floats:
    """Return how far along a path the middles of cells lie, by their nearest point on it, m."""
    east, north = centers(grid)
    i, j = np.nonzero(chosen)
    found: Floats = shapely.line_locate_point(path, shapely.points(east[j], north[i]))
    return found
