"""Polygons and lines on a map, read from and written to files.

GeoJSON is read and written here; GeoPackage and Shapefile by pyogrio, which is imported only where
it is needed, since most cases have no terrain.
"""

from __future__ import annotations

import json
import sqlite3
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
import shapely.geometry
import shapely.geometry.polygon

from debrisflow.case.reference_systems import fault_of_system, wkt_of
from debrisflow.case.words import either
from debrisflow.files import expect_regular_beside, opened, regular, text_of

GEOJSON = (".geojson", ".json")
INSTALL = (
    'is read by pyogrio, which is not installed: pip install rasterio pyogrio (the extra "terrain")'
)
MOST_BYTES = 256_000_000
FARTHEST = 1.0e9  # m, of a place on a map
FORMATS = {".gpkg": b"SQLite format 3\0", ".shp": b"\x00\x00\x27\x0a"}
"""What the files that GDAL may open begin with, by their endings."""
BESIDE_STEM = (".shx", ".dbf", ".prj", ".cpg", ".qix", ".sbn", ".sbx", ".cst")
MOST_TABLES = 1000
NO_DATE = "2000-01-01T00:00:00.000Z"  # the same bytes whenever a file is written
WANTED = {"Polygon": "polygons", "LineString": "lines"}


class UnreadableVectorsError(ValueError):
    """Why a file gives no polygons or lines, in words that follow its name."""


class Polygons(NamedTuple):
    """Polygons on a map.

    Attributes
    ----------
    shapes : tuple of shapely.Polygon
        At least one, valid, without elevations; multipolygons are split into their parts.
    crs : str
        Coordinate reference system as WKT, or by its name where that is not known; empty if the
        file states none.
    """

    shapes: tuple[shapely.Polygon, ...]
    crs: str


class Lines(NamedTuple):
    """Lines on a map, as :class:`Polygons` are."""

    shapes: tuple[shapely.LineString, ...]
    crs: str


def read_polygons(path: Path) -> Polygons:
    """Return the polygons of a file, holes kept.

    Raises
    ------
    UnreadableVectorsError
        If it cannot be read, holds no polygon or something else, or is measured in degrees or
        feet.  A file of GeoJSON without a system may be in degrees: see :func:`look_like_degrees`.
    """
    shapes, crs = _read(path, "Polygon", _stamp(path))
    return Polygons(shapes, crs)


def read_lines(path: Path) -> Lines:
    """Return the lines of a file; errors as those of :func:`read_polygons`."""
    shapes, crs = _read(path, "LineString", _stamp(path))
    return Lines(shapes, crs)


def look_like_degrees(box: tuple[float, float, float, float]) -> bool:
    """Return whether borders, west, south, east and north, may be longitudes and latitudes.

    Those of a small map in meters may be too.

    Examples
    --------
    >>> look_like_degrees((-122.2, 46.2, -122.1, 46.3))
    True
    >>> look_like_degrees((562000.0, 5118000.0, 562100.0, 5118100.0))
    False
    """
    west, south, east, north = box
    return west >= -180.0 and east <= 180.0 and south >= -90.0 and north <= 90.0


def write_polygons(
    path: Path,
    polygons: Sequence[shapely.Polygon | shapely.MultiPolygon],
    attributes: Mapping[str, Sequence[Any]] | None = None,
    crs: str = "",
) -> None:
    """Write polygons to a file of GeoJSON, or with pyogrio to a GeoPackage.

    GeoJSON names its system in the member ``crs``, which GIS programs still read, since the
    coordinates are those of the map and not degrees.

    Parameters
    ----------
    path : Path
        Its ending, ``.geojson`` or ``.gpkg``, sets the format.
    polygons : sequence of shapely.Polygon or shapely.MultiPolygon
    attributes : mapping of str to sequence, optional
        Columns of a value for each polygon: numbers, text, None or nan where there is none.
    crs : str
        As WKT, or by its name of an authority.

    Raises
    ------
    OSError
    UnreadableVectorsError
        If pyogrio is not installed.
    """
    columns = dict(attributes or {})
    if path.suffix.lower() in GEOJSON:
        _write_geojson(path, polygons, columns, crs)
    else:
        _write_by_gdal(path, polygons, columns, crs)


def _stamp(path: Path) -> tuple[int, int]:
    """Return a stamp by which a changed file is recognized."""
    try:
        state = regular(path, MOST_BYTES)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UnreadableVectorsError(f"cannot be read: {reason}") from error
    return state.st_mtime_ns, state.st_size


