"""The step and the run: conservation, the same bits, no compilation twice."""

import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from debrisflow._jit import CACHE_DIRECTORIES, set_threads
from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.errors import NotConvergedError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import Particles
from debrisflow.physics.contact import collide
from debrisflow.physics.drag import drag_coefficient
from debrisflow.physics.viscosity import viscous_acceleration
from debrisflow.run import checkpoint, simulation
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.terms.collision_stress import PhaseCollisions
from debrisflow.schemes.terms.gravity import Gravity
from debrisflow.schemes.terms.pressure import PressureEquation
from debrisflow.schemes.terms.term import Step
from debrisflow.schemes.terms.viscosity import ExplicitViscosity
from debrisflow.space.gravity import gravity_vector
from debrisflow.validation.marching import advance
from tests.building import (
    WEN_YU,
    bed_case,
    energy_of,
    lattice_block,
    momentum_of,
    no_solid,
    one_list,
    settling_case,
    solid_of,
    started,
    tank_case,
)
from tests.fast.test_checkpoint import identical


@pytest.fixture
def rng():
    return np.random.default_rng(41)


@pytest.fixture
def exchanges(monkeypatch):
    """Return a list that grows by the number of pairs of every exchange of places."""
    counts, exchange = [], Particles.exchange

    def counted(particles, one, other):
        counts.append(one.size)
        exchange(particles, one, other)

    monkeypatch.setattr(Particles, "exchange", counted)
    return counts


def test_a_step_that_fails_leaves_the_state_as_it_was(monkeypatch):
    scheme, state = started(settling_case())
    advance(scheme, state, steps=45)
    dt = scheme.stable_dt(state)
    p = state.particles
    fresh = ("concentration", "granular_temperature", "number_density", "on_free_surface")
    before = {n: v.copy() for n, v in p.arrays().items() if n not in fresh}
    (equation,) = (term for term in scheme.terms if isinstance(term, PressureEquation))
    monkeypatch.setattr(equation.solver, "solve", lambda *_: -1)
    with pytest.raises(NotConvergedError):
        scheme.step(state, dt)
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(p, name), values, err_msg=name)
    monkeypatch.undo()
    other, whole = started(settling_case())
    advance(other, whole, steps=45)
    for which, now in ((scheme, state), (other, whole)):
        which.stable_dt(now)
        which.step(now, 0.5 * dt)
    assert identical(state, whole)


def test_forces_before_the_projection_add_up(rng):
    scheme, state = started(settling_case(water={"viscosity": 0.5}))
    p, dt = state.particles, 1e-3
    p.velocity[p.fluid, :2] = rng.normal(size=(p.fluid_count, 2))
    scene = scheme.observe(state)
    step = Step(scene, dt, p.velocity[p.moving].copy(), p.pressure.copy())
    for term in scheme.terms:
        if isinstance(term, Gravity | ExplicitViscosity | PhaseCollisions):
            term.act(step)
    viscous = np.empty((p.fluid_count, 3))
    viscous_acceleration(
        scene.velocity, p.density, scene.viscosity, scene.near, scene.solid, viscous
    )
    collisions = scene.collision_acceleration
    expected = p.velocity[p.fluid] + dt * (gravity_vector(scheme.case) + viscous + collisions)
    for part in (viscous, collisions):
        assert np.abs(part).max() > 1.0
    # one rounding of each part, relative to the greatest
    scale = np.abs(expected).max()
    np.testing.assert_allclose(step.velocity[p.fluid], expected, rtol=0.0, atol=1e-14 * scale)


def dropped(rng, **tables):
    """Return scheme and state of two phases amid a tall tank, with random velocities."""
    scheme, state = started(tank_case(12, 12, "two-phase", (40, 120), **tables))
    p = state.particles
    p.position[p.fluid, :2] += [0.14, 0.90]
    p.velocity[p.fluid, :2] = rng.uniform(-0.05, 0.05, (p.fluid_count, 2))
    return scheme, state


def drift_of_a_drop(scheme, state, until):
    """Return how much of the momentum that gravity gives is found too much or too little."""
    p = state.particles
    before, mass = momentum_of(p), p.density[p.fluid].sum()
    advance(scheme, state, until=until)
    expected = before + mass * gravity_vector(scheme.case) * state.time
    return np.abs(momentum_of(state.particles) - expected).max() / np.abs(expected).max()


def noise_of(state, gravity):
    """Return the kinetic energy of a drop that a fall from rest does not give."""
    p = state.particles
    return energy_of(p.density[p.fluid], p.velocity[p.fluid] - gravity * state.time)


