"""Polygons and lines on a map: what is written is read back; wrong ones are refused in words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import pyogrio.raw
import pytest
import rasterio
import shapely

from debrisflow.case.reference_systems import differ
from debrisflow.case.vectors import (
    UnreadableVectorsError,
    look_like_degrees,
    read_lines,
    read_polygons,
    write_polygons,
)

UTM = rasterio.crs.CRS.from_epsg(32610).to_wkt()
WEST, SOUTH = 562_000.0, 5_118_000.0
HOLED = shapely.box(WEST, SOUTH, WEST + 90.0, SOUTH + 60.0).difference(
    shapely.box(WEST + 10.0, SOUTH + 10.0, WEST + 20.0, SOUTH + 20.0)
)
APART = shapely.MultiPolygon(
    [shapely.box(WEST + k, SOUTH, WEST + k + 5.0, SOUTH + 5.0) for k in (100.0, 120.0)]
)


def geojson(path: Path, *geometries: Any, **members: Any) -> Path:
    features = [{"type": "Feature", "properties": {}, "geometry": part} for part in geometries]
    data = {"type": "FeatureCollection", "features": features} | members
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


@pytest.mark.parametrize("ending", ["geojson", "gpkg"])
def test_polygons_are_read_as_they_were_written(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"extent.{ending}"
    columns = {"depth": np.array([0.5, np.nan]), "name": ["one", "two"]}
    for _ in range(2):  # over the one that is there
        write_polygons(path, [HOLED, APART], columns, UTM)
    found = read_polygons(path)
    assert len(found.shapes) == 3
    expected = shapely.union_all([HOLED, APART])
    assert shapely.union_all(found.shapes).symmetric_difference(expected).area == 0.0
    assert rasterio.crs.CRS.from_wkt(found.crs) == rasterio.crs.CRS.from_epsg(32610)


@pytest.mark.parametrize("ending", ["geojson", "gpkg"])
def test_gdal_reads_attributes_and_system(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"extent.{ending}"
    write_polygons(path, [HOLED, APART], {"depth": [0.5, 1.5], "name": ["one", "two"]}, UTM)
    meta, _, _, columns = pyogrio.raw.read(path)
    assert meta["crs"] == "EPSG:32610"
    assert dict(zip(meta["fields"], map(list, columns), strict=True)) == {
        "depth": [0.5, 1.5],
        "name": ["one", "two"],
    }


def test_a_shapefile_is_read(tmp_path: Path) -> None:
    path = tmp_path / "release.shp"
    shapes = np.array(shapely.to_wkb([HOLED]), dtype=object)
    pyogrio.raw.write(
        path, shapes, [np.array([1.5])], ["depth"], geometry_type="Polygon", crs="EPSG:32610"
    )
    found = read_polygons(path)
    assert [shape.area for shape in found.shapes] == [HOLED.area]
    assert not differ(found.crs, UTM)
    assert differ(found.crs, "EPSG:32611")


def test_the_vertical_part_of_a_system_makes_no_other_one() -> None:
    assert not differ("EPSG:6676+6695", "EPSG:6676")
    assert not differ("EPSG:6676", rasterio.crs.CRS.from_user_input("EPSG:6676+6695").to_wkt())
    assert differ("EPSG:6676+6695", "EPSG:6677")


def test_a_file_without_a_system_tells_none(tmp_path: Path) -> None:
    for ending in ("geojson", "gpkg"):
        write_polygons(tmp_path / f"a.{ending}", [HOLED])
        assert read_polygons(tmp_path / f"a.{ending}").crs == ""


def test_lines_are_taken_apart_and_lose_their_levels(tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": [[0.0, 0.0, 5.0], [10.0, 0.0, 6.0]]}
    lines = {"type": "MultiLineString", "coordinates": [[[0, 1], [1, 1]], [[2, 2], [3, 3]]]}
    found = read_lines(geojson(tmp_path / "a.geojson", line, lines, None))
    assert [list(shape.coords) for shape in found.shapes] == [
        [(0.0, 0.0), (10.0, 0.0)],
        [(0.0, 1.0), (1.0, 1.0)],
        [(2.0, 2.0), (3.0, 3.0)],
    ]


def test_a_file_that_changed_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "a.geojson"
    write_polygons(path, [HOLED])
    assert len(read_polygons(path).shapes) == 1
    write_polygons(path, [APART])
    assert len(read_polygons(path).shapes) == 2


def test_geojson_needs_neither_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyogrio", "rasterio", "rasterio.crs"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    path = tmp_path / "a.geojson"
    write_polygons(path, [HOLED], crs="EPSG:32610")
    assert read_polygons(path).crs == "EPSG:32610"
    with pytest.raises(UnreadableVectorsError, match="pip install rasterio pyogrio"):
        write_polygons(tmp_path / "a.gpkg", [HOLED])


SQUARE = shapely.geometry.mapping(HOLED)
CROSSED = {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]}
LONGITUDES = {"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}}
FEET = {"crs": {"type": "name", "properties": {"name": "EPSG:2286"}}}


@pytest.mark.parametrize(
    ("geometries", "members", "words"),
    [
        ([], {}, "holds no polygons"),
        ([{"type": "Point", "coordinates": [0, 0]}], {}, "holds a Point where polygons are wanted"),
        ([CROSSED], {}, "has a polygon that crosses or touches itself: Self-intersection"),
        ([{"type": "Polygon", "coordinates": [[[0, 0], [1]]]}], {}, "is not GeoJSON: "),
        ([{"type": "Polygon"}], {}, "is not GeoJSON: lacks 'coordinates'"),
        ([{"type": "Polygons", "coordinates": []}], {}, "is not GeoJSON: "),
        ([SQUARE], LONGITUDES, "has geographic coordinates"),
        ([SQUARE], FEET, "has coordinates in US survey foot; project it to that of the DEM"),
    ],
)
def test_wrong_polygons_are_refused(
    tmp_path: Path, geometries: list[Any], members: dict[str, Any], words: str
) -> None:
    path = geojson(tmp_path / "a.geojson", *geometries, **members)
    with pytest.raises(UnreadableVectorsError) as caught:
        read_polygons(path)
    assert str(caught.value).startswith(words)


def test_wrong_files_are_refused(tmp_path: Path) -> None:
    def refused(name: str, content: str | None = None) -> str:
        path = tmp_path / name
        if content is not None:
            path.write_text(content, encoding="utf-8")
        with pytest.raises(UnreadableVectorsError) as caught:
            read_polygons(path)
        return str(caught.value)

    assert refused("none.geojson") == "cannot be read: no such file or directory"
    assert refused("a.geojson", "{").startswith("is not GeoJSON: Expecting")
    assert refused("b.geojson", "[1]").startswith("is not GeoJSON: ")
    assert refused("c.gpkg", "words").startswith("cannot be read as polygons or lines: ")


def test_several_layers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.gpkg"
    for k, name in enumerate(("old", "new")):
        pyogrio.raw.write(
            path,
            np.array(shapely.to_wkb([HOLED]), dtype=object),
            [],
            [],
            driver="GPKG",
            layer=name,
            geometry_type="Polygon",
            crs="EPSG:32610",
            append=k > 0,
        )
    with pytest.raises(UnreadableVectorsError, match="has 2 layers \\(old, new\\)"):
        read_polygons(path)


def test_geographic_geopackages_are_refused(tmp_path: Path) -> None:
    write_polygons(tmp_path / "a.gpkg", [shapely.box(-122.2, 46.2, -122.1, 46.3)], crs="EPSG:4269")
    with pytest.raises(UnreadableVectorsError, match="geographic coordinates \\(EPSG:4269"):
        read_polygons(tmp_path / "a.gpkg")


def test_degrees_are_told_by_their_size() -> None:
    assert look_like_degrees(shapely.box(138.9, 35.1, 139.0, 35.2).bounds)
    assert not look_like_degrees(HOLED.bounds)
    assert look_like_degrees((0.0, 0.0, 50.0, 40.0))  # so is a small map
