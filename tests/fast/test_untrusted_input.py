"""What a case names is either read or refused in words, whatever it holds; nothing else happens.

Hypothesis changes samples; the single files are those that once did more than they should.
"""

from __future__ import annotations

import http.server
import os
import sqlite3
import struct
import threading
import time
import tomllib
from contextlib import suppress
from pathlib import Path
from random import Random

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from debrisflow.case import build_case, load_case, rasters, triangles
from debrisflow.case.overrides import parse_value
from debrisflow.case.rasters import UnreadableRasterError, read_raster
from debrisflow.case.reference_systems import differ, wkt_of
from debrisflow.case.regions import Region, volume_left
from debrisflow.case.series import UnreadableSeriesError, read_series
from debrisflow.case.triangles import (
    Surface,
    UnreadableSurfaceError,
    cells_inside,
    read_surface,
)
from debrisflow.case.vectors import UnreadableVectorsError, read_polygons, write_polygons
from debrisflow.cli import main
from debrisflow.errors import CaseError, DebrisflowError, OutputError
from debrisflow.results.hazard_classes import read_classes
from debrisflow.results.references import read_reference
from tests.conftest import CHANNEL, TANK
from tests.untrusted.mutations import EXTREMES
from tests.untrusted.targets import SQUARE, Target, furnish, targets

GREATEST = 2**32 - 1
same_each_time = settings(
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=30,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture(scope="module")
def furnished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, list[bytes]]]:
    folder = tmp_path_factory.mktemp("untrusted")
    return folder, furnish(folder)


def _meet(target: Target, folder: Path, data: bytes) -> None:
    path = folder / target.file
    path.write_bytes(data)
    try:
        target.meet(path)
    except DebrisflowError:
        return  # anything else fails the test


@pytest.mark.parametrize("name", targets())
@given(seed=st.integers(0, GREATEST))
@same_each_time
def test_a_changed_file_is_read_or_refused(name, furnished, seed: int) -> None:
    folder, samples = furnished
    target, random = targets()[name], Random(seed)
    _meet(target, folder, target.mutate(random.choice(samples[name]), random, target.words))


@pytest.mark.parametrize("name", targets())
@given(data=st.binary(max_size=200))
@same_each_time
def test_any_bytes_are_refused_or_read(name, furnished, data: bytes) -> None:
    _meet(targets()[name], furnished[0], data)


@given(place=st.integers(0, GREATEST), value=st.sampled_from(EXTREMES))
@settings(same_each_time, max_examples=150)
def test_any_value_may_stand_in_any_field(furnished, place: int, value: object) -> None:
    tables = tomllib.loads(Random(place).choice((TANK, CHANNEL)))
    fields = [(table, key) for table in _tables_in(tables) for key in table]
    table, key = fields[place % len(fields)]
    table[key] = value
    with suppress(CaseError):
        build_case(tables, folder=furnished[0])


def _tables_in(node):
    if isinstance(node, dict):
        yield node
    for part in node.values() if isinstance(node, dict) else node:
        if isinstance(part, dict | list):
            yield from _tables_in(part)


READERS = {
    "input.toml": (load_case, CaseError),
    "classes.toml": (lambda path: read_classes(str(path)), CaseError),
    "input.csv": (lambda path: read_series(path, ("time",)), (OSError, UnreadableSeriesError)),
    "curves.csv": (read_reference, OutputError),
    "input.stl": (read_surface, UnreadableSurfaceError),
    "input.ply": (read_surface, UnreadableSurfaceError),
    "input.obj": (read_surface, UnreadableSurfaceError),
    "input.asc": (read_raster, UnreadableRasterError),
    "input.tif": (read_raster, UnreadableRasterError),
    "input.geojson": (read_polygons, UnreadableVectorsError),
    "input.gpkg": (read_polygons, UnreadableVectorsError),
    "input.shp": (read_polygons, UnreadableVectorsError),
}


def _pipe(path: Path) -> None:
    os.mkfifo(path)


# Windows cannot make what this test hands to the readers
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names")
@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_pipe, "is a pipe or a device"),
        (lambda path: path.symlink_to("/dev/zero"), "is a pipe or a device"),
        (Path.mkdir, "is a directory"),
        (lambda path: path.symlink_to(path), "too many levels"),
        (lambda path: path.symlink_to(path.with_name("absent")), "no such file|is missing"),
    ],
    ids=["pipe", "device", "folder", "loop", "absent"],
)
def test_what_is_no_file_is_refused_at_once(tmp_path: Path, name: str, make, words: str) -> None:
    read, errors = READERS[name]
    path = tmp_path / name
    make(path)

    start = time.monotonic()
    with pytest.raises(errors, match=f"(?i){words}"):
        read(path)
    assert time.monotonic() - start < 5.0


