"""Releases and zones on the map: where they are, how deep, and of what volume."""

from __future__ import annotations

from math import atan2, degrees
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case.rasters import Raster, read_raster
from debrisflow.case.releases import (
    AnyRelease,
    HydrographRelease,
    PolygonRelease,
    RasterRelease,
    Segment,
    Zone,
)
from debrisflow.case.terrain import Box
from debrisflow.case.vectors import read_polygons

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
SAMPLES = 1000  # of a hydrograph, by which times are measured
DOWN_STEPS = 2.0  # cells to both sides of a line at which the levels tell what is down


def outline(table: PolygonRelease | Zone) -> shapely.Polygon | shapely.MultiPolygon:
    """Return the polygons of a release or a zone, together, in coordinates of the map, m."""
    if table.file is not None:
        return shapely.union_all(read_polygons(Path(table.file)).shapes)
    if table.corners is None:
        raise TypeError("there are neither corners nor a file")
    return shapely.Polygon(table.corners)


def depths(release: RasterRelease) -> Raster:
    """Return the depths of a release that is a raster, m, 0 where it has none."""
    raster = read_raster(Path(release.file))
    return Raster(raster.grid, np.abs(np.nan_to_num(raster.values)))


def depth_at(release: PolygonRelease | RasterRelease, x: Floats, y: Floats) -> Floats:
    """Return the depth of a release at places on the map, (n,) arrays, m; 0 beside it.

    Examples
    --------
    >>> square = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
    >>> release = PolygonRelease(type="polygon", corners=square, volume=250.0)
    >>> depth_at(release, np.array([5.0, 15.0]), np.array([5.0, 5.0]))
    array([2.5, 0. ])
    """
    if isinstance(release, PolygonRelease):
        return np.where(shapely.contains_xy(outline(release), x, y), greatest_depth(release), 0.0)
    return cells_at(depths(release), x, y, 0.0)


def is_in_zone(zone: Zone, x: Floats, y: Floats) -> Bools:
    """Return which places on the map, (n,) arrays, m, lie in a zone."""
    if zone.raster is None:
        return np.asarray(shapely.contains_xy(outline(zone), x, y))
    return np.asarray(cells_at(read_raster(Path(zone.raster)), x, y, np.nan) == zone.value)


def cells_at(raster: Raster, x: Floats, y: Floats, beyond: float) -> Floats:
    """Return the values of the cells that hold places, and one for places beyond the raster."""
    grid = raster.grid
    column = np.floor((np.asarray(x) - grid.west) / grid.cell).astype(np.int64)
    row = np.floor((grid.north - np.asarray(y)) / grid.cell).astype(np.int64)
    inside = (column >= 0) & (column < grid.columns) & (row >= 0) & (row < grid.rows)
    found = np.full(inside.shape, beyond)
    found[inside] = raster.values[row[inside], column[inside]]
    return found


def borders(release: AnyRelease) -> Box | None:
    """Return the box around a release: west, south, east and north border, m; None of nothing."""
    if isinstance(release, HydrographRelease):
        if isinstance(release.line, str):
            return None
        (a, b), (c, d) = release.line
        return min(a, c), min(b, d), max(a, c), max(b, d)
    if isinstance(release, PolygonRelease):
        west, south, east, north = outline(release).bounds
        return west, south, east, north
    raster = depths(release)
    rows, columns = np.nonzero(raster.values)
    if not len(rows):
        return None
    grid = raster.grid
    return (
        float(grid.west + columns.min() * grid.cell),
        float(grid.north - (rows.max() + 1) * grid.cell),
        float(grid.west + (columns.max() + 1) * grid.cell),
        float(grid.north - rows.min() * grid.cell),
    )


def area(release: PolygonRelease | RasterRelease) -> float:
    """Return the area of a release as seen from above, m2."""
    if isinstance(release, PolygonRelease):
        return float(outline(release).area)
    raster = depths(release)
    return float(np.count_nonzero(raster.values) * raster.grid.cell**2)


def greatest_depth(release: PolygonRelease | RasterRelease) -> float:
    """Return the greatest depth of a release, m, measured vertically."""
    if isinstance(release, RasterRelease):
        return float(depths(release).values.max())
    if release.depth is not None:
        return release.depth
    return (release.volume or 0.0) / area(release)


