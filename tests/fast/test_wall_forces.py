"""Tests of the forces on walls that are surfaces: they balance the momentum of the fluid."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.physics.wall_forces import room_for_forces, wall_forces
from debrisflow.run.probes import samplers
from debrisflow.space.domain import wall_names
from tests.building import (
    Plane,
    advance,
    boxes_from,
    felt,
    momentum_of,
    planes,
    started,
    tank3d_case,
)

LATTICE = reference(3, 2.4, 1.0)
WALLS = ("floor", "left", "right", "front", "back")
SLIDING = {"walls": {name: {"friction": {"law": "coulomb", "angle": 20.0}} for name in WALLS}}
ROUGH = {"walls": {name: {"friction": {"law": "log", "roughness": 0.01}} for name in WALLS}}
SLURRY = {
    "mixture": {"viscosity": 0.5},
    "strength": {"type": "bingham", "yield_stress": 50.0},
}
CASES = {
    "no-slip": {"water": {"viscosity": 1e-3}},
    "rough": ROUGH,
    "slurry": SLURRY,
    "slurry that slides": SLURRY | SLIDING,
}


def of_walls(position, reaction, *walls):
    """Return force and moment on each of several half spaces, of particles of 2 kg."""
    position, reaction = np.array(position, dtype=float), np.array(reaction, dtype=float)
    solid = planes(position, LATTICE, *walls)
    partial = room_for_forces(len(position), solid)
    density, push = np.ones(len(position)), 0.5 * reaction
    wall_forces(2.0, density, push, reaction, position, solid, partial)
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
    partial = room_for_forces(1, solid)
    wall_forces(1.0, np.ones(1), pressed, pressed, place, solid, partial)
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
    np.testing.assert_allclose(found[6:], [7.0, 0.0, 2.0])