@pytest.mark.parametrize(
    "tables",
    [{}, {"scheme": {"form": "study"}}, {"collision_stress": {"enabled": True}}],
    ids=["stable", "study", "collision-stress"],
)
def test_a_free_drop_gains_the_momentum_of_gravity_alone(rng, tables):
    scheme, state = dropped(rng, **tables)
    gravity = gravity_vector(scheme.case)
    noise = noise_of(state, gravity)
    # as long as it takes the pressure alone to stop the noise
    assert drift_of_a_drop(scheme, state, until=0.12) < 1e-12  # rounding of 120 steps
    p = state.particles
    assert p.fluid_count == 144
    assert p.position[p.fluid, 1].min() > 0.8
    # there was something to conserve: pressure and collisions have stopped the noise
    assert noise_of(state, gravity) < 0.6 * noise


@pytest.mark.parametrize(
    "tables",
    [
        {"drag": {"law": "gidaspow"}},
        {"drag": {"law": "wen-yu"}, "collision_stress": {"enabled": True}},
        {"rheology": {"type": "coulomb"}},
    ],
    ids=["drag", "drag-and-collision-stress", "strength"],
)
def test_a_free_drop_with_drag_or_strength_gains_the_momentum_of_gravity_alone(rng, tables):
    scheme, state = dropped(rng, **tables)
    p = state.particles
    p.relative_velocity[p.fluid, 1] = -0.2
    assert drift_of_a_drop(scheme, state, until=0.1) < 1e-12
    # there was something to conserve: drag has ended the slip, in air no pressure drives it
    if "drag" in tables:
        assert np.abs(state.particles.relative_velocity[p.fluid, 1]).mean() < 0.1


def passing_phases(law, c=0.3, speed=0.2):
    """Return scheme and state of a closed box without gravity whose phases pass each other."""
    walls = {name: {"slip": "free-slip"} for name in ("floor", "ceiling")}
    case = tank_case(20, 20, "two-phase", (20, 20), drag={"law": law}, walls=walls)
    plain = case.model_dump() | {"gravity": {"acceleration": 0.0}, "output": {"interval": 0.01}}
    plain["geometry"] |= {"periodic": True, "ceiling": True}
    plain["fill"][0]["sediment_share"] = c
    plain["time"] |= {"largest_step": None}
    scheme, state = started(complete(Case.model_validate(plain)))
    p = state.particles
    is_rock = p.sediment_fraction[p.fluid] > 0
    p.velocity[p.fluid, 0] = np.where(is_rock, speed * (1 - c), -speed * c)
    p.relative_velocity[p.fluid, 0] = speed
    return scheme, state


def slip_of(particles):
    """Return the mean velocity of sediment along x relative to that of water, m/s."""
    is_rock = particles.sediment_fraction[particles.fluid] > 0
    along = particles.velocity[particles.fluid, 0]
    return along[is_rock].mean() - along[~is_rock].mean()


def test_drag_brings_phases_that_pass_each_other_to_a_common_velocity():
    # du/dt = -K(u) [(1 - C) / rho_s + C / rho_l] u, in steps so small that the order is no matter
    c, start, dt = 0.3, 0.2, 1e-5
    scheme, state = passing_phases("wen-yu", c, start)
    exact, time = start, 0.0
    for until in (0.02, 0.05, 0.1):
        advance(scheme, state, until=until)
        while time < until:
            rate = drag_coefficient(c, exact, WEN_YU) * ((1 - c) / 2650.0 + c / 1000.0)
            exact, time = exact - dt * rate * exact, time + dt
        p = state.particles
        carried = p.relative_velocity[p.fluid, 0].mean()
        # C varies from place to place among two phases, and K with it
        assert carried == pytest.approx(exact, rel=0.10)
        # the velocities of the particles follow but for their collisions
        assert slip_of(p) == pytest.approx(exact, abs=0.1 * start)


def test_without_a_law_of_drag_nothing_slips():
    scheme, state = passing_phases("none")
    places = state.particles.position[state.particles.fluid].copy()
    order = state.particles.id[state.particles.fluid].copy()
    advance(scheme, state, steps=1)
    p = state.particles
    # each particle has moved by its own velocity, and none has exchanged places
    moved = p.position[p.fluid][np.argsort(p.id[p.fluid])] - places[np.argsort(order)]
    velocity = p.velocity[p.fluid][np.argsort(p.id[p.fluid])]
    period = scheme.domain.period[0]
    moved[:, 0] -= period * np.rint(moved[:, 0] / period)
    np.testing.assert_allclose(moved, state.time * velocity, atol=1e-15)
    assert not p.owed_displacement.any()


def collided(position, velocity, density, restitution, solid=None):
    """Return velocities after the collisions of particles with the spacing 1."""
    solid = no_solid() if solid is None else solid
    everyone = np.concatenate([position, solid.position])
    near = one_list(everyone, reference(2, 3.1, 1.0), wall_from=len(position))
    after = np.full_like(velocity, np.nan)
    collide(velocity, density, 0.9, restitution, near, solid, after)
    return after