@lru_cache(maxsize=32)
def _read(path: Path, kind: str, stamp: tuple[int, int]) -> tuple[tuple[Any, ...], str]:
    """Return the shapes of a kind in a file, and its system."""
    is_json = path.suffix.lower() in GEOJSON
    found, crs = _read_geojson(path) if is_json else _read_by_gdal(path)
    if fault := fault_of_system(crs):
        raise UnreadableVectorsError(fault)
    shapes = []
    for shape in _parts(found):
        if shape.geom_type != kind:
            raise UnreadableVectorsError(
                f"holds a {shape.geom_type} where {WANTED[kind]} are wanted"
            )
        points = shapely.get_coordinates(shape)
        if not np.isfinite(points).all():
            raise UnreadableVectorsError("has a coordinate that is no number")
        if np.abs(points).max() > FARTHEST:
            raise UnreadableVectorsError(
                f"has a coordinate beyond {FARTHEST:g} m, which is no place on a map"
            )
        if kind == "Polygon" and not shape.is_valid:
            reason = shapely.is_valid_reason(shape)
            raise UnreadableVectorsError(f"has a polygon that crosses or touches itself: {reason}")
        shapes.append(shape)
    if not shapes:
        raise UnreadableVectorsError(f"holds no {WANTED[kind]}")
    return tuple(shapes), wkt_of(crs)


def _parts(shapes: Sequence[Any]) -> Iterator[Any]:
    """Yield the single shapes of collections, without levels."""
    for shape in shapes:
        if shape is None or shape.is_empty:
            continue
        if hasattr(shape, "geoms"):
            yield from _parts(shape.geoms)
        else:
            flat = shapely.force_2d(shape)
            is_ring = flat.geom_type == "LinearRing"
            yield shapely.LineString(flat.coords) if is_ring else flat


def _read_geojson(path: Path) -> tuple[list[Any], str]:
    try:
        data = json.loads(text_of(path, MOST_BYTES))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UnreadableVectorsError(f"cannot be read: {reason}") from error
    except ValueError as error:  # of JSON and of UTF-8
        raise UnreadableVectorsError(f"is not GeoJSON: {error}") from error
    except RecursionError as error:
        raise UnreadableVectorsError("is not GeoJSON: it is nested too deep") from error
    try:
        return [shapely.geometry.shape(part) for part in _geometries(data)], _crs_of(data)
    except RecursionError as error:
        raise UnreadableVectorsError("is not GeoJSON: it is nested too deep") from error
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        reason = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise UnreadableVectorsError(f"is not GeoJSON: {reason}") from error
    except shapely.errors.ShapelyError as error:
        raise UnreadableVectorsError(f"is not GeoJSON: {error}") from error


def _geometries(data: Any) -> Iterator[dict[str, Any]]:
    """Yield the geometries of GeoJSON."""
    kind = data["type"]
    if kind == "FeatureCollection":
        for feature in data["features"]:
            yield from _geometries(feature)
    elif kind == "Feature":
        if data["geometry"] is not None:
            yield data["geometry"]
    else:
        yield data


def _crs_of(data: Any) -> str:
    """Return the name of the system in the member ``crs``, which the format had until 2016."""
    member = data.get("crs")
    name = member["properties"]["name"] if member and member["type"] == "name" else ""
    if not isinstance(name, str):
        raise TypeError("the name of its system is no text")
    return name


def _read_by_gdal(path: Path) -> tuple[list[Any], str]:
    pyogrio = _pyogrio()
    try:
        _expect_format(path)
        layers = [name for name, kind in pyogrio.list_layers(path) if kind is not None]
        if len(layers) > 1:
            raise UnreadableVectorsError(
                f"has {len(layers)} layers ({', '.join(layers)}); save the one that is meant alone"
            )
        if not layers:
            return [], ""
        with warnings.catch_warnings():  # of rings that do not close, which are refused below
            warnings.simplefilter("ignore")
            meta, _, shapes, _ = pyogrio.raw.read(path, layer=layers[0], columns=[], force_2d=True)
        return list(shapely.from_wkb(shapes)), meta["crs"] or ""
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UnreadableVectorsError(f"cannot be read: {reason}") from error
    except UnreadableVectorsError:
        raise
    except (RuntimeError, ValueError, shapely.errors.ShapelyError) as error:  # all of pyogrio's
        raise UnreadableVectorsError(f"cannot be read as polygons or lines: {error}") from error


