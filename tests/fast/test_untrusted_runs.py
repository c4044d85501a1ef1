"""Run folders from people who mean harm: a clean error or an answer, and nothing else happens."""

import base64
import json
import os
import re
import shutil
import tracemalloc
import warnings
import zlib
from pathlib import Path
from random import Random

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import debrisflow
from debrisflow.case.rasters import SLACK, UnreadableRasterError, read_raster
from debrisflow.cli import main
from debrisflow.errors import CaseError, DebrisflowError, OutputError
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.results.frames import read_frame
from debrisflow.results.hazard import hazard_map, read_class_map, write_hazard
from debrisflow.results.hazard_classes import read_classes
from debrisflow.results.maps.layers import Layers
from debrisflow.results.page import pictures
from debrisflow.results.survey import survey
from debrisflow.run import checkpoint
from debrisflow.run.checkpoint import Origin
from debrisflow.run.folder import RunFolder
from debrisflow.run.reading import xml_of
from debrisflow.run.simulation import resume
from debrisflow.run.sound_state import must_be_sound
from debrisflow.run.vtu import read_collection
from tests.hostile.mutations import DOCTYPES, mutated
from tests.hostile.reading import files_read, read_all
from tests.recording import cells, channel_case, placed, record, sliding
from tests.terrain_recording import GAUGE, slide

INPUTS = 60  # of each run
FRAME = "vtu/000001.vtu"


@pytest.fixture(scope="module")
def flume(tmp_path_factory):
    """Return the folder of a run in two dimensions."""
    case = channel_case(length=1.0)
    block = placed(case, cells(case, range(10), range(5)), velocity=1.0)
    folder = record(tmp_path_factory.mktemp("flume") / "run", case, sliding(case, block, (0, 0.1)))
    (folder / "summary.json").write_text('{"end_reason": "end", "steps": 7, "versions": {}}')
    (folder / "run.log").write_text("2026 WARNING it is steep\n")
    return folder


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    """Return the folder of a run on a terrain, with a map of classes."""
    folder = slide(tmp_path_factory.mktemp("slope") / "run", probe=[GAUGE | {"interval": 1.0}])
    write_hazard(folder, hazard_map(folder, read_classes("japan")))
    return folder


@pytest.fixture
def run(flume, tmp_path):
    """Return a copy of the run in two dimensions, to be damaged."""
    return shutil.copytree(flume, tmp_path / "run")


@pytest.fixture
def terrain(slope, tmp_path):
    return shutil.copytree(slope, tmp_path / "run")


def exit_code(folder):
    """Return how the report of a run ends."""
    try:
        read_all(folder)
    except DebrisflowError as error:
        return error.exit_code
    return 0


@pytest.mark.parametrize("which", ["flume", "slope"])
def test_a_folder_with_a_changed_file_is_read_or_refused(which, tmp_path, request):
    folder = request.getfixturevalue(which)
    files = files_read(folder)
    contents = {file: file.read_bytes() for file in files}
    copy = shutil.copytree(folder, tmp_path / "run")
    refused = 0
    for number in range(INPUTS):
        random = Random(f"{which} {number}")
        file = random.choice(files)
        target = copy / file.relative_to(folder)
        target.write_bytes(mutated(contents[file], random, list(contents.values())))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of numbers that overflow
            code = exit_code(copy)
        assert code in (0, 2, 3)
        refused += code > 0
        target.write_bytes(contents[file])
    assert INPUTS // 4 < refused < INPUTS


def test_nothing_runs_what_it_reads():
    dangerous = re.compile(
        r"\b(pickle|marshal|shelve|yaml|allow_pickle|eval|exec|os\.system)\b[.(=]"
    )
    sources = Path(debrisflow.__file__).parent.rglob("*.py")
    found = [file.name for file in sources if dangerous.search(file.read_text(encoding="utf-8"))]
    assert found == ["_kernel_cache.py"]  # machine code, from folders of the user's own alone


