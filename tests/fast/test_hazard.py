"""Hazard classes: tables that are right and wrong, and maps checked by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyogrio
import pytest
from click.testing import CliRunner

from debrisflow.case.rasters import MapGrid, Raster, read_raster, write_raster
from debrisflow.cli import main
from debrisflow.errors import CaseError, OutputError
from debrisflow.results.hazard import hazard_map, read_class_map, write_hazard
from debrisflow.results.hazard_classes import read_classes, shipped
from debrisflow.results.layers import layer_names, read_layer

GRID = MapGrid(1000.0, 2000.0, 10.0, 3, 2)
NAN = np.nan
DEPTH = [[NAN, 0.5, 1.5], [2.5, 0.2, 1.5]]
SPEED = [[NAN, 2.0, 2.0], [0.5, 3.0, 0.2]]
PRESSURE = [[NAN, 8.0, 60.0], [0.5, 120.0, 0.1]]
WHOLE = """
title = "two"
source = "a test"
[[class]]
name = "high"
color = "#ff0000"
any = [{ peak_depth = "> 1.0", peak_speed = ">= 2" }, { peak_pressure = "> strength" }]
[[class]]
name = "low"
color = "#ffff00"
[limit.strength]
of = "peak_depth"
at = [0.0, 1.0]
is = [20.0, 0.0]
"""


def run_with(folder: Path, **layers: object) -> Path:
    (folder / "layers").mkdir(parents=True)
    for name, values in layers.items():
        raster = Raster(GRID, np.asarray(values, dtype=float))
        write_raster(folder / "layers" / f"{name}.tif", raster)
    return folder


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return run_with(tmp_path / "run", peak_depth=DEPTH, peak_speed=SPEED, peak_pressure=PRESSURE)


def test_the_swiss_classes_need_depth_and_speed(run: Path) -> None:
    found = hazard_map(run, read_classes("swiss"))
    np.testing.assert_array_equal(found.raster.values, [[NAN, 1.0, 2.0], [1.0, 1.0, 1.0]])
    assert [(a.name, a.cells, a.area, a.share) for a in found.areas] == [
        ("high", 1, 100.0, 0.2),
        ("medium", 4, 400.0, 0.8),
    ]


def test_the_japanese_classes_compare_force_with_strength(run: Path) -> None:
    # 0.5 m bears 13.8 kN/m2 and 2.5 m 4.6; 60 kN/m2 are marked over 1 m deep, 120 at any depth
    found = hazard_map(run, read_classes("japan"))
    np.testing.assert_array_equal(found.raster.values, [[NAN, 1.0, 3.0], [1.0, 3.0, 1.0]])
    strength = read_classes("japan").limits["strength"]
    depth = np.linspace(0.05, 2.8, 500)
    formula = 35.3 / (depth * (5.6 - depth))
    np.testing.assert_allclose(np.interp(depth, strength.at, strength.values), formula, rtol=0.01)


def test_limits_are_linear_between_points_and_alternatives_any(run: Path, tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(WHOLE)
    found = hazard_map(run, read_classes(str(file)))
    np.testing.assert_array_equal(found.raster.values, [[NAN, 1.0, 2.0], [2.0, 2.0, 2.0]])


def test_every_shipped_table_names_its_source() -> None:
    assert set(shipped()) == {"japan", "swiss"}
    for name in shipped():
        table = read_classes(name)
        assert len(table.source) > 100
        assert "check before use" in table.source


def test_the_command_writes_raster_style_polygons_and_table(run: Path) -> None:
    result = CliRunner().invoke(main, ["hazard", str(run), "--classes", "swiss"])
    assert result.exit_code == 0, result.output
    assert "high         2      1            100   20.0 %" in result.stdout
    assert "source: BWW, BRP and BUWAL (1997)" in result.stdout
    folder = run / "postprocess"
    assert {file.name for file in folder.iterdir()} == {
        f"class_swiss.{ending}" for ending in ("tif", "qml", "geojson", "csv")
    }
    assert read_raster(folder / "class_swiss.tif").grid == GRID
    info = pyogrio.read_info(folder / "class_swiss.geojson")
    assert (info["features"], list(info["fields"])) == (2, ["class", "number", "area_m2"])
    entries = ElementTree.parse(folder / "class_swiss.qml").getroot().iter("paletteEntry")
    assert [entry.get("label") for entry in entries] == ["high", "medium"]


def test_a_map_without_any_class_is_read_back(tmp_path: Path) -> None:
    nothing = np.full((2, 3), NAN)
    run = run_with(tmp_path, peak_depth=nothing, peak_speed=nothing, peak_pressure=nothing)
    write_hazard(run, hazard_map(run, read_classes("swiss")))
    assert np.isnan(read_class_map(run, "class_swiss").raster.values).all()


Change = Callable[[str], str]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda text: text.replace("peak_depth =", "peak_dept ="),
            "class 1 'high': unknown layer 'peak_dept'; did you mean 'peak_depth'?",
        ),
        (
            lambda text: text.replace('">= 2"', '"=> 2"'),
            "class 1 'high': peak_speed = '=> 2': '=>' must be '>', '>=', '<' or '<='",
        ),
        (
            lambda text: text.replace('">= 2"', "2"),
            "class 1 'high': peak_speed = 2 must be text like '> 1.0'",
        ),
        (
            lambda text: text.replace('"> strength"', '"> strengths"'),
            "'strengths' is neither a number nor a [limit]; did you mean 'strength'?",
        ),
        (lambda text: text.replace("#ff0000", "red"), "color = 'red' must be text like '#d7191c'"),
        (lambda text: text.replace("any =", "all ="), "class 1: unknown key 'all'"),
        (lambda text: text.replace('source = "a test"', ""), "the table: lacks 'source'"),
        (lambda text: text.replace('"low"', '"high"'), "class 2: the name 'high' is that of class"),
        (lambda text: text.replace("[0.0, 1.0]", "[1.0, 1.0]"), "limit.strength: at must increase"),
        (
            lambda text: text.replace("[0.0, 1.0]", "[0.0, 1.0, 2.0]"),
            "limit.strength: at has 3 numbers and is 2",
        ),
        (lambda text: text + "[", "is not valid TOML"),
    ],
)
def test_wrong_tables_are_refused_in_words(tmp_path: Path, change: Change, told: str) -> None:
    file = tmp_path / "two.toml"
    file.write_text(change(WHOLE))
    with pytest.raises(CaseError) as error:
        read_classes(str(file))
    assert told in str(error.value)
    assert str(file) in str(error.value)


def test_a_name_that_is_not_shipped_is_refused() -> None:
    with pytest.raises(CaseError, match=r"give 'japan' or 'swiss', or a \.toml; did you mean 'ja"):
        read_classes("japon")
    with pytest.raises(CaseError, match=r"none\.toml cannot be read: no such file"):
        read_classes("none.toml")


def test_missing_layers_are_told(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="holds no layers of a map"):
        layer_names(tmp_path)
    run = run_with(tmp_path / "run", peak_depth=DEPTH, peak_speed=SPEED)
    assert layer_names(run) == ["peak_depth", "peak_speed"]
    known = "no layer 'peak_pressure'; it has peak_depth, peak_speed"
    with pytest.raises(OutputError, match=known):
        read_layer(run, "peak_pressure")
    (run / "layers" / "peak_depth.tif").write_bytes(b"II*\0nothing")
    with pytest.raises(OutputError, match=r"peak_depth\.tif cannot be read"):
        read_layer(run, "peak_depth")
