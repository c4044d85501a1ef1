"""Rows of wall of any direction, and polygons that they fill."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from debrisflow.case.bodies import PolygonObstacle
from debrisflow.neighbors.quadrant import GX, HX, SUMS, TXX, TXY, TYY, VX, N
from debrisflow.neighbors.rows import add_row
from debrisflow.schemes.surfaces import walls_of
from debrisflow.space.polygons import in_polygon, push_off_polygon, sides_of
from debrisflow.space.walls import wall_points
from tests.building import tank_case
from tests.fast.test_quadrant import RADIUS, sums_over

FINE = 2000
SQUARE = ((0.4, 0.1), (0.6, 0.1), (0.6, 0.3), (0.4, 0.3))
WEDGE = ((0.5, 0.0), (0.9, 0.0), (0.9, 0.2))


def row(a, b, normal):
    total = np.zeros(SUMS)
    add_row(*a, *b, *normal, RADIUS, total)
    return total


def case_of(*obstacle, spacing=0.02):
    return tank_case(20, 10, "water", (60, 30), spacing, obstacle=obstacle)


def polygon(corners, name="sill", **more):
    return {"type": "polygon", "name": name, "corners": corners} | more


def felt(case, places):
    """Return what is felt of the walls of a case at places, (n, 2) array, m."""
    position = np.pad(np.array(places, dtype=float), ((0, 0), (0, 1)))
    surfaces = walls_of(case, 0.3)[0]
    surfaces.build(position, 0.3 * case.particles.spacing)
    return surfaces.survey(position)


@pytest.mark.parametrize("turn", [0.0, 0.6, 2.0, 4.1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_row_has_the_sums_of_the_points_along_it(turn, side):
    along, normal = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    share = (np.arange(FINE) + 0.5) / FINE
    a, b = -1.2 * along - 0.7 * side * normal, 0.9 * along - 0.7 * side * normal
    points = a + share[:, None] * (b - a)
    expected = sums_over(points, np.hypot(*(b - a)) / FINE)
    np.testing.assert_allclose(row(a, b, normal), expected, atol=2e-5)


def test_a_long_row_is_the_first_of_a_half_plane_and_parts_add_up():
    whole = row((-9.0, -2.9), (9.0, -2.9), (0.0, 1.0))
    half = np.sqrt(RADIUS**2 - 2.9**2)
    assert whole[N] == pytest.approx(2.0 * (RADIUS * np.arcsinh(half / 2.9) - half), rel=1e-12)
    parts = row((-9.0, -2.9), (0.1, -2.9), (0.0, 1.0)) + row((0.1, -2.9), (9.0, -2.9), (0.0, 1.0))
    np.testing.assert_allclose(whole, parts, atol=1e-14)
    np.testing.assert_array_equal(row((-1.0, -3.2), (1.0, -3.2), (0.0, 1.0)), 0.0)


def test_before_the_middle_of_a_side_a_square_is_felt_as_the_box_is():
    places = [(0.4 - d, 0.2) for d in (0.004, 0.01, 0.03)] + [(0.5, 0.3 + d) for d in (0.004, 0.02)]
    box = {"type": "box", "name": "sill", "x": (0.4, 0.6), "y": (0.1, 0.3)}
    ours, theirs = felt(case_of(polygon(SQUARE)), places), felt(case_of(box), places)
    assert (ours.faces == 1).all()
    for field in ("distance", "normal", "push"):
        found, expected = (getattr(one, field)[:, 0] for one in (ours, theirs))
        np.testing.assert_allclose(found, expected, atol=1e-9, rtol=1e-9, err_msg=field)
    np.testing.assert_allclose(ours.sums, theirs.sums, rtol=1e-9, atol=1e-9)


def test_a_polygon_is_felt_the_same_however_it_is_turned():
    middle, off = np.array([0.5, 0.3]), np.array([[-0.11, 0.0], [-0.105, 0.09], [0.0, -0.13]])
    square = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])
    c, s = np.cos(0.5), np.sin(0.5)
    turn = np.array([[c, -s], [s, c]])
    straight = felt(case_of(polygon((middle + square).tolist())), middle + off)
    turned = felt(case_of(polygon((middle + square @ turn.T).tolist())), middle + off @ turn.T)
    # one place lies in the line of a row, and counts as a little beside it
    for first in (GX, VX, HX):
        expected = straight.sums[:, first : first + 2] @ turn.T
        np.testing.assert_allclose(turned.sums[:, first : first + 2], expected, rtol=1e-3, atol=0.2)
    np.testing.assert_allclose(turned.sums[:, N], straight.sums[:, N], rtol=1e-3)
    trace = [one.sums[:, TXX] + one.sums[:, TYY] for one in (straight, turned)]
    np.testing.assert_allclose(trace[1], trace[0], rtol=1e-3)
    assert not np.allclose(turned.sums[:, TXY], straight.sums[:, TXY], atol=1e-3)
    np.testing.assert_allclose(turned.normal[:, 0, :2], straight.normal[:, 0, :2] @ turn.T)


@pytest.mark.parametrize("corners", [SQUARE, SQUARE[::-1], WEDGE])
def test_rows_fill_a_polygon_and_lie_in_it(corners):
    case = case_of(polygon(corners), spacing=0.01)
    sides = sides_of(case)
    rows, shape = sides.ends[~sides.is_face], shapely.Polygon(corners)
    assert shapely.covers(shape, shapely.linestrings(rows)).all()
    # under the surface of the polygon and the walls that it touches, floor and right wall
    walls = shapely.box(-1.0, -1.0, 2.0, 0.0), shapely.box(0.6, -1.0, 2.0, 1.0)
    whole = shapely.union_all([shape, *walls])
    reached = (shape - whole.buffer(-0.04, join_style="mitre")).area
    length = np.linalg.norm(rows[:, 1] - rows[:, 0], axis=1).sum()
    assert 0.01 * length == pytest.approx(reached, rel=0.02)
    drawn = wall_points(case)
    assert in_polygon(PolygonObstacle(**polygon(corners)), drawn.position[drawn.name == 7]).all()


def test_what_lies_on_a_wall_is_no_face_unless_it_moves():
    motion = {"velocity": (0.0, 0.1)}
    still, moving = (sides_of(case_of(polygon(WEDGE, **more))) for more in ({}, {"motion": motion}))
    base = [np.all(np.abs(sides.ends[sides.is_face][:, :, 1]) < 1e-9) for sides in (still, moving)]
    assert not any(base)
    lengths = [
        np.linalg.norm(np.diff(sides.ends[sides.is_face], axis=1), axis=2).sum()
        for sides in (still, moving)
    ]
    assert lengths[1] - lengths[0] == pytest.approx(0.4)


def test_particles_start_outside_a_polygon_and_not_too_near():
    part = PolygonObstacle(**polygon(WEDGE))
    places = np.zeros((500, 3))
    places[:, :2] = np.random.default_rng(1).uniform(0.3, 1.0, (500, 2)) * [1.0, 0.3]
    places = places[~in_polygon(part, places)]
    before, shape = places.copy(), shapely.Polygon(WEDGE)
    push_off_polygon(places, part, 0.01)
    apart = shapely.distance(shapely.points(places[:, :2]), shape)
    assert apart.min() >= 0.01 * (1.0 - 1e-9)
    far = shapely.distance(shapely.points(before[:, :2]), shape) >= 0.01
    np.testing.assert_array_equal(places[far], before[far])
    assert not far.all()
