"""The loaders of what a case names, each with samples, and what it may say of an input.

A target takes a file and either returns or raises an error that is meant for the user.  What a
reader accepts goes on into a case, and a small case that is accepted into the forecast of
``debrisflow check``.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
import tomli_w

from debrisflow.case import build_case, case_schema, load_case
from debrisflow.case.estimate import particle_estimate
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.reference_systems import differ, fault_of_system, wkt_of
from debrisflow.case.resolved import ResolvedCase
from debrisflow.case.vectors import write_polygons
from debrisflow.errors import DebrisflowError
from debrisflow.results.hazard_classes import SHIPPED, read_classes
from debrisflow.results.references import read_reference
from debrisflow.run.forecast import forecast
from tests.untrusted.mutations import Words, mutated, mutated_case

ROOT = Path(__file__).parents[2]
BAD_CASES = ROOT / "tests" / "fast" / "bad_cases"
SMALL = 4000  # particles, of a case that is forecast
SMALL_MEMORY = 3e8  # bytes

TANK: dict[str, Any] = {
    "title": "a box of water",
    "particles": {"spacing": 0.1},
    "geometry": {"type": "tank3d", "length": 1.0, "width": 1.0, "height": 1.0},
    "time": {"end": 1.0},
    "output": {"interval": 0.5},
}
CHANNEL: dict[str, Any] = TANK | {
    "geometry": {"type": "channel", "length": 2.0, "height": 1.0},
    "inflow": {"depth": 0.3},
}
WATER = {"type": "block", "x": [0, 0.4], "y": [0, 1], "z": [0, 0.4], "material": "water"}
RELEASE = {"type": "polygon", "corners": [[40, 40], [60, 40], [60, 60]], "volume": 2000.0}
VALLEY: dict[str, Any] = TANK | {
    "particles": {"spacing": 4.0},
    "geometry": {"type": "terrain", "dem": "plane.asc"},
}
SQUARE = shapely.box(30.0, 30.0, 70.0, 70.0)


class Target(NamedTuple):
    """A loader and what is tried on it.

    Attributes
    ----------
    file : str
        Name of the file that an input becomes.
    meet : callable
        Takes that file; raises nothing but a ``DebrisflowError``.
    mutate : callable
        Returns another input of one, by a generator of random numbers and words.
    words : sequence of bytes
        Names and values that the loader knows.
    """

    file: str
    meet: Callable[[Path], None]
    mutate: Callable[..., bytes] = mutated
    words: Words = ()


def check(case: ResolvedCase) -> None:
    """Forecast a case that is small, as ``debrisflow check`` does any case."""
    expected = particle_estimate(case)
    if expected["total"] < SMALL and expected["memory"] < SMALL_MEMORY:
        str(forecast(case))


def _built(tables: Mapping[str, Any], folder: Path) -> None:
    check(build_case(tables, folder=folder))


def _built_in_one(ways: Sequence[Mapping[str, Any]], folder: Path) -> None:
    """Build cases that use a file in several ways; raise the last error if none is accepted."""
    errors = []
    for tables in ways:
        try:
            _built(tables, folder)
        except DebrisflowError as error:
            errors.append(error)
    if len(errors) == len(ways):
        raise errors[-1]


def _case(path: Path) -> None:
    check(load_case(path))


def _override(path: Path) -> None:
    """Take each line of a file as a change to a case, as after ``--set``."""
    text = path.read_bytes().decode("utf-8", "surrogateescape")
    errors = []
    for base in ("tank.toml", "valley.toml"):
        try:
            check(load_case(path.parent / base, text.split("\n")[:5]))
        except DebrisflowError as error:
            errors.append(error)
    if len(errors) > 1:
        raise errors[0]


def _hydrograph(path: Path) -> None:
    _built(CHANNEL | {"inflow": {"depth": 0.3, "hydrograph": path.name}}, path.parent)


def _motion(path: Path) -> None:
    gate = {"type": "box", "name": "gate", "x": [0.6, 0.7], "y": [0, 1], "z": [0, 1]}
    _built(TANK | {"obstacle": [gate | {"motion": path.name}], "fill": [WATER]}, path.parent)


def _reference(path: Path) -> None:
    read_reference(path)


def _classes(path: Path) -> None:
    read_classes(str(path))


def _mesh(path: Path) -> None:
    fill = {"type": "mesh", "file": path.name, "material": "water"}
    body = {"type": "mesh", "name": "rock", "file": path.name}
    moved = fill | {"offset": [0.3, 0.3, 0.0]}
    ways = ({"fill": [fill]}, {"obstacle": [body], "fill": [moved]})
    _built_in_one([TANK | tables for tables in ways], path.parent)


def _dem(path: Path) -> None:
    tables = {"geometry": {"type": "terrain", "dem": path.name}, "release": [RELEASE]}
    _built(VALLEY | tables, path.parent)


def _prj(path: Path) -> None:
    """Read a grid anew beside which a file says its system."""
    shutil.copyfile(path.with_name("plane.asc"), path.with_suffix(".asc"))
    _dem(path.with_suffix(".asc"))


def _release_raster(path: Path) -> None:
    _built(VALLEY | {"release": [{"type": "raster", "file": path.name}]}, path.parent)


def _polygons(path: Path) -> None:
    release = {"type": "polygon", "file": path.name, "volume": 2000.0}
    friction = {"law": "coulomb", "angle": 20.0}
    zone = {"name": "fan", "file": path.name, "friction": friction}
    line = {
        "type": "hydrograph",
        "line": path.name,
        "velocity": 2.0,
        "hydrograph": {"time": [0.0, 5.0], "discharge": [9.0, 0.0], "concentration": [0.3, 0.3]},
    }
    ways = ({"release": [release], "zone": [zone]}, {"release": [line]})
    _built_in_one([VALLEY | tables for tables in ways], path.parent)


def _system(path: Path) -> None:
    """Ask for a reference system by a name, as a file gives it."""
    name = path.read_bytes().decode("utf-8", "replace")
    wkt_of(name), fault_of_system(name), differ(name, "EPSG:32654")


def _shape_with(ending: str) -> Callable[[Path], None]:
    """Return a target of one file of a Shapefile, whose others are sound."""

    def meet(path: Path) -> None:
        for other in (".shp", ".shx", ".dbf", ".prj"):
            if other != ending:
                shutil.copyfile(path.with_name("sound" + other), path.with_suffix(other))
        _polygons(path.with_suffix(".shp"))

    return meet


@cache
def _schema_words() -> Words:
    """Return the names of fields, types and words of a case."""
    found: set[str] = set()

    def gather(node: Any) -> None:
        if isinstance(node, dict):
            found.update(node.get("properties", ()))
            found.update(str(word) for word in node.get("enum", ()))
            found.update([str(node["const"])] if "const" in node else ())
            for value in node.values():
                gather(value)
        elif isinstance(node, list):
            for value in node:
                gather(value)

    gather(json.loads(case_schema()))
    return tuple(word.encode() for word in sorted(found))


def targets() -> dict[str, Target]:
    """Return the targets by name; those of GDAL only where it is installed."""
    csv = (b"time", b"discharge", b"concentration", b"x", b"y", b"z", b"angle", b"\n", b",", b"#")
    curves = (b"y_over_h", b"u_over_us", b"time", b"front", b".low", b".high", b"\n", b",", b"nan")
    hazard = (b"any", b"class", b"limit", b"of", b"at", b"is", b"peak_depth", b"peak_speed", b">=")
    head = (b"ncols", b"nrows", b"xllcorner", b"yllcenter", b"cellsize", b"NODATA_value", b"-9999")
    solid = (
        b"facet normal",
        b"vertex",
        b"endsolid",
        b"outer loop",
        b"f 1 2 3",
        b"v 0 0 0",
        b"usemtl",
    )
    ply = (b"element vertex", b"element face", b"property list uchar int vertex_indices", b"double")
    json_words = (b'"type"', b'"Polygon"', b'"coordinates"', b'"crs"', b'"geometries"', b"null")
    systems = (
        b"PROJCS[",
        b"GEOGCS[",
        b"UNIT[",
        b"EPSG:",
        b"+proj=utm",
        b"VERT_CS[",
        b"urn:ogc:def",
    )
    found = {
        "case": Target("input.toml", _case, mutated_case, _schema_words()),
        "override": Target("input.txt", _override, mutated, _schema_words()),
        "hydrograph": Target("input.csv", _hydrograph, mutated, csv),
        "motion": Target("input.csv", _motion, mutated, csv),
        "reference": Target("input.csv", _reference, mutated, curves),
        "classes": Target("input.toml", _classes, mutated_case, hazard),
        "stl": Target("input.stl", _mesh, mutated, solid),
        "obj": Target("input.obj", _mesh, mutated, solid),
        "ply": Target("input.ply", _mesh, mutated, ply),
        "asc": Target("input.asc", _dem, mutated, head),
        "release": Target("input.asc", _release_raster, mutated, head),
        "geojson": Target("input.geojson", _polygons, mutated, json_words),
    }
    if find_spec("rasterio") and find_spec("pyogrio"):
        found |= {
            "prj": Target("plane2.prj", _prj, mutated, systems),
            "system": Target("input.txt", _system, mutated, systems),
            "tif": Target("input.tif", _dem, mutated, ()),
            "gpkg": Target("input.gpkg", _polygons, mutated, ()),
            "shp": Target("input.shp", _shape_with(".shp"), mutated, ()),
            "shx": Target("input.shx", _shape_with(".shx"), mutated, ()),
            "dbf": Target("input.dbf", _shape_with(".dbf"), mutated, ()),
        }
    return found


def furnish(folder: Path) -> dict[str, list[bytes]]:
    """Put into a folder what the targets name beside their input; return samples for each.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    dict of str to list of bytes
        By the name of the target; there are samples for all that are installed.
    """
    for file in BAD_CASES.iterdir():
        if file.suffix not in (".toml", ".txt"):
            shutil.copyfile(file, folder / file.name)
    shutil.copytree(ROOT / "cases" / "data", folder / "data", dirs_exist_ok=True)
    plane = _plane()
    write_raster(folder / "plane.asc", plane)
    release = Raster(plane.grid, np.where(np.abs(plane.values - 90.0) < 5.0, 1.0, 0.0))
    write_raster(folder / "masses.asc", release)
    for name, tables in (
        ("tank", TANK | {"fill": [WATER]}),
        ("valley", VALLEY | {"release": [RELEASE]}),
    ):
        (folder / f"{name}.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
    for kind in ("stl", "obj", "ply"):
        _write_tetrahedron(folder / f"solid.{kind}")
    write_polygons(folder / "square.geojson", [SQUARE], {"name": ["a"]})
    samples: dict[str, list[bytes]] = {
        "case": [path.read_bytes() for path in _cases()],
        "override": [b"time.end=2", b"fill.0.x=[0, 1]\ngravity.slope=5", b"probe.a.x=1\nfill=[]"],
        "hydrograph": [
            b"time,discharge,concentration\n0,0.1,0.2\n5,0,0.2\n",
            *_all(BAD_CASES, "*.csv"),
        ],
        "motion": [b"time,x\n0,0\n1,0.1\n2,0.2\n", *_all(BAD_CASES, "*.csv")],
        "reference": [
            b"time,front\n0,0.1\n1,0.2\n",
            b"# a band\ny_over_h,u,u.low,u.high\n0,0,0,0\n1,1,0.9,nan\n",
        ],
        "classes": _all(SHIPPED, "*.toml"),
        "stl": [*_all(folder, "*.stl"), _text_stl()],
        "obj": _all(folder, "*.obj"),
        "ply": [*_all(folder, "*.ply"), _text_ply()],
        "asc": [*_all(folder, "plane.asc"), *_all(BAD_CASES, "*.asc")],
        "release": _all(folder, "masses.asc"),
        "geojson": _all(folder, "*.geojson"),
    }
    if find_spec("rasterio") and find_spec("pyogrio"):
        samples |= _samples_of_gdal(folder, plane)
    return samples


def _cases() -> list[Path]:
    small = [p for p in sorted((ROOT / "cases").glob("*.toml")) if p.stat().st_size < 6000]
    return [*small, *sorted(BAD_CASES.glob("*.toml"))[::8]]


def _all(folder: Path, pattern: str) -> list[bytes]:
    return [
        path.read_bytes() for path in sorted(folder.glob(pattern)) if path.stat().st_size < 9000
    ]


def _plane() -> Raster:
    rows, columns = 12, 12
    levels = 100.0 - 2.0 * np.arange(columns) + np.zeros((rows, columns))
    return Raster(MapGrid(0.0, 0.0, 10.0, columns, rows), levels)


def _write_tetrahedron(path: Path) -> None:
    import meshio

    points = 0.5 * np.vstack([np.zeros(3), np.eye(3)])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    binary = {} if path.suffix == ".obj" else {"binary": True}
    meshio.write(path, meshio.Mesh(points, [("triangle", faces)]), **binary)


def _text_stl() -> bytes:
    facet = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"
    vertices = "".join(f"vertex {k} {k % 2} 0.5\n" for k in range(3))
    return f"solid a\n{facet.format(vertices)}endsolid a\n".encode()


def _text_ply() -> bytes:
    head = "ply\nformat ascii 1.0\nelement vertex 3\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    return (head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").encode()


def _samples_of_gdal(folder: Path, plane: Raster) -> dict[str, list[bytes]]:
    import pyogrio.raw
    import rasterio

    wkt = rasterio.crs.CRS.from_epsg(32654).to_wkt()
    write_raster(folder / "plane.tif", Raster(plane.grid._replace(crs=wkt), plane.values))
    write_polygons(folder / "square.gpkg", [SQUARE], {}, wkt)
    pyogrio.raw.write(
        folder / "sound.shp",
        np.array(shapely.to_wkb([SQUARE]), dtype=object),
        [np.array([1])],
        ["number"],
        driver="ESRI Shapefile",
        geometry_type="Polygon",
        crs=wkt,
    )
    names = [wkt, "EPSG:32654", "urn:ogc:def:crs:EPSG::6676", "+proj=utm +zone=54", "ESRI:102761"]
    return {
        "prj": [name.encode() for name in names],
        "system": [name.encode() for name in names],
        "tif": _all(folder, "plane.tif"),
        "gpkg": [(folder / "square.gpkg").read_bytes()],
        **{ending: [(folder / f"sound.{ending}").read_bytes()] for ending in ("shp", "shx", "dbf")},
    }
