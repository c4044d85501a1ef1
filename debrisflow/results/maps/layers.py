"""The layers of a run, read from its folder, and the part of the map that they are shown in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid, Raster, UnreadableRasterError, read_raster
from debrisflow.errors import OutputError
from debrisflow.results.maps.looks import DEPTH, LOOKS, Look
from debrisflow.results.reader import Run
from debrisflow.run.tables import read_table

Floats = NDArray[np.float64]
LAYERS = "layers"
SUFFIXES = (".tif", ".asc")
FRAME_TIMES = "depth.csv"
REDUCED: dict[str, Callable[..., Floats]] = {"arrival": np.fmin.reduce, "terrain": np.mean}
THRESHOLD = 0.05  # m, of files that do not state it
MARGIN, LEAST_MARGIN = 0.08, 4.0  # of the longer side of the flow, and cells
SHEET = (0.5, 1.5)  # the least and the greatest height of a map over its width


class Layer(NamedTuple):
    """A layer over the part of the map that is shown.

    Attributes
    ----------
    name : str
    look : Look
    values : (rows, columns) float64 array
        The northernmost row first; nan where it is not shown.
    least : float
        Lower end of the first class: of a depth the threshold, below which nothing is shown.
    """

    name: str
    look: Look
    values: Floats
    least: float


class Layers:
    """The layers that the folder of a run holds.

    Parameters
    ----------
    folder : Path
        Of the run.
    aspects : (float, float)
        The least and the greatest height over width of the part that is shown.
    most_cells : float
        Of that part; of more, blocks of cells become one: the greatest value of the flow and its
        first arrival, the mean of the terrain.

    Attributes
    ----------
    folder : Path
    files : dict of Path by name

    Raises
    ------
    OutputError
        If there are none, or the terrain is not among them.
    """

    def __init__(
        self, folder: Path, aspects: tuple[float, float] = SHEET, most_cells: float = np.inf
    ) -> None:
        found = sorted((folder / LAYERS).glob("*"), key=lambda file: SUFFIXES[0] == file.suffix)
        self.folder, self._aspects, self._most = folder, aspects, most_cells
        self.files = {file.stem: file for file in found if file.suffix in SUFFIXES}
        if "terrain" not in self.files:
            raise OutputError(
                f"{folder} has no layers to draw: {folder / LAYERS} lacks the terrain, which runs "
                "on a terrain write"
            )

    @cached_property
    def terrain(self) -> Raster:
        """Return the elevation, m, over the part that is shown."""
        return self._cropped("terrain")

    @cached_property
    def release(self) -> Floats | None:
        """Return the depth of what is released, m, nan where nothing is; None if not known."""
        if "release" not in self.files:
            return None
        values = self._cropped("release").values
        return np.where(values > 0.0, values, np.nan)

    @property
    def names(self) -> list[str]:
        """Return the names of the layers that can be shown, in the order of their table."""
        return [name for name in LOOKS if name in self.files]

    def layer(self, name: str) -> Layer:
        """Return a layer over the part that is shown.

        Raises
        ------
        OutputError
            If there is none of this name, or its file is damaged.
        """
        if name not in self.names:
            there = ", ".join(self.names) or "none"
            raise OutputError(f"{self.folder} has no layer '{name}' to show; there are: {there}")
        return self._shown(name, LOOKS[name])

    @cached_property
    def frames(self) -> list[tuple[float, str]]:
        """Return times, s, and names of the depths at times, if the run kept any."""
        listing = self.folder / LAYERS / FRAME_TIMES
        if not listing.is_file():
            return []
        table = read_table(listing, needed=("time", "frame"))
        named = [
            (float(time), f"depth_{int(number):06d}")
            for time, number in zip(table["time"], table["frame"], strict=True)
        ]
        return [(time, name) for time, name in named if name in self.files]

    def frame(self, name: str) -> Layer:
        """Return the depth at a time by its name."""
        return self._shown(name, DEPTH)

    def _shown(self, name: str, look: Look) -> Layer:
        least = self.threshold if look.is_depth else 0.0
        values = self._cropped(name).values
        return Layer(name, look, np.where(values >= least, values, np.nan), least)

    @cached_property
    def threshold(self) -> float:
        """Return the depth, m, below which a cell counts as not reached."""
        return float(self.tags("peak_depth").get("threshold", f"{THRESHOLD}").split()[0])

    def tags(self, name: str) -> Mapping[str, str]:
        """Return what the file of a layer says of itself; nothing if it is an ASCII grid."""
        file = self.files.get(name)
        if file is None or file.suffix != ".tif":
            return {}
        import rasterio

        with rasterio.open(file) as opened:
            tags: Mapping[str, str] = opened.tags()
            return tags

    @cached_property
    def _part(self) -> tuple[float, float, float, float]:
        """West, south, east and north of the part that is shown, m."""
        grid = self.whole("terrain").grid
        touched = np.zeros(grid.shape, dtype=bool)
        for name in (*self.names, "release"):
            if name in self.files:
                touched |= self.whole(name).values > self.threshold
        return part_around(grid, touched, self._aspects)

    def whole(self, name: str) -> Raster:
        """Return a layer as it is in its file."""
        try:
            raster = read_raster(self.files[name])
        except UnreadableRasterError as error:
            raise OutputError(f"{self.files[name]} {error}") from error
        if name != "terrain" and raster.grid[:5] != self.whole("terrain").grid[:5]:
            raise OutputError(f"{self.files[name]} is not on the grid of {self.files['terrain']}")
        return raster

    def _cropped(self, name: str) -> Raster:
        part = self.whole(name).cropped(*self._part)
        factor = int(np.ceil(np.sqrt(part.values.size / self._most)))
        return coarsened(part, factor, REDUCED.get(name, np.fmax.reduce))


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


def terrain_around(run: Run) -> Raster:
    """Return the terrain of a run in the coordinates of its particles.

    Raises
    ------
    OutputError
        If the run has none, or its file is damaged.
    """
    raster = Layers(run.folder).whole("terrain")
    base = (getattr(run.case.geometry, "origin", None) or (0.0, 0.0, 0.0))[2]
    return Raster(raster.grid._replace(west=0.0, south=0.0), raster.values - base)


def has_layers(folder: Path) -> bool:
    """Return whether the folder of a run holds layers of a map."""
    return any((folder / LAYERS / f"terrain{suffix}").is_file() for suffix in SUFFIXES)


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
