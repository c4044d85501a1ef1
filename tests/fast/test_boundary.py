"""Walls of three dimensions as surfaces: their sums, their faces, and what they do to a fluid."""

from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista
from scipy.integrate import quad

from debrisflow.case import Case, load_case
from debrisflow.case.defaults import complete
from debrisflow.neighbors import half_space
from debrisflow.neighbors.boundary import (
    PULLED_BACK,
    face_at,
    face_count,
    rebounded,
    wall_sums_at,
)
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.octant import SUMS, box_sums, octants
from debrisflow.particles.seeding import seed
from debrisflow.physics import compressible
from debrisflow.physics.operators import velocity_gradient_at
from debrisflow.schemes.surfaces import elements_from, surfaces_of
from debrisflow.space.bodies import bodies_of, in_walls
from debrisflow.space.domain import domain, wall_names
from debrisflow.space.floor import runout_bend
from debrisflow.space.mesh_pieces import pieces_of
from debrisflow.space.walls import wall_points
from tests.building import (
    Plane,
    acceleration_at,
    boxes_from,
    felt,
    fluid_of,
    frame_of,
    lattice_block,
    no_walls,
    numbers_of,
    planes,
    random_patch,
    tank3d_case,
    two_lists,
)

CASES = Path(__file__).parents[2] / "cases"
RADIUS = 2.4
LATTICE = reference(3, RADIUS, 1.0)
INFINITE = np.inf
NORMALS = [(0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (-0.48, 0.6, 0.64)]
ROUNDING = 1e-12
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
    whole = quad(lambda r: integrand(r, -1.0), 0.0, max(-q, 0.0))[0]
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
    box_sums(np.array(lower, dtype=float), np.array(upper, dtype=float), octants(RADIUS), total)
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
    surfaces, place = surfaces_of(tank3d_case(), 0.0), np.array([[-0.01, 0.3, 0.005]])
    surfaces.build(place, 0.0)
    u, v, w = rebounded(0, -1.0, 0.2, 0.3, 0.03, 0.0, surfaces.survey(place))
    assert (u, v, w) == pytest.approx((0.0, 0.2, 0.3), abs=1e-14)


def test_in_a_corner_each_wall_has_a_face():
    walls = [Plane(normal=normal) for normal in np.eye(3)]
    solid = planes(np.array([[0.3, 0.1, 0.2]]), LATTICE, *walls)
    assert [face_at(0, f, solid)[4] for f in range(3)] == [1, 2, 0]


# ---- closed surfaces of triangles


def write_box(path, lower, upper, rng):
    """Write a box as triangles that turn to either side."""
    box = pyvista.Box(np.stack([lower, upper], axis=1).ravel()).triangulate().clean()
    triangles = box.regular_faces.copy()
    flipped = rng.random(len(triangles)) < 0.5
    triangles[flipped] = triangles[flipped][:, ::-1]
    meshio.write(path, meshio.Mesh(box.points, [("triangle", triangles)]))


def meshed(tmp_path, rng, lower=(0.3, 0.2, 0.3), upper=(0.6, 0.5, 0.6)):
    """Return the case of a tank with a box that is a mesh, and its elements."""
    write_box(tmp_path / "box.obj", lower, upper, rng)
    mesh = {"type": "mesh", "name": "rock", "file": str(tmp_path / "box.obj")}
    case = tank3d_case((0.0, 0.1), obstacle=[mesh], scheme={"sound_speed": 20.0})
    return case, elements_from(*pieces_of(case, PULLED_BACK))


def volume_of(elements):
    return np.sum(elements.area * np.sum(elements.inner * elements.normal, axis=1)) / 3.0


@pytest.mark.parametrize("on_floor", [False, True])
def test_elements_look_out_of_the_body_and_enclose_its_volume(tmp_path, rng, on_floor):
    low = 0.0 if on_floor else 0.3
    case, elements = meshed(tmp_path, rng, (0.3, 0.2, low), (0.6, 0.5, low + 0.3))
    back = PULLED_BACK * case.particles.spacing
    # every face moved in, but the base on a floor moved with that
    expected = (0.3 - 2.0 * back) ** 2 * (0.3 if on_floor else 0.3 - 2.0 * back)
    assert volume_of(elements) == pytest.approx(expected, rel=1e-4)
    middle = np.array([0.45, 0.35, low + 0.15])
    assert np.all(np.sum((elements.middle - middle) * elements.normal, axis=1) > 0.14)
    total = (elements.area[:, None] * elements.normal).sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-8)
    assert set(elements.number) == {len(case.obstacle) + 6}


