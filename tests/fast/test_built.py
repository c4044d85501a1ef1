"""What is built of the lengths that a case asks for, and what is reported of it."""

import logging
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.case import dump_case, load_case
from debrisflow.case.built import roundings
from debrisflow.case.doubts import doubts
from debrisflow.case.regions import surface_of
from debrisflow.case.triangles import cells_inside, nearest_points
from debrisflow.cli import main
from debrisflow.errors import CaseError
from debrisflow.particles.seeding import seed
from debrisflow.particles.start import initial_state
from debrisflow.run.simulation import simulate
from debrisflow.space.carving import filled, fitted
from debrisflow.space.volumes import differences
from debrisflow.space.walls import wall_points
from debrisflow.validation.marching import advance
from tests.building import started, tank3d_case

TETRAHEDRON = Path(__file__).parent / "bad_cases" / "tetrahedron.obj"
CASES = sorted((Path(__file__).parents[2] / "cases").glob("*.toml"))
TOO_SHORT = {("heap3d", 1.3)}  # its periodic width is the least that its own spacing allows

# from the paper: a square of water, 2 1/4 inches wide
MARTIN = """
title = "Martin & Moyce"
particles = { spacing = 0.01 }
geometry = { type = "tank", length = 0.584, height = 0.2 }
time = { end = 0.001 }
output = { interval = 0.001 }

[[fill]]
type = "block"
x = [0.0, 0.146]
y = [0.0, 0.146]
material = "water"

[[fill]]
type = "block"
x = [0.146, 0.584]
y = [0.0, 0.03]
material = "water"
"""

CHANNEL = """
title = "a flume"
particles = { spacing = 0.1 }
geometry = { type = "channel3d", length = 3.0, width = 0.98, height = 1.0 }
time = { end = 1.0 }
output = { interval = 0.1 }

[inflow]
depth = 0.25
"""

PIER = {"type": "box", "name": "pier", "x": [0.43, 0.73], "y": [0.31, 0.61], "z": [0.0, 0.34]}


def written(folder, text):
    path = folder / "case.toml"
    path.write_text(text)
    return path


def again(case, folder):
    """Return a case as a run writes it and `resume` reads it."""
    return load_case(written(folder, dump_case(case)))


@pytest.fixture
def martin(tmp_path):
    return written(tmp_path, MARTIN)


class TestShippedCases:
    @pytest.mark.parametrize("factor", [0.7, 0.9, 1.3])
    @pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
    def test_another_spacing_needs_no_other_change(self, path, factor, tmp_path):
        change = [f"particles.spacing={load_case(path).particles.spacing * factor:.10g}"]
        if (path.stem, factor) in TOO_SHORT:
            with pytest.raises(CaseError, match=r"1 error\n.*too short to be periodic"):
                load_case(path, change)
            return

        case = load_case(path, change)

        read = again(case, tmp_path)
        assert read.model_dump() == case.model_dump()
        assert read.asked is None

    @pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
    def test_at_its_own_spacing_all_is_built_as_asked(self, path):
        assert differences(load_case(path)) == []


class TestLengths:
    def test_a_tank_off_the_lattice_is_built_and_told(self, martin):
        case = load_case(martin)

        assert (case.geometry.length, case.geometry.height) == (0.58, 0.2)
        assert [(row.key, row.asked, row.built) for row in roundings(case)] == [
            ("geometry.length", 0.584, 0.58),
            ("fill.0.x.1", 0.146, 0.15),
            ("fill.0.y.1", 0.146, 0.15),
            ("fill.1.x.0", 0.146, 0.15),
            ("fill.1.x.1", 0.584, 0.58),
        ]

    def test_what_touches_still_touches(self, martin):
        case = load_case(martin)

        assert case.fill[0].x[1] == case.fill[1].x[0]
        assert case.fill[1].x[1] == case.geometry.length
        assert seed(case).fluid_count == 15 * 15 + 43 * 3

    def test_what_is_built_builds_the_same(self, martin, tmp_path):
        case = load_case(martin)
        read = again(case, tmp_path)

        assert differences(read) == []
        position = initial_state(case).particles.position
        np.testing.assert_array_equal(initial_state(read).particles.position, position)

    def test_a_periodic_space_stays_as_long_as_it_must_be(self):
        path = next(path for path in CASES if path.stem == "poiseuille2d")
        case = load_case(path, ["particles.spacing=6.5e-5"])

        assert case.geometry.length == pytest.approx(13 * 6.5e-5)
        assert case.fill[0].x == (0.0, case.geometry.length)

    @pytest.mark.parametrize("place", [0.144, 0.146, 0.15])
    def test_a_probe_at_the_wall_that_is_asked_is_at_the_one_that_is_built(self, martin, place):
        probe = '[[probe]]\nname = "p"\ntype = "pressure"\nwall = "right"\ninterval = 1.0\n'
        text = MARTIN.replace("0.584", f"{place}").partition("[[fill]]\ntype")[0]
        fill = f'[[fill]]\ntype = "block"\nx = [0, {place}]\ny = [0, 0.1]\nmaterial = "water"\n'
        martin.write_text(f"{text}{fill}{probe}x = {place}\ny = 0.05\n")

        summary = simulate(load_case(martin), martin.parent / "run", threads=1)

        assert summary["steps"] > 0


