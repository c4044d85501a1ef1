"""Measures of a run on a terrain: distances, areas and peaks from its layers, and its ledger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.errors import OutputError
from debrisflow.results.flow_path import along, centers, path_of
from debrisflow.results.layers import layer_file, read_layer
from debrisflow.results.measured import REST_SHARE, Measured, last_part
from debrisflow.results.reader import Run
from debrisflow.run.ledger import PLACES
from debrisflow.run.tables import Table

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
NEEDED = (
    "terrain",
    "peak_depth",
    "peak_speed",
    "peak_momentum_flux",
    "peak_pressure",
    "arrival",
    "deposit",
)
FRONT_COLUMNS = (
    "time", "front", "reach", "area", "moving_front", "moving_share", "front_speed",
)  # fmt: skip
FRONT_HEAD = (
    "time: s",
    "front: m; how far along the flow path the cells lie that the flow has reached until then;",
    "  nan before it has reached any",
    "reach: m; the straight distance in plan from the start of that path, the middle of the first",
    "  release, to the farthest of them",
    "area: m2 in plan; of these cells",
    "moving_front: m; as reach, within which 99.5 % of the volume lies that is faster than",
    "  output.rest_speed",
    "moving_share: share of the volume on the terrain that is faster than output.rest_speed",
    "front_speed: m/s; of front, over two output intervals",
)
PATH_HEAD = (
    "a row for each part, a cell long, of the flow path, which is the steepest way down from the",
    "  middle of the first release; nan where the flow does not come",
    "s: m along it in plan; middle of the part",
    "east, north, elevation: m, of that place on the terrain as given",
    "peak_depth, peak_speed, peak_pressure: m, m/s, kPa; greatest in the cells that have their",
    "  nearest point of the path in this part; those above its start do not count",
    "arrival: s; first in these cells",
    "width: m; area of these cells over the length of the part",
)


class Descent(NamedTuple):
    """How far a flow came.

    Attributes
    ----------
    toe : (float, float), m
        The cell that is farthest along the flow path, on the map.
    runout : float, m
        How far it lies along the path from the middle of the first release, in plan.
    reach : float, m
        The straight distance from there to the farthest cell, in plan.
    fall, travel : float, m
        H and L: vertical and horizontal distance from the highest released cell, or the middle of
        the line of a hydrograph, to the reached cell that is farthest from it.
    bound : str
        Why the flow may go farther than that; empty if it does not.
    """

    toe: tuple[float, float]
    runout: float
    reach: float
    fall: float
    travel: float
    bound: str

    @property
    def equivalent_friction(self) -> float:
        """Return H / L."""
        return self.fall / self.travel if self.travel > 0.0 else np.nan


class Peak(NamedTuple):
    """The greatest value of a layer and the cell that has it, on the map, m; nan of none."""

    value: float
    place: tuple[float, float]


@dataclass(frozen=True)
class TerrainSurvey(Measured):
    """What was measured of a run on a terrain, beside what :class:`Measured` has.

    Attributes
    ----------
    layers : dict of str to (rows, columns) array
        The northernmost row first; nan where there are no data.
    grid : MapGrid
    path : shapely.LineString
        The steepest way down from the middle of the first release, on the map.
    profile : Table
        As ``path.csv``, along it.
    mobility : Descent
    """

    layers: dict[str, Floats]
    grid: MapGrid
    path: shapely.LineString
    profile: Table
    mobility: Descent

    @property
    def reached(self) -> Flags:
        """Return the cells that the flow reached, (rows, columns)."""
        return np.isfinite(self.layers["peak_depth"])

    @property
    def ledger_error(self) -> float:
        """Return by how many particles the ledger fails to add up, at its worst row."""
        table = self.run.ledger
        missing = table["released"] - np.sum([table[place] for place in PLACES], axis=0)
        return float(np.abs(missing).max(initial=0.0))

    def peak(self, name: str) -> Peak:
        """Return the greatest value of a layer and its place."""
        values = self.layers[name]
        if not np.isfinite(values).any():
            return Peak(np.nan, (np.nan, np.nan))
        row, column = np.unravel_index(np.nanargmax(values), values.shape)
        return Peak(float(values[row, column]), _place(self.grid, int(row), int(column)))


def survey_terrain(
    run: Run, window: tuple[float, float] | None = None, smoothing: float | None = None
) -> TerrainSurvey:
    """Measure a run on a terrain by its layers, its history and its ledger.

    Parameters
    ----------
    run : Run
    window : (float, float), s, optional
        Over which samples of probes are averaged; the last fifth of the history if left out.
    smoothing : float, s, optional
        Span of the running means of probes; ten intervals of each if left out.

    Raises
    ------
    OutputError
        If the run has not written its layers yet, or a file is missing or damaged.
    """
    if layer_file(run.folder, "terrain") is None:
        raise OutputError(
            f"{run.folder} holds no layers yet: a run on a terrain writes them at its end, and "
            "when it is interrupted"
        )
    terrain = read_layer(run.folder, "terrain")
    layers = {name: read_layer(run.folder, name).values for name in NEEDED}
    path = _path(run, terrain)
    reached = np.isfinite(layers["peak_depth"])
    history = run.history
    return TerrainSurvey(
        run=run,
        window=window or last_part(history["time"]),
        fronts=_fronts(run, layers["arrival"], path, terrain.grid),
        has_grains=bool(history["sediment_volume_in"].any()),
        smoothing=smoothing,
        layers=layers,
        grid=terrain.grid,
        path=path,
        profile=_profile(layers, reached, path, terrain.grid),
        mobility=_descent(run, terrain, reached, path),
    )


def _path(run: Run, terrain: Raster) -> shapely.LineString:
    """Return the flow path; that of a flow that never came is a point."""
    if not np.isfinite(read_layer(run.folder, "arrival").values).any():
        middle = centers(terrain.grid)
        place = float(middle[0].mean()), float(middle[1].mean())
        return shapely.LineString([place, place])
    return path_of(run.case, terrain)


def _place(grid: MapGrid, row: int, column: int) -> tuple[float, float]:
    """Return the middle of a cell on the map, m."""
    return grid.west + (column + 0.5) * grid.cell, grid.north - (row + 0.5) * grid.cell


def _elevation(terrain: Raster, x: Floats, y: Floats) -> Floats:
    """Return the elevation at places on the map, (n,) arrays, m: linear between middles of cells.

    Beside cells without data, that of the cell.

    Examples
    --------
    >>> slope = Raster(MapGrid(0.0, 0.0, 2.0, 3, 1), np.array([[4.0, 2.0, 0.0]]))
    >>> _elevation(slope, np.array([2.0, 3.0, 6.0]), np.array([1.0, 1.0, 1.0]))
    array([3., 2., 0.])
    """
    grid = terrain.grid
    column, row = (x - grid.west) / grid.cell - 0.5, (grid.north - y) / grid.cell - 0.5
    found: Floats = map_coordinates(terrain.values, [row, column], order=1, mode="nearest")
    whole: Floats = map_coordinates(terrain.values, [row, column], order=0, mode="nearest")
    return np.where(np.isnan(found), whole, found)


def _distances(start: shapely.Point, grid: MapGrid, chosen: Flags) -> Floats:
    """Return the straight distances of the middles of cells from a place, m."""
    east, north = centers(grid)
    i, j = np.nonzero(chosen)
    found: Floats = shapely.distance(start, shapely.points(east[j], north[i]))
    return found


def _fronts(run: Run, arrival: Floats, path: shapely.LineString, grid: MapGrid) -> Table:
    """Return the columns ``FRONT_COLUMNS`` at the times of the history."""
    time, chosen = run.history["time"], np.isfinite(arrival)
    order = np.argsort(arrival[chosen], kind="stable")
    count = np.searchsorted(arrival[chosen][order], time + 1e-9, side="right")
    greatest = []
    start = shapely.Point(path.coords[0])
    for values in (along(path, grid, chosen), _distances(start, grid, chosen)):
        highest = np.maximum.accumulate(values[order])
        greatest.append(np.concatenate([[np.nan], highest])[count])
    ledger = run.ledger
    inside = ledger["moving"] + ledger["at_rest"]
    share = ledger["moving"] / np.maximum(inside, 1.0)
    columns = (
        time,
        *greatest,
        count * grid.cell**2,
        run.history["front_all"],
        np.interp(time, ledger["time"], share),
        _speed(time, greatest[0], run.case.output.interval),
    )
    return dict(zip(FRONT_COLUMNS, columns, strict=True))


def _speed(time: Floats, front: Floats, interval: float) -> Floats:
    """Return the speed of a front over an interval to both sides, m/s; nan where it is not known.

    Examples
    --------
    >>> _speed(np.arange(5.0), np.array([np.nan, 0.0, 4.0, 4.0, 8.0]), 1.0)
    array([nan,  4.,  2.,  2.,  4.])
    """
    known = ~np.isnan(front)
    found = np.full(time.shape, np.nan)
    if known.any():
        start = time[known][0]
        ends = (np.clip(time + step, start, time[-1]) for step in (-interval, interval))
        before, after = ends
        passed = np.interp(after, time[known], front[known])
        passed -= np.interp(before, time[known], front[known])
        np.divide(passed, after - before, out=found, where=known & (after > before))
    return found


def _profile(
    layers: dict[str, Floats], reached: Flags, path: shapely.LineString, grid: MapGrid
) -> Table:
    """Return terrain and flow along a path, a row for each part of it that is a cell long."""
    cell = grid.cell
    parts = max(int(np.ceil(path.length / cell - 1e-9)), 1)
    s = (np.arange(parts) + 0.5) * cell
    s[-1] = 0.5 * ((parts - 1) * cell + max(path.length, 1e-9))
    points = shapely.get_coordinates(shapely.line_interpolate_point(path, s))
    place = along(path, grid, reached)
    beside = place > 0.0  # not above the start of the path
    part = np.minimum((place[beside] / cell).astype(int), parts - 1)
    table = {
        "s": s,
        "east": points[:, 0],
        "north": points[:, 1],
        "elevation": _elevation(Raster(grid, layers["terrain"]), *points.T),
    }
    for name in ("peak_depth", "peak_speed", "peak_pressure"):
        table[name] = np.full(parts, np.nan)
        np.fmax.at(table[name], part, layers[name][reached][beside])
    table["arrival"] = np.full(parts, np.nan)
    np.fmin.at(table["arrival"], part, layers["arrival"][reached][beside])
    table["width"] = np.bincount(part, minlength=parts) * cell
    return table


def _descent(run: Run, terrain: Raster, reached: Flags, path: shapely.LineString) -> Descent:
    if not reached.any():
        return Descent((np.nan, np.nan), np.nan, np.nan, np.nan, np.nan, bound="")
    grid, start = terrain.grid, shapely.Point(path.coords[0])
    far, cells = along(path, grid, reached), np.argwhere(reached)
    row, column = (int(k) for k in cells[np.argmax(far)])
    top = _top(run, terrain) or (start.x, start.y)
    from_top = _distances(shapely.Point(top), grid, reached)
    end = cells[np.argmax(from_top)]
    level = _elevation(terrain, *np.array([top]).T)[0]
    return Descent(
        toe=_place(grid, row, column),
        runout=float(far.max()),
        reach=float(_distances(start, grid, reached).max()),
        fall=float(level - terrain.values[tuple(end)]),
        travel=float(from_top.max()),
        bound=_bound(run),
    )


def _top(run: Run, terrain: Raster) -> tuple[float, float] | None:
    """Return the middle of the highest released cell, m; None where no mass was released."""
    if layer_file(run.folder, "release") is None:
        return None
    release = np.nan_to_num(read_layer(run.folder, "release").values)
    level = np.where(release > 0.0, terrain.values, np.nan)
    if not np.isfinite(level).any():
        return None
    row, column = np.unravel_index(np.nanargmax(level), level.shape)
    return _place(terrain.grid, int(row), int(column))


def _bound(run: Run) -> str:
    """Return why a flow may go farther than it has; empty if it has come to rest on the map.

    A run that ends by ``time.stop_energy`` may still creep.
    """
    ledger = run.ledger
    moving, rests, left = (float(ledger[name][-1]) for name in ("moving", "at_rest", "left"))
    if left > 0.0:
        return "a lower bound: some of it left over an edge of the DEM"
    if moving >= REST_SHARE * (moving + rests) > 0.0:
        return "a lower bound: the flow still moves at the end"
    return ""