@pytest.mark.parametrize("name", READERS)
def test_a_file_too_large_is_refused_before_it_is_read(tmp_path: Path, name: str) -> None:
    read, errors = READERS[name]
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(5_000_000_000)  # of zeros that take no room

    with pytest.raises(errors, match="has 5,000,000,000 bytes, more than the "):
        read(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = " + "[" * 4000, "deep in each other"),
        ("a = " + "[" * 40 + "]" * 40, "deep in each other"),
        (".".join("a" * 60000) + " = 1", "more than 64 parts"),
        ("a = " + "9" * 5000, "that cannot be one"),
        ("a = 0x" + "f" * 50, "more than 64 bits"),
        ('"a\\u0000" = 1', "cannot be printed"),
        ("a = 1\na = 2", "is not valid TOML"),
    ],
)
def test_toml_made_to_be_endless_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    for read in (load_case, lambda path: read_classes(str(path))):
        with pytest.raises(CaseError, match=words):
            read(path)
    assert isinstance(parse_value(text.removeprefix("a = ")), str | int)


def test_encodings_of_a_case(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(TANK, encoding="utf-8-sig")
    assert load_case(path).title == "a column of water"
    path.write_text(TANK, encoding="utf-16")
    with pytest.raises(CaseError, match="is not a text file in UTF-8"):
        load_case(path)


def test_a_case_of_many_errors_is_refused_within_seconds(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(TANK + "\n".join(f"key{k} = 'a'" for k in range(20_000)), encoding="utf-8")

    start = time.monotonic()
    with pytest.raises(CaseError, match="more than 100 errors, of which the first are") as caught:
        load_case(path)
    assert len(str(caught.value).splitlines()) == 101
    assert time.monotonic() - start < 10.0


def test_an_override_may_have_any_number_for_an_entry(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(TANK, encoding="utf-8")
    with pytest.raises(CaseError, match="no such entry"):
        load_case(path, [f"fill.{'9' * 5000}.x=1"])


def test_a_raster_that_needs_more_memory_than_there_is(tmp_path, monkeypatch) -> None:
    path = tmp_path / "dem.asc"
    head = "ncols 10000\nnrows 10000\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
    path.write_text(head + "1 2 3\n")
    monkeypatch.setattr(rasters, "available_memory", lambda: 1e9)
    with pytest.raises(UnreadableRasterError, match=r"need 6\.0 GB .*; 1\.0 GB are available"):
        read_raster(path)
    path.write_text(head + "ncols 3\n")
    with pytest.raises(UnreadableRasterError, match="has two lines of ncols"):
        read_raster(path)


def test_a_list_of_other_files_is_no_geotiff(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    sound = tmp_path / "sound.tif"
    grid = rasters.MapGrid(0.0, 0.0, 1.0, 3, 2)
    rasters.write_raster(sound, rasters.Raster(grid, np.ones((2, 3))))
    list_of_files = tmp_path / "dem.tif"
    list_of_files.write_text(
        '<VRTDataset rasterXSize="3" rasterYSize="2"><GeoTransform>0,1,0,2,0,-1</GeoTransform>'
        '<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename>'
        f"{sound}</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>"
    )
    with pytest.raises(UnreadableRasterError, match="cannot be read as a raster"):
        read_raster(list_of_files)
    for name in ("/vsicurl/http://127.0.0.1:9/a.tif", "/vsizip/a.zip/a.tif"):
        with pytest.raises(UnreadableRasterError, match="no such file"):
            read_raster(Path(name))


def test_entities_beside_a_raster_are_not_expanded(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    path = tmp_path / "dem.tif"
    grid = rasters.MapGrid(0.0, 0.0, 1.0, 3, 2)
    rasters.write_raster(path, rasters.Raster(grid, np.ones((2, 3))))
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 20))
    (tmp_path / "dem.tif.aux.xml").write_text(
        f'<!DOCTYPE a [<!ENTITY e0 "x">{entities}]><PAMDataset><Metadata>&e19;</Metadata>'
        "</PAMDataset>"
    )
    assert read_raster(path).values.sum() == 6.0


@pytest.mark.parametrize("ending", [".gpkg", ".shp", ".kml", ".vrt", ".zip"])
def test_gdal_opens_only_what_an_ending_says(tmp_path: Path, ending: str) -> None:
    pytest.importorskip("pyogrio")
    path = tmp_path / f"areas{ending}"
    path.write_text(
        '<OGRVRTDataSource><OGRVRTLayer name="a"><SrcDataSource>/etc/passwd</SrcDataSource>'
        "</OGRVRTLayer></OGRVRTDataSource>"
    )
    with pytest.raises(UnreadableVectorsError, match=r"it is no \.|must be a file of"):
        read_polygons(path)


def test_a_view_of_a_geopackage_is_not_run(tmp_path: Path) -> None:
    pytest.importorskip("pyogrio")
    path = tmp_path / "areas.gpkg"
    write_polygons(path, [SQUARE], {}, "EPSG:32654")
    assert len(read_polygons(path).shapes) == 1
    with sqlite3.connect(path) as base:
        base.execute(
            "CREATE VIEW endless AS WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k FROM n) "
            "SELECT k FROM n"
        )
    base.close()
    with pytest.raises(UnreadableVectorsError, match="'endless', which is computed"):
        read_polygons(path)


def test_the_name_of_a_system_opens_no_file_and_no_connection(tmp_path: Path) -> None:
    asked = []

    class Server(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_error(404)

        def log_message(self, *_: object) -> None:
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Server) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            known = tmp_path / "known.prj"
            known.write_text(wkt_of("EPSG:32654"))
            address = f"http://127.0.0.1:{server.server_port}/a"
            for name in (address, str(known), f"ESRI::{known}"):
                assert wkt_of(name) == name
        finally:
            server.shutdown()
    assert not asked
    assert not differ("EPSG:3\x00\x0154", "EPSG:32654")


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("ply\nformat ascii 1.0\nelement vertex 3\n", "its head has no end"),
        ("ply\nformat ascii 1.0\nelement face 4000000000\nend_header\n", "promises more"),
        (f"ply\nformat ascii 1.0\nelement face {'9' * 5000}\nend_header\n", "promises more"),
    ],
)
def test_heads_of_ply(tmp_path: Path, head: str, words: str) -> None:
    path = tmp_path / "a.ply"
    path.write_text(head)
    with pytest.raises(UnreadableSurfaceError, match=words):
        read_surface(path)


def test_meshes_of_impossible_numbers(tmp_path: Path) -> None:
    binary = tmp_path / "a.stl"
    binary.write_bytes(b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 50)
    with pytest.raises(UnreadableSurfaceError, match=r"not a readable STL file|holds no triangles"):
        read_surface(binary)
    text = tmp_path / "a.obj"
    text.write_text("v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(UnreadableSurfaceError, match=r"beyond 1e\+09"):
        read_surface(text)
    text.with_name("b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -3\n")
    with pytest.raises(UnreadableSurfaceError, match="not a readable OBJ file"):
        read_surface(text.with_name("b.obj"))


def test_triangles_in_parts_enclose_the_same_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    corner = 4.0 * np.vstack([np.zeros(3), np.eye(3)])
    surface = Surface(corner[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]])
    whole = cells_inside(surface, 0.3)
    monkeypatch.setattr(triangles, "MOST_TRIED", 10.0)
    np.testing.assert_array_equal(cells_inside(surface, 0.3), whole)
    assert len(whole) > 300


def test_columns_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time,front,front\n0,1,2\n1,2,3\n")
    with pytest.raises(OutputError, match="two columns front"):
        read_reference(path)
    with pytest.raises(UnreadableSeriesError, match="two columns 'front'"):
        read_series(path, ("time", "front"))


def test_the_end_of_the_memory_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise MemoryError("Unable to allocate 9 TiB")

    monkeypatch.setattr("debrisflow.case.load_case", fail)
    result = CliRunner().invoke(main, ["check", "case.toml"])
    assert result.exit_code == 1
    assert "memory of this machine is used up (Unable to allocate 9 TiB)" in result.output


def test_many_regions_take_little_memory() -> None:
    ends = np.arange(300.0)
    boxes = [Region((a, a, a), (a + 0.5, a + 0.5, a + 0.5)) for a in ends]
    assert volume_left(boxes, []) == pytest.approx(300 * 0.125)


def test_a_table_of_classes_with_lists_for_names(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    table = 'title = "a"\nsource = "b"\n[[class]]\nname = "c"\ncolor = "#000000"\n[limit.s]\n'
    path.write_text(table + "of = []\nat = [1, 2]\nis = [1, 2]\n")
    with pytest.raises(CaseError, match="unknown layer"):
        read_classes(str(path))
    path.write_text(table + f'of = "peak_depth"\nat = [1, {"9" * 400}]\nis = [1, 2]\n')
    with pytest.raises(CaseError, match="more than 64 bits"):
        read_classes(str(path))
    path.write_text(table + 'of = "peak_depth"\nat = [1, nan]\nis = [1, 2]\n')
    with pytest.raises(CaseError, match="finite numbers"):
        read_classes(str(path))
