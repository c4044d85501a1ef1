"""Walls of boxes as surfaces: their sums over half spaces and boxes, and their faces."""

import numpy as np
import pytest
from scipy.integrate import quad

from debrisflow.neighbors import half_space
from debrisflow.neighbors.boundary import (
    face_at,
    face_count,
    rebounded,
    wall_sums_at,
)
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.octant import SUMS, box_sums, octants
from debrisflow.schemes.surfaces import walls_of
from tests.building import (
    Plane,
    boxes_from,
    felt,
    frame_of,
    planes,
    tank3d_case,
)

RADIUS = 2.4
LATTICE = reference(3, RADIUS, 1.0)
SINGLE = 1e-6  # the table is kept in single precision


@pytest.fixture
def rng():
    return np.random.default_rng(61)


def turn_of(rng):
    """Return a rotation anywhere."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def matrix(sums):
    """Return T, (3, 3) array, of the sums of a particle."""
    xx, yy, zz, xy, xz, yz = sums[5:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def felt_sums(position, boxes, **known):
    """Return the sums of each particle over boxes, (n, 11) array."""
    solid = felt(position, LATTICE, boxes, np.zeros(len(boxes.origin)), **known)
    return np.array([wall_sums_at(i, solid) for i in range(len(position))])


# ---- half spaces


def beyond(integrand, q, radius):
    """Return the integral of a function of r over the half space beyond q.

    The function takes the distance r and the least cosine with the normal.
    """
    whole = quad(lambda r: integrand(r, -1.0), 0.0, -q)[0] if q < 0.0 else 0.0
    return whole + quad(lambda r: integrand(r, q / r), abs(q), radius, epsabs=1e-12)[0]


FORMS = {
    "number_density_beyond": lambda r, u: (RADIUS / r - 1.0) * r**2 * (1.0 - u),
    "smooth_density_beyond": lambda r, u: (1.0 - r / RADIUS) ** 2 * r**2 * (1.0 - u),
    "push_beyond": lambda r, u: (RADIUS / r - 1.0) * r * (1.0 - u**2) / 2.0,
    "across_beyond": lambda r, u: (RADIUS / r - 1.0) * r**2 * (1.0 - u**3) / 3.0,
    "lever_beyond": lambda r, u: (RADIUS / r - 1.0) * r**3 * (1.0 - u**2) / 2.0,
}


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("q", [-1.0, -0.3, -1e-3, 0.0, 1e-3, 0.2, 0.5, 1.3, 2.39, 2.4, 3.0])
def test_the_sums_over_a_half_space_are_integrals(name, q):
    if name == "lever_beyond" and q < 0.0:
        return  # not asked for inside
    expected = 0.0 if q >= RADIUS else 2.0 * np.pi * beyond(FORMS[name], q, RADIUS)
    assert getattr(half_space, name)(q, RADIUS) == pytest.approx(expected, rel=1e-9, abs=1e-10)


# ---- boxes


def box_integrals(lower, upper, points=48):
    """Return the sums of a box about the origin, in spacings, by Gauss' rule."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    axes = []
    for low, high in zip(np.maximum(lower, -RADIUS), np.minimum(upper, RADIUS), strict=True):
        half = max(0.5 * (high - low), 0.0)
        axes.append((0.5 * (low + high) + half * nodes, half * weights))
    x, y, z = np.meshgrid(*(place for place, _ in axes), indexing="ij")
    volume = np.einsum("i,j,k->ijk", *(part for _, part in axes))
    r = np.sqrt(x * x + y * y + z * z)
    w = volume * np.maximum(RADIUS / r - 1.0, 0.0)
    f = w / (r * r)
    smooth = volume * np.where(r < RADIUS, (1.0 - r / RADIUS) ** 2, 0.0)
    terms = [w, smooth, f * x, f * y, f * z, f * x * x, f * y * y, f * z * z]
    return np.array([term.sum() for term in [*terms, f * x * y, f * x * z, f * y * z]])


def sums_of(lower, upper):
    """Return the sums of a box about the origin, in spacings."""
    total = np.empty(SUMS)
    box_sums(np.array(lower, dtype=float), np.array(upper, dtype=float), total, octants(RADIUS))
    return total


def boxes_in_front(rng, count):
    """Yield the ends of boxes that a particle at the origin stands outside of, by 0.3 or more."""
    for k in range(count):
        lower = rng.uniform(-3.0, 1.0, 3)
        upper = lower + rng.uniform(0.3, 4.0, 3)
        beyond = 1 + k % 3  # in front of a face, an edge, a corner
        for axis in rng.permutation(3)[:beyond]:
            gap, wide = rng.uniform(0.3, 1.2), rng.uniform(0.3, 4.0)
            lower[axis], upper[axis] = (gap, gap + wide) if k % 2 else (-gap - wide, -gap)
        for axis in range(3):
            if rng.random() < 0.3:
                upper[axis] = np.inf if upper[axis] > 0.0 and lower[axis] > -3.0 else upper[axis]
        yield lower, upper


