"""The files on a map that a case names: found beside it, read, and refused where they are wrong.

The names of elevation models, rasters and polygons become absolute paths; borders, lines and
hydrographs are put into the case.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from debrisflow.case.problems import Problem
from debrisflow.case.rasters import UnreadableRasterError, read_raster
from debrisflow.case.reference_systems import differ
from debrisflow.case.releases import Hydrograph
from debrisflow.case.series import UnreadableSeriesError, read_series
from debrisflow.case.terrain import bounds, cells_around
from debrisflow.case.vectors import (
    UnreadableVectorsError,
    look_like_degrees,
    read_lines,
    read_polygons,
)

OTHER_SYSTEM = (
    "has coordinates of another system than the DEM; save it in that of the DEM, as GIS programs do"
)
DEGREES = (
    "has coordinates that look like degrees, far off the DEM; save it in the coordinate system of "
    "the DEM"
)


def find_map_files(data: dict[str, Any], folder: Path) -> dict[str, list[Problem]]:
    """Replace the names of map files by absolute paths or by the contents of the files.

    Parameters
    ----------
    data : dict
        The case as read from TOML; changed in place.
    folder : Path
        Folder of the case file, in which the names are looked up.

    Returns
    -------
    dict of str to list of Problem
        What is wrong with the files that a table names, by the name of the table.
    """
    problems: dict[str, list[Problem]] = {}
    geometry = data.get("geometry")
    places: list[tuple[str, dict[str, Any]]] = []
    if isinstance(geometry, dict) and geometry.get("type") == "terrain":
        places.append(("geometry", geometry))
    for name in ("release", "zone"):
        entries = data.get(name)
        places += [
            (f"{name}.{k}", entry)
            for k, entry in enumerate(entries if isinstance(entries, list) else [])
            if isinstance(entry, dict)
        ]
    dem: Path | None = None
    crs, reaches = "", None
    for key, table in places:
        for field, read in _readers(key, table).items():
            given = table.get(field)
            if not isinstance(given, str):
                continue
            path = (folder / given).absolute()
            try:
                table[field], found, box = read(path)
                if field == "dem":
                    dem, crs, reaches = path, found, box
                elif differ(found, crs):
                    raise UnreadableVectorsError(OTHER_SYSTEM)
                elif reaches and _far_in_degrees(box, reaches):
                    raise UnreadableVectorsError(DEGREES)
                elif dem and field == "crop":
                    table[field] = list(cells_around(table[field], read_raster(dem).grid))
            except (UnreadableRasterError, UnreadableVectorsError, UnreadableSeriesError) as error:
                table[field] = given
                wrong = Problem(f"{key}.{field}", str(error), given)
                problems.setdefault(key.partition(".")[0], []).append(wrong)
    return problems


_Box = tuple[float, float, float, float]
_Reader = Callable[[Path], tuple[Any, str, _Box | None]]


def _readers(key: str, table: Mapping[str, Any]) -> dict[str, _Reader]:
    """Return how the files are read that the fields of a table name."""
    if key == "geometry":
        return {"dem": _raster, "crop": _borders}
    if key.startswith("zone"):
        return {"file": _polygons, "raster": _raster}
    if table.get("type") == "hydrograph":
        return {"line": _line, "hydrograph": _hydrograph}
    return {"file": _raster if table.get("type") == "raster" else _polygons}


def _raster(path: Path) -> tuple[str, str, _Box | None]:
    grid = read_raster(path).grid
    return str(path), grid.crs, (grid.west, grid.south, grid.east, grid.north)


def _polygons(path: Path) -> tuple[str, str, _Box]:
    found = read_polygons(path)
    return str(path), found.crs, bounds(found)


def _borders(path: Path) -> tuple[list[float], str, _Box]:
    found = read_polygons(path)
    return list(bounds(found)), found.crs, bounds(found)


def _line(path: Path) -> tuple[list[list[float]], str, _Box]:
    found = read_lines(path)
    if len(found.shapes) > 1:
        raise UnreadableVectorsError(f"holds {len(found.shapes)} lines where one is wanted")
    line = found.shapes[0]
    if len(line.coords) != 2:
        raise UnreadableVectorsError(
            f"holds a line of {len(line.coords)} points; a straight one of two is wanted"
        )
    return [list(point) for point in line.coords], found.crs, line.bounds


def _hydrograph(path: Path) -> tuple[dict[str, list[float]], str, None]:
    try:
        return read_series(path, tuple(Hydrograph.model_fields)), "", None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UnreadableSeriesError(f"cannot be read: {reason}") from error


def _far_in_degrees(box: _Box | None, reaches: _Box) -> bool:
    """Return whether a box may be one of longitudes and latitudes, beside a map that is not."""
    if box is None:
        return False
    west, south, east, north = box
    apart = west > reaches[2] or east < reaches[0] or south > reaches[3] or north < reaches[1]
    return apart and look_like_degrees(box) and not look_like_degrees(reaches)