def _expect_format(path: Path) -> None:
    """Refuse what is not what its ending says: GDAL opens whatever a file turns out to be.

    Some of its formats are lists of other files or addresses in a network, or archives.  A view
    of a GeoPackage is a query, which may take any time.

    Raises
    ------
    OSError
    UnreadableVectorsError
    """
    known = FORMATS.get(path.suffix.lower())
    if known is None or "!" in str(path) or str(path).startswith("/vsi"):
        raise UnreadableVectorsError(
            f"must be a file of {either(('.geojson', '.json', *FORMATS))}, and without an "
            "exclamation mark in its path"
        )
    expect_regular_beside(path, (".aux.xml", "-wal", "-shm", "-journal"), BESIDE_STEM)
    with opened(path, MOST_BYTES) as file:
        if file.read(len(known)) != known:
            raise UnreadableVectorsError(
                f"cannot be read as polygons or lines: it is no {path.suffix} file"
            )
    if path.suffix.lower() == ".gpkg":
        _expect_tables(path)


def _expect_tables(path: Path) -> None:
    """Refuse a GeoPackage with views or other tables that are computed as they are read."""
    where = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    try:
        with closing(sqlite3.connect(where, uri=True)) as base:
            base.execute("PRAGMA trusted_schema = off")
            made = base.execute("SELECT type, name, sql FROM sqlite_schema").fetchmany(MOST_TABLES)
    except sqlite3.Error as error:
        raise UnreadableVectorsError(f"is no GeoPackage: {error}") from error
    if len(made) == MOST_TABLES:
        raise UnreadableVectorsError(f"has {MOST_TABLES} tables or more; save its layer alone")
    for kind, name, sql in made:
        text = str(sql or "").upper()
        is_index = "USING RTREE" in " ".join(text.split())
        computed = "GENERATED" in text or ("VIRTUAL" in text and not is_index)
        if kind == "view" or (kind == "table" and computed):
            raise UnreadableVectorsError(
                f"holds {name!r}, which is computed as it is read; save its layer as a new file"
            )


def _pyogrio() -> Any:
    try:
        import pyogrio
        import pyogrio.raw
    except ImportError as error:
        raise UnreadableVectorsError(INSTALL) from error
    return pyogrio


def _write_geojson(
    path: Path, polygons: Sequence[Any], columns: Mapping[str, Sequence[Any]], crs: str
) -> None:
    data: dict[str, Any] = {"type": "FeatureCollection"}
    if crs:
        data["crs"] = {"type": "name", "properties": {"name": _name_of(crs)}}
    data["features"] = [
        {
            "type": "Feature",
            "properties": {name: _plain(values[k]) for name, values in columns.items()},
            "geometry": shapely.geometry.mapping(_counterclockwise(polygon)),
        }
        for k, polygon in enumerate(polygons)
    ]
    path.write_text(json.dumps(data, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8")


def _name_of(crs: str) -> str:
    """Return a system by the name that an authority gives it, where one does."""
    try:
        from rasterio.crs import CRS
    except ImportError:
        return crs
    authority = CRS.from_user_input(crs).to_authority()
    return "urn:ogc:def:crs:{}::{}".format(*authority) if authority else crs


def _plain(value: Any) -> Any:
    """Return a value as a type of JSON."""
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _counterclockwise(polygon: Any) -> Any:
    """Return a polygon, or one of several parts, whose outer rings run as GeoJSON has them."""
    orient = shapely.geometry.polygon.orient
    if isinstance(polygon, shapely.MultiPolygon):
        return shapely.MultiPolygon([orient(part) for part in polygon.geoms])
    return orient(polygon)


def _write_by_gdal(
    path: Path, polygons: Sequence[Any], columns: Mapping[str, Sequence[Any]], crs: str
) -> None:
    pyogrio = _pyogrio()
    parts = [
        shapely.MultiPolygon([shape]) if isinstance(shape, shapely.Polygon) else shape
        for shape in polygons
    ]
    path.unlink(missing_ok=True)
    pyogrio.set_gdal_config_options({"OGR_CURRENT_DATE": NO_DATE})
    with warnings.catch_warnings():  # where the map states no system
        warnings.filterwarnings("ignore", message="'crs' was not provided")
        try:
            pyogrio.raw.write(
                path,
                np.array(shapely.to_wkb(parts), dtype=object),
                [np.asarray(values) for values in columns.values()],
                list(columns),
                driver="GPKG",
                layer=path.stem,
                geometry_type="MultiPolygon",
                crs=crs or None,
            )
        except RuntimeError as error:  # base of all errors of pyogrio
            raise OSError(str(error)) from error
