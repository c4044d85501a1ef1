"""How well a run reproduces an observed event: extent, run-out distance and deposit."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid, Raster, UnreadableRasterError, read_raster
from debrisflow.case.reference_systems import differ
from debrisflow.case.vectors import UnreadableVectorsError, read_polygons
from debrisflow.errors import CaseError
from debrisflow.results.flow_path import along, centers, path_of
from debrisflow.results.layers import read_layer
from debrisflow.results.reader import open_run

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
VECTORS = (".gpkg", ".geojson", ".json", ".shp")
LEAST_CHANGE = 0.3  # m, of an elevation that a difference of two surveys can tell


class Contingency(NamedTuple):
    """How cells that are observed and simulated agree.

    Attributes
    ----------
    hits, misses, false_alarms, correct_rejections : int
        Cells observed and simulated, only observed, only simulated, neither.
    """

    hits: int
    misses: int
    false_alarms: int
    correct_rejections: int

    @property
    def csi(self) -> float:
        """Critical success index, ``H / (H + M + F)``: 1 for the same extent, 0 for none shared.

        Examples
        --------
        >>> Contingency(6, 2, 4, 88).csi
        0.5
        """
        return _ratio(self.hits, self.hits + self.misses + self.false_alarms)

    @property
    def hss(self) -> float:
        """Heidke skill score: 1 for the same extent, 0 for no better than chance.

        ``2 (H C - M F) / [(H + M)(M + C) + (H + F)(F + C)]``

        Examples
        --------
        >>> Contingency(6, 2, 4, 88).hss
        0.6341463414634146
        """
        h, m, f, c = self
        return _ratio(2 * (h * c - m * f), (h + m) * (m + c) + (h + f) * (f + c))

    @property
    def d2pc(self) -> float:
        """Distance to the perfect classification: 0 for the same extent.

        ``[(1 - H / (H + M))^2 + (F / (F + C))^2]^1/2``, in the plane of the rates of hits and of
        false alarms.

        Examples
        --------
        >>> round(Contingency(6, 2, 4, 88).d2pc, 4)
        0.2538
        """
        h, m, f, c = self
        return float(np.hypot(1.0 - _ratio(h, h + m), _ratio(f, f + c)))

    @property
    def foc(self) -> float:
        """Factor of conservativeness, ``(H + F) / (H + M)``: over 1 where too much is reached."""
        return _ratio(self.hits + self.false_alarms, self.hits + self.misses)


class Row(NamedTuple):
    """A figure of a score."""

    measure: str
    value: float
    unit: str
    meaning: str

    @property
    def shown(self) -> str:
        """Return the value with the digits that count.

        Examples
        --------
        >>> [Row("", value, "", "").shown for value in (0.123456, 22543.2, 1e-9)]
        ['0.1235', '22,543', '0']
        """
        return f"{self.value:,.0f}" if abs(self.value) >= 1000.0 else f"{round(self.value, 6):.4g}"


class Observed(NamedTuple):
    """What was observed, on the grid of a run.

    Attributes
    ----------
    reached : (rows, columns) bool array
    change : (rows, columns) float64 array or None
        Of the elevation, m, if it was measured; nan where the file has no data.
    """

    reached: Flags
    change: Floats | None


class Extents(NamedTuple):
    """The observed and the simulated extent on the grid of a run.

    Attributes
    ----------
    terrain : Raster
    observed, simulated, compared : (rows, columns) bool array
        Reached cells, and those that are compared: where the terrain is known.
    change : (rows, columns) float64 array or None
        Of the elevation, m, if it was measured; nan where the file has no data.
    threshold : float, m
    """

    terrain: Raster
    observed: Flags
    simulated: Flags
    compared: Flags
    change: Floats | None
    threshold: float


class Comparison(NamedTuple):
    """A run against what was observed.

    Attributes
    ----------
    terrain : Raster
    observed, simulated, compared : (rows, columns) bool array
        Reached cells, and those that are compared.
    path : shapely.LineString
        Along which run-out distances are measured, from the middle of the first release.
    contingency : Contingency
    rows : list of Row
    """

    terrain: Raster
    observed: Flags
    simulated: Flags
    compared: Flags
    path: shapely.LineString
    contingency: Contingency
    rows: list[Row]


def contingency(observed: Flags, simulated: Flags, compared: Flags) -> Contingency:
    """Return how two extents agree over the cells that are compared."""
    pairs = ((True, True), (True, False), (False, True), (False, False))
    return Contingency(
        *(int(((observed == o) & (simulated == s) & compared).sum()) for o, s in pairs)
    )


def compare_with_observed(run: Path, file: Path, threshold: float | None = None) -> Comparison:
    """Return the score of a run against an observed extent or a change of elevation.

    Parameters are those of :func:`extents_of`.

    Raises
    ------
    OutputError
        If the run lacks a layer.
    CaseError
        If the file cannot be read, or does not fit the map of the run.
    """
    found = extents_of(run, file, threshold)
    terrain, seen, simulated, compared, changed, threshold = found
    grid = terrain.grid
    agreement = contingency(seen, simulated, compared)
    case = open_run(run).case
    path = path_of(case, terrain)
    least = max(threshold, case.output.layer_depth)
    rows = [
        Row("threshold", least, "m", "depth from which a cell is simulated"),
        *_extent_rows(agreement, _unknown(changed) & simulated & compared, grid),
        *_distance_rows(seen, simulated, path, grid),
    ]
    if changed is not None:
        change = "change of elevation from which a cell is observed, and deposit counts"
        rows.insert(1, Row("threshold_change", threshold, "m", change))
        deposit = np.nan_to_num(read_layer(run, "deposit").values)
        rows += _deposit_rows(np.nan_to_num(changed), deposit, compared, threshold, grid)
    return Comparison(terrain, seen, simulated, compared, path, agreement, rows)


def extents_of(run: Path, file: Path, threshold: float | None = None) -> Extents:
    """Return an observed extent, or where an elevation has changed, and the extent of a run.

    Parameters
    ----------
    run : Path
        Its folder.
    file : Path
        Polygons of the reached area, or a raster of the change of elevation, m.
    threshold : float, m, optional
        Depth, and change of elevation, from which a cell counts; if left out 0.3 m of a raster,
        and with polygons ``output.layer_depth``.  Less than that no depth can be told, since
        ``peak_depth`` has no data there.

    Raises
    ------
    OutputError
        If the run lacks a layer.
    CaseError
        If the file cannot be read, or does not fit the map of the run.
    """
    depth, terrain = read_layer(run, "peak_depth"), read_layer(run, "terrain")
    is_raster = file.suffix.lower() not in VECTORS
    if threshold is None:
        threshold = LEAST_CHANGE if is_raster else 0.0
    grid = depth.grid
    seen = _observed_change(file, grid, threshold) if is_raster else _observed_extent(file, grid)
    compared = np.isfinite(terrain.values)
    if not (seen.reached & compared).any():
        raise CaseError(f"{file}: nothing of what was observed lies on the map of {run}")
    simulated = np.nan_to_num(depth.values) > threshold
    return Extents(terrain, seen.reached, simulated, compared, seen.change, threshold)


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else float("nan")


def _observed_extent(file: Path, grid: MapGrid) -> Observed:
    """Return the cells whose middles lie in the polygons of a file."""
    try:
        polygons = read_polygons(file)
    except UnreadableVectorsError as error:
        raise CaseError(f"{file} {error}") from error
    _expect_system(file, polygons.crs, grid)
    east, north = centers(grid)
    x, y = np.meshgrid(east, north)
    area: Any = shapely.union_all(polygons.shapes)
    shapely.prepare(area)
    return Observed(shapely.contains_xy(area, x, y), None)


def _observed_change(file: Path, grid: MapGrid, threshold: float) -> Observed:
    """Return the cells in which a raster has changed by more than a threshold, up or down.

    Such rasters are often cut to the event: cells without data are taken as unchanged.
    """
    try:
        raster = read_raster(file)
    except UnreadableRasterError as error:
        raise CaseError(f"{file} {error}") from error
    _expect_system(file, raster.grid.crs, grid)
    change = on_grid(raster, grid)
    return Observed(np.abs(np.nan_to_num(change)) > threshold, change)


def _expect_system(file: Path, crs: str, grid: MapGrid) -> None:
    if differ(crs, grid.crs):
        raise CaseError(
            f"{file} is in another coordinate reference system than the map of the run; project it "
            "to that of the DEM"
        )


def on_grid(raster: Raster, grid: MapGrid) -> Floats:
    """Return a raster on another grid: the mean of the cells whose middles lie in a cell of it.

    Where its own cells are larger, the one in which the middle lies.  nan where there is none.

    Examples
    --------
    >>> fine = Raster(MapGrid(0.0, 0.0, 1.0, 4, 2), np.arange(8.0).reshape(2, 4))
    >>> on_grid(fine, MapGrid(0.0, 0.0, 2.0, 3, 1))
    array([[2.5, 4.5, nan]])
    >>> on_grid(Raster(MapGrid(0.0, 0.0, 2.0, 1, 1), np.array([[7.0]])), fine.grid)
    array([[ 7.,  7., nan, nan],
           [ 7.,  7., nan, nan]])
    """
    own = raster.grid
    if own.cell > grid.cell:
        east, north = centers(grid)
        column, row = _cells(east, north, own)
        padded = np.pad(raster.values, ((0, 1), (0, 1)), constant_values=np.nan)
        return padded[row[:, None], column[None, :]]
    column, row = _cells(*centers(own), grid)
    cell = row[:, None] * (grid.columns + 1) + column[None, :]
    known = np.isfinite(raster.values)
    size = (grid.rows + 1) * (grid.columns + 1)
    total = np.bincount(cell[known], raster.values[known], size)
    count = np.bincount(cell[known], minlength=size)
    mean = np.full(size, np.nan)
    np.divide(total, count, out=mean, where=count > 0)
    return mean.reshape(grid.rows + 1, grid.columns + 1)[:-1, :-1]


def _cells(
    east: Floats, north: Floats, grid: MapGrid
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the columns and rows of places; one past the last for what is beyond the grid."""
    column = np.floor((east - grid.west) / grid.cell).astype(np.int64)
    row = np.floor((grid.north - north) / grid.cell).astype(np.int64)
    column[(column < 0) | (column >= grid.columns)] = grid.columns
    row[(row < 0) | (row >= grid.rows)] = grid.rows
    return column, row