def test_the_sums_over_a_box_are_integrals(rng):
    # the table is linear between steps of a tenth of a spacing; of a half space N is 7, G and T 4
    for lower, upper in boxes_in_front(rng, 60):
        expected = box_integrals(lower, upper)
        np.testing.assert_allclose(sums_of(lower, upper), expected, atol=0.01)


def test_a_box_in_two_parts_has_the_sums_of_the_whole(rng):
    for lower, upper in boxes_in_front(rng, 60):
        axis = rng.integers(3)
        ends = np.maximum(lower[axis], -RADIUS), np.minimum(upper[axis], RADIUS)
        below, above = upper.copy(), lower.copy()
        below[axis] = above[axis] = rng.uniform(*ends)
        parts = sums_of(lower, below) + sums_of(above, upper)
        np.testing.assert_allclose(parts, sums_of(lower, upper), atol=20.0 * SINGLE)


def test_a_half_space_in_octants_has_the_sums_of_its_closed_form():
    for q in np.linspace(-1.0, RADIUS, 35):
        lower, upper = np.array([-np.inf, -np.inf, q]), np.full(3, np.inf)
        middle = np.array([np.inf, 0.3, np.inf])
        parts = sums_of(lower, middle) + sums_of(np.array([-np.inf, 0.3, q]), upper)
        # the push has a steep peak where the particle is on the surface
        atol = 0.006 if abs(q) > 0.3 else 0.1
        np.testing.assert_allclose(parts, sums_of(lower, upper), atol=atol)


def test_a_box_out_of_reach_has_no_sums():
    for lower in ([2.4, -1.0, -1.0], [-9.0, -3.5, 0.0]):
        np.testing.assert_array_equal(sums_of(lower, np.array(lower) + 1.0), 0.0)


def test_the_sums_of_a_turned_box_are_turned(rng):
    for lower, upper in boxes_in_front(rng, 20):
        turn, place = turn_of(rng), rng.normal(size=(1, 3))
        (upright,) = felt_sums(place * 0.0, boxes_from(lower, upper))
        # the rows of the axes are unit vectors along the box
        turned = boxes_from(lower, upper, origin=place, axes=turn.T[None])
        (found,) = felt_sums(place, turned)
        np.testing.assert_allclose(found[:2], upright[:2], atol=1e-10)
        np.testing.assert_allclose(found[2:5], turn @ upright[2:5], atol=1e-10)
        np.testing.assert_allclose(matrix(found), turn @ matrix(upright) @ turn.T, atol=1e-10)


def test_the_sums_scale_with_the_spacing(rng):
    place, lower, upper = np.zeros((1, 3)), np.array([-0.2, 0.4, -3.0]), np.array([0.9, 2.0, 1.0])
    (one,) = felt_sums(place, boxes_from(lower, upper))
    small = reference(3, RADIUS, 0.01)
    solid = felt(place, small, boxes_from(0.01 * lower, 0.01 * upper))
    found = np.array(wall_sums_at(0, solid))
    found[2:5] *= 0.01  # G in 1/m
    np.testing.assert_allclose(found, one, atol=1e-9)


def test_where_parts_of_a_floor_meet_the_nearest_counts_alone():
    # a bend that rises by 30 degrees at x = 0
    rise = np.radians(30.0)
    normals = [(0.0, 0.0, 1.0), (-np.sin(rise), 0.0, np.cos(rise))]
    ends = [-np.inf] * 3, [np.inf, np.inf, 0.0]
    floors = [boxes_from(*ends, axes=[frame_of(normal)], is_floor=[True]) for normal in normals]
    both = boxes_from(
        np.tile(ends[0], (2, 1)),
        np.tile(ends[1], (2, 1)),
        axes=[frame_of(normal) for normal in normals],
        is_floor=[True, True],
    )
    for x, nearest in ((-1.0, 0), (1.0, 1)):
        place = np.array([[x, 0.0, 0.5 + max(x, 0.0) * np.tan(rise)]])
        np.testing.assert_array_equal(felt_sums(place, both), felt_sums(place, floors[nearest]))
        solid = felt(place, LATTICE, both, np.zeros(2))
        assert face_count(0, solid) == 1  # the other goes on beneath it
        assert face_at(0, 0, solid)[4] == nearest


# ---- faces


def faces_of(place, boxes, **known):
    """Return distance, normal and number of the faces that a place stands in front of."""
    place = np.array([place], dtype=float)
    solid = felt(place, LATTICE, boxes, np.zeros(len(boxes.origin)), **known)
    found = [face_at(0, f, solid) for f in range(face_count(0, solid))]
    return [(face[0], np.array(face[1:4]), face[4]) for face in found]


def the_face_of(place, boxes):
    """Return the only face that a place stands in front of."""
    ((distance, normal, number),) = faces_of(place, boxes)
    assert np.linalg.norm(normal) == pytest.approx(1.0, rel=1e-14)
    return distance, normal, number


