"""Tests of the forces on walls that are surfaces: they balance the momentum of the fluid."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.patches import Patch, no_patches, patches_of, shares
from debrisflow.physics.wall_forces import room_for_forces, share_in_patch, wall_forces
from debrisflow.run.probes import samplers
from debrisflow.space.domain import wall_names
from debrisflow.validation.marching import advance
from tests.building import Plane, boxes_from, felt, momentum_of, planes, started, tank3d_case

LATTICE = reference(3, 2.4, 1.0)
NO_PATCHES = no_patches()
WALLS = ("floor", "left", "right", "front", "back")
SLIDING = {"walls": {name: {"friction": {"law": "coulomb", "angle": 20.0}} for name in WALLS}}
ROUGH = {"walls": {name: {"friction": {"law": "log", "roughness": 0.01}} for name in WALLS}}
SLURRY = {
    "mixture": {"viscosity": 0.5},
    "rheology": {"type": "bingham", "yield_stress": 50.0},
}
CASES = {
    "no-slip": {"water": {"viscosity": 1e-3}},
    "rough": ROUGH,
    "slurry": SLURRY,
    "slurry that slides": SLURRY | SLIDING,
}


def of_walls(position, reaction, *walls, patches=NO_PATCHES):
    """Return force and moment on each of several half spaces, of particles of 2 kg."""
    position, reaction = np.array(position, dtype=float), np.array(reaction, dtype=float)
    solid = planes(position, LATTICE, *walls)
    partial = room_for_forces(len(position), solid, patches)
    density, push = np.ones(len(position)), 0.5 * reaction
    wall_forces(2.0, density, push, reaction, position, solid, patches, partial)
    return partial.sum(axis=0)


def test_a_wall_takes_what_it_does_to_a_particle_at_its_foot():
    (found,) = of_walls([[3.0, 1.0, 0.5]], [[-1.0, 0.0, 4.0]], Plane())
    np.testing.assert_allclose(found[:3], [2.0, 0.0, -8.0])
    np.testing.assert_allclose(found[3:], np.cross([3.0, 1.0, 0.0], [2.0, 0.0, -8.0]))


def test_in_a_corner_each_face_takes_what_is_across_it_and_the_nearest_the_rest():
    walls = Plane(), Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    floor, side = of_walls([[0.7, 0.0, 0.5]], [[3.0, 0.5, 4.0]], *walls)
    np.testing.assert_allclose(floor[:3], [0.0, -1.0, -8.0])
    np.testing.assert_allclose(side[:3], [-6.0, 0.0, 0.0])


def test_in_a_corner_of_a_tank_each_wall_pushes_by_its_own_and_along_the_other():
    inf = np.inf
    corner = boxes_from([[-inf, -inf, -inf], [-inf, -inf, 0.0]], [[inf, inf, 0.0], [0.0, inf, inf]])
    place, pressed = np.array([[0.5, 0.0, 0.5]]), np.array([[3.0, 0.0, 4.0]])
    number = np.tile(np.arange(2)[:, None, None], (1, 3, 2))
    number[1, 2, 0] = -1  # the floor covers it
    corner = corner._replace(number=number)
    solid = felt(place, LATTICE, corner, slip=(1.0, 1.0))
    partial = room_for_forces(1, solid, no_patches())
    wall_forces(1.0, np.ones(1), pressed, pressed, place, solid, NO_PATCHES, partial)
    floor, side = partial.sum(axis=0)[:, :3]
    np.testing.assert_allclose(floor + side, -pressed[0])
    # a fifth of the push of a plane is missing in the sum of both, and goes through the other
    assert 1.2 < side[0] / -3.0 < 1.3
    assert side[0] / -3.0 == pytest.approx(floor[2] / -4.0, rel=0.02)


def test_all_walls_together_take_the_reaction_on_all_particles(rng):
    walls = Plane(), Plane((0.0, 0.0, 0.0), (0.8, 0.0, 0.6)), Plane((0, 0, 0), (0.0, 0.6, 0.8))
    position = rng.uniform((0.3, 0.3, 1.3), (1.5, 1.5, 2.5), (300, 3))
    position = np.concatenate([position, rng.uniform(0.3, 1.0, (100, 3))])
    reaction = rng.normal(size=position.shape)
    solid = planes(position, LATTICE, *walls)
    reaction[solid.row < 0] = 0.0
    found = of_walls(position, reaction, *walls)[:, :3].sum(axis=0)
    np.testing.assert_allclose(found, -2.0 * reaction.sum(axis=0), atol=1e-10)


def of_patches(*patches, period=(0.0, 0.0, 0.0), dimension=3):
    """Return patches of (wall, center, normal, size) where particles are 1 m apart."""
    found = [Patch(wall, np.array(c), np.array(n), size) for wall, c, n, size in patches]
    return patches_of(found, 1.0, dimension, np.array(period))


def test_a_patch_takes_the_share_of_a_particle_whose_square_it_covers():
    up, aside = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]
    patches = of_patches(
        (0, [3.0, 1.0, 0.0], up, 2.0),  # covers the square of the particle
        (0, [4.0, 1.0, 0.0], up, 2.0),  # one half of it
        (0, [4.0, 2.25, 0.0], up, 2.0),  # half times a quarter
        (0, [3.0, 1.0, 0.0], up, 0.5),  # it lies in the square: half times half
        (0, [4.5, 1.0, 0.0], up, 2.0),  # beside it
        (0, [3.0, 1.0, 0.6], up, 2.0),  # over it
        (0, [3.0, 1.0, 0.0], aside, 2.0),  # of a face that looks elsewhere
        (1, [3.0, 1.0, 0.0], up, 2.0),  # of another wall
    )
    found = of_walls(
        [[3.0, 1.0, 0.5]],
        [[-1.0, 0.0, 4.0]],
        Plane(),
        Plane((-9.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        patches=patches,
    )
    covered = np.array([1.0, 0.5, 0.125, 0.25, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(found[2:, :3], covered[:, None] * [2.0, 0.0, -8.0])


def test_patches_side_by_side_share_out_the_force_on_a_wall(rng):
    position = rng.uniform((0.5, 0.5, 0.3), (3.5, 3.5, 1.5), (200, 3))
    reaction = rng.normal(size=position.shape)
    sides = np.arange(0.0, 4.1, 0.8) + 0.4
    tiles = of_patches(*((0, [x, y, 0.0], [0.0, 0.0, 1.0], 0.8) for x in sides for y in sides))
    found = of_walls(position, reaction, Plane(), patches=tiles)
    assert np.ptp(found[1:, 2]) > 10.0
    np.testing.assert_allclose(found[1:, :3].sum(axis=0), found[0, :3], atol=1e-11)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("period", [(0.0, 0.0, 0.0), (6.0, 0.0, 0.0)])
def test_places_of_cells_and_feet_of_particles_have_the_same_share(rng, dimension, period):
    tilt = np.radians(25.0)
    normals = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [np.sin(tilt), np.cos(tilt), 0.0]]
    normals += [[0.0, 0.0, 1.0], [-np.sin(tilt), 0.0, np.cos(tilt)]] if dimension == 3 else []
    for normal in np.array(normals):
        center = np.array([1.0, 2.0, 0.0])
        patches = of_patches((0, center, normal, 3.0), period=period, dimension=dimension)
        place = center + rng.uniform(-6.5, 6.5, (400, 3))
        place -= ((place - center) @ normal)[:, None] * normal  # on the plane
        place[:, dimension:] = 0.0
        found = shares(0, patches, place, np.tile(normal, (400, 1)))
        of_feet = [share_in_patch(*foot, *normal, 0, patches) for foot in place]
        np.testing.assert_allclose(found, of_feet, atol=1e-12)
        assert 0.0 < found.mean() < 1.0
        # the squares of places spread evenly cover the patch
        along = patches.frame[0, 1]
        line = center + (np.arange(-3, 4) + 0.3)[:, None] * along
        total = shares(0, patches, line, np.tile(normal, (7, 1))).sum()
        assert total == pytest.approx(3.0)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.mark.parametrize("name", CASES)
def test_the_walls_take_the_weight_less_what_the_momentum_of_the_fluid_grows_by(name):
    tables = CASES[name]
    material = "mixture" if "mixture" in tables else "water"
    block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.5], "z": [0.0, 0.6]}
    probe = {"name": "push", "type": "force", "wall": "floor", "interval": 0.1}
    case = tank3d_case(fill=[block | {"material": material}], probe=[probe], **tables)
    scheme, state = started(case)
    mass = 0.1**3 * state.particles.density[state.particles.fluid].sum()
    weight = np.array([0.0, 0.0, -9.81 * mass])
    for _ in range(60):
        before, start = momentum_of(state.particles), state.time
        advance(scheme, state, 1)
        gained = 0.1**3 * (momentum_of(state.particles) - before) / (state.time - start)
        force = state.wall_force[:, :3].sum(axis=0)
        np.testing.assert_allclose(force, weight - gained, atol=1e-6 * 9.81 * mass)
    assert np.abs(gained).max() > 0.05 * 9.81 * mass  # it moves


def test_a_probe_gives_the_mean_since_the_row_before():
    probe = {"name": "push", "type": "force", "wall": "right", "about": [1.0, 0.0, 0.0]}
    case = tank3d_case(probe=[probe | {"interval": 0.1}])
    _, state = started(case)
    (sampler,) = samplers(case, state).values()
    number = wall_names(case).index("right")
    state.time, state.wall_force = 0.0, np.zeros((len(wall_names(case)), 6))
    state.wall_force[number] = [5.0, 0.0, 0.0, 0.0, 3.0, 1.0]
    assert sampler.sample(state)[:6] == (5.0, 0.0, 0.0, 0.0, 3.0, 1.0)  # at rest
    for dt, push in [(0.25, 4.0), (0.75, 8.0)]:
        state.time, state.dt, state.wall_force[number, 0] = state.time + dt, dt, push
        state.wall_force[number, 2] = 2.0
        sampler.add_step(state)
    found = sampler.sample(state)
    np.testing.assert_allclose(found[:3], [7.0, 0.0, 2.0])
    # the moment about (1, 0, 0) of 2 N along z is 2 N m about -y less
    np.testing.assert_allclose(found[3:6], [0.0, 3.0 + 2.0, 1.0])
    np.testing.assert_allclose(found[6:9], [7.0, 0.0, 2.0])
    np.testing.assert_allclose(found[9:15], [4.0, 8.0, 0.0, 0.0, 2.0, 2.0])  # least and greatest


def test_a_patch_gives_its_mean_reaction_since_the_row_before():
    place = {"x": 0.8, "y": 0.3, "z": 0.2, "size": 0.2, "interval": 0.1}
    gauge = {"type": "pressure", "wall": "right"} | place
    floor = gauge | {"wall": "floor", "x": 0.3, "z": 0.0}
    case = tank3d_case(probe=[floor | {"name": "other"}, gauge | {"name": "gauge"}])
    _, state = started(case)
    _, sampler = samplers(case, state).values()
    numbers = [wall_names(case).index(name) for name in ("floor", "right")]
    assert state.patches.wall.tolist() == numbers
    state.time, state.patch_force = 0.0, np.array([[7.0, 7.0, 7.0], [3.0, 9.0, 9.0]])
    assert sampler.sample(state)[1] == pytest.approx(3.0 / 0.2**2)  # at rest
    for dt, push in [(0.25, 4.0), (0.75, 8.0)]:
        state.time, state.dt, state.patch_force[1] = state.time + dt, dt, [push, 0.0, 0.0]
        sampler.add_step(state)
    area = 0.2**2
    assert sampler.sample(state)[1:] == pytest.approx((7.0 / area, 4.0 / area, 8.0 / area))
