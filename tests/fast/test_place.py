"""Which wall a lost particle went through, in words."""

import numpy as np
import pytest

from debrisflow.particles.place import wall_passed
from tests.building import tank3d_case, tank_case

PILLAR = {"type": "box", "name": "pillar", "x": [0.4, 0.5], "y": [0.1, 0.2], "z": [0.0, 0.3]}
GATE = {
    "type": "box",
    "name": "gate",
    "x": [0.6, 0.65],
    "y": [0.0, 0.6],
    "z": [0.0, 0.4],
    "motion": {"velocity": [0.0, 0.0, 1.0]},
}


@pytest.mark.parametrize(
    ("place", "wall"),
    [
        ((0.05, -0.02), "the floor"),
        ((-0.02, 0.05), "wall left"),
        ((0.17, 0.05), "wall right"),
    ],
)
def test_walls_of_a_tank_in_two_dimensions(place, wall):
    case = tank_case(8, 8, "water", tank=(16, 16))
    assert wall_passed(case, np.array([*place, 0.0]), 0.0) == wall


@pytest.mark.parametrize(
    ("place", "time", "wall"),
    [
        ((0.45, 0.15, 0.1), 0.0, "obstacle pillar"),
        ((0.45, 0.15, -0.1), 0.0, "the floor"),
        ((0.3, -0.1, 0.2), 0.0, "wall front"),
        ((0.3, 0.7, 0.2), 0.0, "wall back"),
        ((0.62, 0.3, 0.1), 0.0, "obstacle gate"),
        ((0.62, 0.3, 0.1), 0.4, "a wall"),  # the gate has been drawn
    ],
)
def test_walls_and_obstacles_in_three_dimensions(place, time, wall):
    case = tank3d_case(particles={"spacing": 0.05}, obstacle=[PILLAR, GATE])
    assert wall_passed(case, np.array(place), time) == wall
