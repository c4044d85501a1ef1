"""What is allowed and was hardly meant is told, and shipped cases have nothing of it."""

from pathlib import Path

import pytest

from debrisflow.case import load_case
from debrisflow.case.doubts import doubts
from debrisflow.run.forecast import forecast
from debrisflow.run.simulation import simulate
from tests.building import tank_case

CASES = sorted((Path(__file__).parents[2] / "cases").glob("*.toml"))


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ({"gravity": {"vector": [0.0, 9.81]}}, "gravity points upward, by 9.81 m/s2; down is"),
        ({"gravity": {"slope": 89.0}}, "gravity.slope = 89 degree: steeper than debris flows are"),
        ({"gravity": {"acceleration": 981.0}}, "gravity is 981 m/s2; on Earth it is 9.81 m/s2"),
        ({"water": {"density": 1.0}}, "water.density = 1 kg/m3: 1000 is usual"),
        ({"sediment": {"density": 2.65}}, "sediment.density = 2.65 kg/m3: 2650 is usual"),
        ({"time": {"end": 0.001}}, "output.interval = 1 s: longer than the run, time.end = 0.001"),
    ],
)
def test_what_was_hardly_meant_is_told_with_what_is_usual(tables, told):
    (line,) = doubts(tank_case(6, 6, "water", **tables))
    assert told in line
    assert f"warning        {line}" in str(forecast(tank_case(6, 6, "water", **tables)))


def test_more_grains_than_fit_are_told():
    path = next(path for path in CASES if path.stem == "settling2d")
    (line,) = doubts(load_case(path, ["fill.0.sediment_share=0.8"]))
    assert line.startswith("fill.0.sediment_share = 0.8: more grains than fit")


@pytest.mark.parametrize("rows", [1, 2])
def test_a_layer_of_one_row_is_told(rows):
    lines = doubts(tank_case(6, rows, "water", tank=(6, 12)))
    assert [line[:15] for line in lines] == ["fill.0: one row"] * (rows == 1)


def test_grains_larger_than_particles_are_told_where_they_collide():
    grains = {"sediment": {"grain_diameter": 0.02}}
    assert doubts(tank_case(6, 6, "sediment", **grains)) == []
    (line,) = doubts(tank_case(6, 6, "sediment", collision_stress={"enabled": True}, **grains))
    assert "grains larger than a particle" in line


def test_a_run_keeps_its_doubts_in_its_log(tmp_path):
    simulate(tank_case(6, 6, "water", time={"end": 0.001}), tmp_path / "run", threads=1)
    assert "WARNING output.interval = 1 s" in (tmp_path / "run" / "run.log").read_text()


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_shipped_cases_are_not_doubtful(path):
    assert doubts(load_case(path)) == []


@pytest.mark.parametrize(
    ("motion", "is_doubtful"),
    [
        ({"velocity": (0.0, 1.5)}, False),
        ({"velocity": (0.0, 1500.0)}, True),
        ({"time": (0.0, 0.001, 1.0), "y": (0.0, 0.9, 0.9)}, True),
        ({"time": (0.0, 1.0), "angle": (0.0, 10.0), "about": (0.5, 0.0)}, False),
    ],
)
def test_a_wall_that_shortens_the_step_by_ten_is_doubtful(motion, is_doubtful):
    gate = {"type": "box", "name": "gate", "x": (0.25, 0.3), "y": (0.0, 0.2), "motion": motion}
    told = [
        line
        for line in doubts(tank_case(20, 10, "water", (40, 30), obstacle=[gate]))
        if "gate" in line
    ]
    assert bool(told) == is_doubtful
    assert all(line.startswith("obstacle.gate.motion: up to ") for line in told)


LEG = [[0.2, 0.0], [0.3, 0.0], [0.3, 0.02], [0.207, 0.02], [0.207, 0.15], [0.2, 0.15]]


@pytest.mark.parametrize(
    ("corners", "is_doubtful"),
    [(LEG, True), ([[0.2, 0.0], [0.35, 0.0], [0.35, 0.1]], False)],
    ids=["leg", "wedge"],
)
def test_thin_parts_of_a_polygon_are_doubtful(corners, is_doubtful):
    part = {"type": "polygon", "name": "sill", "corners": corners}
    case = tank_case(10, 10, "water", (40, 30), obstacle=[part])
    assert any("thinner than a spacing" in line for line in doubts(case)) == is_doubtful
