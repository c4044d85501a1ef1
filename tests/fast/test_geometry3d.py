"""Walls, obstacles and meshes in three dimensions."""

import meshio
import numpy as np
import pytest
import pyvista

from debrisflow.case import dump_case, load_case
from debrisflow.particles.record import Kind
from debrisflow.particles.seeding import seed, wall_particles
from debrisflow.space.domain import WALL_NAMES, wall_names
from debrisflow.space.walls import wall_points
from tests.building import tank3d_case

D0 = 0.1
BOX = {"type": "box", "name": "pier", "x": [0.5, 0.8], "y": [0.4, 0.6], "z": [0.0, 0.5]}
WIDE = (1.6, 1.2, 1.0)


def write_mesh(path, body):
    body = body.triangulate()
    meshio.write(path, meshio.Mesh(body.points, [("triangle", body.regular_faces)]))
    return str(path)


def mesh(file, **fields):
    return {"type": "mesh", "name": "rock", "file": file} | fields


def test_the_dam_break_of_the_study_has_its_number_of_particles():
    cube = {"type": "block", "x": [0, 2], "y": [0, 2], "z": [0, 2], "material": "water"}
    case = tank3d_case(size=(6.0, 6.0, 2.3), fill=[cube])
    particles, walls = seed(case), wall_particles(case)
    assert particles.count == particles.fluid_count == 8_000
    assert walls.count == 30_456  # drawn for probes; the fluid feels surfaces
    assert np.sum(walls.position[:, 2] < 0) == 3 * 66 * 66
    every = np.concatenate([particles.position, walls.position])
    assert np.unique(np.rint(every / D0 - 0.5), axis=0).shape == (38_456, 3)


def nearest_of_box(points, lower, upper):
    """Return vectors from points to the nearest point of a box."""
    return np.clip(points, lower, upper) - points


@pytest.mark.parametrize("size", [(0.8, 0.6, 1.0), (1.1, 0.9, 0.5)])
def test_walls_of_a_tank_point_to_the_nearest_point_of_its_space(size):
    points = wall_points(tank3d_case(size=size, z=(0.0, 0.5)))
    inwards = nearest_of_box(points.position, np.zeros(3), [*size[:2], np.inf])
    over_rim = np.zeros_like(inwards)
    over_rim[:, 2] = size[2] - points.position[:, 2]
    over_rim[over_rim[:, 2] > 2.6 * D0, 2] = np.inf  # farther than the layers reach
    lengths = [np.linalg.norm(way, axis=1) for way in (inwards, over_rim)]
    np.testing.assert_allclose(points.depth, np.minimum(*lengths), atol=1e-12)
    tied = np.abs(lengths[0] - lengths[1]) < 1e-9
    out = np.where((lengths[0] < lengths[1])[:, None], inwards, over_rim)[~tied]
    normal = out / np.linalg.norm(out, axis=1, keepdims=True)
    np.testing.assert_allclose(points.normal[~tied], normal, atol=1e-12)
    rings = np.minimum(np.abs(inwards).max(axis=1), over_rim[:, 2])
    np.testing.assert_array_equal(points.layer, np.rint(rings / D0 + 0.5))
    assert points.layer.max() == 3
    # a corner: three walls at once
    assert np.any(np.all(np.abs(points.normal) > 0.5, axis=1))


def test_walls_bear_the_names_of_their_sides():
    points = wall_points(tank3d_case())
    sides = {
        "floor": (points.position[:, 2] < 0),
        "left": points.position[:, 0] < 0,
        "right": points.position[:, 0] > 0.8,
        "front": points.position[:, 1] < 0,
        "back": points.position[:, 1] > 0.6,
    }
    for name, there in sides.items():
        alone = there & (sum(s.astype(int) for s in sides.values()) == 1)
        assert set(points.name[alone]) == {WALL_NAMES.index(name)}


def test_a_periodic_tank_repeats_across_its_sides():
    points = wall_points(tank3d_case(size=(0.8, 1.2, 1.0), geometry={"periodic": True}))
    assert points.position[:, 1].min() > 0
    assert points.position[:, 1].max() < 1.2
    assert not np.any(points.normal[:, 1])
    assert {WALL_NAMES[k] for k in set(points.name)} == {"floor", "left", "right"}


