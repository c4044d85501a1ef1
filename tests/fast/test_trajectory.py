"""Where obstacles are that move, and how fast they are."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.case.motion import Motion
from debrisflow.results.pictures.panels import plan_obstacles
from debrisflow.space.domain import domain
from debrisflow.space.scene import faces_with_images
from debrisflow.space.trajectory import Trajectory
from tests.building import tank3d_case, tank_case

CORNERS = {
    2: np.array([[0.4, 0.0, 0.0], [0.5, 0.0, 0.0], [0.4, 0.3, 0.0], [0.5, 0.3, 0.0]]),
    3: np.array([[x, y, z] for x in (0.4, 0.5) for y in (0.1, 0.3) for z in (0.0, 0.3)]),
}
CASES = {2: tank_case(20, 10, "water", spacing=0.05), 3: tank3d_case()}


def way_of(dimension, **motion):
    return Trajectory(Motion(**motion), CORNERS[dimension], CASES[dimension])


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_drawn_gate_waits_moves_and_is_gone(dimension):
    velocity = np.zeros(dimension)
    velocity[-1] = 2.0
    way = way_of(dimension, velocity=tuple(velocity), start=0.2)
    up = np.eye(3)[dimension - 1]
    np.testing.assert_array_equal(way.pose(0.2).displacement, 0.0)
    assert way.speed(0.1) == 0.0
    np.testing.assert_allclose(way.pose(0.3).displacement, 0.2 * up)
    np.testing.assert_allclose(way.velocity(0.3)[0], 2.0 * up)
    later, much_later = way.pose(50.0), way.pose(1e6)
    np.testing.assert_array_equal(later.displacement, much_later.displacement)
    height = CASES[dimension].geometry.height
    assert later.moved(CORNERS[dimension])[:, dimension - 1].min() > height
    assert way.speed(50.0) == 0.0


def test_a_gate_that_has_been_drawn_is_not_seen_from_above():
    gate = {"type": "box", "name": "gate", "x": (0.4, 0.5), "y": (0.0, 0.6), "z": (0.0, 0.6)}
    pier = gate | {"name": "pier", "x": (0.6, 0.7), "z": (0.0, 0.3)}
    drawn = gate | {"motion": {"velocity": (0.0, 0.0, 2.0)}}
    case = tank3d_case(z=(0.0, 0.3), obstacle=[drawn, pier])
    gone = 0.5 * case.geometry.height + 0.01  # s
    before, after = (plan_obstacles(case, time) for time in (0.0, gone))
    assert {face[:, 0].min().round(6) for face in before} >= {0.4, 0.6}
    assert min(face[:, 0].min() for face in after) == pytest.approx(0.6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_in_a_space_that_repeats_it_goes_round_any_number_of_times(dimension):
    axis = dimension - 2  # a tank of three dimensions repeats along y
    box = {"type": "box", "name": "sill", "x": (0.3, 0.4), "y": (0.0, 0.1), "z": (0.0, 0.1)}
    if dimension == 2:
        box.pop("z")
        case = tank_case(20, 10, "water", spacing=0.05, obstacle=[box])
    else:
        case = tank3d_case(size=(0.8, 1.2, 1.0), obstacle=[box])
    case = case.model_copy(update={"geometry": case.geometry.model_copy(update={"periodic": True})})
    period = domain(case).period[axis]
    way = Trajectory(Motion(velocity=tuple(np.eye(dimension)[axis])), CORNERS[dimension], case)
    for round_ in (0.0, 1.0, 7.0):
        place = way.pose((round_ + 0.3) * period).displacement[axis]
        assert place == pytest.approx(0.3 * period)
    assert way.speed(9.0 * period) == pytest.approx(1.0)


def test_what_crosses_the_end_of_a_space_that_repeats_is_seen_at_both_ends():
    sill = {"type": "box", "name": "sill", "x": (0.3, 0.5), "y": (0.0, 0.1)}
    moves = sill | {"motion": {"velocity": (1.0, 0.0)}}
    case = tank_case(20, 10, "water", spacing=0.05, obstacle=[moves])
    case = case.model_copy(update={"geometry": case.geometry.model_copy(update={"periodic": True})})
    for time, ends in ((0.1, [(0.4, 0.6)]), (0.6, [(-0.1, 0.1), (0.9, 1.1)])):
        faces = faces_with_images(case, time)
        seen = sorted((one[..., 0].min(), one[..., 0].max()) for one in faces)
        np.testing.assert_allclose(seen, ends, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_table_passes_its_rows_and_then_stands_still(dimension):
    way = way_of(dimension, time=(0.0, 0.5, 0.8), x=(0.0, 0.1, 0.05))
    for time, x in ((0.0, 0.0), (0.5, 0.1), (0.8, 0.05), (9.0, 0.05)):
        np.testing.assert_allclose(way.pose(time).displacement, [x, 0.0, 0.0], atol=1e-15)
    assert way.speed(0.8) == way.speed(9.0) == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_a_velocity_is_the_change_of_the_place(dimension, seed):
    rng = np.random.default_rng(seed)
    time = rng.uniform(0.05, 0.9)
    x, angle = rng.uniform(-0.2, 0.2, 3), rng.uniform(-40.0, 40.0, 3)
    way = way_of(
        dimension,
        time=(0.0, 0.3, 0.6, 1.0),
        x=(0.0, *x),
        angle=(0.0, *angle),
        about=(0.45, 0.1),
    )
    places, tiny = CORNERS[dimension], 1e-6
    before, after = (way.pose(time + sign * tiny).moved(places) for sign in (-1.0, 1.0))
    velocity, spin = way.velocity(time)
    pose = way.pose(time)
    arms = pose.moved(places) - pose.axis - pose.displacement
    found = velocity + np.cross(spin, arms)
    np.testing.assert_allclose(found, (after - before) / (2.0 * tiny), atol=1e-4)
    assert way.speed(time) == pytest.approx(np.linalg.norm(found, axis=1).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_turns_by_a_right_angle_turns_from_x_upward(dimension):
    way = way_of(dimension, time=(0.0, 1.0), angle=(0.0, 90.0), about=(0.4, 0.0))
    along = np.array([[0.5, 0.0, 0.0]])
    up = np.eye(3)[dimension - 1]
    np.testing.assert_allclose(
        way.pose(1.0).moved(along)[0], np.array([0.4, 0.0, 0.0]) + 0.1 * up, atol=1e-12
    )


def test_what_slides_along_x_keeps_the_faces_along_which_it_slides():
    assert way_of(3, velocity=(1.0, 0.0, 0.0)).axes == {0}
    assert way_of(3, time=(0.0, 1.0), z=(0.0, 0.1)).axes == {2}
    assert way_of(3, time=(0.0, 1.0), angle=(0.0, 1.0), about=(0.0, 0.0)).axes == {0, 2}
