"""The layers of a map that a run leaves: rasters, extents and their styles for GIS programs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow import __version__
from debrisflow.case.rasters import MapGrid, Raster, has_rasterio, raster_of_plan, write_raster
from debrisflow.case.vectors import UnreadableVectorsError, write_polygons
from debrisflow.particles.layers import Layers
from debrisflow.run.atomic import UNFINISHED, made, replaced_files
from debrisflow.run.layer_styles import style
from debrisflow.run.tables import Series

Floats = NDArray[np.float64]
FOLDER = "layers"
EXTENT = "extent"
FRAME = "depth"
FRAME_TIMES = "depth.csv"
FRAME_HEAD = (
    "time: s",
    "frame: number in the name of the file, depth_NNNNNN, of the depth at that time",
)
ENDINGS = ("tif", "asc")
ESTIMATOR = (
    "volume of each particle spread evenly over a square of side 2 particle_spacing, by overlap "
    "with cells; sampled every step"
)


class Layer(NamedTuple):
    """What a layer holds."""

    unit: str
    meaning: str


LAYERS = {
    "peak_depth": Layer("m", "greatest depth, measured vertically: volume over area of the cell"),
    "peak_speed": Layer("m/s", "greatest speed: momentum over mass of the cell"),
    "peak_momentum_flux": Layer("m3/s2", "greatest product of depth and speed squared"),
    "peak_pressure": Layer("kPa", "greatest product of density and speed squared"),
    "arrival": Layer("s", "first time at which the depth exceeds the threshold"),
    "duration": Layer("s", "time during which the depth exceeds the threshold"),
    "deposit": Layer("m", "depth at the end, of particles slower than output.rest_speed only"),
    "final_depth": Layer("m", "depth at the end"),
    "release": Layer("m", "depth of all released masses, without hydrographs"),
    "terrain": Layer("m", "elevation of the terrain as given"),
}
WHILE_DEEP = ("peak_speed", "peak_momentum_flux", "peak_pressure", "arrival", "duration")
"""Layers that count while the depth exceeds the threshold only."""


class Origin(NamedTuple):
    """Where layers come from, for their tags.

    Attributes
    ----------
    case : str
        SHA-256 of the case and its files, see :func:`debrisflow.case.content.digest_of`.
    spacing : float
        d0, m.
    threshold : float, m
        Depth from which a cell counts as reached.
    time : float, s
    """

    case: str
    spacing: float
    threshold: float
    time: float

    def tags(self, name: str) -> dict[str, str]:
        """Return the tags of a layer."""
        layer = LAYERS.get(name) or Layer("m", "depth at the time")
        return {
            "name": name,
            "unit": layer.unit,
            "meaning": layer.meaning,
            "estimator": ESTIMATOR,
            "threshold": f"{self.threshold:g} m",
            "particle_spacing": f"{self.spacing:g} m",
            "time": f"{self.time:.9g} s",
            "case_sha256": self.case,
            "software": f"debrisflow {__version__}",
        }


def write_layers(
    folder: Path, grid: MapGrid, layers: Layers, others: Mapping[str, Floats], origin: Origin
) -> list[Path]:
    """Write all layers of a run with their styles, and the extent of the flow as polygons.

    Layers of the flow have no data where the depth never exceeded the threshold.  Existing files
    are replaced when all new ones are complete.

    Parameters
    ----------
    folder : Path
        Of the layers, ``RUN/layers``.
    grid : MapGrid
    layers : Layers
    others : mapping of str to (columns, rows) float64 array, m
        Deposit, final depth, release and terrain, where the run has them; nan for no data.
    origin : Origin

    Returns
    -------
    list of Path

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    is_reached = layers.peak_depth > origin.threshold
    plans = {
        name: np.where(is_reached, getattr(layers, name), np.nan)
        for name in ("peak_depth", *WHILE_DEEP)
    }
    plans |= others
    with replaced_files(folder) as unfinished:
        for name, values in plans.items():
            write_raster(
                unfinished / f"{name}.{_ending()}",
                raster_of_plan(grid, values),
                origin.tags(name),
            )
            text = style(name, LAYERS[name].unit, values)
            (unfinished / f"{name}.qml").write_text(text, encoding="utf-8")
        _write_extent(unfinished, raster_of_plan(grid, layers.peak_depth), origin)
        return [folder / file.name for file in sorted(unfinished.iterdir())]


