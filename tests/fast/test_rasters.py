"""Rasters on a map: what is written is read back; wrong ones are refused in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.transform import Affine

from debrisflow.case.rasters import (
    MapGrid,
    Raster,
    UnreadableRasterError,
    raster_of_plan,
    read_raster,
    write_raster,
)

UTM = rasterio.crs.CRS.from_epsg(32610).to_wkt()
GRID = MapGrid(500_000.25, 5_100_000.5, 2.5, 4, 3, UTM)


def values() -> np.ndarray:
    found = np.arange(12.0).reshape(3, 4) + 100.25
    found[0, 1] = np.nan
    return found


@pytest.mark.parametrize("ending", ["tif", "asc"])
def test_a_raster_is_read_as_it_was_written(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"dem.{ending}"
    write_raster(path, Raster(GRID, values()))
    found = read_raster(path)
    assert found.grid._replace(crs="") == GRID._replace(crs="")
    assert rasterio.crs.CRS.from_wkt(found.grid.crs) == rasterio.crs.CRS.from_epsg(32610)
    np.testing.assert_array_equal(found.values, values())


def test_a_geotiff_has_tags_and_place(tmp_path: Path) -> None:
    path = tmp_path / "depth.tif"
    write_raster(path, Raster(GRID, values()), {"unit": "m"})
    with rasterio.open(path) as file:
        assert file.transform == Affine(2.5, 0.0, GRID.west, 0.0, -2.5, GRID.north)
        assert (file.nodata, file.dtypes[0], file.tags()["unit"]) == (-9999.0, "float32", "m")
        assert file.read(1)[0, 1] == -9999.0


def test_the_plan_starts_in_the_south_west() -> None:
    raster = Raster(GRID, values())
    assert raster.plan[0, 0] == raster.values[-1, 0]
    np.testing.assert_array_equal(raster_of_plan(GRID, raster.plan).values, raster.values)


def test_a_crop_keeps_the_places_of_cells() -> None:
    raster = Raster(GRID, values())
    part = raster.cropped(GRID.west + 2.5, GRID.south, GRID.east, GRID.south + 5.0)
    assert part.grid == GRID._replace(west=GRID.west + 2.5, columns=3, rows=2)
    np.testing.assert_array_equal(part.values, values()[1:, 1:])


def test_cells_given_by_their_middles(tmp_path: Path) -> None:
    path = tmp_path / "dem.asc"
    path.write_text("NCOLS 2\nNROWS 1\nXLLCENTER 5\nYLLCENTER 15\nCELLSIZE 10\n1 -9999\n")
    found = read_raster(path)
    assert found.grid == MapGrid(0.0, 10.0, 10.0, 2, 1)
    np.testing.assert_array_equal(found.values, [[1.0, np.nan]])


HEAD = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + "1 2\n3\n", "holds 3 values where 2 columns by 2 rows make 4"),
        (HEAD + "1 2\n3 x\n", "holds what is no number"),
        (HEAD + "-9999 -9999\n-9999 nan\n", "holds no value"),
        (HEAD.replace("ncols 2\n", "") + "1 2\n", "its head lacks ncols"),
        (HEAD.replace("cellsize 1", "cellsize -1") + "1 2 3 4", "not positive"),
        (HEAD.replace("ncols 2", "ncols 2e9") + "1 2 3 4", "more than 4e+08"),
        (HEAD.replace("nrows 2", "nrows 1.5") + "1 2 3", "not whole"),
        (HEAD.replace("nrows 2", "nrows two") + "1 2 3 4", "nrows = two, which is no number"),
        ("", "its head lacks"),
        ("\N{DEGREE SIGN}", "not plain text"),
    ],
)
def test_wrong_ascii_grids_are_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "dem.asc"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UnreadableRasterError, match=words.replace("+", r"\+")):
        read_raster(path)


@pytest.mark.parametrize(
    ("crs", "transform", "words"),
    [
        ("26910+6360", Affine(1.0, 0.0, 5.0, 0.0, -1.0, 0.0), "heights in US survey foot"),
        (4326, Affine(0.001, 0.0, 138.0, 0.0, -0.001, 36.0), "geographic coordinates"),
        (2225, Affine(1.0, 0.0, 6e6, 0.0, -1.0, 2e6), "coordinates in US survey foot"),
        (32610, Affine(1.0, 0.0, 5.0, 0.0, 1.0, 0.0), "south up"),
        (32610, Affine(1.0, 0.2, 0.0, 0.2, -1.0, 0.0), "is rotated"),
        (32610, Affine(1.0, 0.0, 0.0, 0.0, -2.0, 0.0), "cells of 1 by 2"),
    ],
)
def test_wrong_geotiffs_are_refused(
    tmp_path: Path, crs: int | str, transform: Affine, words: str
) -> None:
    path = tmp_path / "dem.tif"
    form = {"driver": "GTiff", "width": 2, "height": 2, "count": 1, "dtype": "float32"}
    with rasterio.open(path, "w", **form, crs=f"EPSG:{crs}", transform=transform) as file:
        file.write(np.ones((2, 2), dtype=np.float32), 1)
    with pytest.raises(UnreadableRasterError, match=words):
        read_raster(path)


def test_stored_numbers_are_scaled_as_the_band_says(tmp_path: Path) -> None:
    path = tmp_path / "decimeters.tif"
    stored = np.array([[12345, -9999], [10, -20]], dtype=np.int16)
    place = {"crs": UTM, "transform": Affine(2.5, 0.0, 0.0, 0.0, -2.5, 5.0)}
    form = {"width": 2, "height": 2, "count": 1, "dtype": "int16", "nodata": -9999}
    with rasterio.open(path, "w", driver="GTiff", **form, **place) as file:
        file.write(stored, 1)
        file.scales, file.offsets = (0.1,), (100.0,)
    found = read_raster(path).values
    np.testing.assert_allclose(found, [[1334.5, np.nan], [101.0, 98.0]])


def test_a_file_that_is_no_raster_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "dem.tif"
    path.write_bytes(b"II*\0 cut short")
    with pytest.raises(UnreadableRasterError, match="cannot be read"):
        read_raster(path)
    with pytest.raises(UnreadableRasterError, match="no such file"):
        read_raster(tmp_path / "absent.tif")
    with pytest.raises(UnreadableRasterError, match="no such file"):
        read_raster(tmp_path / "absent.asc")