LOWER, UPPER = np.array([0.3, 0.2, 0.3]), np.array([0.6, 0.5, 0.6])


def of_box_and_mesh(places, elements):
    """Return what places feel of a box, and of its elements; its spacing is 0.1 m."""
    lattice, back = reference(3, RADIUS, 0.1), 0.1 * PULLED_BACK
    box = boxes_from(LOWER, UPPER, inner_lower=[LOWER + back], inner_upper=[UPPER - back])
    none = boxes_from([9.0] * 3, [9.1] * 3)
    return felt(places, lattice, box), felt(places, lattice, none, np.zeros(8), elements=elements)


@pytest.mark.parametrize(
    ("least", "most", "share"), [(0.3, 0.5, 1.0), (0.5, 1.0, 0.4), (1.0, 2.4, 0.1)]
)
def test_a_box_of_triangles_has_nearly_the_sums_of_a_box(tmp_path, rng, least, most, share):
    _, elements = meshed(tmp_path, rng)
    places = rng.uniform(LOWER - 0.24, UPPER + 0.24, (8000, 3))
    gap = np.maximum(np.maximum(LOWER - places, places - UPPER), 0.0)
    distance = np.linalg.norm(gap, axis=1) / 0.1
    places = places[(distance > least) & (distance < most)]
    assert len(places) > 200
    box, mesh = of_box_and_mesh(places, elements)
    error = np.array(
        [np.subtract(wall_sums_at(i, mesh), wall_sums_at(i, box)) for i in range(len(places))]
    )
    error[:, 2:5] *= 0.1
    of = np.sqrt(np.mean(error**2, axis=0))
    # root mean squares, where a half space half a spacing away has N = 7.2, m = 1.5, G = 3.9
    assert of[0] < 0.1 * share
    assert of[1] < 0.02 * share
    assert of[2:5].max() < 0.012 * share
    assert of[5:].max() < 0.025 * share


@pytest.mark.parametrize(("least", "most"), [(-0.2, 0.0), (0.0, 0.3), (0.3, 1.5)])
def test_over_a_face_of_triangles_the_face_is_that_of_the_body(tmp_path, rng, least, most):
    case, elements = meshed(tmp_path, rng)
    inner, heights = (
        rng.uniform(LOWER + 0.03, UPPER - 0.03, (600, 3)),
        rng.uniform(least, most, 600),
    )
    rows, axis, is_upper = np.arange(600), rng.integers(3, size=600), rng.random(600) < 0.5
    surface = np.where(is_upper, UPPER[axis], LOWER[axis])
    out = np.zeros((600, 3))
    out[rows, axis] = np.where(is_upper, 1.0, -1.0)
    inner[rows, axis] = surface
    _, mesh = of_box_and_mesh(inner + 0.1 * heights[:, None] * out, elements)
    for i in rows:
        distance, *normal, number = face_at(i, 0, mesh)
        assert distance == pytest.approx(0.1 * heights[i], abs=1e-7)  # of a file
        np.testing.assert_allclose(normal, out[i], atol=1e-5)
        assert number == wall_names(case).index("rock")


def test_off_an_edge_of_triangles_the_face_is_that_of_the_body(tmp_path, rng):
    _, elements = meshed(tmp_path, rng)
    places = rng.uniform(LOWER - 0.15, UPPER + 0.15, (3000, 3))
    beyond = np.sum((places < LOWER) | (places > UPPER), axis=1)
    places = places[beyond >= 2]
    box, mesh = of_box_and_mesh(places, elements)
    distance = np.linalg.norm(np.maximum(np.maximum(LOWER - places, places - UPPER), 0.0), axis=1)
    near = np.flatnonzero(distance < 0.2)
    assert len(near) > 300
    for i in near:
        expected, found = face_at(i, 0, box), face_at(i, 0, mesh)
        assert face_count(i, mesh) == face_count(i, box) == 1
        assert mesh.is_edge[mesh.row[i], 0]
        np.testing.assert_allclose(found[:4], expected[:4], atol=1e-4)


