"""Obstacles that move: what particles feel of them, lists, steps, and files."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import pyvista

from debrisflow.case import load_case
from debrisflow.neighbors.boundary import face_count, flow_of_walls_at, velocity_beside
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.start import initial_state
from debrisflow.run.folder import RunFolder
from debrisflow.run.probes import samplers
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.vicinity import ListAndSurfaces
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.plan_grid import plan
from debrisflow.space.scene import obstacle_faces, trajectories
from tests.building import tank3d_case, tank_case

OBSTACLE = len(WALL_NAMES)
FLAP = {"time": (0.0, 0.4, 1.0), "angle": (0.0, 20.0, -30.0), "x": (0.0, 0.05, 0.3)}
SHAPES = {
    "box": {"type": "box", "x": (0.42, 0.47), "y": (0.0, 0.4)},
    "polygon": {"type": "polygon", "corners": ((0.42, 0.0), (0.6, 0.0), (0.5, 0.3))},
    "box3d": {"type": "box", "x": (0.32, 0.47), "y": (0.2, 0.4), "z": (0.0, 0.4)},
}


def case_of(shape, **motion):
    obstacle = SHAPES[shape] | {"name": "flap", "motion": motion}
    if shape == "box3d":
        return tank3d_case(obstacle=[obstacle])
    return tank_case(16, 10, "water", (60, 30), 0.025, obstacle=[obstacle])


def lists_of(case):
    d0 = case.particles.spacing
    lattice = reference(case.dimension, case.particles.effective_radius, d0)
    return ListAndSurfaces(case, lattice, domain(case))


def particles_at(position):
    every = slice(0, len(position))
    return SimpleNamespace(position=position, moving=every, fluid=every, fluid_count=len(position))


def some_places(case, count=400):
    """Return places around the obstacle of a case, (n, 3) array, m."""
    rng = np.random.default_rng(3)
    position = np.zeros((count, 3))
    position[:, : case.dimension] = rng.uniform(0.05, 0.75, (count, case.dimension))
    if case.dimension == 3:
        position[:, 1] = rng.uniform(0.05, 0.55, count)
    return position


@pytest.mark.parametrize("shape", SHAPES)
def test_the_velocity_at_a_face_is_that_of_the_obstacle_there(shape):
    case = case_of(shape, about=(0.45, 0.0), **FLAP)
    way = trajectories(case)[OBSTACLE]
    vicinity, position = lists_of(case), some_places(case)
    vicinity.update(particles_at(position), 0.3, is_fresh=True)
    solid, seen = vicinity.solid, 0
    tiny = 1e-6
    before, after = way.pose(0.3 - tiny), way.pose(0.3 + tiny)
    for i in np.flatnonzero(solid.row >= 0):
        for f in range(face_count(i, solid)):
            row = solid.row[i]
            foot = position[i] - solid.distance[row, f] * solid.normal[row, f]
            velocity = -np.array(velocity_beside(0.0, 0.0, 0.0, i, f, solid))
            if solid.number[row, f] != OBSTACLE:
                np.testing.assert_array_equal(velocity, 0.0)
                continue
            pose, seen = way.pose(0.3), seen + 1
            at_start = pose.axis + (foot - pose.axis - pose.displacement) @ pose.turn
            expected = (after.moved(at_start) - before.moved(at_start)) / (2.0 * tiny)
            np.testing.assert_allclose(velocity, expected, atol=1e-5)
    assert seen > 20


@pytest.mark.parametrize("shape", SHAPES)
def test_lists_follow_an_obstacle_that_moves(shape):
    case = case_of(shape, about=(0.45, 0.0), **FLAP)
    kept, position = lists_of(case), some_places(case)
    particles = particles_at(position)
    kept.update(particles, 0.0, is_fresh=True)
    for time in np.arange(0.01, 1.0, 0.01):
        kept.update(particles, time, is_fresh=False)
    fresh = lists_of(case)
    fresh.update(particles, time, is_fresh=True)
    ours, theirs = kept.solid, fresh.solid
    rows = np.flatnonzero(theirs.row >= 0)
    assert np.isin(rows, np.flatnonzero(ours.row >= 0)).all()
    for field in ("sums", "faces", "distance", "velocity"):
        found, expected = (getattr(one, field)[one.row[rows]] for one in (ours, theirs))
        if found.ndim > 1 and field != "sums":
            shown = np.arange(3) < theirs.faces[theirs.row[rows], None]
            found, expected = found[shown], expected[shown]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9, err_msg=field)


@pytest.mark.parametrize("shape", SHAPES)
def test_what_moves_with_a_wall_is_not_compressed_by_it(shape):
    velocity = (0.7, 0.0) if shape != "box3d" else (0.7, 0.0, 0.0)
    case = case_of(shape, velocity=velocity)
    vicinity, position = lists_of(case), some_places(case)
    vicinity.update(particles_at(position), 0.1, is_fresh=True)
    solid, seen = vicinity.solid, 0
    for i in np.flatnonzero(solid.row >= 0):
        row, faces = solid.row[i], face_count(i, solid)
        if faces == 1 and solid.number[row, 0] == OBSTACLE and not solid.is_edge[row, 0]:
            along = solid.normal[row, 0] @ [0.7, 0.0, 0.0]
            assert flow_of_walls_at(i, solid) == pytest.approx(-solid.push[row, 0] * along)
            seen += 1
    assert seen > 10


@pytest.mark.parametrize("shape", SHAPES)
def test_a_gate_that_is_gone_is_felt_no_more(shape):
    velocity = (0.0, 8.0) if shape != "box3d" else (0.0, 0.0, 8.0)
    case = case_of(shape, velocity=velocity)
    vicinity, position = lists_of(case), some_places(case)
    vicinity.update(particles_at(position), 50.0, is_fresh=True)
    assert not np.any(vicinity.solid.number[vicinity.solid.faces > 0, 0] == OBSTACLE)
    assert vicinity.wall_speed == 0.0


@pytest.mark.parametrize("shape", ["box", "box3d"])
def test_a_fast_gate_limits_the_step(shape):
    speed = 40.0
    velocity = (0.0, speed) if shape != "box3d" else (0.0, 0.0, speed)
    case = case_of(shape, velocity=velocity)
    scheme, state = scheme_of(case), initial_state(case)
    scheme.fill_number_density(state)
    assert scheme.stable_dt(state) * speed <= 0.2 * case.particles.spacing * (1.0 + 1e-9)


def test_what_moves_is_no_floor_of_the_plan_nor_of_a_height():
    still = tank_case(16, 10, "water", (60, 30), 0.025, obstacle=[SHAPES["box"] | {"name": "sill"}])
    moving = case_of("box", velocity=(0.0, 1.0))
    assert plan(still).obstacle_height.max() > 0.0
    assert plan(moving).obstacle_height.max() == 0.0
    probe = {"type": "height", "name": "level", "x": 0.45, "interval": 0.1}
    case = tank_case(
        16,
        10,
        "water",
        (60, 30),
        0.025,
        obstacle=[SHAPES["box"] | {"name": "sill", "motion": {"velocity": (0.0, 1.0)}}],
        probe=[probe],
    )
    assert samplers(case, initial_state(case))["level"].base == 0.0


def test_a_run_holds_its_obstacles_at_the_time_of_each_frame(tmp_path):
    case = case_of("box", velocity=(0.0, 0.5), start=0.1)
    state = initial_state(case)
    with RunFolder.create(tmp_path / "run", case) as folder:
        for time in (0.0, 0.1, 0.3):
            state.time = time
            folder.write_frame(state)
    meshes = [pyvista.read(file) for file in sorted((tmp_path / "run/obstacles").iterdir())]
    assert [round(float(mesh.bounds[2]), 6) for mesh in meshes] == [0.0, 0.0, 0.1]
    assert not np.any(pyvista.read(tmp_path / "run/walls.vtp").cell_data["obstacle"] == 0)
    with RunFolder.open(tmp_path / "run", case) as folder:
        folder.rewind(0.1)
    assert "000002" not in (tmp_path / "run/obstacles.pvd").read_text()


def test_faces_are_drawn_where_they_are():
    case = case_of("polygon", velocity=(0.0, 0.5))
    (before,), (after,) = (obstacle_faces(case, time) for time in (-1.0, 0.2))
    np.testing.assert_allclose(before[0, :, :2], SHAPES["polygon"]["corners"])
    np.testing.assert_allclose(after - before, np.tile([0.0, 0.1, 0.0], (1, 3, 1)), atol=1e-15)


def test_a_motion_comes_from_a_file_with_the_columns_that_it_has(tmp_path):
    (tmp_path / "gate.csv").write_text("# measured\ntime, y\n0, 0\n0.1, 0.2\n")
    (tmp_path / "case.toml").write_text(
        'title = "gate"\nparticles = { spacing = 0.05 }\n'
        'geometry = { type = "tank", length = 1.0, height = 0.5 }\n'
        'fill = [{ type = "block", x = [0.0, 0.4], y = [0.0, 0.3], material = "water" }]\n'
        'obstacle = [{ type = "box", name = "gate", x = [0.4, 0.41], y = [0.0, 0.5],'
        ' motion = "gate.csv" }]\n'
        "time = { end = 1.0 }\noutput = { interval = 0.5 }\n"
    )
    case = load_case(tmp_path / "case.toml")
    way = trajectories(case)[OBSTACLE]
    np.testing.assert_allclose(way.pose(0.1).displacement, [0.0, 0.2, 0.0])