def test_an_obstacle_is_wall_whose_normals_point_out_of_it():
    case = tank3d_case(size=WIDE, fill=[], scheme={"sound_speed": 20.0}, obstacle=[BOX])
    points = wall_points(case)
    assert wall_names(case)[-1] == "pier"
    own = points.name == len(WALL_NAMES)
    p = points.position[own]
    assert own.sum() == 3 * 2 * 5
    lower, upper = np.array([0.5, 0.4, 0.0]), np.array([0.8, 0.6, 0.5])
    # the base stands on the floor, where no fluid comes
    gaps = np.column_stack([p - lower, upper - p])[:, [0, 1, 3, 4, 5]]
    np.testing.assert_allclose(points.depth[own], gaps.min(axis=1), atol=1e-12)
    flat = np.sort(gaps, axis=1)
    single = flat[:, 1] - flat[:, 0] > 1e-9
    outward = np.array([[-1, 0, 0], [0, -1, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    expected = outward[np.argmin(gaps[single], axis=1)]
    np.testing.assert_allclose(points.normal[own][single], expected, atol=1e-12)
    x, y, z = points.position.T
    beneath = (x > 0.6) & (x < 0.7) & (y > 0.4) & (y < 0.6) & (z < 0.0)
    assert beneath.sum() == 6
    # from under the box, half a spacing from its side, the way into the open is around its edge
    np.testing.assert_allclose(points.depth[beneath], np.hypot(0.05, z[beneath]), atol=1e-12)


def test_a_mesh_is_wall_with_the_normals_of_its_surface(tmp_path):
    center = np.array([0.83, 0.61, 0.52])
    ball = pyvista.Sphere(radius=0.4, theta_resolution=60, phi_resolution=60)
    file = write_mesh(tmp_path / "ball.stl", ball)
    case = tank3d_case(
        size=WIDE,
        fill=[],
        scheme={"sound_speed": 20.0},
        obstacle=[mesh(file, offset=tuple(center))],
    )
    points = wall_points(case)
    own = points.name == len(WALL_NAMES)
    out = points.position[own] - center
    distance = np.linalg.norm(out, axis=1)
    assert distance.max() < 0.4
    assert own.sum() > 200
    np.testing.assert_allclose(points.depth[own], 0.4 - distance, atol=0.002)
    clear = (distance > 0.1) & (points.depth[own] > 0.01)
    cosine = np.sum(points.normal[own] * out, axis=1) / distance
    # triangles of six degrees tilt the normal by half of that at most
    assert np.all(cosine[clear] > np.cos(np.radians(4.0)))
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, atol=1e-9)


def wedge():
    """Return a ramp that rises by 0.4 m over 0.8 m along x and stands on z = 0."""
    corners = [[0, 0, 0], [0.8, 0, 0], [0.8, 0, 0.4], [0, 0.6, 0], [0.8, 0.6, 0], [0.8, 0.6, 0.4]]
    faces = [[0, 1, 2], [3, 5, 4], [0, 3, 1], [1, 3, 4], [0, 2, 3], [2, 5, 3], [1, 4, 2], [4, 5, 2]]
    return np.array(corners, dtype=float), np.array(faces)


@pytest.mark.parametrize(("start", "points_on_it"), [(0.4, False), (0.35, True)])
def test_a_ramp_on_the_floor_has_the_normal_of_its_slope_and_none_into_the_floor(
    tmp_path, start, points_on_it
):
    corners, faces = wedge()
    path = tmp_path / "ramp.stl"
    meshio.write(path, meshio.Mesh(corners, [("triangle", faces)]))
    ramp = mesh(str(path), offset=(start, 0.3, 0.0))
    points = wall_points(
        tank3d_case(size=WIDE, fill=[], scheme={"sound_speed": 20.0}, obstacle=[ramp])
    )
    own = points.name == len(WALL_NAMES)
    x, y, z = (points.position[own] - [start, 0.3, 0.0]).T
    slope = np.array([-1.0, 0.0, 2.0]) / np.sqrt(5.0)
    below = (0.5 * x - z) / np.sqrt(1.25)
    aside = np.minimum(np.minimum(y, 0.6 - y), 0.8 - x)
    sloped = below < aside - 1e-9
    assert sloped.sum() > 30
    assert np.any(below[sloped] < 1e-6) == points_on_it
    np.testing.assert_allclose(points.depth[own][sloped], below[sloped], atol=1e-6)
    np.testing.assert_allclose(
        points.normal[own][sloped], np.tile(slope, (sloped.sum(), 1)), atol=1e-4
    )
    assert points.normal[own][:, 2].min() > -1e-9


def test_a_filled_sphere_has_its_volume_and_velocity(tmp_path):
    file = write_mesh(tmp_path / "ball.ply", pyvista.Sphere(radius=0.5))
    drop = {"type": "mesh", "file": file, "offset": (0.8, 0.6, 0.6), "material": "mixture"}
    case = tank3d_case(
        size=WIDE, fill=[drop | {"velocity": (0.0, 0.0, -1.0)}], particles={"spacing": 0.05}
    )
    particles = seed(case)
    volume = particles.fluid_count * 0.05**3
    assert volume == pytest.approx(np.pi / 6.0, rel=0.03)
    assert set(particles.kind[particles.fluid]) == {Kind.MIXTURE}
    assert np.all(particles.velocity[particles.fluid] == [0.0, 0.0, -1.0])
    away = np.linalg.norm(particles.position[particles.fluid] - [0.8, 0.6, 0.6], axis=1)
    assert away.max() < 0.5


def test_a_resolved_case_finds_its_mesh_from_anywhere(tmp_path):
    write_mesh(tmp_path / "ball.obj", pyvista.Sphere(radius=0.3))
    text = """
title = "a drop"
particles = { spacing = 0.1 }
geometry = { type = "tank3d", length = 1.0, width = 1.0, height = 1.0 }
time = { end = 1.0 }
output = { interval = 0.1 }

[[fill]]
type = "mesh"
file = "ball.obj"
offset = [0.5, 0.5, 0.5]
material = "water"
"""
    (tmp_path / "case.toml").write_text(text)
    case = load_case(tmp_path / "case.toml")
    run = tmp_path / "runs" / "drop"
    run.mkdir(parents=True)
    (run / "case.toml").write_text(dump_case(case))
    assert load_case(run / "case.toml") == case
    assert case.fill[0].file == str(tmp_path / "ball.obj")
