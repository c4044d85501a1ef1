"""What moving obstacles run into is told by a check and in the log."""

import pytest

from debrisflow.case.doubts import doubts
from debrisflow.run.forecast import forecast
from debrisflow.space.encounters import encounters
from tests.building import tank3d_case, tank_case

GATE = {"type": "box", "name": "gate", "x": [0.1, 0.105], "y": [0.0, 0.2]}
SILL = {"type": "polygon", "name": "sill", "corners": [[0.2, 0.0], [0.3, 0.0], [0.3, 0.1]]}


def of(motion, *others, body=GATE, **tables):
    obstacle = [body | {"motion": motion}, *others]
    return tank_case(10, 10, "water", tank=(40, 30), obstacle=obstacle, **tables)


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        ({"velocity": [0.0, -1.0]}, "the wall at y = 0 m at t = 0.01 s"),
        ({"velocity": [-1.0, 0.0], "start": 0.2}, "the wall at x = 0 m at t = 0.31 s"),
        ({"velocity": [0.5, 0.0]}, "obstacle.sill at t = 0.195 s"),
    ],
)
def test_a_motion_into_a_wall_or_another_obstacle_is_told(motion, told):
    case = of(motion, SILL)
    first = encounters(case)[0]
    assert first == f"obstacle.gate: runs into {told}; what both share counts twice"
    assert f"warning        {first}" in str(forecast(case))


@pytest.mark.parametrize(
    "motion",
    [
        {"velocity": [0.0, 1.5], "start": 0.1},  # through the open top
        {"time": [0.0, 1.0], "x": [0.0, 0.09]},  # up to the sill
        {"time": [0.0, 1.0], "angle": [0.0, 30.0], "about": [0.1, 0.0]},  # a flap on the floor
    ],
)
def test_what_slides_or_leaves_runs_into_nothing(motion):
    assert encounters(of(motion, SILL)) == []


def test_beside_each_other_in_three_dimensions_nothing_is_met():
    gate = {"type": "box", "name": "gate", "x": [0.1, 0.2], "y": [0.0, 0.3], "z": [0.0, 0.4]}
    pier = gate | {"name": "pier", "x": [0.4, 0.5], "y": [0.3, 0.6]}
    moves = gate | {"motion": {"time": [0.0, 1.0], "x": [0.0, 0.3]}}
    assert encounters(tank3d_case(obstacle=[moves, pier])) == []
    (line,) = encounters(tank3d_case(obstacle=[moves, pier | {"y": [0.2, 0.6]}]))
    assert "obstacle.gate: runs into obstacle.pier" in line


def test_a_motion_after_the_end_is_told():
    (line,) = doubts(of({"velocity": [0.0, 1.0], "start": 5.0}, output={"interval": 0.1}))
    assert line.startswith("obstacle.gate.motion.start = 5 s: it never moves")
