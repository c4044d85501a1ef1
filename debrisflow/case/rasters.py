"""Rasters on a map: grids of equal square cells, north up, read from and written to files.

ESRI ASCII grids are read and written here; GeoTIFF by rasterio, which is imported by what needs it,
since most cases have no terrain.  GDAL opens nothing else: some of its formats are lists of other
files, or addresses in a network.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.memory import available_memory, size
from debrisflow.case.reference_systems import LONGEST_WKT, METRE, fault_of_heights
from debrisflow.files import MOST_BINARY, expect_regular_beside, opened, regular

Floats = NDArray[np.float64]
Stamp = tuple[int, int]
NODATA = -9999.0
ASCII = (".asc", ".agr", ".grd")
INSTALL = (
    "is read by rasterio, which is not installed: pip install rasterio pyogrio "
    '(the extra "terrain")'
)
FARTHEST = 1.0e9  # m, of a place on a map
LARGEST_NUMBER = 1.0e30  # what lies beyond stands for "no data" in many programs
MOST_CELLS = 400_000_000  # 3 GiB of levels
BYTES_A_CELL = 60  # while a file is read
NOT_PLAIN = "is not an ESRI ASCII grid: it is not plain text"
LINES_AT_ONCE = 1000
MOST_NAMES = 20  # at the head of an ESRI ASCII grid
LONGEST_LINE = 50_000_000  # bytes
BESIDE = (".aux.xml", ".msk", ".ovr")  # what GDAL reads beside a file, its name as it is
BESIDE_STEM = (".tfw", ".tifw", ".wld", ".aux")  # and in the place of its ending
MOST_SHORTENED = 4000  # cells for each byte of a file, of which the rest may be empty
SLACK = 4_000_000  # cells that any file may claim
UNEVEN = 1.0e-6  # by which the sides of a cell may differ


class UnreadableRasterError(ValueError):
    """Why a file gives no raster, in words that follow its name."""


class MapGrid(NamedTuple):
    """A grid of equal square cells on a map, its rows along the parallels of the map.

    Attributes
    ----------
    west, south : float, m
        Corner of the grid.
    cell : float, m
        Side of a cell.
    columns, rows : int
    crs : str
        Coordinate reference system as WKT; empty where the file tells none.
    """

    west: float
    south: float
    cell: float
    columns: int
    rows: int
    crs: str = ""

    @property
    def east(self) -> float:
        """Eastern border, m."""
        return self.west + self.columns * self.cell

    @property
    def north(self) -> float:
        """Northern border, m."""
        return self.south + self.rows * self.cell

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, as the values of a raster have them."""
        return self.rows, self.columns


class Raster(NamedTuple):
    """Values of the cells of a grid on a map.

    Attributes
    ----------
    grid : MapGrid
    values : (rows, columns) float64 array
        The northernmost row first; nan where a cell has none.
    """

    grid: MapGrid
    values: Floats

    @property
    def plan(self) -> Floats:
        """The values as (columns, rows) array, along x from the west and along y from the south."""
        return np.ascontiguousarray(self.values[::-1].T)

    def cropped(self, west: float, south: float, east: float, north: float) -> Raster:
        """Return the cells whose middles lie between borders, m.

        Examples
        --------
        >>> raster = Raster(MapGrid(0.0, 0.0, 10.0, 3, 2), np.arange(6.0).reshape(2, 3))
        >>> grid, values = raster.cropped(10.0, 0.0, 30.0, 10.0)
        >>> grid.west, grid.south, grid.columns, grid.rows
        (10.0, 0.0, 2, 1)
        >>> values
        array([[4., 5.]])
        """
        grid, cell = self.grid, self.grid.cell
        first = max(round((west - grid.west) / cell), 0)
        last = min(round((east - grid.west) / cell), grid.columns)
        top = max(round((grid.north - north) / cell), 0)
        bottom = min(round((grid.north - south) / cell), grid.rows)
        values = self.values[top : max(bottom, top), first : max(last, first)]
        kept = MapGrid(
            west=grid.west + first * cell,
            south=grid.north - bottom * cell,
            cell=cell,
            columns=values.shape[1],
            rows=values.shape[0],
            crs=grid.crs,
        )
        return Raster(kept, values)