@pytest.mark.parametrize("jitter", [0.1, 0.3, 1.0])
def test_collisions_conserve_momentum_and_lose_energy(rng, jitter):
    position = lattice_block(2, 15)
    count = len(position)
    position[:, :2] += rng.uniform(-jitter, jitter, (count, 2))
    velocity = np.zeros((count, 3))
    velocity[:, :2] = rng.normal(size=(count, 2))
    density = rng.choice([1000.0, 2650.0], count)
    after = collided(position, velocity, density, restitution=0.2)
    assert not np.array_equal(after, velocity)
    exchanged = density @ np.abs(after - velocity)
    assert np.abs(density @ (after - velocity)).max() < 1e-14 * exchanged.max()
    assert energy_of(density, after) < energy_of(density, velocity)


@pytest.mark.parametrize("restitution", [0.0, 0.2, 1.0])
def test_two_particles_part_with_their_restitution(restitution):
    position = np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0]])
    velocity = np.array([[1.0, 2.0, 0.0], [-1.0, 0.5, 0.0]])
    density = np.array([1000.0, 2650.0])
    after = collided(position, velocity, density, restitution)
    normal, along = np.array([0.6, 0.8, 0.0]), np.array([-0.8, 0.6, 0.0])
    approach = (velocity[0] - velocity[1]) @ normal
    assert (after[1] - after[0]) @ normal == pytest.approx(restitution * approach, abs=1e-14)
    np.testing.assert_allclose(after @ along, velocity @ along, atol=1e-15)
    np.testing.assert_allclose(density @ after, density @ velocity, rtol=1e-14)
    # those that part, or are farther than the distance, do not collide
    assert np.array_equal(collided(position, -velocity, density, restitution), -velocity)
    assert np.array_equal(collided(2 * position, velocity, density, restitution), velocity)


def test_a_wall_stops_what_comes_near_and_lets_it_slide():
    position, wall = np.array([[0.0, 0.3, 0.0]]), np.array([[0.2, -0.5, 0.0]])
    solid = solid_of(wall, (0.0, 1.0, 0.0), depth=0.5, velocity=0.0)
    velocity, density = np.array([[1.0, -2.0, 0.0]]), np.full(1, 1000.0)
    after = collided(position, velocity, density, 0.2, solid)
    np.testing.assert_allclose(after[0], [1.0, 0.4, 0.0], rtol=1e-15)
    position[0, 1] = 0.45  # farther than 0.9 d0 less half a spacing
    after = collided(position, velocity, density, 0.2, solid)
    assert np.array_equal(after, velocity)


def dam_break(**tables):
    """Return a dam break with so many particles that multigrid solves the pressure."""
    return tank_case(75, 80, "water", (150, 100), **tables)


@pytest.mark.parametrize("case", [dam_break, bed_case, settling_case])
def test_two_threads_compute_the_same_bits_as_one(case, exchanges):
    states = []
    try:
        for threads in (1, 2):
            assert set_threads(threads) == threads
            scheme, state = started(case())
            states.append(advance(scheme, state, steps=60))
    finally:
        set_threads(1)
    multigrid = states[0].particles.unknown_count >= Solver.MULTIGRID_FROM
    assert multigrid == (case is dam_break)
    assert sum(exchanges) > 0 or case is not settling_case
    assert identical(*states)


@pytest.mark.parametrize(
    ("case", "multigrid_from", "multigrid_below"),
    [
        (dam_break, 6000, 0.05),
        (bed_case, 6000, 0.05),
        (partial(bed_case, spacing=0.01), 500, 1.0),
        (settling_case, 6000, 0.05),
    ],
    ids=["dam_break", "bed", "bed with multigrid in all systems", "settling"],
)
def test_a_resumed_run_repeats_the_bits_of_an_uninterrupted_one(
    case, multigrid_from, multigrid_below, tmp_path, monkeypatch, exchanges, ends
):
    monkeypatch.setattr(Solver, "MULTIGRID_FROM", multigrid_from)
    monkeypatch.setattr(Solver, "MULTIGRID_BELOW", multigrid_below)
    whole, rest = tmp_path / "whole", tmp_path / "rest"
    output = {"interval": 0.02, "checkpoint_interval": 0.02}
    simulation.simulate(case(time={"end": 0.08}, output=output), whole)
    shutil.copytree(whole, rest)
    (rest / "summary.json").unlink()  # as if the run had not come to its end
    saved = checkpoint.load(rest / "checkpoint.h5").state
    assert 0 < saved.step < ends[0].step  # the last checkpoint is one of the middle
    simulation.resume(rest)
    assert identical(*ends)
    assert sum(exchanges) > 0 or case is not settling_case
    outputs = [
        f.relative_to(whole) for f in sorted(whole.rglob("*")) if f.suffix in (".vtu", ".csv")
    ]
    assert len(outputs) == 5 + 3  # frames; deposit, history and maxima
    for name in outputs:
        assert (whole / name).read_bytes() == (rest / name).read_bytes(), name