@pytest.mark.parametrize(
    "name",
    ["../secret.vtu", "/etc/secret.vtu", "vtu/../../secret.vtu", r"..\secret.vtu", "C:/secret.vtu"],
)
def test_a_collection_lists_files_within_its_folder_only(run, name):
    secret = run.parent / "secret.vtu"
    shutil.copy(run / FRAME, secret)
    listing = run / "particles.pvd"
    listing.write_text(listing.read_text().replace(FRAME, name))
    with pytest.raises(OutputError, match=r"not within its folder"):
        survey(open_run(run))
    with pytest.raises(OutputError), RunFolder.open(run, open_run(run).case) as folder:
        folder.rewind(-1.0)
    assert secret.exists()


def test_a_collection_lists_no_files_of_other_kinds(run):
    listing = run / "particles.pvd"
    listing.write_text(listing.read_text().replace(FRAME, "case.toml"))
    with pytest.raises(OutputError, match=r"'case\.toml', which is no file of VTK"):
        read_collection(listing)


@pytest.mark.parametrize("time", ["nan", "inf", "0.0", "-1"])
def test_times_of_frames_increase(run, time):
    listing = run / "particles.pvd"
    listing.write_text(listing.read_text().replace('timestep="0.1"', f'timestep="{time}"'))
    with pytest.raises(OutputError, match=r"particles\.pvd is damaged: .*time"):
        _ = open_run(run).files


@pytest.mark.parametrize(
    "name", ["history.csv", "vtu", "render/side.png", "history.csv.unfinished"]
)
def test_a_link_out_of_the_folder_is_refused(run, name):
    secret = run.parent / "secret"
    secret.write_bytes(b"\x89PNG secret")
    link = run / name
    if link.is_dir():
        shutil.move(link, run.parent / "moved")
        secret = run.parent / "moved"
    link.unlink(missing_ok=True)
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(secret)
    with pytest.raises(OutputError, match=r"is a link out of the folder of its run"):
        open_run(run)
    with pytest.raises(OutputError, match=r"is a link out of the folder of its run"):
        resume(run)


def test_links_within_the_folder_and_files_that_are_not_read_do_not_count(run):
    (run / "history.csv").rename(run / "of_mine.csv")
    (run / "history.csv").symlink_to("of_mine.csv")
    (run / "dem.tif").symlink_to("/dem.tif")
    assert len(open_run(run).history["time"]) == 2


@pytest.mark.parametrize("name", ["case.toml", "history.csv", FRAME, "particles.pvd", "run.log"])
def test_a_pipe_is_refused_and_not_waited_for(run, name):
    (run / name).unlink()
    os.mkfifo(run / name)
    with pytest.raises(OutputError, match=r"is no r|holds no case"):
        open_run(run)


@pytest.mark.parametrize("text", DOCTYPES)
def test_xml_with_entities_is_refused_before_they_expand(run, text):
    (run / "particles.pvd").write_bytes(text)
    with pytest.raises(OutputError, match="it declares a DOCTYPE"):
        xml_of(run / "particles.pvd")


def test_very_deep_xml_is_refused(run):
    (run / "particles.pvd").write_bytes(b"<a>" * 10**6)
    with pytest.raises(OutputError, match="deep"):
        xml_of(run / "particles.pvd")


def test_a_claim_of_points_takes_no_memory(run):
    file = run / FRAME
    file.write_text(
        re.sub(r'NumberOfPoints="\d+"', 'NumberOfPoints="1000000000000"', file.read_text())
    )
    with pytest.raises(OutputError, match=r"claims 1000000000000 points, which a file of"):
        read_frame(0.0, file)


@pytest.mark.parametrize("claimed", [True, False])
def test_a_bomb_is_not_unpacked(run, claimed):
    size = 2**28
    bomb = zlib.compress(bytes(size), 9)
    block = size if claimed else 1200
    header = np.array([1, block, block, len(bomb)], dtype="<u4").tobytes()
    text = base64.b64encode(header).decode() + base64.b64encode(bomb).decode()
    file = run / FRAME
    found = re.sub(r'(Name="pressure"[^>]*>\s*)[^<]*', lambda m: m[1] + text, file.read_text())
    file.write_text(found)
    tracemalloc.start()
    with pytest.raises(OutputError, match="its array 'pressure' cannot be unpacked"):
        read_frame(0.0, file)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2**24