class TestSupply:
    @pytest.mark.parametrize("given", ["discharge = 0.245", "velocity = 1.0"])
    def test_what_enters_is_what_is_asked(self, tmp_path, given):
        case = load_case(written(tmp_path, CHANNEL + given))

        assert (case.inflow.depth, case.geometry.width) == (0.3, 1.0)
        assert case.inflow.discharge == pytest.approx(0.25 * 0.98)
        assert case.inflow.velocity == pytest.approx(0.25 * 0.98 / 0.3)
        (line,) = doubts(case)
        assert line.startswith("inflow.depth = 0.25 m is built 0.3 m deep")
        assert again(case, tmp_path).inflow == case.inflow


class TestObstacles:
    def test_where_walls_are_surfaces_a_box_stays_where_it_is(self):
        assert tank3d_case(obstacle=[PIER], size=(1.2, 0.8, 1.0)).obstacle[0].x == (0.43, 0.73)

    def test_in_the_form_study_it_follows_the_lattice(self):
        study = {"type": "explicit", "form": "study"}
        (pier,) = tank3d_case(obstacle=[PIER], size=(1.2, 0.8, 1.0), scheme=study).obstacle

        assert (pier.x, pier.y, pier.z) == ((0.4, 0.7), (0.3, 0.6), (0.0, 0.3))

    def test_in_the_form_study_walls_are_particles_on_the_lattice(self, martin):
        case = load_case(martin, ["scheme.form=study"])
        cell = wall_points(case).position[:, :2] / 0.01 - 0.5

        np.testing.assert_allclose(cell, np.rint(cell), atol=1e-9)
        inside = (cell > -0.5) & (cell < (57.5, 19.5))
        assert not np.any(inside.all(axis=1))

    def test_a_dam_across_a_flume_ends_at_the_walls_that_are_built(self, tmp_path):
        dam = '[[obstacle]]\ntype = "box"\nname = "dam"\nx = [2.03, 2.15]\ny = [0.0, 0.98]\n'
        path = written(tmp_path, f"{CHANNEL}velocity = 1.0\n{dam}z = [0.0, 0.33]\n")

        case = load_case(path)
        (dam,) = case.obstacle

        assert (dam.x, dam.y, dam.z) == ((2.03, 2.15), (0.0, 1.0), (0.0, 0.33))
        assert ("obstacle.dam.y.1", 0.98, 1.0) in [row[:3] for row in roundings(case)]

    def test_a_thin_box_at_a_wall_goes_with_it(self):
        plate = PIER | {"x": [1.06, 1.16], "z": [0.0, 0.3]}
        (plate,) = tank3d_case(obstacle=[plate], size=(1.16, 0.8, 1.0)).obstacle

        assert plate.x == pytest.approx((1.1, 1.2))


class TestCarving:
    def test_a_later_fill_replaces_an_earlier_one(self, martin):
        text = MARTIN.replace("x = [0.146, 0.584]", "x = [0.05, 0.25]")
        martin.write_text(text.replace("y = [0.0, 0.03]", "y = [0.05, 0.1]"))
        first, second = filled(load_case(martin))

        assert len(first) == 15 * 15 - 10 * 5
        assert len(second) == 20 * 5
        both = np.concatenate([first, second])
        assert len(np.unique(both.round(6), axis=0)) == len(both)

    @pytest.mark.parametrize(
        ("ends", "cells"),
        [((0.4, 0.7), 3), ((0.43, 0.73), 3), ((0.45, 0.75), 3), ((0.44, 0.76), 4)],
    )
    def test_an_obstacle_is_cut_out_of_a_fill(self, ends, cells):
        box = PIER | {"x": list(ends), "y": list(ends), "z": [0.0, 0.3]}
        case = tank3d_case(size=(1.2, 1.2, 1.0), obstacle=[box])

        assert seed(case).fluid_count == 12 * 12 * 5 - cells * cells * 3

    def test_the_last_fill_that_overlaps_an_obstacle_is_cut_too(self):
        block = {"type": "block", "x": [0.0, 1.2], "y": [0.0, 0.8], "material": "water"}
        fill = [block | {"z": [0.0, 0.2]}, block | {"x": [0.0, 0.6], "z": [0.1, 0.4]}]
        case = tank3d_case(size=(1.2, 0.8, 1.0), obstacle=[PIER], fill=fill)
        lower, upper = filled(case)

        assert len(lower) == 12 * 8 * 2 - 3 * 3 * 2 - 6 * 8 + 2 * 3
        assert len(upper) == 6 * 8 * 3 - 2 * 3 * 2

    def test_rows_before_a_box_stand_half_a_spacing_from_it(self):
        case = tank3d_case(size=(1.2, 0.8, 1.0), obstacle=[PIER])
        place = fitted(case, np.concatenate(filled(case)))

        box = case.obstacle[0]
        ends = np.array([box.x, box.y, box.z])
        off = place - np.clip(place, *ends.T)
        distance = np.linalg.norm(off, axis=1)
        before_a_face = np.count_nonzero(off, axis=1) == 1
        assert distance[before_a_face].min() > 0.04
        assert distance.min() > 0.02
        assert np.all(place > 0.0)
        assert np.all(place < (1.2, 0.8, 1.0))

    def test_a_mesh_is_cut_out_and_nothing_starts_at_its_surface(self):
        rock = {"type": "mesh", "name": "rock", "file": str(TETRAHEDRON), "offset": [0.2, 0.1, 0.0]}
        case = tank3d_case(size=(1.2, 1.2, 1.0), obstacle=[rock])
        surface = surface_of(case.obstacle[0])
        places = np.concatenate(filled(case))

        cells = cells_inside(surface, 0.1)
        assert len(places) == 12 * 12 * 5 - np.count_nonzero(cells[:, 2] < 5)
        place = fitted(case, places)
        distance = np.linalg.norm(place - nearest_points(surface, place)[0], axis=1)
        assert distance.min() > 0.025 - 1e-9
        assert np.linalg.norm(place - places, axis=1).max() < 0.025

    def test_a_box_on_the_lattice_moves_nothing(self):
        pier = PIER | {"x": [0.4, 0.7], "y": [0.3, 0.6], "z": [0.0, 0.3]}
        case = tank3d_case(size=(1.2, 0.8, 1.0), obstacle=[pier])
        place = np.concatenate(filled(case))

        np.testing.assert_array_equal(fitted(case, place), place)