class EmptyRasterError(UnreadableRasterError):
    """All cells of a raster are without data, which a layer of a run may be and a DEM not.

    Parameters
    ----------
    raster : Raster
    """

    def __init__(self, raster: Raster) -> None:
        super().__init__("holds no value: all its cells are without data")
        self.raster = raster


def raster_of_plan(grid: MapGrid, plan: Floats) -> Raster:
    """Return a raster of values along x from the west and y from the south, (columns, rows)."""
    return Raster(grid, np.ascontiguousarray(np.asarray(plan, dtype=float).T[::-1]))


def read_raster(path: Path) -> Raster:
    """Return the raster of a file.

    Raises
    ------
    UnreadableRasterError
        If it cannot be read, is not on a grid of square cells with north up, or is measured in
        degrees or feet.
    """
    try:
        regular(path, MOST_BINARY)
        return _read(path, stamp_of(path))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UnreadableRasterError(f"cannot be read: {reason}") from error


def stamp_of(path: Path) -> Stamp:
    """Return what tells that a file has not changed: its time, ns, and its size.

    Raises
    ------
    OSError
    """
    state = path.stat()
    return state.st_mtime_ns, state.st_size


@lru_cache(maxsize=8)
def _read(path: Path, stamp: Stamp) -> Raster:
    """Return the raster of a file, as it is at a stamp of its time and size."""
    raster = _read_ascii(path) if path.suffix.lower() in ASCII else _read_by_gdal(path)
    if not np.isfinite(raster.values).any():
        raise EmptyRasterError(raster)
    raster.values.flags.writeable = False  # shared by all who ask
    return raster


def write_raster(path: Path, raster: Raster, tags: Mapping[str, str] | None = None) -> None:
    """Write a raster, with tags where the format has them: GeoTIFF, or an ESRI ASCII grid.

    Raises
    ------
    OSError
    """
    if path.suffix.lower() in ASCII:
        _write_ascii(path, raster)
        return
    rasterio = _rasterio()
    values = np.where(np.isnan(raster.values), NODATA, raster.values).astype(np.float32)
    grid = raster.grid
    # in memory first: GDAL does not always say that a file did not fit on the disk
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff",
            width=grid.columns,
            height=grid.rows,
            count=1,
            dtype="float32",
            crs=grid.crs or None,
            transform=rasterio.Affine(grid.cell, 0.0, grid.west, 0.0, -grid.cell, grid.north),
            nodata=NODATA,
            compress="deflate",
            predictor=3,
        ) as file:
            file.write(values, 1)
            file.update_tags(**(tags or {}))
        path.write_bytes(memory.read())


def has_rasterio() -> bool:
    """Return whether GeoTIFF can be read and written."""
    try:
        _rasterio()
    except UnreadableRasterError:
        return False
    return True


def _rasterio() -> Any:
    try:
        import rasterio
    except ImportError as error:
        raise UnreadableRasterError(INSTALL) from error
    return rasterio


def _read_by_gdal(path: Path) -> Raster:
    rasterio = _rasterio()
    expect_regular_beside(path, BESIDE, BESIDE_STEM)
    try:
        with warnings.catch_warnings():  # of a file without a place, which is refused below
            warnings.simplefilter("ignore")
            file = rasterio.open(path, driver="GTiff")
        with file:
            grid = _grid_of(file)
            _must_hold(path, grid)
            if np.dtype(file.dtypes[0]).kind not in "iuf":
                raise UnreadableRasterError(f"holds {file.dtypes[0]} numbers, which are no levels")
            stored = file.read(1, masked=True).astype(np.float64).filled(np.nan)
            scale, offset = file.scales[0], file.offsets[0]
    except UnreadableRasterError:
        raise
    except (rasterio.errors.RasterioError, RuntimeError, ValueError) as error:
        raise UnreadableRasterError(f"cannot be read as a raster: {error}") from error
    with np.errstate(over="ignore", invalid="ignore"):
        values = stored * scale + offset
    return Raster(grid, np.where(np.isnan(_without_sentinels(stored)), np.nan, values))


def _must_hold(path: Path, grid: MapGrid) -> None:
    """Refuse a file that claims cells which it cannot hold, before memory is taken for them."""
    size = path.stat().st_size
    if grid.columns * grid.rows > MOST_SHORTENED * size + SLACK:
        raise UnreadableRasterError(
            f"claims {grid.columns} x {grid.rows} cells, which {size} bytes cannot hold"
        )


