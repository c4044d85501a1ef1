"""Scores against observed events, by examples made by hand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
import shapely
from click.testing import CliRunner
from PIL import Image

from debrisflow.case import ResolvedCase, build_case, dump_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.vectors import write_polygons
from debrisflow.cli import main
from debrisflow.errors import CaseError
from debrisflow.results import open_run
from debrisflow.results.flow_path import flow_path
from debrisflow.results.score import (
    Contingency,
    compare_with_observed,
    contingency,
    on_grid,
)

UTM = rasterio.crs.CRS.from_epsg(32610).to_wkt()
GRID = MapGrid(1000.0, 2000.0, 10.0, 3, 3, UTM)
AROUND = MapGrid(960.0, 1960.0, 10.0, 11, 11, UTM)
NAN = np.nan
TERRAIN = [[30.0, 29.0, 30.0], [20.0, 19.0, 20.0], [10.0, 9.0, 10.0]]
DEPTH = [[NAN, 2.0, NAN], [NAN, 1.0, 0.5], [NAN, NAN, 0.2]]
DEPOSIT = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, 0.0, 0.2]]
CHANGE = [[0.0, -2.0, 0.0], [0.2, 1.5, 0.0], [0.0, 0.5, NAN]]


def case_of(folder: Path, around: MapGrid = AROUND, **tables: Any) -> ResolvedCase:
    """Return a case with a release on the middle cell of the northernmost row."""
    write_raster(folder / "dem.tif", Raster(around, np.zeros(around.shape) + 30.0))
    corners = [(1010.0, 2020.0), (1020.0, 2020.0), (1020.0, 2030.0), (1010.0, 2030.0)]
    return build_case(
        {
            "title": "an event",
            "particles": {"spacing": 1.0},
            "geometry": {"type": "terrain", "dem": "dem.tif"},
            "release": [{"type": "polygon", "corners": corners, "depth": 2.0}],
            "time": {"end": 10.0},
            "output": {"interval": 1.0},
        }
        | tables,
        folder=folder,
    )


@pytest.fixture
def run(tmp_path: Path) -> Path:
    layers = {"terrain": TERRAIN, "peak_depth": DEPTH, "deposit": DEPOSIT}
    (tmp_path / "run" / "layers").mkdir(parents=True)
    (tmp_path / "run" / "case.toml").write_text(dump_case(case_of(tmp_path)))
    for name, values in layers.items():
        raster = Raster(GRID, np.array(values))
        write_raster(tmp_path / "run" / "layers" / f"{name}.tif", raster)
    return tmp_path / "run"


def figures(run: Path, file: Path, threshold: float | None = None) -> dict[str, float]:
    return {row.measure: row.value for row in compare_with_observed(run, file, threshold).rows}


def test_cells_are_counted_where_they_are_compared() -> None:
    observed = np.array([[1, 1, 0], [0, 1, 0], [0, 0, 1]], dtype=bool)
    simulated = np.array([[1, 0, 0], [1, 1, 0], [0, 0, 1]], dtype=bool)
    compared = np.ones((3, 3), dtype=bool)
    compared[2, 2] = False
    assert contingency(observed, simulated, compared) == (2, 1, 1, 4)


def test_scores_of_a_table_by_hand() -> None:
    cells = Contingency(2, 1, 1, 4)
    assert cells.csi == 0.5
    assert cells.hss == pytest.approx(2 * (2 * 4 - 1 * 1) / (3 * 5 + 3 * 5))
    assert cells.d2pc == pytest.approx(math.hypot(1 / 3, 1 / 5))
    assert cells.foc == 1.0
    perfect, none = Contingency(3, 0, 0, 6), Contingency(0, 3, 0, 6)
    assert (perfect.csi, perfect.hss, perfect.d2pc, perfect.foc) == (1.0, 1.0, 0.0, 1.0)
    assert (none.csi, none.hss, none.d2pc, none.foc) == (0.0, 0.0, 1.0, 0.0)


def test_an_extent_is_compared_by_the_middles_of_cells(run: Path, tmp_path: Path) -> None:
    file = tmp_path / "extent.geojson"
    # the middle column, from the north to the middle of the southernmost cell and beyond
    write_polygons(file, [shapely.box(1011.0, 2004.0, 1019.0, 2030.0)], crs=UTM)
    found = figures(run, file)
    expected = {
        "hits": 2,
        "misses": 1,
        "false_alarms": 2,
        "correct_rejections": 4,
        "observed_area": 300.0,
        "simulated_area": 400.0,
        "csi": 0.4,
        "foc": 4 / 3,
        "runout_observed": 20.0,
        "runout_simulated": 20.0,
        "runout_error": 0.0,
        "reach_observed": 20.0,
        "reach_simulated": math.hypot(10.0, 20.0),
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert "deposit_rms" not in found
    assert figures(run, file, 0.7)["hits"] == 2
    assert figures(run, file, 0.7)["false_alarms"] == 0


def test_a_change_of_elevation_is_compared_with_the_deposit(run: Path, tmp_path: Path) -> None:
    file = tmp_path / "dod.asc"
    write_raster(file, Raster(GRID, np.array(CHANGE)))
    found = figures(run, file)
    expected = {
        "threshold": 0.3,
        "threshold_change": 0.3,
        "hits": 2,
        "misses": 1,
        "false_alarms": 1,
        "correct_rejections": 5,
        "false_alarms_no_data": 0,  # 0.2 m is below the threshold
        "runout_observed": 20.0,
        "runout_simulated": 10.0,
        "runout_difference": -10.0,
        "runout_error": -50.0,
        "deposit_csi": 1 / 3,
        "deposit_volume_observed": 200.0,
        "deposit_volume_simulated": 150.0,
        "deposit_volume_error": -25.0,
        "deposit_rms": 0.5,
        "eroded_volume_observed": 200.0,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert figures(run, file, 0.1)["false_alarms_no_data"] == 1


def test_a_flow_that_has_not_come_to_rest_has_no_deposit(run: Path, tmp_path: Path) -> None:
    write_raster(run / "layers" / "deposit.tif", Raster(GRID, np.full((3, 3), NAN)))
    file = tmp_path / "dod.tif"
    write_raster(file, Raster(GRID, np.array(CHANGE)))
    found = figures(run, file)
    assert found["deposit_volume_simulated"] == 0.0
    assert found["deposit_rms"] == pytest.approx(math.sqrt((1.5**2 + 0.5**2) / 2))


def test_a_finer_survey_is_averaged_and_a_coarser_one_sampled() -> None:
    fine = Raster(MapGrid(1000.0, 2000.0, 5.0, 6, 6), np.arange(36.0).reshape(6, 6))
    np.testing.assert_allclose(on_grid(fine, GRID)[0], [3.5, 5.5, 7.5])
    assert on_grid(fine, GRID).mean() == pytest.approx(fine.values.mean())
    coarse = Raster(MapGrid(1000.0, 2000.0, 30.0, 1, 1), np.array([[4.0]]))
    np.testing.assert_array_equal(on_grid(coarse, GRID), np.full((3, 3), 4.0))


def test_the_depth_that_decides_is_told(run: Path, tmp_path: Path) -> None:
    file, dod = tmp_path / "extent.geojson", tmp_path / "dod.asc"
    write_polygons(file, [shapely.box(1011.0, 2004.0, 1019.0, 2030.0)], crs=UTM)
    write_raster(dod, Raster(GRID, np.array(CHANGE)))
    least = open_run(run).case.output.layer_depth
    assert figures(run, file)["threshold"] == least > 0.0
    assert figures(run, file, 0.7)["threshold"] == 0.7
    assert "threshold_change" not in figures(run, file)
    told = figures(run, dod, 0.5 * least)
    assert (told["threshold"], told["threshold_change"]) == (least, 0.5 * least)


def test_the_path_leaves_a_hollow_by_its_outlet() -> None:
    level = np.full((5, 7), 9.0)
    level[2, 1:] = [5.0, 2.0, 4.0, 3.0, 2.5, 1.0]
    path = flow_path(Raster(MapGrid(0.0, 0.0, 1.0, 7, 5), level), 1.5, 2.5)
    assert path.coords[0] == (1.5, 2.5)
    assert path.coords[-1] == (6.5, 2.5)
    assert path.length == 5.0


def test_the_run_out_starts_in_the_middle_of_the_first_release(run: Path, tmp_path: Path) -> None:
    line = [(1010.0, 2005.0), (1020.0, 2005.0)]
    graph = {"time": [0.0, 5.0], "discharge": [20.0, 20.0], "concentration": [0.0, 0.0]}
    flood = {"type": "hydrograph", "line": line, "hydrograph": graph, "velocity": 1.0}
    flood |= {"direction": 180.0, "start": 0.0}
    mass = {"type": "polygon", "corners": [(990.0, 2000.0), (1000.0, 2000.0), (1000.0, 2010.0)]}
    case = case_of(tmp_path, release=[mass | {"depth": 2.0, "start": 1.0}, flood])
    (run / "case.toml").write_text(dump_case(case))
    file = tmp_path / "extent.geojson"
    write_polygons(file, [shapely.box(1011.0, 2001.0, 1019.0, 2009.0)], crs=UTM)
    assert compare_with_observed(run, file).path.coords[0] == (1015.0, 2005.0)


def test_run_out_follows_a_bend(tmp_path: Path) -> None:
    # a channel of one cell down to the south and then to the east, 100 m each
    grid = MapGrid(0.0, 0.0, 10.0, 13, 13)
    level = np.full((13, 13), 99.0)
    level[1:12, 1] = np.arange(40.0, 29.0, -1.0)
    level[11, 1:] = np.arange(30.0, 18.0, -1.0)
    depth = np.zeros((13, 13))
    depth[1, 1] = depth[11, 6] = 1.0
    folder = tmp_path / "run" / "layers"
    folder.mkdir(parents=True)
    for name, values in {"terrain": level, "peak_depth": depth}.items():
        write_raster(folder / f"{name}.asc", Raster(grid, values))
    corners = [(10.0, 110.0), (20.0, 110.0), (20.0, 120.0), (10.0, 120.0)]
    scar = [{"type": "polygon", "corners": corners, "depth": 1.0}]
    case = case_of(tmp_path, MapGrid(-20.0, 0.0, 10.0, 15, 15), release=scar)
    (tmp_path / "run" / "case.toml").write_text(dump_case(case))
    file = tmp_path / "extent.geojson"
    write_polygons(file, [shapely.box(110.0, 10.0, 120.0, 20.0)])
    found = figures(tmp_path / "run", file)
    assert found["runout_observed"] == pytest.approx(200.0, abs=12.0)
    assert found["runout_simulated"] == pytest.approx(150.0, abs=12.0)
    assert found["reach_observed"] == pytest.approx(100.0 * math.sqrt(2.0))


def test_the_command_writes_a_table_and_a_map(run: Path, tmp_path: Path) -> None:
    file = tmp_path / "dod.tif"
    write_raster(file, Raster(GRID, np.array(CHANGE)))
    result = CliRunner().invoke(main, ["score", str(run), "--observed", str(file)])
    assert result.exit_code == 0, result.output
    assert "csi                            0.5" in result.stdout
    table = (run / "postprocess" / "score.csv").read_text().splitlines()
    assert "csi,0.5,,critical success index; 1 is perfect" in table
    with Image.open(run / "postprocess" / "score.png") as picture:
        assert min(picture.size) > 500


@pytest.mark.parametrize(
    ("name", "box", "crs", "told"),
    [
        (
            "far.geojson",
            (0.0, 0.0, 10.0, 10.0),
            UTM,
            "nothing of what was observed lies on the map",
        ),
        (
            "other.geojson",
            (1000.0, 2000.0, 1020.0, 2020.0),
            "EPSG:32611",
            "is in another coordinat",
        ),
        ("none.gpkg", None, "", "none.gpkg cannot be read: no such file"),
        ("none.tif", None, "", "none.tif cannot be read: no such file"),
    ],
)
def test_what_fits_no_map_is_refused_in_words(
    run: Path, tmp_path: Path, name: str, box: tuple[float, ...] | None, crs: str, told: str
) -> None:
    if box is not None:
        write_polygons(tmp_path / name, [shapely.box(*box)], crs=crs)
    with pytest.raises(CaseError) as error:
        compare_with_observed(run, tmp_path / name)
    assert told in str(error.value)
