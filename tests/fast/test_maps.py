"""Maps: what stands where, what is not shown, and in which language."""

import re
import zlib
from base64 import b64decode
from importlib.resources import files

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.image import imread

from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results import fonts, open_run
from debrisflow.results.hazard_classes import read_classes, shipped
from debrisflow.results.maps import draw_maps, pictures
from debrisflow.results.maps.layers import Layer, Layers
from debrisflow.results.maps.looks import DEPTH, LOOKS, scale_of
from debrisflow.results.maps.places import places
from debrisflow.results.maps.sheet import OPAQUE, Ground, Text, draw_map, styled
from debrisflow.results.maps.structures import structures
from debrisflow.results.maps.web import packed, page_words, web_map
from debrisflow.results.terrain_answers import PEAKS, PLACE_WORDS
from debrisflow.results.terrain_report import class_areas
from debrisflow.results.words import Words, _table
from debrisflow.run.folder import RunFolder
from tests.building import tank3d_case
from tests.fan import GRID, TIMES, fan_case, write_classes, write_frames, write_layers


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return a run that holds a case and the layers of a flow onto a fan."""
    folder = tmp_path_factory.mktemp("maps") / "fan"
    probe = {"name": "gate", "type": "point", "x": 0.5, "y": 0.25, "z": 0.1, "interval": 0.1}
    case = tank3d_case(probe=[probe]).model_copy(update={"title": "Fan, 扇状地"})
    with RunFolder.create(folder, case):
        pass
    probes = "time,vx,vy,vz,pressure,concentration\n0,1,0,0,5,0.2\n0.1,2,0,0,nan,0.2\n"
    (folder / "probes" / "gate.csv").write_text(probes)
    write_layers(folder)
    write_frames(folder)
    write_classes(folder)
    return open_run(folder)


def without_font(monkeypatch):
    for module in (fonts, pictures):
        monkeypatch.setattr(module, "japanese_font", lambda: None)


def test_a_sheet_a_layer_of_the_size_that_was_asked_for(run):
    written, _ = draw_maps(run, Words(), ("peak_depth", "arrival"), 60)
    assert [file.name for file in written] == ["peak_depth.png", "arrival.png"]
    coarse_size = np.array(imread(written[0]).shape[:2])
    fine, _ = draw_maps(run, Words(), ("peak_depth",), 120)
    assert imread(fine[0]).shape[:2] == pytest.approx(2 * coarse_size, abs=2)


def test_a_cell_has_the_color_of_its_class_where_it_lies_on_the_map():
    """And one below the threshold shows the terrain."""
    grid = MapGrid(1000.0, 5000.0, 10.0, 20, 30)
    level, depth = np.full(grid.shape, 7.0), np.full(grid.shape, np.nan)
    depth[4, 15] = 3.0
    layer = layer_of(depth)
    with styled(Words()):
        figure = draw_map(Ground(Raster(grid, level), None), layer, Text("", "", ()), Words())
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    image = np.asarray(canvas.buffer_rgba())[::-1, :, :3] / 255.0

    def at(east, north):
        column, row = figure.axes[0].transData.transform((east, north))
        return image[int(row), int(column)]

    flat = at(1057.0, 5153.0)
    assert flat[0] == flat[1] == flat[2]  # gray
    # row 4 from the north, column 15 from the west
    expected = OPAQUE * np.array(to_rgb("#423f85")) + (1.0 - OPAQUE) * flat
    assert at(1155.0, 5255.0) == pytest.approx(expected, abs=0.03)
    assert at(1155.0, 5045.0) == pytest.approx(flat, abs=0.03)


def layer_of(values):
    look = LOOKS["peak_depth"]
    return Layer("peak_depth", look, values, scale_of(look, values, 0.05))


def test_the_part_that_is_shown_holds_the_flow_and_the_release(run):
    layers = Layers(run)
    whole = np.loadtxt(run.folder / "layers" / "peak_depth.asc", skiprows=6)
    shown = layers.layer("peak_depth").values
    assert np.sum(whole >= 0.05) == np.isfinite(shown).sum()
    assert np.nanmin(shown) >= 0.05
    assert shown.size < whole.size
    grid = layers.terrain.grid
    assert 0.5 <= grid.rows / grid.columns <= 1.5
    assert np.isfinite(layers.release).sum() > 50


def test_blocks_of_cells_keep_the_greatest_depth_and_the_first_arrival(run):
    fine, coarse = Layers(run), Layers(run, most_cells=1000)
    assert coarse.terrain.values.size <= 1000
    for name, best in (("peak_depth", np.nanmax), ("arrival", np.nanmin)):
        assert best(coarse.layer(name).values) == best(fine.layer(name).values)
    assert coarse.terrain.grid.north == fine.terrain.grid.north


def test_layers_of_another_grid_are_refused(run, tmp_path):
    folder = tmp_path / "run"
    with RunFolder.create(folder, tank3d_case()):
        pass
    write_layers(folder)
    other = Raster(GRID._replace(west=0.0), np.ones(GRID.shape))
    write_raster(folder / "layers" / "deposit.asc", other)
    with pytest.raises(OutputError, match="'deposit' is not on the grid of the terrain"):
        Layers(open_run(folder)).layer("deposit")


def test_what_is_not_there_is_said(run, tmp_path):
    told = CliRunner().invoke(main, ["maps", str(run.folder), "--layers", "peak_deth"])
    assert told.exit_code == 3
    assert "no layer 'peak_deth' to show; there are: peak_depth, peak_speed," in told.output

    with RunFolder.create(tmp_path / "tank", tank3d_case()):
        pass
    told = CliRunner().invoke(main, ["maps", str(tmp_path / "tank")])
    assert told.exit_code == 3
    assert "has no layers to draw" in told.output


def test_a_map_of_classes_names_them_and_their_source(run):
    layer = Layers(run).layer("class_japan")
    assert layer.scale.names == ("reached", "special", "special, marked")
    assert np.nanmax(layer.values) == 3
    assert "Enforcement Order" in layer.source
    written, _ = draw_maps(run, Words(), ("class_japan",), 60)
    assert written[0].name == "class_japan.png"


def test_a_structure_stands_where_it_is_on_the_map(tmp_path):
    corner = np.array([GRID.west + 190.0, GRID.south + 240.0])
    box = {"type": "box", "name": "dam", "z": [395.0, 412.0]}
    box |= {"x": [corner[0], corner[0] + 70.0], "y": [corner[1], corner[1] + 5.0]}
    with RunFolder.create(tmp_path / "run", fan_case(tmp_path, obstacle=[box])):
        pass
    (ring,) = structures(open_run(tmp_path / "run").case)["dam"]
    assert ring.min(axis=0) == pytest.approx(corner)
    assert ring.max(axis=0) == pytest.approx(corner + np.array([70.0, 5.0]))


class TestLanguage:
    def test_all_words_of_maps_and_page_are_known(self):
        known = _table("ja")
        told = {look.title for look in (*LOOKS.values(), DEPTH)} | set(page_words(Words()).values())
        for path in shipped().values():
            table = read_classes(path.stem)
            told |= {table.title, *(one.name for one in table.classes)}
        told |= {meaning for *_, meaning in PEAKS} | set(PLACE_WORDS.values())
        answers = files("debrisflow.results").joinpath("terrain_answers.py").read_text()
        told |= set(re.findall(r"""words\(\s*["']([^"']+)["'][,)]""", answers))
        for name in ("page.html", "report.html", "terrain.html", "measured.html", "map.html"):
            text = files("debrisflow.results").joinpath("templates", name).read_text()
            told |= set(re.findall(r"""words\(["']([^"']+)["'][,)]""", text))
        assert len(told) > 60
        assert told - set(known) == set()

    def test_what_is_filled_in_is_the_same_in_both(self):
        for english, japanese in _table("ja").items():
            assert set(re.findall(r"{\w+}", english)) == set(re.findall(r"{\w+}", japanese))

    def test_without_a_font_the_labels_are_english_and_it_is_said(self, run, monkeypatch):
        without_font(monkeypatch)
        told = CliRunner().invoke(
            main,
            ["maps", str(run.folder), "--language", "ja", "--layers", "deposit", "--dpi", "60"],
        )
        assert told.exit_code == 0, told.output
        assert "fonts-noto-cjk" in told.output
        layers = Layers(run)
        text = pictures.text_of(run, layers, layers.layer("deposit"), Words())
        assert text.subtitle == "fan"  # since the title could not be written

    # fonts belong to the system: .ci/run installs one; what is drawn without one is tested above
    @pytest.mark.skipif(fonts.japanese_font() is None, reason="no Japanese font is installed")
    def test_with_a_font_they_are_japanese(self, run):
        written, messages = draw_maps(run, Words("ja"), ("deposit",), 60)
        assert written[0].is_file()
        assert not messages


def test_the_areas_of_classes_are_those_of_their_cells(run):
    (worst, *_) = class_areas(run, "class_japan").areas
    assert worst.name == "special, marked"
    assert worst.area == 25.0 * np.sum(Layers(run).layer("class_japan").values == 3)


class TestPage:
    def test_numbers_come_back_to_within_a_step(self):
        values = np.random.default_rng(2).uniform(-3.0, 900.0, (7, 5))
        values[2, 3] = np.nan
        found = packed(values)
        numbers = np.frombuffer(zlib.decompress(b64decode(found["values"])), "<u2").reshape(7, 5)
        back = np.where(numbers == 0, np.nan, found["low"] + found["step"] * (numbers - 1.0))
        assert back == pytest.approx(values, abs=found["step"], nan_ok=True)

    def test_it_holds_layers_frames_and_probes(self, run):
        found = web_map(run, Words("ja"))
        assert [one["name"] for one in found["layers"]] == [*LOOKS, "class_japan"]
        assert found["layers"][-1]["names"][0] == "到達範囲"
        assert found["layers"][-1]["colors"][0] == "#fee08b"
        assert found["frames"]["times"] == list(TIMES)
        assert found["layers"][0]["title"] == "最大流動深"
        (place,) = found["places"]
        assert place["name"] == "gate"
        pressure = next(one for one in place["curves"] if one["title"] == "圧力")
        assert pressure["values"] == [5.0, None]
        assert pressure["unit"] == "Pa"

    def test_a_probe_stands_where_it_is_on_the_map(self, run):
        grid = MapGrid(-10.0, -20.0, 0.5, 100, 100)
        (place,) = places(run, grid, Words())
        assert place["line"] == [[21.0, 59.5]]  # x = 0.5, y = 0.25 from the origin (0, 0)
