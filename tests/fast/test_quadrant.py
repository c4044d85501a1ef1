"""Walls of two dimensions: sums over half planes and quadrants against rows of particles."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from debrisflow.neighbors import half_plane
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.quadrant import SUMS, box_sums, quadrants

RADIUS = 3.1
TABLE = quadrants(RADIUS)
FINE = 400  # places along a spacing of a row


def sums_over(points, weight):
    """Return all sums over points, (n, 2) array, each of a weight."""
    r = np.hypot(*points.T)
    inside = r < RADIUS
    (x, y), r = points[inside].T, r[inside]
    w, q = RADIUS / r - 1.0, RADIUS / r**3
    f, none = w / r**2, np.zeros_like(r)
    each = [w, none, f * x, f * y, none, f * x * x, f * y * y, none, f * x * y, none, none]
    each += [w * x / r, w * y / r, none, q * x, q * y, none]
    return weight * np.sum(each, axis=1)


def rows_along_y(x_from, y_from):
    """Return places along the rows of a quadrant that runs along y."""
    x = x_from + 0.5 + np.arange(5)
    y = y_from + (np.arange(8 * FINE) + 0.5) / FINE
    return np.array(list(product(x, y)))


def found_over(lower, upper):
    """Return the sums of a box, and whether it is a half plane."""
    total = np.empty(SUMS)
    ends = (np.array([*end, wall]) for end, wall in ((lower, -np.inf), (upper, np.inf)))
    return total, box_sums(*ends, total, TABLE)


@pytest.mark.parametrize("q", [0.0, 0.3, 0.5, 1.7, 2.9])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_half_plane_is_its_rows(q, axis, side):
    points = rows_along_y(q, -4.0)
    lower, upper = [-np.inf, -np.inf], [np.inf, np.inf]
    (lower if side > 0 else upper)[axis] = side * q
    points = points * [side, 1.0]
    expected = sums_over(points if axis == 0 else points[:, ::-1], 1.0 / FINE)
    found, is_half_plane = found_over(lower, upper)
    assert is_half_plane
    np.testing.assert_allclose(found, expected, atol=2e-3)


@pytest.mark.parametrize("q", [(0.5, 0.5), (0.3, 1.2), (2.0, 0.7)])
def test_a_quadrant_is_the_mean_of_rows_along_either_face(q):
    along = sums_over(rows_along_y(*q), 1.0 / FINE)
    across = sums_over(rows_along_y(q[1], q[0])[:, ::-1], 1.0 / FINE)
    found, is_half_plane = found_over(q, [np.inf, np.inf])
    assert not is_half_plane
    # the table is read between its steps
    np.testing.assert_allclose(found, 0.5 * (along + across), atol=0.01)


def test_beside_a_corner_quadrants_make_up_the_half_plane():
    for x, y in ((0.5, -0.4), (1.2, -1.7), (0.4, -2.8)):
        upper, _ = found_over([x, y], [np.inf, np.inf])
        lower, _ = found_over([x, -np.inf], [np.inf, y])
        whole, _ = found_over([x, -np.inf], [np.inf, np.inf])
        np.testing.assert_allclose(upper + lower, whole, atol=0.01)


def test_a_particle_on_the_lattice_before_a_wall_lacks_no_neighbor():
    lattice = reference(2, RADIUS, 1.0)
    for q in (0.5, 1.5, 2.5):
        above = [(x, y) for x in range(-4, 5) for y in range(-4, 5) if (x, y) != (0, 0)]
        fluid = sums_over(np.array([p for p in above if p[1] > -q], dtype=float), 1.0)
        wall, _ = found_over([-np.inf, -np.inf], [np.inf, -q])
        whole = fluid + wall
        # up to how much the lattice flickers along the wall, of which the rows are the mean
        assert whole[0] == pytest.approx(lattice.number_density, rel=2e-3)
        np.testing.assert_allclose(whole[[2, 3]], 0.0, atol=0.13)
        np.testing.assert_allclose(whole[[14, 15]], 0.0, atol=0.35)


def test_a_plate_one_spacing_thick_is_one_row():
    found, _ = found_over([-np.inf, 0.5], [np.inf, 1.5])
    whole = [half_plane.push_beyond(q, RADIUS) for q in (0.5, 1.5)]
    assert found[3] == pytest.approx(whole[0] - whole[1], rel=1e-2)