def volume(release: AnyRelease) -> float:
    """Return the volume of a release, m3; of a hydrograph up to its last time.

    Examples
    --------
    >>> from debrisflow.case.releases import Hydrograph
    >>> flood = Hydrograph(time=(0.0, 10.0, 20.0), discharge=(0.0, 8.0, 0.0), concentration=(0.0,))
    >>> volume(
    ...     HydrographRelease(
    ...         type="hydrograph", line=((0.0, 0.0), (9.0, 0.0)), hydrograph=flood, velocity=3.0
    ...     )
    ... )
    80.0
    """
    if isinstance(release, HydrographRelease):
        graph = release.hydrograph
        if isinstance(graph, str):
            raise TypeError("the hydrograph is not read")
        return float(np.trapezoid(graph.discharge, graph.time))
    if isinstance(release, RasterRelease):
        raster = depths(release)
        return float(raster.values.sum() * raster.grid.cell**2)
    if release.volume is not None:
        return release.volume
    return (release.depth or 0.0) * area(release)


def volume_until(release: HydrographRelease, time: float) -> float:
    """Return the volume that a hydrograph has brought at a time, s, m3.

    Between its rows the discharge is linear.

    Examples
    --------
    >>> from types import SimpleNamespace as Table
    >>> graph = Table(time=(0.0, 10.0, 20.0), discharge=(0.0, 4.0, 0.0))
    >>> volume_until(Table(start=5.0, hydrograph=graph), 10.0)
    5.0
    """
    graph, now = release.hydrograph, time - release.start
    if isinstance(graph, str):
        raise TypeError("the hydrograph is not read")
    times, discharge = np.array(graph.time), np.array(graph.discharge)
    ends = np.append(times[times < now], min(max(now, times[0]), times[-1]))
    return float(np.trapezoid(np.interp(ends, times, discharge), ends))


def share_below(release: HydrographRelease, least: float, end: float) -> float:
    """Return for which share of the time in which a hydrograph flows it is below a discharge.

    Parameters
    ----------
    release : HydrographRelease
    least : float, m3/s
    end : float, s
        What comes later does not count.

    Examples
    --------
    >>> from types import SimpleNamespace as Table
    >>> graph = Table(time=(0.0, 10.0, 20.0), discharge=(0.0, 4.0, 0.0))
    >>> share_below(Table(start=0.0, hydrograph=graph), 1.0, 100.0)
    0.25
    """
    graph = release.hydrograph
    if isinstance(graph, str):
        raise TypeError("the hydrograph is not read")
    last = min(graph.time[-1], end - release.start)
    middles = graph.time[0] + (np.arange(SAMPLES) + 0.5) / SAMPLES * (last - graph.time[0])
    discharge = np.interp(middles, graph.time, graph.discharge)
    flows = discharge > 0.0
    return float(np.mean(discharge[flows] < least)) if last > 0.0 and flows.any() else 0.0


def entering_depth(release: HydrographRelease) -> float:
    """Return how deep a flow enters over its line at its greatest discharge, m."""
    if isinstance(release.line, str) or isinstance(release.hydrograph, str):
        raise TypeError("line and hydrograph are not read")
    peak = max(release.hydrograph.discharge)
    return peak / (release.velocity * length_of(release.line))


def length_of(line: Segment) -> float:
    """Return the length of a line, m."""
    (a, b), (c, d) = line
    return float(np.hypot(c - a, d - b))


def direction_down(line: Segment, levels: Raster) -> float | None:
    """Return the direction across a line that goes down, degrees clockwise from north.

    The levels two cells to both sides of it tell which one that is; None where they are equal or
    not known.

    Examples
    --------
    >>> from debrisflow.case.rasters import MapGrid
    >>> falls_east = Raster(MapGrid(0.0, 0.0, 1.0, 20, 10), np.tile(np.arange(20.0)[::-1], (10, 1)))
    >>> direction_down(((10.0, 2.0), (10.0, 8.0)), falls_east)
    90.0
    """
    start, end = np.array(line)
    along = (end - start) / np.hypot(*(end - start))
    across = np.array([along[1], -along[0]])
    points = start + np.linspace(0.0, 1.0, 21)[:, None] * (end - start)
    step = DOWN_STEPS * levels.grid.cell * across
    before, behind = points + step, points - step
    rise = cells_at(levels, before[:, 0], before[:, 1], np.nan)
    rise = rise - cells_at(levels, behind[:, 0], behind[:, 1], np.nan)
    rise = rise[np.isfinite(rise)]
    if not len(rise) or rise.mean() == 0.0:
        return None
    east, north = -np.sign(rise.mean()) * across
    return round(degrees(atan2(east, north)) % 360.0, 6)
