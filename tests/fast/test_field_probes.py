"""Probes of many points, lines and grids: their values, files and plots."""

import shutil

import numpy as np
import pytest
import pyvista

from debrisflow.errors import OutputError
from debrisflow.results import open_run
from debrisflow.results.plots.fields import grid_figure
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import probe_curve
from debrisflow.results.survey import survey
from debrisflow.run import simulation
from debrisflow.run.folder import DERIVED, RunFolder
from debrisflow.run.probes import samplers
from tests.building import bed_case, started, tank3d_case, tank_case

LINE = {"name": "cut", "type": "line", "interval": 0.02, "start": (0.5, -0.08), "end": (0.5, 0.1)}
GRID = {"name": "map", "type": "grid", "interval": 0.05, "x": (0.2, 0.6), "y": (-0.1, 0.1)}
SLOPES = np.array([[2.0, -1.0, 0.5], [0.3, 4.0, -2.0], [1.0, 0.0, 3.0]])


def linear(case):
    """Return a state of a case whose velocity and pressure vary linearly."""
    _, state = started(case)
    p, axes = state.particles, slice(case.dimension)
    p.velocity[p.fluid, axes] = 1.0 + p.position[p.fluid, axes] @ SLOPES[axes, axes]
    p.pressure[p.fluid] = 500.0 - 700.0 * p.position[p.fluid, case.dimension - 1]
    return state


def columns_of(case, state, name):
    """Return the columns of a sample of a probe."""
    sampler = samplers(case, state)[name]
    names = [column.name for column in sampler.columns(case.dimension)]
    return dict(zip(names, np.array(sampler.rows(state)).T, strict=True))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_linear_field_is_exact_along_a_line_and_dry_above_the_water(dimension):
    build = {2: lambda **t: tank_case(10, 10, "water", **t), 3: tank3d_case}[dimension]
    top = 0.15 if dimension == 2 else 0.9
    ends = ((0.03, 0.2, 0.0), (0.04, 0.3, top)) if dimension == 3 else ((0.03, 0.0), (0.04, top))
    line = LINE | {"start": ends[0], "end": ends[1], "points": 31}
    case = build(probe=[line])
    found = columns_of(case, linear(case), "cut")
    place = np.column_stack([found[axis] for axis in "xyz"[:dimension]])
    np.testing.assert_allclose(place[[0, -1]], ends, rtol=1e-12)
    np.testing.assert_allclose(found["s"], np.linalg.norm(place - ends[0], axis=1), atol=1e-12)
    wet, velocity = found["wet"] == 1.0, [found[f"velocity_{a}"] for a in "xyz"[:dimension]]
    assert 5 < np.count_nonzero(wet) < 31
    under = place[:, -1] < (0.1 if dimension == 2 else 0.5)  # what is just above is wet too
    assert wet[under].all()
    axes = slice(dimension)
    expected = 1.0 + place[under] @ SLOPES[axes, axes]
    np.testing.assert_allclose(np.array(velocity).T[under], expected, atol=1e-9)
    expected = 500.0 - 700.0 * place[under, -1]
    np.testing.assert_allclose(found["pressure"][under], expected, rtol=1e-9)
    for name in ("velocity_x", "pressure", "concentration"):
        assert np.isnan(found[name][~wet]).all()


def test_a_line_takes_a_point_a_spacing():
    case = bed_case(probe=[LINE])
    assert case.probe[0].points == 10  # 0.18 m by 0.02 m


