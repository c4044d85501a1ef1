"""Friction along walls that are surfaces: each law by hand, what it conserves, what it holds."""

import numpy as np
import pytest

from debrisflow.neighbors.boundary import FACES
from debrisflow.neighbors.lattice import reference
from debrisflow.physics.base_friction import (
    BaseFriction,
    Columns,
    Grid,
    friction_at,
    hold_along_walls,
    pressed_by,
    slow_along_walls,
    slowed_speed,
    survey_columns,
)
from debrisflow.schemes.terms.momentum_exchange import ENTRIES
from tests.building import Plane, lattice_block, planes

SPACING = 0.5
LATTICE = reference(3, 2.4, SPACING)
NONE = BaseFriction(*np.zeros((4, 2)))
FLOOR = Plane(normal=(0.3, 0.0, 0.9))
UP = np.array(FLOOR.normal) / np.linalg.norm(FLOOR.normal)
ALONG = np.array([UP[2], 0.0, -UP[0]])


def on_floor(*heights):
    """Return what particles over a tilted floor, which is wall 0, feel of it."""
    return planes(np.outer(heights, UP), LATTICE, FLOOR)


def of_law(**law):
    """Return the friction of wall 0."""
    fields = {name: np.array([law.get(name, 0.0), 0.0]) for name in BaseFriction._fields}
    return BaseFriction(**fields)


def columns(count, depth=2.0, speed=3.0, beside=1.0):
    return Columns(*(np.full(count, value) for value in (depth, speed, beside)))


def felt(height, velocity, reaction, friction, **column):
    """Return speed along the floor, sliding friction and drag of a particle over it."""
    solid = on_floor(height)
    pressed, *_ = pressed_by(0, 0, *reaction, solid)
    return friction_at(0, 0, *velocity, pressed, friction, columns(1, **column), SPACING, solid)


def test_sliding_friction_is_a_share_of_what_presses():
    law = of_law(sliding=0.4)
    for height in (0.2, 0.7, 1.0):  # whatever its height, as far as the wall pushes it
        speed, sliding, drag = felt(height, 2.0 * ALONG + UP, 7.0 * UP + 3.0 * ALONG, law)
        assert speed == pytest.approx(2.0, rel=1e-14)
        assert sliding == pytest.approx(0.4 * 7.0, rel=1e-13)
        assert drag == 0.0
    # what pulls does not press
    assert felt(0.2, 2.0 * ALONG, -7.0 * UP, law)[1] == 0.0


def test_the_drag_of_each_law_is_its_formula():
    fast = 2.0 * ALONG + 5.0 * UP  # what is across a wall does not count

    def drag(height=0.2, **law):
        return felt(height, fast, 0.0 * UP, of_law(**law))[2]

    wall = (0.41 / np.log(1.0 + 30.0 * 0.2 / 0.01)) ** 2 / SPACING
    assert drag(roughness=0.01) == pytest.approx(wall, rel=1e-13)
    mean = (3.0 / 2.0) ** 2  # the mean of the column tells the stress, not the particle
    depth = 2.0 * UP[2]  # across the floor
    assert drag(turbulent=0.05) == pytest.approx(0.05 * mean / (SPACING * UP[2]), rel=1e-13)
    manning = 0.02 * depth ** (-1.0 / 3.0) * mean / (SPACING * UP[2])
    assert drag(manning=0.02) == pytest.approx(manning, rel=1e-13)
    for law in ({"roughness": 0.01}, {"turbulent": 0.05}, {"manning": 0.02}):
        assert drag(1.01 * SPACING, **law) == 0.0


@pytest.mark.parametrize("b", [0.0, 0.3, 40.0])
def test_a_speed_after_a_step_solves_the_implicit_balance(b):
    for speed, sliding, dt in ((2.0, 0.5, 0.1), (0.01, 3.0, 0.001), (5.0, 0.0, 1.0)):
        after = slowed_speed(speed, sliding, b, dt)
        assert after + dt * (sliding + b * after**2) == pytest.approx(speed, rel=1e-12)
    assert slowed_speed(0.1, 3.0, b, 0.1) == 0.0


def test_what_is_across_the_wall_stays_and_what_friction_holds_stands_still():
    law, solid = of_law(sliding=0.5), on_floor(0.2, 0.2, 0.2, 5.0)
    reaction = np.tile(10.0 * UP, (4, 1))
    velocity = np.array([2.0 * ALONG - UP, 0.04 * ALONG - UP, -0.2 * ALONG, 2.0 * ALONG])
    slow_along_walls(0.01, reaction, law, columns(4), SPACING, solid, velocity)
    expected = np.array([1.95 * ALONG - UP, -UP, -0.15 * ALONG, 2.0 * ALONG])
    np.testing.assert_allclose(velocity, expected, atol=1e-14)