def test_a_file_with_a_hole_takes_no_memory(run):
    os.truncate(run / "history.csv", 2**40)
    with pytest.raises(OutputError, match="more than the 4,000,000,000 allowed"):
        _ = open_run(run).history


def test_a_raster_claims_no_more_than_it_can_hold(terrain):
    rasterio = pytest.importorskip("rasterio")
    file, side = terrain / "layers/peak_depth.tif", int(SLACK**0.5) * 5
    place = rasterio.Affine(1.0, 0.0, 9.0, 0.0, -1.0, 9.0)
    known = {"width": side, "height": side, "count": 1, "dtype": "float32", "transform": place}
    with rasterio.open(file, "w", driver="GTiff", tiled=True, SPARSE_OK=True, **known):
        pass
    assert file.stat().st_size < 2**20
    with pytest.raises(UnreadableRasterError, match=r"which .* bytes cannot hold"):
        read_raster(file)


def test_a_raster_that_names_other_files_is_refused(terrain):
    pytest.importorskip("rasterio")
    (terrain / "layers/peak_depth.tif").write_text(
        '<VRTDataset rasterXSize="5" rasterYSize="5"><VRTRasterBand dataType="Float32" band="1">'
        "<SimpleSource><SourceFilename>/vsicurl/http://127.0.0.1:9/x.tif</SourceFilename>"
        "</SimpleSource></VRTRasterBand></VRTDataset>"
    )
    with pytest.raises(UnreadableRasterError, match="not recognized"):
        read_raster(terrain / "layers/peak_depth.tif")


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "7",
        '{"steps": "<b>"}',
        '{"wall_seconds": NaN}',
        '{"versions": [1]}',
        "[" * 10**5,
        "\0",
    ],
)
def test_a_summary_of_other_values_is_damaged(run, text):
    (run / "summary.json").write_text(text)
    with pytest.raises(OutputError, match=r"summary\.json (is damaged|cannot be read)"):
        _ = open_run(run).summary


@pytest.mark.parametrize("row", ["inf,1", "1,inf", "1,nan", "nan,0", "5,-1", "5,0.5", "5,1e300"])
def test_frames_of_depth_have_times_and_numbers(terrain, row):
    (terrain / "layers/depth.csv").write_text(f"time,frame\n{row}\n")
    with pytest.raises(OutputError, match=r"depth\.csv is damaged"):
        _ = Layers(open_run(terrain)).frames


@pytest.mark.parametrize("head", ["", "# title\n", "# a\x1b[2J\n# b\n"])
def test_a_map_of_classes_has_title_and_source(terrain, head):
    (terrain / "postprocess/class_japan.csv").write_text(head)
    with pytest.raises(OutputError, match=r"class_japan\.csv is damaged"):
        read_class_map(terrain, "class_japan")


@pytest.mark.parametrize("color", ["red; background: url(http://x)", "#12345", ""])
def test_colors_of_classes_are_colors(terrain, color):
    file = terrain / "postprocess/class_japan.qml"
    file.write_text(re.sub(r'color="[^"]*"', f'color="{color}"', file.read_text()))
    with pytest.raises(OutputError, match=r"class_japan\.qml is damaged"):
        read_class_map(terrain, "class_japan")


def test_a_missing_column_is_told(run):
    table = open_run(run).deposit
    with pytest.raises(OutputError, match="no column nowhere is in the table"):
        table["nowhere"]
    with pytest.raises(KeyError):
        table["nowhere"]


@pytest.mark.parametrize("name", ["x", "maximal_depth"])
def test_a_table_of_maxima_without_a_column_is_told(run, name):
    file = run / "maxima.csv"
    file.write_text(
        re.sub(
            rf"^{name},|,{name}\b", lambda m: m[0].replace(name, "q"), file.read_text(), flags=re.M
        )
    )
    with pytest.raises(OutputError, match=r"has no column \w+"):
        _ = open_run(run).maxima