@pytest.mark.parametrize(
    ("shift", "fastest", "mean"), [(0.0, 0.05, 0.02), (0.03, 0.3, 0.05), (0.05, 0.5, 0.1)]
)
def test_still_water_around_a_box_stays_still(shift, fastest, mean):
    # speeds in sqrt(g d0), about 1 m/s
    ends = {axis: [at + shift, at + 0.3 + shift] for axis, at in (("x", 0.4), ("y", 0.3))}
    box = PIER | ends | {"z": [0.0, 0.3 + shift]}
    scheme, state = started(tank3d_case(z=(0.0, 0.6), size=(1.2, 0.8, 1.0), obstacle=[box]))
    count, speeds = state.particles.fluid_count, []
    while state.time < 0.1:
        advance(scheme, state, steps=1)
        speeds.append(np.linalg.norm(state.particles.velocity[state.particles.fluid], axis=1))
    assert np.max(speeds) < fastest
    assert np.sqrt(np.mean(np.square(speeds), axis=1)).max() < mean
    assert state.particles.fluid_count == count


class TestReport:
    def test_check_prints_a_table_of_what_differs(self, martin):
        told = CliRunner().invoke(main, ["check", str(martin)]).output.splitlines()

        head = next(k for k, line in enumerate(told) if line.startswith("built to the spacing"))
        assert told[head].split()[-3:] == ["asked", "built", "difference"]
        rows = [line.split() for line in told[head + 1 :]]
        assert rows[0] == ["geometry.length", "0.584", "m", "0.58", "m", "-0.7%"]
        assert rows[-2] == ["fill.0,", "area", "0.021316", "m2", "0.0225", "m2", "+5.6%"]

    def test_of_an_end_of_an_extent_the_share_is_that_of_the_extent(self):
        block = {"type": "block", "x": [0.04, 0.5], "y": [0.0, 0.6], "z": [0.0, 0.4]}
        case = tank3d_case(size=(0.6, 0.6, 1.0), fill=[block | {"material": "water"}])
        (row,) = roundings(case)

        assert (row.key, row.asked, row.built) == ("fill.0.x.0", 0.04, 0.0)
        assert str(row).split()[-1] == "-8.7%"  # of 0.46 m, not all of 0.04 m

    def test_check_says_nothing_where_nothing_differs(self, martin):
        martin.write_text(MARTIN.replace("0.146", "0.15").replace("0.584", "0.58"))

        assert "asked" not in CliRunner().invoke(main, ["check", str(martin)]).output

    def test_a_run_notes_it_in_its_log(self, martin, tmp_path):
        simulate(load_case(martin), tmp_path / "run", threads=1)

        assert "geometry.length                0.584 m" in (tmp_path / "run/run.log").read_text()
        assert logging.getLogger("debrisflow").handlers == []

    def test_the_volume_of_a_fill_around_a_box_is_told_where_it_is_off(self):
        case = tank3d_case(
            z=(0.0, 0.4),
            size=(0.6, 0.6, 1.0),
            obstacle=[PIER | {"x": [0.14, 0.44], "y": [0.14, 0.44], "z": [0.0, 0.34]}],
        )
        (row,) = differences(case)

        assert row.key == "fill.0, volume"
        assert row.asked == pytest.approx(0.6 * 0.6 * 0.4 - 0.3 * 0.3 * 0.34)
        assert row.built == pytest.approx((6 * 6 * 4 - 3 * 3 * 3) * 1e-3)