def numbered():
    """Return a unit box about the origin of which each face is a wall of its own."""
    return boxes_from([-0.5] * 3, [0.5] * 3, number=np.arange(6).reshape(1, 3, 2))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_face_of_a_box_has_distance_normal_and_number(axis, side):
    out, aside = side * np.eye(3)[axis], 0.4 * (1.0 - np.eye(3)[axis])
    number = 2 * axis + (side > 0.0)
    for height in (1.2, 0.3, 1e-9, -0.05):  # in front of it, and under it
        place = (0.5 + height) * out + aside
        distance, normal, found = the_face_of(place, numbered())
        assert distance == pytest.approx(height, abs=1e-14)
        np.testing.assert_allclose(normal, out, atol=1e-14)
        assert found == number
    assert faces_of((0.5 + RADIUS + 0.01) * out, numbered()) == []


@pytest.mark.parametrize("out", [(0.3, 0.4, 0.0), (0.0, -0.4, 0.3), (0.2, -0.3, 0.6)])
def test_off_an_edge_or_corner_the_normal_leads_from_the_nearest_point(out):
    out = np.array(out)
    place = out + 0.5 * np.sign(out)
    distance, normal, number = the_face_of(place, numbered())
    assert distance == pytest.approx(np.linalg.norm(out), rel=1e-14)
    np.testing.assert_allclose(normal, out / distance, rtol=1e-14, atol=1e-14)
    # of the face whose plane is the farthest below
    axis = np.argmax(np.abs(out))
    assert number == 2 * axis + (out[axis] > 0.0)


def test_the_nearest_of_the_faces_come_first_and_the_fourth_is_left_out(rng):
    normals = np.concatenate([np.eye(3), [[0.0, 0.0, -1.0]]])
    heights = np.array([0.9, 0.3, 0.6, 1.4])
    position = np.zeros((1, 3))
    for order in (rng.permutation(4) for _ in range(6)):
        walls = [Plane(-heights[k] * normals[k], normals[k]) for k in order]
        solid = planes(position, LATTICE, *walls)
        found = [face_at(0, f, solid) for f in range(face_count(0, solid))]
        np.testing.assert_allclose([face[0] for face in found], [0.3, 0.6, 0.9], rtol=1e-14)
        assert [order[face[4]] for face in found] == [1, 2, 0]


@pytest.mark.parametrize("x", [-0.3, -1e-9, 1e-9, 0.2])
def test_the_seam_of_two_boxes_with_one_surface_is_no_edge(x):
    lower = [[-5.0, -5.0, -5.0], [0.0, -5.0, -5.0]]
    boxes = boxes_from(lower, [[0.0, 5.0, 0.0], [5.0, 5.0, 0.0]])
    distance, normal, number = the_face_of((x, 0.3, 0.4), boxes)
    assert distance == pytest.approx(0.4, rel=1e-14)
    np.testing.assert_allclose(normal, [0.0, 0.0, 1.0], atol=1e-14)
    assert number == (x > 0.0)
    # a step between the two is one
    boxes.upper[0, 2] = boxes.inner_upper[0, 2] = -0.1
    assert len(faces_of((-0.3, 0.3, 0.4), boxes)) == 2


@pytest.mark.parametrize("x", [-0.3, -0.05, 0.05])
def test_under_the_seam_of_two_boxes_the_surface_is_the_face(x):
    lower = [[-5.0, -5.0, -5.0], [0.0, -5.0, -5.0]]
    boxes = boxes_from(lower, [[0.0, 5.0, 0.0], [5.0, 5.0, 0.0]])
    boxes.number[0, 0, 1] = boxes.number[1, 0, 0] = -1  # what they hide of each other
    distance, normal, _ = faces_of((x, 0.3, -0.2), boxes)[0]
    assert distance == pytest.approx(-0.2, rel=1e-14)
    np.testing.assert_allclose(normal, [0.0, 0.0, 1.0], atol=1e-14)


def test_at_the_foot_of_a_wall_what_dips_into_it_bounces_off_it():
    # 0.1 spacings deep in a side of the tank, 0.05 over its floor
    surfaces, place = walls_of(tank3d_case(), 0.0)[0], np.array([[-0.01, 0.3, 0.005]])
    surfaces.build(place, 0.0)
    u, v, w = rebounded(0, -1.0, 0.2, 0.3, 0.03, 0.0, surfaces.survey(place))
    assert (u, v, w) == pytest.approx((0.0, 0.2, 0.3), abs=1e-14)


def test_in_a_corner_each_wall_has_a_face():
    walls = [Plane(normal=normal) for normal in np.eye(3)]
    solid = planes(np.array([[0.3, 0.1, 0.2]]), LATTICE, *walls)
    assert [face_at(0, f, solid)[4] for f in range(3)] == [1, 2, 0]
