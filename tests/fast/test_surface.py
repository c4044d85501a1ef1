"""Surfaces of triangles: what they enclose, and how wrong files are told."""

import os

import meshio
import numpy as np
import pytest
import pyvista

from debrisflow.case.triangles import (
    Surface,
    UnreadableSurfaceError,
    cells_inside,
    nearest_points,
    open_edges,
    read_surface,
)


def surface_of(mesh):
    mesh = mesh.triangulate()
    return Surface(mesh.points[mesh.regular_faces].astype(float))


def sphere(radius, center, resolution=40):
    return surface_of(
        pyvista.Sphere(
            radius=radius, center=center, theta_resolution=resolution, phi_resolution=resolution
        )
    )


@pytest.mark.parametrize("spacing", [0.05, 0.02])
def test_cells_inside_a_sphere_are_those_within_its_radius(spacing):
    center = np.array([0.61, 0.57, 0.55])
    found = cells_inside(sphere(0.5, center, resolution=200), spacing)
    every = np.argwhere(np.ones(np.full(3, round(1.2 / spacing)), dtype=bool))
    distance = np.linalg.norm((every + 0.5) * spacing - center, axis=1)
    # the triangles lie inside the sphere, by 1e-4 of its radius at this resolution
    assert set(map(tuple, every[distance < 0.4998])) <= set(map(tuple, found))
    assert set(map(tuple, found)) <= set(map(tuple, every[distance < 0.5]))
    assert len(found) * spacing**3 == pytest.approx(np.pi / 6.0, rel=0.02)


def test_a_box_on_the_lattice_encloses_its_cells_whichever_way_it_turns():
    box = surface_of(pyvista.Cube(bounds=(0.0, 0.4, -0.1, 0.3, 0.1, 0.3)))
    turned = Surface(box.corners[:, ::-1])
    for surface in (box, turned):
        found = set(map(tuple, cells_inside(surface, 0.1)))
        assert found == {(i, j, k) for i in range(4) for j in range(-1, 3) for k in (1, 2)}


def test_a_hollow_body_encloses_its_shell_only():
    outer, inner = sphere(0.5, np.zeros(3)), sphere(0.3, np.zeros(3))
    shell = Surface(np.concatenate([outer.corners, inner.corners]))
    found = np.linalg.norm((cells_inside(shell, 0.05) + 0.5) * 0.05, axis=1)
    assert found.min() > 0.29
    assert open_edges(shell) == 0


def test_volume_and_area_of_a_box():
    box = surface_of(pyvista.Cube(bounds=(1.0, 1.4, 2.0, 2.3, 3.0, 3.2)))
    assert box.volume == pytest.approx(0.4 * 0.3 * 0.2, rel=1e-5)
    assert box.area == pytest.approx(2 * (0.12 + 0.08 + 0.06), rel=1e-5)


def test_the_nearest_point_of_a_sphere_lies_along_its_radius():
    position = np.random.default_rng(1).normal(size=(200, 3))
    position *= 0.3 / np.linalg.norm(position, axis=1, keepdims=True)
    nearest, normal = nearest_points(sphere(0.5, np.zeros(3), resolution=100), position)
    np.testing.assert_allclose(nearest, position * 5.0 / 3.0, atol=0.02)
    assert np.sum(normal * position, axis=1).min() > 0.3 * np.cos(np.radians(4.0))


@pytest.mark.parametrize(
    ("kind", "options"),
    [("stl", {}), ("stl", {"binary": True}), ("obj", {}), ("ply", {}), ("ply", {"binary": False})],
)
def test_a_file_of_each_kind_gives_the_same_body(tmp_path, kind, options):
    body = pyvista.Sphere(radius=0.5).triangulate()
    path = tmp_path / f"ball.{kind}"
    meshio.write(path, meshio.Mesh(body.points, [("triangle", body.regular_faces)]), **options)
    surface = read_surface(path)
    assert open_edges(surface) == 0
    assert surface.volume == pytest.approx(surface_of(body).volume, rel=1e-5)
    moved = surface.placed(2.0, (1.0, 0.0, 0.0))
    np.testing.assert_allclose(moved.lower, [0.0, -1.0, -1.0], atol=0.01)


def test_quadrilaterals_are_cut_in_two(tmp_path):
    box = pyvista.Cube()
    path = tmp_path / "box.obj"
    faces = box.clean().regular_faces
    meshio.write(path, meshio.Mesh(box.clean().points, [("quad", faces)]))
    surface = read_surface(path)
    assert len(surface.corners) == 12
    assert surface.volume == pytest.approx(1.0)
    assert open_edges(surface) == 0


def test_vertices_that_are_not_finite_are_told(tmp_path):
    path = tmp_path / "body.obj"
    path.write_text("v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(UnreadableSurfaceError, match="finite"):
        read_surface(path)


def test_a_changed_file_is_read_again(tmp_path):
    path = tmp_path / "body.obj"
    for size, changed in ((1, 1_000), (2, 2_000)):
        path.write_text(f"v 0 0 0\nv {size} 0 0\nv 0 1 0\nf 1 2 3\n")
        os.utime(path, (changed, changed))
        assert read_surface(path).upper[0] == size