def _grid_of(file: Any) -> MapGrid:
    """Return the grid of an open file."""
    a, b, west, d, e, north = tuple(file.transform)[:6]
    if file.count != 1:
        raise UnreadableRasterError(f"has {file.count} bands where one of levels is wanted")
    if file.transform.is_identity:
        raise UnreadableRasterError("does not say where it lies: it has no geotransform")
    if b != 0.0 or d != 0.0:
        raise UnreadableRasterError(
            "is rotated against the map; warp it to a grid with north up, as gdalwarp does"
        )
    if a <= 0.0 or e >= 0.0:
        raise UnreadableRasterError(
            "has south up or east on the left; warp it to a grid with north up, as gdalwarp does"
        )
    if abs(a + e) > UNEVEN * a:
        raise UnreadableRasterError(f"has cells of {a:g} by {-e:g}; resample it to square cells")
    crs = file.crs
    if crs is not None and crs.is_geographic:
        raise UnreadableRasterError(
            f"has geographic coordinates ({crs.to_string()}: degrees); project it to a system "
            "in meters, such as the UTM zone or the national grid"
        )
    if crs is not None and not METRE.fullmatch(crs.linear_units or "m"):
        raise UnreadableRasterError(
            f"has coordinates in {crs.linear_units}; project it to a system in meters, and convert "
            "its levels if they are in feet too"
        )
    if crs is not None and (fault := fault_of_heights(crs.to_wkt())):
        raise UnreadableRasterError(fault)
    unit = (file.units or (None,))[0]
    if unit and not METRE.fullmatch(unit):
        raise UnreadableRasterError(f"has levels in {unit}; convert them to meters")
    return _sound(
        MapGrid(
            west=west,
            south=north + e * file.height,
            cell=a,
            columns=file.width,
            rows=file.height,
            crs=crs.to_wkt() if crs is not None else "",
        )
    )


def _sound(grid: MapGrid) -> MapGrid:
    """Return a grid of which the numbers can be right."""
    if not (np.isfinite([grid.west, grid.south, grid.cell]).all() and grid.cell > 0.0):
        raise UnreadableRasterError("has a corner or a cell that is no number or not positive")
    if max(abs(grid.west), abs(grid.south)) > FARTHEST or not 1 / FARTHEST < grid.cell < FARTHEST:
        raise UnreadableRasterError(
            f"has a corner at {grid.west:g}, {grid.south:g} and cells of {grid.cell:g} m, which "
            "are no lengths on a map"
        )
    if grid.columns < 1 or grid.rows < 1:
        raise UnreadableRasterError("has no cells")
    if grid.columns * grid.rows > MOST_CELLS:
        raise UnreadableRasterError(
            f"has {grid.columns} x {grid.rows} cells, more than {MOST_CELLS:.0e}; cut out what is "
            "needed"
        )
    needed, available = BYTES_A_CELL * grid.columns * grid.rows, available_memory()
    if available is not None and needed > available:
        raise UnreadableRasterError(
            f"has {grid.columns} x {grid.rows} cells, which need {size(needed)} of memory to be "
            f"read; {size(available)} are available; cut out what is needed"
        )
    return grid


def _without_sentinels(values: Floats) -> Floats:
    return np.where(np.abs(values) < LARGEST_NUMBER, values, np.nan)


def _read_ascii(path: Path) -> Raster:
    """Return an ESRI ASCII grid; the file beside it that ends on .prj tells its system."""
    with opened(path, MOST_BINARY) as file:
        head, first = _head_of(file)
        grid = _sound(_ascii_grid(head, _prj_of(path)))
        count = grid.columns * grid.rows
        values = _values_of(file, first, count)
    if values.size != count:
        raise UnreadableRasterError(
            f"holds {values.size} values where {grid.columns} columns by {grid.rows} rows make "
            f"{count}; the file may be cut short"
        )
    values[values == head.get("nodata_value", NODATA)] = np.nan
    return Raster(grid, _without_sentinels(values.reshape(grid.shape)))