def test_the_first_frame_has_the_free_surface_that_the_first_step_finds():
    scheme, state = started(tank_case(12, 10, "water"))
    scheme.fill_number_density(state)
    p, rows = state.particles, slice(0, state.particles.unknown_count)
    n, on_free_surface = p.number_density[rows].copy(), p.on_free_surface[rows].copy()
    assert 12 <= on_free_surface[p.fluid].sum() < 3 * 12
    scheme.step(state, 1e-9)
    np.testing.assert_allclose(p.number_density[rows], n, rtol=1e-13)
    np.testing.assert_array_equal(p.on_free_surface[rows], on_free_surface)


def test_still_water_stays_in_its_tank():
    scheme, state = started(tank_case(20, 15, "water"))
    advance(scheme, state, until=0.25)
    p = state.particles
    assert p.fluid_count == 300
    assert not state.through_wall.any()
    assert not state.left.any()
    # sqrt(2 g d0) is the speed of falling by one spacing
    assert np.abs(p.velocity[p.fluid]).max() < np.sqrt(2 * 9.81 * 0.01)


def test_a_channel_may_be_empty_until_its_supply_arrives():
    case = bed_case()
    scheme, state = started(case.model_copy(update={"fill": ()}))
    advance(scheme, state, until=0.05)
    assert state.particles.fluid_count == state.entered.sum() > 0


PROLOGUE = """
import sys
from debrisflow import _jit
from debrisflow.physics import operators
from debrisflow.validation.marching import advance
from tests.building import *
"""
EPILOGUE = """
modules = [m for name, m in sys.modules.items() if name.startswith("debrisflow")]
kernels = {value for m in modules for value in vars(m).values() if hasattr(value, "stats")}
counts = [(sum(k.stats.cache_misses.values()), sum(k.stats.cache_hits.values())) for k in kernels]
print(*map(sum, zip(*counts)), _jit.CACHE_DIRECTORIES[-1])
"""
DENSITY = """
near = one_list(lattice_block(2, 8), reference(2, 3.1, 1.0))
operators.number_density(near, no_solid(), np.empty(64))
"""
STEPS = "advance(*started(bed_case()), steps=2)\n"
EXPLICIT_STEPS = """
block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.4], "z": [0.0, 0.4], "material": "mixture"}
tables = {"collision_stress": {"enabled": True}, "rheology": {"type": "coulomb"}}
advance(*started(tank3d_case(fill=[block], **tables)), steps=2)
"""


@pytest.mark.parametrize(
    ("work", "is_fresh"),
    [(DENSITY, True), (STEPS, False), (EXPLICIT_STEPS, False)],
    ids=["density", "step", "explicit step"],
)
def test_a_second_process_compiles_nothing(work, is_fresh, tmp_path):
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    if not is_fresh:
        # a whole step takes half a minute to compile, so that it begins with what the other tests
        # have compiled; a copy, since they may go on compiling meanwhile
        own = tmp_path / "debrisflow" / CACHE_DIRECTORIES[-1].name
        shutil.copytree(CACHE_DIRECTORIES[-1], own, ignore=shutil.ignore_patterns("*.tmp.*"))
    results = []
    for _ in range(2):
        run = subprocess.run(
            [sys.executable, "-c", PROLOGUE + work + EPILOGUE],
            env=environment,
            cwd=Path(__file__).parents[2],
            capture_output=True,
            text=True,
            check=True,
        )
        misses, hits, folder = run.stdout.strip().split(maxsplit=2)
        files = {file for file in Path(folder).rglob("*") if file.is_file()}
        results.append((int(misses), int(hits), files))
    (first_misses, _, first_files), (misses, hits, files) = results
    assert first_misses > 0 or not is_fresh
    assert misses == 0
    assert hits > 0
    assert files == first_files
    assert len(files) >= hits


def test_what_sinks_through_the_floor_before_a_recess_is_lost_at_once():
    scheme, state = started(bed_case())
    p = state.particles
    advance(scheme, state, steps=1)
    lost = int(np.argmax(p.position[p.fluid, 1]))
    p.position[lost, :2] = 0.1, -0.05  # the floor is at 0 there, the bottom of the recess at -0.1
    identity = p.id[lost]
    advance(scheme, state, steps=1)
    assert state.through_wall.sum() == 1
    assert identity not in p.id