def test_the_exchange_of_momentum_is_held_by_the_same_friction():
    law, solid = of_law(sliding=0.5, roughness=0.01), on_floor(0.2)
    velocity, reaction = 1.5 * ALONG[None], 10.0 * UP[None]
    hold, carried = np.empty((1, 6)), np.empty((1, 3))
    hold_along_walls(0.01, velocity, reaction, law, columns(1), SPACING, solid, hold, carried)
    assert not carried.any()
    _, sliding, drag = friction_at(0, 0, *velocity[0], 10.0, law, columns(1), SPACING, solid)
    matrix = hold[0][ENTRIES]
    slowed = 0.01 * (sliding + drag * 1.5**2)
    np.testing.assert_allclose(matrix @ velocity[0], slowed * ALONG, atol=1e-14)
    np.testing.assert_allclose(matrix @ UP, 0.0, atol=1e-14)


def test_a_moving_wall_carries_along_what_it_holds():
    law, solid = of_law(sliding=0.5, roughness=0.01), on_floor(0.2)
    moving = solid._replace(velocity=np.tile(0.7 * ALONG, (1, FACES, 1)))
    velocity, reaction = 1.5 * ALONG[None], 10.0 * UP[None]
    hold, carried, still = np.empty((1, 6)), np.empty((1, 3)), np.empty((1, 6))
    hold_along_walls(0.01, velocity, reaction, law, columns(1), SPACING, moving, hold, carried)
    hold_along_walls(
        0.01, velocity - 0.7 * ALONG, reaction, law, columns(1), SPACING, solid, still, carried * 0
    )
    np.testing.assert_allclose(hold, still, rtol=1e-12)
    np.testing.assert_allclose(carried[0], 0.7 * hold[0][ENTRIES] @ ALONG, atol=1e-14)
    after = velocity.copy()
    slow_along_walls(0.01, reaction, law, columns(1), SPACING, moving, after)
    relative = velocity - 0.7 * ALONG
    slow_along_walls(0.01, reaction, law, columns(1), SPACING, solid, relative)
    np.testing.assert_allclose(after, relative + 0.7 * ALONG, atol=1e-14)


def test_in_a_corner_each_wall_holds_what_presses_on_it():
    walls = Plane(), Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    solid = planes(np.array([[0.0, 0.2, 0.2]]), LATTICE, *walls)
    law = NONE._replace(sliding=np.array([0.5, 0.2]))
    velocity, reaction = np.array([[2.0, 0.0, 0.0]]), np.array([[0.0, 3.0, 10.0]])
    slow_along_walls(0.1, reaction, law, columns(1), SPACING, solid, velocity)
    np.testing.assert_allclose(velocity, [[2.0 - 0.1 * (5.0 + 0.6), 0.0, 0.0]], atol=1e-14)
    hold, carried = np.empty((1, 6)), np.empty((1, 3))
    hold_along_walls(0.1, velocity, reaction, law, columns(1), SPACING, solid, hold, carried)
    held = hold[0][ENTRIES] @ velocity[0]
    np.testing.assert_allclose(held, [0.1 * (5.0 + 0.6), 0.0, 0.0], atol=1e-14)


@pytest.mark.parametrize("repeats", [False, True])
def test_columns_have_the_depth_and_speed_of_an_even_layer_up_to_the_ends(repeats):
    position = lattice_block(3, (12, 8, 3), SPACING)
    count = len(position)
    velocity = np.tile([3.0, 0.0, -4.0], (count, 1))
    next_to_wall = position[:, 2] < SPACING
    grid = Grid(
        lower=np.zeros(2),
        width=np.full(2, 2.0 * SPACING),
        shape=np.array([6, 4]),
        repeats=np.full(2, repeats),
    )
    found = columns(count)
    survey_columns(position, velocity, next_to_wall, grid, SPACING, np.zeros((6, 4, 5)), found)
    np.testing.assert_allclose(found.depth, 3.0 * SPACING, rtol=1e-13)
    np.testing.assert_allclose(found.speed, 5.0, rtol=1e-13)
    np.testing.assert_allclose(found.beside, 1.0, rtol=1e-13)