def test_a_line_through_the_end_of_a_period_sees_what_is_beyond_it():
    across = LINE | {"start": (0.4, 0.0, 0.25), "end": (0.4, 0.6, 0.25), "points": 13}
    case = tank3d_case(geometry={"periodic": True}, probe=[across])
    _, state = started(case)
    p = state.particles
    wave = 2.0 * np.pi / 0.6
    p.velocity[p.fluid, 0] = np.cos(wave * p.position[p.fluid, 1])
    p.position[p.fluid, 1] += 0.6  # a period further
    found = columns_of(case, state, "cut")
    assert found["wet"].all()
    np.testing.assert_allclose(found["velocity_x"][0], found["velocity_x"][-1], rtol=1e-9)
    # a straight line through what lies within two spacings, a third of the wave
    np.testing.assert_allclose(found["velocity_x"], np.cos(wave * found["y"]), atol=0.3)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the folder of a whole run with a line and a grid."""
    folder = tmp_path_factory.mktemp("fields") / "whole"
    simulation.simulate(probed(), folder, threads=1)
    return folder


def probed(probes=(LINE, GRID)):
    return bed_case(time={"end": 0.15}, output={"interval": 0.05}, probe=probes)


def test_a_line_has_a_row_for_each_time_and_point(whole):
    table = open_run(whole).probe("cut")
    assert table["time"].size == 10 * 9  # 0, 0.02, ... and the end
    assert np.unique(table["time"]).size == 9
    assert table["wet"].any()


def test_a_grid_is_read_by_time_x_and_y_as_paraview_shows_it(whole):
    run = open_run(whole)
    table = run.grid("map")
    assert table["velocity"].shape == (4, 21, 11, 3)
    assert table["pressure"].shape == (4, 21, 11)
    np.testing.assert_allclose([table["x"][-1], table["y"][0]], [0.6, -0.1])
    image = pyvista.read(whole / "probes" / "map" / "000002.vti")
    number = image.find_closest_point((table["x"][7], table["y"][2], 0.0))
    assert image.point_data["wet"][number] == 1.0
    np.testing.assert_allclose(image.point_data["velocity"][number], table["velocity"][2, 7, 2])
    assert table["wet"][0, :, :5].all()  # the bed
    assert np.isnan(table["pressure"][table["wet"] == 0.0]).all()


def test_an_interrupted_run_writes_the_same_files(whole, tmp_path, interrupt):
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(probed(), tmp_path / "broken", threads=1)
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    simulation.resume(tmp_path / "rest", threads=1)
    files = [f.relative_to(whole) for f in (whole / "probes").rglob("*") if f.is_file()]
    assert len(files) == 1 + 1 + 4
    for file in files:
        assert (tmp_path / "rest" / file).read_bytes() == (whole / file).read_bytes()


def test_a_checkpoint_before_the_last_samples_cuts_them(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "cut")
    with RunFolder.open(tmp_path / "cut", probed()) as folder:
        folder.rewind(0.05)
    run = open_run(tmp_path / "cut")
    assert run.probe("cut")["time"].max() <= 0.05
    assert run.grid("map")["time"].max() <= 0.05
    assert len(list((tmp_path / "cut/probes/map").iterdir())) == run.grid("map")["time"].size


def test_a_line_that_is_being_written_is_read_up_to_its_last_whole_sample(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "cut")
    file = tmp_path / "cut/probes/cut.csv"
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:-3]))
    assert open_run(tmp_path / "cut").probe("cut")["time"].size == 10 * 8


def test_overwriting_removes_the_images_of_earlier_grids_and_no_others(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "again")
    mine = tmp_path / "again/probes/mine.pvd"
    mine.write_text('<VTKFile><Collection><DataSet file="elsewhere/a.vti"/></Collection></VTKFile>')
    RunFolder.create(tmp_path / "again", probed(()), overwrite=True).close()
    assert list((tmp_path / "again/probes").iterdir()) == [mine]


def test_lines_and_grids_are_drawn(whole):
    files, _ = postprocess(survey(open_run(whole)))
    names = {file.name for file in files}
    assert {"lines.png", "grids.png"} <= names <= set(DERIVED)


def test_a_flat_grid_has_a_low_panel(tmp_path):
    heights = []
    for number, top in enumerate((0.1, 0.4)):
        grid = {"name": "map", "type": "grid", "interval": 0.1, "x": (0.0, 0.8), "y": (0.0, top)}
        case = tank_case(20, 10, "water", spacing=0.05, probe=[grid])
        _, state = started(case)
        with RunFolder.create(tmp_path / f"run{number}", case) as folder:
            folder.write_probe("map", 0.0, samplers(case, state)["map"].rows(state))
        heights.append(grid_figure(open_run(tmp_path / f"run{number}")).get_figheight())
    assert heights[0] < heights[1] - 0.5


def test_a_line_is_no_curve_in_time(whole):
    with pytest.raises(OutputError, match=r"probe cut is a line: its columns are of many points"):
        probe_curve(open_run(whole), "cut.velocity_x")


def test_a_damaged_image_is_told(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "cut")
    pyvista.ImageData(dimensions=(2, 2, 1)).save(tmp_path / "cut/probes/map/000001.vti")
    with pytest.raises(
        OutputError, match=r"000001\.vti is damaged: it has 4 points where \d+ are wanted"
    ):
        open_run(tmp_path / "cut").grid("map")


def test_a_box_is_shown_by_a_plane_through_its_middle(tmp_path):
    box = {"x": (0.0, 0.8), "y": (0.1, 0.5), "z": (0.0, 0.6), "step": 0.1}
    case = tank3d_case(probe=[GRID | box], time={"end": 0.1}, output={"interval": 0.1})
    state = linear(case)
    with RunFolder.create(tmp_path / "box", case) as folder:
        folder.write_probe("map", 0.0, samplers(case, state)["map"].rows(state))
    table = open_run(tmp_path / "box").grid("map")
    assert table["pressure"].shape == (1, 9, 5, 7)
    wet = table["wet"] == 1.0
    x, y, z = np.meshgrid(table["x"], table["y"], table["z"], indexing="ij")
    np.testing.assert_allclose(table["pressure"][wet], (500.0 - 700.0 * z)[wet[0]], rtol=1e-5)
    expected = 1.0 + np.stack([x, y, z], axis=-1) @ SLOPES
    np.testing.assert_allclose(table["velocity"][wet], expected[wet[0]], atol=1e-5)