def _unknown(change: Floats | None) -> Flags | np.bool_:
    """Return where a raster has no data; nowhere of polygons."""
    return np.False_ if change is None else np.isnan(change)


def _extent_rows(agreement: Contingency, unknown: Flags, grid: MapGrid) -> list[Row]:
    h, m, f, c = agreement
    area = grid.cell**2
    return [
        Row("hits", h, "cells", "observed and simulated"),
        Row("misses", m, "cells", "observed only"),
        Row("false_alarms", f, "cells", "simulated only"),
        Row("false_alarms_no_data", int(unknown.sum()), "cells", "of these, taken as unchanged"),
        Row("correct_rejections", c, "cells", "neither"),
        Row("observed_area", (h + m) * area, "m2", "in plan"),
        Row("simulated_area", (h + f) * area, "m2", "in plan"),
        Row("csi", agreement.csi, "", "critical success index; 1 is perfect"),
        Row("hss", agreement.hss, "", "Heidke skill score; 1 is perfect, 0 is chance"),
        Row("d2pc", agreement.d2pc, "", "distance to the perfect classification; 0 is perfect"),
        Row("foc", agreement.foc, "", "factor of conservativeness; over 1 too much is reached"),
    ]


def _distance_rows(
    observed: Flags, simulated: Flags, path: shapely.LineString, grid: MapGrid
) -> list[Row]:
    start = shapely.Point(path.coords[0])
    east, north = centers(grid)
    rows: list[Row] = []
    for word, how in (("runout", "along the flow path"), ("reach", "in a straight line")):
        found = []
        for chosen in (observed, simulated):
            i, j = np.nonzero(chosen)
            to_all = (
                along(path, grid, chosen)
                if word == "runout"
                else shapely.distance(start, shapely.points(east[j], north[i]))
            )
            found.append(float(to_all.max(initial=0.0)))
        seen, made = found
        from_start = f"from the middle of the first release, {how}, to the farthest cell"
        rows += [
            Row(f"{word}_observed", seen, "m", from_start),
            Row(f"{word}_simulated", made, "m", from_start),
            Row(f"{word}_difference", made - seen, "m", "simulated less observed"),
            Row(f"{word}_error", 100.0 * _ratio(made - seen, seen), "%", "of the observed"),
        ]
    return rows