def test_only_pictures_come_onto_a_page(run):
    (run / "render").mkdir()
    (run / "render/a.png").write_text("root:x:0:0")
    (run / "render/b.png").write_bytes(b"\x89PNG\r\n")
    assert [one.name for one in pictures(run / "render")] == ["b"]


def test_a_message_steers_no_terminal(run):
    (run / "history.csv").write_text("time,\x1b]0;mine\x07\n0,1\n")
    told = CliRunner().invoke(main, ["postprocess", str(run)])
    assert told.exit_code == 3
    assert "\x1b" not in told.output
    name = "a\x1b[2Jb"
    (run.parent / name).mkdir()
    told = CliRunner().invoke(main, ["postprocess", str(run.parent / name)])
    assert (told.exit_code, "\x1b" in told.output) == (3, False)
    (run / "case.toml").write_text('"\\u001b[2J" = 1\n')
    with pytest.raises(CaseError) as caught:
        open_run(run)
    assert "\x1b" not in str(caught.value)


def test_a_message_forges_no_line_of_the_log(run):
    case = open_run(run).case
    with RunFolder.open(run, case) as folder:
        folder.log.info("a title\n2026-01-01 00:00:00,000 ERROR forged \x1b[2J")
    last = (run / "run.log").read_text().splitlines()[-1]
    assert last.startswith("  2026")
    assert "\x1b" not in last


def test_of_a_long_log_some_warnings_are_told(run):
    (run / "run.log").write_text("2026 WARNING steep\n" * 1000 + "x" * 3 * 2**20)
    assert open_run(run).warnings[-2:] == ["steep", "more than 200 warnings are in run.log"]


def test_a_summary_says_what_a_run_writes(flume):
    assert json.loads((flume / "summary.json").read_text()) == open_run(flume).summary


FORGED = {
    "kind": lambda p, state: p.kind.__setitem__(slice(3), 77),
    "wall": lambda p, state: p.wall.__setitem__(slice(3), 100),
    "pressure": lambda p, state: setattr(p, "pressure", np.zeros(0)),
    "position": lambda p, state: p.position.__setitem__(slice(3), 1e6),
    "density": lambda p, state: p.density.__setitem__(slice(3), 0.0),
    "velocity": lambda p, state: p.velocity.__setitem__(slice(3), np.nan),
    "time": lambda p, state: setattr(state, "time", np.nan),
    "step": lambda p, state: setattr(state, "step", -5),
    "released": lambda p, state: setattr(state, "released", np.array([-1])),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_checkpoint_with_numbers_of_no_run_is_refused(name):
    case = channel_case(length=1.0)
    state, start = initial_state(case), initial_state(case)
    must_be_sound(state, case, start)
    FORGED[name](state.particles, state)
    with pytest.raises(OutputError, match=rf"none of a run: {name}\b"):
        must_be_sound(state, case, start)


@pytest.mark.parametrize("content", ["", "[" * 10**5, "[1", '{"a": ' * 900 + "1" + "}" * 900])
def test_an_origin_that_cannot_be_compared_is_damage(tmp_path, content):
    case = channel_case(length=1.0)
    checkpoint.save(tmp_path / "c.h5", initial_state(case), Origin("debrisflow", "zen", content))
    with pytest.raises(OutputError, match="damaged"):
        checkpoint.load(tmp_path / "c.h5")


def test_an_array_with_two_names_is_refused(tmp_path):
    case = channel_case(length=1.0)
    checkpoint.save(tmp_path / "c.h5", initial_state(case), Origin("debrisflow", "zen", "{}"))
    with h5py.File(tmp_path / "c.h5", "a") as file:
        del file["particles/density"]
        file["particles/density"] = file["particles/pressure"]
    with pytest.raises(OutputError, match=r"damaged: .* has several names"):
        checkpoint.load(tmp_path / "c.h5")
