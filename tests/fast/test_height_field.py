"""Ground over a plan: its surface, and what particles feel of it."""

import numpy as np
import pytest
from scipy.integrate import quad

from debrisflow.neighbors import half_space
from debrisflow.neighbors.boundary import wall_sums_at
from debrisflow.neighbors.half_space import PULLED_BACK, STRETCH
from debrisflow.neighbors.height_field import foot_on, ground_at, height_field, levels_at
from debrisflow.neighbors.lattice import reference
from tests.building import Plane, boxes_from, felt, planes

LATTICE = reference(3, 2.4, 1.0)
RADIUS, CELL, COUNT = 2.4, 2.0, 40
NOWHERE_NEAR = boxes_from([900.0] * 3, [901.0] * 3)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def ground(level, cell=CELL, count=COUNT):
    """Return the ground whose level is a function of x and y, about the origin."""
    middle = (np.arange(count) - 0.5 * (count - 1)) * cell
    levels = level(*np.meshgrid(middle, middle, indexing="ij"))
    return height_field(levels, cell, (-0.5 * count * cell,) * 2, number=0)


def plane(slope, turn, level=0.3):
    """Return the ground that is a plane, and the plane."""
    x, y = np.tan(slope) * np.cos(turn), np.tan(slope) * np.sin(turn)
    normal = np.array([-x, -y, 1.0]) * np.cos(slope)
    return ground(lambda a, b: level + x * a + y * b), Plane((0.0, 0.0, level), tuple(normal))


def sphere(radius, sign):
    """Return a ground that is part of a sphere around (0, 0, sign * radius), and lowest there."""

    def level(a, b):
        return sign * (radius - np.sqrt(np.maximum(radius**2 - a**2 - b**2, 0.0)))

    return ground(level, 0.25, 60)


def test_the_surface_goes_through_the_values_of_its_cells(rng):
    levels = rng.normal(size=(9, 7))
    field = height_field(levels, 2.0, (10.0, -4.0), 0)
    x, y = np.meshgrid(11.0 + 2.0 * np.arange(9), -3.0 + 2.0 * np.arange(7), indexing="ij")
    found = np.empty(levels.size)
    levels_at(x.ravel(), y.ravel(), field, found)
    np.testing.assert_allclose(found, levels.ravel(), atol=1e-12)


def test_slopes_and_curvatures_are_derivatives_of_the_level(rng):
    field = height_field(rng.normal(size=(9, 7)), 2.0, (0.0, 0.0), 0)
    step = 1e-4
    for x, y in rng.uniform(3.0, 11.0, (50, 2)):
        _, zx, zy, xx, xy, yy = ground_at(x, y, field)
        along, across = (
            [ground_at(x + s, y, field) for s in (-step, step)],
            [ground_at(x, y + s, field) for s in (-step, step)],
        )
        assert (along[1][0] - along[0][0]) / (2 * step) == pytest.approx(zx, abs=1e-7)
        assert (across[1][0] - across[0][0]) / (2 * step) == pytest.approx(zy, abs=1e-7)
        if abs(x / 2 % 1.0) > 0.01 and abs(y / 2 % 1.0) > 0.01:  # it jumps between cells
            assert (along[1][1] - along[0][1]) / (2 * step) == pytest.approx(xx, abs=1e-6)
            assert (across[1][2] - across[0][2]) / (2 * step) == pytest.approx(yy, abs=1e-6)
        assert (across[1][1] - across[0][1]) / (2 * step) == pytest.approx(xy, abs=1e-6)


@pytest.mark.parametrize("slope", [0.0, 0.3, 0.8])
def test_on_a_plane_particles_feel_the_half_space_under_it(slope, rng):
    field, wall = plane(slope, 0.7)
    position = rng.uniform(-8.0, 8.0, (400, 3))
    position[:, 2] = rng.uniform(-1.0, 3.0, 400) + position[:, 0] * np.tan(slope) * np.cos(0.7)
    position[:, 2] += position[:, 1] * np.tan(slope) * np.sin(0.7)
    found = felt(position, LATTICE, NOWHERE_NEAR, ground=field)
    exact = planes(position, LATTICE, wall)
    np.testing.assert_array_equal(found.row >= 0, exact.row >= 0)
    np.testing.assert_allclose(found.sums, exact.sums, atol=3e-3)  # that of a table
    np.testing.assert_allclose(found.distance[:, 0], exact.distance[:, 0], atol=1e-9)
    np.testing.assert_allclose(found.normal[:, 0], exact.normal[:, 0], atol=1e-9)
    np.testing.assert_allclose(found.push[:, 0], exact.push[:, 0], atol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_over_a_bowl_and_a_dome_the_foot_is_the_nearest_point(sign, rng):
    field = sphere(10.0, sign)
    for x, y in rng.uniform(-4.0, 4.0, (50, 2)):
        height = rng.uniform(0.0, 2.0)
        center = np.array([0.0, 0.0, sign * 10.0])
        level = ground_at(x, y, field)[0]
        place = np.array([x, y, level])
        outward = (center - place) * sign / 10.0
        place = place + height * outward
        distance, *normal, curvature = foot_on(*place, field)
        assert distance == pytest.approx(height, abs=2e-3)
        np.testing.assert_allclose(normal, outward, atol=5e-3)
        assert curvature == pytest.approx(sign * 0.1, rel=0.05)


def of_ball(distance, radius, sign, integrand):
    """Return the integral of f(r, r_n) over the solid around a ball or in a ball, as seen."""
    distance = STRETCH * (distance + PULLED_BACK)
    center = radius - distance if sign > 0 else -(radius + distance)  # along the normal, upward

    def over(r):
        # of the directions at r whose point is in the solid: cosine to the normal below a bound
        bound = (radius**2 - r * r - center**2) / (-2.0 * r * center)
        if sign > 0:  # outside the ball: |r - c| > radius
            low, high = -1.0, np.clip(bound if center > 0 else -bound, -1.0, 1.0)
        else:  # inside the ball
            low, high = -1.0, np.clip(bound, -1.0, 1.0)
        return 2.0 * np.pi * r * r * quad(lambda u: integrand(r, -r * u), low, high)[0]

    return quad(over, 1e-9, RADIUS, limit=200)[0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("height", [0.5, 1.5])
def test_the_curvature_gives_what_a_plane_lacks(sign, height):
    field = sphere(10.0, sign)
    position = np.array([[0.0, 0.0, height]])
    solid = felt(position, LATTICE, NOWHERE_NEAR, ground=field)
    n, m, _, _, push, *_ = wall_sums_at(0, solid)
    q = STRETCH * (height + PULLED_BACK)
    flat = (
        half_space.number_density_beyond(q, RADIUS),
        half_space.smooth_density_beyond(q, RADIUS),
        half_space.push_beyond(q, RADIUS),
    )
    exact = (
        of_ball(height, 10.0, sign, lambda r, _: RADIUS / r - 1.0),
        of_ball(height, 10.0, sign, lambda r, _: (1.0 - r / RADIUS) ** 2),
        of_ball(height, 10.0, sign, lambda r, across: (RADIUS / r - 1.0) * across / r**2),
    )
    for found, plain, true in zip((n, m, -push), flat, exact, strict=True):
        assert abs(true / plain - 1.0) > 0.03
        assert abs(found - true) < 0.2 * abs(plain - true)