def _deposit_rows(
    change: Floats, deposit: Floats, compared: Flags, threshold: float, grid: MapGrid
) -> list[Row]:
    """Return how a simulated deposit agrees with where the elevation has risen."""
    rise = np.where(change > threshold, change, 0.0)
    made = np.where(deposit > threshold, deposit, 0.0)
    either = compared & ((rise > 0.0) | (made > 0.0))
    difference = (made - rise)[either]
    area = grid.cell**2
    seen, simulated = (float(values[compared].sum()) * area for values in (rise, made))
    eroded = float(np.where(change < -threshold, change, 0.0)[compared].sum()) * -area
    rms = float(np.sqrt(np.mean(difference**2))) if difference.size else float("nan")
    agreement = contingency(rise > 0.0, made > 0.0, compared)
    thick = "where thicker than the threshold"
    return [
        Row("deposit_csi", agreement.csi, "", "critical success index of the deposit"),
        Row("deposit_volume_observed", seen, "m3", f"risen, {thick}"),
        Row("deposit_volume_simulated", simulated, "m3", f"deposit, {thick}"),
        Row("deposit_volume_error", 100.0 * _ratio(simulated - seen, seen), "%", "of the observed"),
        Row("deposit_rms", rms, "m", "root mean square of simulated less observed, where either"),
        Row("eroded_volume_observed", eroded, "m3", "sunk by more than the threshold"),
    ]


def score_lines(found: Comparison) -> list[str]:
    """Return the figures as lines of a table."""
    width = max(len(row.measure) for row in found.rows)
    return [f"{r.measure:<{width}} {r.shown:>9} {r.unit:<5} {r.meaning}" for r in found.rows]
