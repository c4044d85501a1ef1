"""Closed meshes as surfaces: their elements, sums and faces."""

import meshio
import numpy as np
import pytest
import pyvista

from debrisflow.neighbors.boundary import (
    face_at,
    face_count,
    wall_sums_at,
)
from debrisflow.neighbors.half_space import PULLED_BACK
from debrisflow.neighbors.lattice import reference
from debrisflow.schemes.surfaces import elements_from, walls_of
from debrisflow.space.domain import wall_names
from debrisflow.space.mesh_pieces import pieces_of
from tests.building import (
    boxes_from,
    felt,
    tank3d_case,
)

RADIUS = 2.4


@pytest.fixture
def rng():
    return np.random.default_rng(61)


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
    surfaces = walls_of(case, 0.0)[0]
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