@pytest.mark.parametrize(("deepest", "shallowest"), [(-1.0, -0.3), (-0.3, -0.05)])
def test_inside_triangles_the_sums_are_nearly_those_inside_a_box(
    tmp_path, rng, deepest, shallowest
):
    _, elements = meshed(tmp_path, rng)
    places = rng.uniform(LOWER, UPPER, (4000, 3))
    depth = np.minimum(places - LOWER, UPPER - places).min(axis=1) / 0.1
    places = places[(-depth > deepest) & (-depth < shallowest)]
    box, mesh = of_box_and_mesh(places, elements)
    assert len(places) > 500
    sums = [np.array([wall_sums_at(i, solid) for i in range(len(places))]) for solid in (mesh, box)]
    error = np.sqrt(np.mean((sums[0] - sums[1]) ** 2, axis=0))
    assert error[0] < 0.25  # of up to 29
    assert error[1] < 0.06


def test_before_the_toe_of_a_wedge_its_base_is_no_face(tmp_path, rng):
    # 15 degrees steep, on the floor; the base is nearer than the slope's middles are
    rise = 0.3 * np.tan(np.radians(15.0))
    section = np.array([[0.3, 0.0], [0.6, 0.0], [0.6, rise]])
    points = np.array([(x, y, z) for y in (0.2, 0.5) for x, z in section])
    faces = [[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [0, 2, 5], [0, 5, 3]]
    meshio.write(tmp_path / "wedge.obj", meshio.Mesh(points, [("triangle", np.array(faces))]))
    mesh = {"type": "mesh", "name": "rock", "file": str(tmp_path / "wedge.obj")}
    case = tank3d_case((0.0, 0.1), obstacle=[mesh], scheme={"sound_speed": 20.0})
    surfaces = surfaces_of(case, 0.0)
    places = np.array(
        [[x, 0.35, z] for x in np.linspace(0.21, 0.29, 9) for z in (0.01, 0.03, 0.06)]
    )
    surfaces.build(places, 0.0)
    solid, rock = surfaces.survey(places), wall_names(case).index("rock")
    for i, place in enumerate(places):
        found = [face_at(i, f, solid) for f in range(face_count(i, solid))]
        toe = np.linalg.norm(place[[0, 2]] - [0.3, 0.0])
        slope = np.array([-np.sin(np.radians(15.0)), np.cos(np.radians(15.0))])
        along = (place[[0, 2]] - [0.3, 0.0]) @ [slope[1], -slope[0]]
        expected = toe if along < 0.0 else (place[[0, 2]] - [0.3, 0.0]) @ slope
        (distance,) = [face[0] for face in found if face[4] == rock]
        assert distance == pytest.approx(expected, abs=1e-7)


# ---- the walls of cases


BENT = {"runout_start": 1.4, "runout_slope": 5.0}
RECESS = {"bed_start": 0.5, "bed_end": 0.9, "bed_thickness": 0.15}
CHANNELS = {
    "weir": RECESS | {"weir_height": 0.1},
    "straight": {},
    "periodic": {"periodic": True},
    "periodic with a recess": RECESS | {"periodic": True},
    "plain": BENT | {"runout_width": 1.23},
    "run-out between walls": BENT,
    "recess before a run-out": BENT | RECESS | {"runout_width": 1.23},
}
IN_THREE = [*sorted(path.stem for path in CASES.glob("*3d.toml")), *CHANNELS]


def flume(shape):
    """Return a case: a flume of 20 degrees with water in it, spacing 0.05 m."""
    shape = {"type": "channel3d", "length": 2.6, "width": 0.4, "height": 0.8} | shape
    block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.4], "z": [0.0, 0.4]}
    return complete(
        Case(
            title="flume",
            particles={"spacing": 0.05},
            gravity={"slope": 20.0},
            geometry=shape,
            fill=[block | {"material": "water"}],
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )


@pytest.fixture(params=IN_THREE, scope="module")
def walled(request):
    """Return a case of three dimensions, each that is shipped and some flumes."""
    name = request.param
    return flume(CHANNELS[name]) if name in CHANNELS else load_case(CASES / f"{name}.toml")


def around(case, rng, count=200_000):
    """Return places anywhere in the space of a case and as far beyond as walls are felt."""
    space, reach = domain(case), case.particles.effective_radius * case.particles.spacing
    repeats = space.period > 0.0
    lower = np.where(repeats, 0.0, space.lower) - reach
    upper = np.where(repeats, space.period, space.upper) + reach
    return rng.uniform(lower, upper, (count, 3))


def test_no_two_bodies_overlap_but_parts_of_a_floor(walled, rng):
    places, bodies = around(walled, rng), bodies_of(walled)
    count = np.zeros(len(places), dtype=int)
    for body in bodies:
        if not body.is_floor:
            count += body.holds(places)
    count += np.any([body.holds(places) for body in bodies if body.is_floor] or False, axis=0)
    assert np.count_nonzero(count == 1) > 1000
    np.testing.assert_array_equal(places[count > 1], np.zeros((0, 3)))


def test_drawn_cells_of_wall_are_in_the_walls_and_open_ones_beside_them_are_not(walled):
    points, d0 = wall_points(walled), walled.particles.spacing
    assert in_walls(walled, points.position).all()
    first = points.layer == 1
    # half a spacing over each of up to three faces that meet at an edge or corner
    out = (points.depth[first] + 0.75 * d0)[:, None] * points.normal[first]
    assert not in_walls(walled, points.position[first] + out).any()


def test_a_fill_stands_in_no_wall(walled):
    particles = seed(walled)
    assert not in_walls(walled, particles.position[particles.fluid]).any()


# ---- what walls do to a fluid


def accelerations(position, solid, fluid, **changes):
    """Return acceleration and change of velocity by collisions of each particle, (n, 6) array."""
    near, numbers = two_lists(position, LATTICE), numbers_of(LATTICE, **changes)
    return np.array([acceleration_at(i, fluid, near, solid, numbers) for i in range(len(position))])


def corner_of(position, slip=1.0):
    """Return what particles feel of three walls, not at right angles."""
    walls = [
        Plane((0.0, 0.0, 0.0), (0.36, -0.48, 0.8), slip),
        Plane((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), slip),
        Plane((0.0, 5.0, 0.0), (0.0, -0.8, 0.6), slip),
    ]
    return planes(position, LATTICE, *walls)


@pytest.mark.parametrize("apart", [True, False])
def test_what_walls_take_from_motion_is_stored_by_compression(rng, apart):
    # with the same pressure everywhere the walls have it too; alone, there are walls and no fluid
    position = random_patch(3, 300, rng, 6.0)
    solid = corner_of(position)
    s, still = 0.02, {"gravity": np.zeros(3), "artificial_viscosity": 0.0, "diffusion": 0.0}
    near, numbers = two_lists(position, LATTICE), numbers_of(LATTICE, **still)
    if apart:
        near.fluid_count[:] = 0
    pressure = np.full(300, numbers.density * numbers.sound_speed**2 * s)
    fluid = fluid_of(300, velocity=rng.normal(size=(300, 3)), pressure=pressure)
    fluid = fluid._replace(compression=np.full(300, s))
    taken, stored = np.empty((2, 300))
    for i in range(300):
        given = acceleration_at(i, fluid, near, solid, numbers)[:3]
        _, _, rate = compressible.density_rate_at(i, fluid, near, solid, numbers)
        taken[i] = np.dot(given, fluid.velocity[i])
        stored[i] = numbers.sound_speed**2 * s / (1.0 + s) * rate
    assert np.count_nonzero(solid.faces > 1) > 20
    assert np.abs(stored).max() > 10.0
    if apart:  # each by itself
        np.testing.assert_allclose(taken, -stored, atol=ROUNDING * np.abs(stored).max())
    else:
        assert abs(taken.sum() + stored.sum()) < ROUNDING * np.abs(stored).sum()


@pytest.mark.parametrize("normal", [(0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (-0.48, 0.6, -0.64)])
@pytest.mark.parametrize("pressure", [0.0, 800.0])
def test_a_ceiling_does_not_pull(rng, normal, pressure):
    normal, gravity = np.array(normal), np.array([0.0, 0.0, -9.81])
    for height in (-0.2, 0.1, 0.5, 1.0, 2.0):
        position = height * normal[None]
        solid = planes(position, LATTICE, Plane(normal=normal))
        fluid = fluid_of(1, pressure=np.full(1, pressure))
        (found,) = accelerations(position, solid, fluid, gravity=gravity)
        push = -np.array(wall_sums_at(0, solid)[2:5])
        least = 3.0 / LATTICE.number_density * pressure / 1000.0 * push @ normal
        # no less than its own pressure alone does
        assert (found[:3] - gravity) @ normal >= least - ROUNDING * 9.81
        if pressure == 0.0 and normal[2] == -1.0:
            np.testing.assert_allclose(found, [*gravity, *(0.0,) * 9], atol=1e-12)


def standing_on(normal, rows=10):
    """Return a block of lattice on a plane through the origin, and its heights over the plane."""
    turn = frame_of(normal)
    block = lattice_block(3, (9, 9, rows)) - [4.5, 4.5, 0.0]
    return block @ turn, block[:, 2], np.all(np.abs(block[:, :2]) < 0.1, axis=1)


@pytest.mark.parametrize("normal", NORMALS)
def test_fluid_at_rest_on_a_plane_stays_nearly_at_rest(normal):
    # on the two rows over it a wall pushes 0.6 % less and 2.2 % more than its lattice would
    position, height, inner = standing_on(normal)
    solid, gravity = planes(position, LATTICE, Plane(normal=normal)), -9.81 * np.array(normal)
    pressure = 1000.0 * 9.81 * (10.0 - height)
    still = fluid_of(len(position), pressure=pressure)
    found = accelerations(position, solid, still, gravity=gravity)[inner, :3]
    lift, height = found @ normal, height[inner]
    deep = height < 7.0  # the free surface is out of reach
    share = lift[deep] / (pressure[inner][deep] / 1000.0)  # 1 spacing = 1 m
    np.testing.assert_array_less(np.abs(share), np.where(height[deep] < 2.0, 0.025, 1e-12))
    np.testing.assert_allclose(found - np.outer(lift, normal), 0.0, atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_layer_on_a_slope_keeps_all_of_the_gravity_along_it(normal, slip, rng):
    position, height, inner = standing_on(normal)
    normal = np.array(normal)
    along = np.cross(normal, rng.normal(size=3))
    solid = planes(position, LATTICE, Plane(normal=normal, slip=slip))
    pressure = 1000.0 * 9.0 * (10.0 - height)
    still = fluid_of(len(position), pressure=pressure)
    found = accelerations(position, solid, still, gravity=along - 9.0 * normal)
    across = found[inner, :3] @ normal
    lowest = height[inner] < 7.0
    assert np.count_nonzero(lowest) == 7
    np.testing.assert_allclose(
        (found[inner, :3] - across[:, None] * normal)[lowest], np.tile(along, (7, 1)), atol=1e-9
    )


def over_plane(rng, normal, least=0.26, count=600):
    """Return particles anywhere over a plane, none nearer to it than a fourth of a spacing."""
    anywhere = rng.uniform(-3.0, 3.0, (count, 3))
    return anywhere[anywhere @ normal > least]


def shear(position, velocity, solid):
    """Return the velocity gradients of all particles, (n, 3, 3) array."""
    near = two_lists(position, LATTICE)
    return np.array(
        [velocity_gradient_at(i, velocity, near, solid) for i in range(len(position))]
    ).reshape(-1, 3, 3)


@pytest.mark.parametrize("normal", NORMALS)
def test_a_linear_profile_over_a_no_slip_wall_is_exact(normal, rng):
    normal = np.array(normal)
    position = over_plane(rng, normal)
    gradient = np.outer(rng.normal(size=3), normal)
    found = shear(position, position @ gradient.T, planes(position, LATTICE, Plane(normal=normal)))
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
def test_a_linear_profile_along_a_free_slip_wall_is_exact(normal, rng):
    # the velocity along the wall varies along it, that across it with the height
    normal = np.array(normal)
    position = over_plane(rng, normal)
    along = np.eye(3) - np.outer(normal, normal)
    gradient = along @ rng.normal(size=(3, 3)) @ along + rng.normal() * np.outer(normal, normal)
    velocity = position @ gradient.T + along @ rng.normal(size=3)
    solid = planes(position, LATTICE, Plane(normal=normal, slip=1.0))
    found = shear(position, velocity, solid)
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


def test_the_shear_over_a_floor_is_exact_beside_a_free_slip_side(rng):
    turn = turn_of(rng)
    anywhere = rng.uniform(0.0, 3.0, (900, 3))
    upright = anywhere[np.all(anywhere[:, 1:] > 0.26, axis=1)]
    position, gradient = upright @ turn, 7.0 * np.outer(turn[0], turn[2])
    walls = Plane(normal=turn[2]), Plane(normal=turn[1], slip=1.0)
    found = shear(position, position @ gradient.T, planes(position, LATTICE, *walls))
    assert np.count_nonzero((upright[:, 1:] < 1.0).all(axis=1)) > 20
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
def test_walls_hold_what_sticks_to_them_and_nothing_else(normal):
    position, height, inner = standing_on(normal)
    rows = [int(np.flatnonzero(inner & (height == row + 0.5))[0]) for row in range(5)]
    along, viscosity = np.cross(normal, [0.3, -1.0, 0.5]), np.full(len(position), 300.0)
    calm = {"gravity": np.zeros(3), "artificial_viscosity": 0.0}

    def dragged(velocity, slip):
        solid = planes(position, LATTICE, Plane(normal=normal, slip=slip))
        fluid = fluid_of(len(position), velocity=velocity, viscosity=viscosity)
        found = accelerations(position, solid, fluid, **calm)[rows, :3]
        np.testing.assert_allclose(np.cross(found, along), 0.0, atol=1e-10)
        return found @ along / (along @ along)

    sliding = np.tile(along, (len(position), 1))
    np.testing.assert_allclose(dragged(sliding, 1.0), 0.0, atol=1e-10)
    whole = dragged(sliding, 0.0)
    assert np.all(whole[:2] < 0.0)
    np.testing.assert_allclose(whole[3:], 0.0, atol=1e-10)  # out of reach
    # of a straight profile down to the surface 5 % of the drag on the first row are left over
    rest = dragged(height[:, None] * along, 0.0)
    np.testing.assert_allclose(rest, 0.0, atol=0.05 * 0.5 * abs(whole[0]))


def test_a_corner_of_a_rising_floor_is_as_solid_as_one_of_a_level_floor():
    case = flume(BENT)
    surfaces, rise, d0 = surfaces_of(case, 0.0), runout_bend(case), 0.05
    up, half = np.array([-np.sin(rise), 0.0, np.cos(rise)]), 0.5 * d0
    on_floor = np.array([2.0, half, (2.0 - BENT["runout_start"]) * np.tan(rise)])
    places = np.array([[0.8, half, half], on_floor + half * up])
    surfaces.build(places, 0.0)
    level, rising = (np.array(wall_sums_at(i, surfaces.survey(places))) for i in (0, 1))
    # what the octants lose of the half space of the floor beside it
    np.testing.assert_allclose(rising[:2], level[:2], rtol=0.015)
    np.testing.assert_allclose(np.linalg.norm(rising[2:5]), np.linalg.norm(level[2:5]), rtol=0.01)


def test_a_run_out_is_not_felt_in_the_recess_before_it():
    place, found = np.array([[0.88, 0.2, -0.12]]), []
    for shape in (RECESS, RECESS | BENT):
        surfaces = surfaces_of(flume(shape), 0.0)
        surfaces.build(place, 0.0)
        found.append(surfaces.survey(place))
    np.testing.assert_array_equal(*[solid.faces for solid in found])
    np.testing.assert_allclose(*[wall_sums_at(0, solid) for solid in found], rtol=1e-12)


def test_what_is_far_from_all_walls_feels_none(rng):
    position = random_patch(3, 50, rng, 4.0) + 3.0
    velocity = rng.normal(size=(50, 3))
    fluid = fluid_of(50, velocity=velocity, pressure=rng.uniform(0.0, 1e3, 50))
    far = planes(position, LATTICE, Plane())
    assert not wall_sums_at(0, far)[0]
    found = accelerations(position, far, fluid)
    np.testing.assert_array_equal(found, accelerations(position, no_walls(50), fluid))