def _ending() -> str:
    return ENDINGS[0] if has_rasterio() else ENDINGS[1]


def _write_extent(folder: Path, peak_depth: Raster, origin: Origin) -> None:
    """Write where the greatest depth exceeds the threshold, as GeoJSON and GeoPackage."""
    shapes = polygons_of(peak_depth.grid, peak_depth.values > origin.threshold)
    attributes = {
        "area_m2": [shape.area for shape in shapes],
        "deeper_than_m": [origin.threshold] * len(shapes),
    }
    for ending in ("geojson", "gpkg"):
        try:
            path = folder / f"{EXTENT}.{ending}"
            write_polygons(path, shapes, attributes, peak_depth.grid.crs)
        except UnreadableVectorsError:
            continue  # without pyogrio there is GeoJSON alone


def polygons_of(grid: MapGrid, chosen: NDArray[np.bool_]) -> list[shapely.Polygon]:
    """Return the outlines of cells, one for each group that hangs together by sides.

    Parameters
    ----------
    grid : MapGrid
    chosen : (rows, columns) bool array
        The northernmost row first.

    Examples
    --------
    >>> grid = MapGrid(100.0, 0.0, 10.0, 3, 2)
    >>> found = polygons_of(grid, np.array([[True, True, False], [False, True, False]]))
    >>> [(shape.area, shape.bounds) for shape in found]
    [(300.0, (100.0, 0.0, 120.0, 20.0))]
    """
    edges = np.diff(np.pad(chosen, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(edges == 1)
    _, last = np.nonzero(edges == -1)
    north = grid.south + (grid.rows - row) * grid.cell
    south = grid.south + (grid.rows - row - 1) * grid.cell
    runs = shapely.box(grid.west + first * grid.cell, south, grid.west + last * grid.cell, north)
    whole = shapely.simplify(shapely.union_all(runs), 0.0)
    parts = shapely.get_parts(whole)
    return sorted((part for part in parts if not part.is_empty), key=lambda part: -part.area)


class DepthFrames:
    """Writes the depth at times, ``depth_NNNNNN.tif``, and ``depth.csv`` with the times.

    Parameters
    ----------
    folder : Path
        Of the layers; frames there are continued.
    grid : MapGrid
    """

    def __init__(self, folder: Path, grid: MapGrid) -> None:
        self._folder, self._grid = made(folder), grid
        self._times = Series(folder / FRAME_TIMES, ("time", "frame"), FRAME_HEAD)
        self._count = len(_frames(folder))

    def write(self, depth: Floats, origin: Origin) -> None:
        """Append a depth, (columns, rows) array, m, at the time of its origin."""
        shown = raster_of_plan(self._grid, np.where(depth > 0.0, depth, np.nan))
        with replaced_files(self._folder) as unfinished:
            file = unfinished / f"{FRAME}_{self._count:06d}.{_ending()}"
            write_raster(file, shown, origin.tags(FRAME))
        self._times.append([(origin.time, self._count)])
        self._count += 1

    def flush(self) -> None:
        """Bring the table of times to the disk, where the frames are."""
        self._times.flush()

    def truncate_after(self, time: float) -> None:
        """Remove the frames later than a time, s."""
        self._times.truncate_after(time)
        lines = self._times.path.read_text(encoding="utf-8").splitlines()
        self._count = sum(line[:1].isdigit() for line in lines)
        for file in _frames(self._folder)[self._count :]:
            file.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the table of times."""
        self._times.close()


def _frames(folder: Path) -> list[Path]:
    """Return the frames of depth in a folder, in the order of time."""
    named = re.compile(rf"{FRAME}_\d{{6,}}\.({'|'.join(ENDINGS)})")
    return sorted(file for file in folder.glob(f"{FRAME}_*") if named.fullmatch(file.name))


def layer_files(folder: Path) -> Iterator[Path]:
    """Yield the files that a run writes into the folder of its layers, unfinished ones too."""
    names = "|".join(map(re.escape, LAYERS))
    ours = re.compile(
        rf"({names})\.(tif|asc|prj|qml)|{EXTENT}\.(geojson|gpkg)"
        rf"|{FRAME}_\d{{6,}}\.(tif|asc|prj)|{re.escape(FRAME_TIMES)}"
    )
    for file in (*folder.glob("*"), *folder.glob(f"new{UNFINISHED}/*")):
        if ours.fullmatch(file.name.removesuffix(UNFINISHED)):
            yield file