def _head_of(file: BinaryIO) -> tuple[dict[str, float], bytes]:
    """Return the names and numbers at the head of a grid, and its first line of values."""
    head: dict[str, float] = {}
    while line := _line(file):
        if not line.isascii():
            raise UnreadableRasterError(NOT_PLAIN)
        words = line.split()
        is_name = len(words) == 2 and words[0][:1].isalpha() and words[0].lower() != b"nan"
        if not is_name or len(head) > MOST_NAMES:
            break
        name = words[0].decode("ascii")
        if name.lower() in head:
            raise UnreadableRasterError(f"has two lines of {name}")
        head[name.lower()] = _number(words[1].decode("ascii"), name)
    return head, line


def _values_of(file: BinaryIO, line: bytes, count: int) -> Floats:
    """Return the values of a grid from a line on, not many more than a given number."""
    parts, found = [], 0
    while line and found <= count:
        lines = line + b"".join(islice(iter(lambda: _line(file), b""), LINES_AT_ONCE))
        if not lines.isascii():
            raise UnreadableRasterError(NOT_PLAIN)
        try:
            parts.append(np.array(lines.split(), dtype=np.float64))
        except ValueError as error:
            reason = str(error).replace("b'", "'")
            raise UnreadableRasterError(f"holds what is no number: {reason}") from error
        found += parts[-1].size
        line = _line(file)
    return np.concatenate(parts) if parts else np.empty(0)


def _line(file: BinaryIO) -> bytes:
    line = file.readline(LONGEST_LINE)
    if len(line) == LONGEST_LINE:
        raise UnreadableRasterError("is not an ESRI ASCII grid: it has a line without end")
    return line


def _number(word: str, name: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise UnreadableRasterError(f"has {name} = {word}, which is no number") from error


def _ascii_grid(head: Mapping[str, float], crs: str) -> MapGrid:
    corner = [(f"{axis}llcorner", f"{axis}llcenter") for axis in "xy"]
    known = [next((name for name in names if name in head), None) for names in corner]
    missing = [name for name in ("ncols", "nrows", "cellsize") if name not in head]
    missing += [names[0] for names, found in zip(corner, known, strict=True) if found is None]
    if missing:
        raise UnreadableRasterError(
            f"is not an ESRI ASCII grid: its head lacks {', '.join(missing)}"
        )
    cell = head["cellsize"]
    west, south = (
        head[name] - (0.5 * cell if name.endswith("center") else 0.0)
        for name in known
        if name is not None
    )
    columns, rows = head["ncols"], head["nrows"]
    if not (float(columns).is_integer() and float(rows).is_integer()):
        raise UnreadableRasterError("has a number of columns or rows that is not whole")
    return MapGrid(west, south, cell, int(columns), int(rows), crs)


def _prj_of(path: Path) -> str:
    """Return what a .prj file beside a grid says; geographic systems and feet are refused."""
    beside = path.with_suffix(".prj")
    if not beside.is_file():
        return ""
    with opened(beside, LONGEST_WKT) as file:
        wkt = file.read(LONGEST_WKT).decode("utf-8", "replace").strip()
    if wkt.upper().startswith(("GEOGCS", "GEOGCRS", "GEODCRS")):
        raise UnreadableRasterError(
            f"has geographic coordinates (degrees), says {beside.name}; project it to a system in "
            "meters, such as the UTM zone or the national grid"
        )
    units = re.findall(r'(?:UNIT|LENGTHUNIT)\[\s*"([^"]*)"', wkt, re.IGNORECASE)
    if wkt.upper().startswith(("PROJCS", "PROJCRS")) and units and "foot" in units[-1].lower():
        raise UnreadableRasterError(
            f"has coordinates in {units[-1]}, says {beside.name}; project it to a system in meters"
        )
    if fault := fault_of_heights(wkt):
        raise UnreadableRasterError(fault)
    return wkt


def _write_ascii(path: Path, raster: Raster) -> None:
    grid = raster.grid
    head = {
        "ncols": grid.columns,
        "nrows": grid.rows,
        "xllcorner": repr(grid.west),
        "yllcorner": repr(grid.south),
        "cellsize": repr(grid.cell),
        "NODATA_value": f"{NODATA:g}",
    }
    values = np.where(np.isnan(raster.values), NODATA, raster.values).astype(np.float32)
    with path.open("w", encoding="ascii") as file:
        file.writelines(f"{name} {value}\n" for name, value in head.items())
        np.savetxt(file, values, fmt="%.7g")
    if grid.crs:
        path.with_suffix(".prj").write_text(grid.crs + "\n", encoding="utf-8")
