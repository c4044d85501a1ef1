"""The explicit step and its run: what it conserves, the same bits, what ends it."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
import pyvista

from debrisflow._jit import set_threads
from debrisflow.case.defaults import LARGEST_PATH
from debrisflow.errors import DivergedError
from debrisflow.neighbors.lists import FixedNeighbors
from debrisflow.run import checkpoint, simulation
from debrisflow.run.measures import elastic_energy, energies
from debrisflow.schemes.explicit import Explicit
from debrisflow.schemes.terms.density import Density
from debrisflow.space.mesh_pieces import pieces_of
from debrisflow.validation.marching import advance
from tests.building import momentum_of, started, tank3d_case
from tests.fast.test_checkpoint import identical

D0 = 0.05
PILLAR = {"type": "box", "name": "pillar", "x": [0.6, 0.7], "y": [0.1, 0.2], "z": [0.0, 0.2]}


def still_tank(**tables):
    """Return water 8 spacings deep in a tank of 8 by 8 spacings."""
    particles = {"spacing": D0}
    return tank3d_case(z=(0.0, 0.4), size=(0.4, 0.4, 0.6), particles=particles, **tables)


def dam_break(material="mixture", concentration=0.4, **tables):
    """Return a block in the corner of a tank, 6 by 4 by 6 of its 20 by 6 spacings."""
    block = {"type": "block", "x": [0.0, 0.3], "y": [0.0, 0.2], "z": [0.0, 0.3]}
    grains = {"grain_diameter": D0 / 3.0, "restitution": 0.8}
    tables = {
        "fill": [block | {"material": material}],
        "sediment": grains,
        "mixture": {"concentration": concentration},
        "particles": {"spacing": D0},
    } | tables
    return tank3d_case(size=(1.0, 0.3, 0.4), **tables)


def energy_of(case, particles):
    """Return the kinetic, potential and elastic energy of the fluid, J."""
    p, rows = particles, particles.fluid
    motion = p.position[rows], p.velocity[rows], p.density[rows], p.kind[rows]
    stored = elastic_energy(case, p.density[rows], p.kind[rows], p.compression[rows])
    return sum(energies(case, *motion)) + stored


def test_still_water_keeps_its_place_and_its_pressure():
    case = still_tank()
    scheme, state = started(case)
    p, rows = state.particles, state.particles.fluid
    lowest, errors = [], []
    start = p.position[rows, 2].mean()
    for until in np.arange(0.02, 0.31, 0.02):
        advance(scheme, state, until=until)
        height, expected = p.position[rows, 2], 9810.0 * (0.4 - p.position[rows, 2])
        lowest.append((p.pressure[rows] / expected)[height < D0].mean())
        errors.append((p.pressure[rows] - expected)[height < 0.3])
        # 1 % of the depth; the least that a layer could sink or swell is d0
        assert p.position[rows, 2].mean() == pytest.approx(start, abs=0.004)
        # the uppermost row carries the pressure of its weight
        assert p.position[rows, 2].max() + 0.5 * D0 == pytest.approx(0.4, abs=0.1 * D0)
    # the fluid swings about its rest: the mean is that of rest, each moment within a tenth
    assert np.mean(lowest) == pytest.approx(1.0, abs=0.05)
    assert max(np.sqrt(np.mean(e**2)) for e in errors) < 0.1 * 9810.0 * 0.4
    # sqrt(2 g d0), about 1 m/s, is the speed of falling by one spacing
    assert np.abs(p.velocity[rows]).max() < 0.2 * np.sqrt(2 * 9.81 * D0)
    assert p.fluid_count == 8**3
    assert not state.left.any()
    assert not state.through_wall.any()


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_film_of_a_few_rows_stands_on_its_pressure(rows):
    scheme, state = started(tank3d_case(z=(0.0, 0.1 * rows), size=(0.8, 0.8, 1.0)))
    advance(scheme, state, until=0.5)
    p, speeds = state.particles, []
    for until in np.arange(0.6, 1.05, 0.1):
        advance(scheme, state, until=until)
        speeds.append(np.sum(p.velocity[p.fluid] ** 2, axis=1).mean())
    height = np.sort(p.position[p.fluid, 2])[:64].mean()
    assert height == pytest.approx(0.05, rel=0.06)  # 0.498, 0.473 and 0.493 spacings
    assert np.sqrt(np.mean(speeds)) < 0.016  # 3, 7 and 15 mm/s
    assert state.bounces == 0


@pytest.mark.parametrize("enabled", [False, True], ids=["plain", "collision-stress"])
def test_a_free_drop_gains_the_momentum_of_gravity_alone(enabled):
    block = {"type": "block", "x": [0.4, 0.7], "y": [0.4, 0.7], "z": [0.6, 0.9]}
    case = tank3d_case(
        size=(1.1, 1.1, 1.2),
        particles={"spacing": D0},
        fill=[block | {"material": "mixture"}],
        collision_stress={"enabled": enabled},
    )
    scheme, state = started(case)
    p, rows = state.particles, state.particles.fluid
    p.velocity[rows] = np.random.default_rng(3).uniform(-0.3, 0.3, (6**3, 3))
    noise = np.sum((p.velocity[rows] - p.velocity[rows].mean(axis=0)) ** 2)
    before, mass = momentum_of(p), p.density[rows].sum()
    advance(scheme, state, steps=50)
    expected = before + mass * np.array([0.0, 0.0, -9.81]) * state.time
    # rounding of 50 steps
    drift = np.abs(momentum_of(p) - expected).max() / np.abs(expected).max()
    assert drift < 1e-12
    # there was something to conserve: pressure, damping and collisions have stopped the noise
    assert np.sum((p.velocity[rows] - p.velocity[rows].mean(axis=0)) ** 2) < 0.6 * noise
    assert p.position[rows, 2].min() > 0.5


def test_a_dam_break_gains_no_energy():
    case = dam_break("water")
    scheme, state = started(case)
    start = energy_of(case, state.particles)
    for until in np.arange(0.05, 0.61, 0.05):
        advance(scheme, state, until=until)
        # the bottom is the zero of height, so that the start is twice what can be set free
        assert energy_of(case, state.particles) < 1.005 * start
    assert state.particles.position[state.particles.fluid, 0].max() > 0.9  # it has crossed the tank
    assert not state.through_wall.any()


def test_grains_hold_back_a_collapse_the_more_the_denser_they_stand():
    reached = {}
    for name, c, enabled in (("none", 0.4, False), ("loose", 0.4, True), ("dense", 0.5, True)):
        case = dam_break(concentration=c, collision_stress={"enabled": enabled})
        scheme, state = started(case)
        advance(scheme, state, until=0.4)
        reached[name] = state.particles.position[state.particles.fluid, 0].mean() - 0.15
    # a difference of less than a tenth might be chance: the shear is spread over few particles
    assert reached["dense"] < 0.9 * reached["loose"]
    assert reached["loose"] < 0.9 * reached["none"]


def test_the_agitation_of_the_study_stays_bounded():
    # without the cap this is where the fluid blows up
    stress = {"enabled": True, "granular_temperature": "neighborhood"}
    case = dam_break(concentration=0.5, collision_stress=stress)
    scheme, state = started(case)
    start = energy_of(case, state.particles)
    for until in np.arange(0.05, 0.41, 0.05):
        advance(scheme, state, until=until)
        p, rows = state.particles, state.particles.fluid
        assert energy_of(case, p) < 1.005 * start
        # twice the speed of a fall from the top
        assert np.linalg.norm(p.velocity[rows], axis=1).max() < 2.0 * np.sqrt(2 * 9.81 * 0.3)
    assert p.granular_temperature[rows].max() > 0.0
    assert p.fluid_count == 6 * 4 * 6


def test_two_threads_compute_the_same_bits_as_one():
    states = []
    size = {"particles": {"spacing": 0.025}, "obstacle": [PILLAR]}  # some blocks of particles
    try:
        for threads in (1, 2):
            assert set_threads(threads) == threads
            scheme, state = started(dam_break(collision_stress={"enabled": True}, **size))
            states.append(advance(scheme, state, steps=60))
    finally:
        set_threads(1)
    assert states[0].particles.fluid_count == 12 * 8 * 12
    assert identical(*states)


def probed_dam_break():
    """Return a short run with everything that a checkpoint must carry: passages, arrivals."""
    probes = (
        {"name": "front", "type": "section", "interval": 0.01, "x": 0.32},
        {"name": "level", "type": "height", "interval": 0.007, "x": 0.35, "y": 0.15},
        {"name": "load", "type": "force", "interval": 0.02, "wall": "pillar"},
    )
    return dam_break(
        probe=probes,
        obstacle=[PILLAR | {"x": [0.4, 0.5]}],
        collision_stress={"enabled": True},
        time={"end": 0.2},
        output={"interval": 0.04},
    )


def test_a_resumed_run_repeats_the_bits_of_an_uninterrupted_one(tmp_path, ends):
    whole, rest = tmp_path / "whole", tmp_path / "rest"
    simulation.simulate(probed_dam_break(), whole, threads=1)
    shutil.copytree(whole, rest)
    (rest / "summary.json").unlink()  # as if the run had not come to its end
    saved = checkpoint.load(rest / "checkpoint.h5").state
    assert 0 < saved.step < ends[0].step  # the last checkpoint is one of the middle
    assert any(np.any(saved.sums[name] != ends[0].sums[name]) for name in saved.sums)
    simulation.resume(rest, threads=1)
    assert identical(*ends)
    outputs = {f.relative_to(whole) for f in whole.rglob("*") if f.suffix in (".vtu", ".csv")}
    names = {file.name for file in outputs}
    tables = {"deposit", "history", "maxima", "front", "level", "load"}
    assert {name.removesuffix(".csv") for name in names if name.endswith(".csv")} == tables
    assert {f"{frame:06d}.vtu" for frame in range(6)} < names
    for name in outputs:
        assert (whole / name).read_bytes() == (rest / name).read_bytes(), name


def displaced(case, *places, steps=1):
    """Return the state some steps after the last one before particles are sorted.

    At that one the first particles were put at other places.
    """
    scheme, state = started(case)
    advance(scheme, state, steps=Explicit.REFRESH - 1)
    for row, place in enumerate(places):
        state.particles.position[row] = place
        state.particles.velocity[row] = 0.0
    return advance(scheme, state, steps=steps)


def test_what_is_over_the_rim_has_left_and_what_is_below_it_went_through_a_wall():
    # beside the tank above its rim at 0.6 m; beside it below the rim; under the floor
    state = displaced(still_tank(), (0.8, 0.2, 0.7), (0.8, 0.2, 0.3), (0.2, 0.2, -0.4))
    assert state.particles.fluid_count == 8**3 - 3
    assert state.left.tolist() == [1, 0, 0]
    assert state.through_wall.tolist() == [2, 0, 0]


def test_what_went_into_an_obstacle_is_taken_out_when_the_particles_are_sorted():
    thick = PILLAR | {"x": [0.6, 0.8], "y": [0.05, 0.25]}
    case, inside = dam_break(obstacle=[thick]), (0.68, 0.13, 0.12)  # in the second layer
    assert not displaced(case, inside, steps=1).through_wall.any()
    state = displaced(case, inside, steps=2)
    assert state.through_wall.tolist() == [0, 0, 1]
    assert not state.left.any()
    assert state.particles.fluid_count == 6 * 4 * 6 - 1


def test_elements_of_meshes_are_sorted_once(monkeypatch, tmp_path):
    sorted_elements, begin = [], FixedNeighbors.__init__

    def counted(self, points, *others):
        sorted_elements.append(len(points))
        begin(self, points, *others)

    monkeypatch.setattr(FixedNeighbors, "__init__", counted)
    pyvista.Cube(bounds=(0.6, 0.7, 0.1, 0.2, 0.0, 0.2)).triangulate().save(tmp_path / "rock.stl")
    rock = {"type": "mesh", "name": "rock", "file": str(tmp_path / "rock.stl")}
    case = dam_break(obstacle=[rock])
    scheme, state = started(case)
    advance(scheme, state, steps=2 * Explicit.REFRESH + 5)
    assert sorted_elements == [len(pieces_of(case, 0.0)[0])]


def test_walls_of_three_dimensions_are_no_particles():
    _, state = started(dam_break(obstacle=[PILLAR]))
    assert state.particles.count == state.particles.fluid_count == 6 * 4 * 6


def test_a_velocity_that_is_no_number_ends_the_step_before_it_spoils_the_state():
    scheme, state = started(still_tank())
    advance(scheme, state, steps=7)
    dt = scheme.stable_dt(state)
    p = state.particles
    p.velocity[20, 1] = np.nan
    position, velocity = p.position.copy(), p.velocity.copy()
    with pytest.raises(DivergedError, match=r"step 7, particle \d+ at .* got the velocity .*nan"):
        scheme.step(state, dt)
    np.testing.assert_array_equal(p.position, position)
    np.testing.assert_array_equal(p.velocity, velocity)
    assert scheme.stable_dt(state) == 0.0


def test_a_run_that_diverges_says_where_and_keeps_its_last_checkpoint(tmp_path, monkeypatch):
    step = Explicit.step

    def step_and_spoil(scheme, state, dt):
        if state.step == 9:
            state.particles.pressure[:] = np.nan
            scheme.terms = tuple(term for term in scheme.terms if not isinstance(term, Density))
        return step(scheme, state, dt)

    monkeypatch.setattr(Explicit, "step", step_and_spoil)
    with pytest.raises(
        DivergedError, match=r"(?s)at t = .* s, step 9, particle \d+ at .*checkpoint"
    ):
        simulation.simulate(still_tank(), tmp_path / "run", threads=1)
    kept = checkpoint.load(tmp_path / "run" / "checkpoint.h5").state
    assert kept.step == 0  # the state that failed replaces none
    assert np.all(np.isfinite(kept.particles.position))
    assert np.all(np.isfinite(kept.particles.velocity))


def test_the_time_step_obeys_sound_path_and_viscosity():
    case = still_tank(scheme={"sound_speed": 30.0, "courant": 0.5})
    scheme, state = started(case)
    p = state.particles
    acoustic = 0.5 * D0 / 30.0
    assert scheme.stable_dt(state) == pytest.approx(acoustic, rel=1e-14)
    p.velocity[3] = [0.0, -60.0, 80.0]
    assert scheme.stable_dt(state) == pytest.approx(LARGEST_PATH * D0 / 100.0, rel=1e-14)
    p.velocity[3] = 0.0
    viscous = still_tank(water={"viscosity": 2000.0})  # nu = 2 m2/s
    scheme, state = started(viscous)
    assert scheme.stable_dt(state) == pytest.approx(0.2 * D0**2 / 2.0, rel=1e-14)


def test_the_time_step_obeys_colliding_grains():
    scheme, state = started(dam_break(collision_stress={"enabled": True}))
    quiet = scheme.stable_dt(state)
    rows = state.particles.fluid
    state.particles.velocity[rows, 0] = 400.0 * state.particles.position[rows, 2]
    scheme.fill_number_density(state)  # the pressure of grains fades where n is less than n0
    state.step += 1  # a scheme observes once at each step
    density = 1000.0 + 0.4 * 1650.0
    found = scheme.stable_dt(state)
    temperature = state.particles.granular_temperature[rows]
    # equation (10) by hand: g0, then viscosity of the hottest and stiffness of the hardest pressed
    g0 = 1.0 / (1.0 - (0.4 / scheme.case.sediment.packing_limit) ** (1.0 / 3.0))
    shared = 0.4**2 * 2650.0 * g0 * 1.8
    viscosity = 0.8 * D0 / 3.0 * shared * np.sqrt(temperature.max() / np.pi) / density
    assert found <= 0.2 * D0**2 / viscosity * (1.0 + 1e-12)
    most = np.max(state.particles.collision_pressure[rows]) / density * (2.0 + g0 / 3.0)
    assert most > 0.0
    assert found <= 0.2 * D0 / np.sqrt(most) * (1.0 + 1e-12)
    assert found < 0.1 * quiet


def test_a_tank_that_has_lost_all_its_fluid_is_observed_and_stepped():
    scheme, state = started(tank3d_case())
    p = state.particles
    p.position[p.fluid, 2] = 100.0
    advance(scheme, state, steps=scheme.REFRESH + 1)
    assert p.fluid_count == 0
    assert state.left.sum() > 0


def test_fluid_that_runs_over_rim_and_pier_leaves_and_goes_through_no_wall():
    pier = PILLAR | {"x": [0.6, 0.8], "y": [0.0, 0.2], "z": [0.0, 0.4]}
    block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.3], "z": [0.0, 0.4]}
    fill = [block | {"material": "water", "velocity": [3.0, 0.0, 2.0]}]
    scheme, state = started(
        tank3d_case(size=(1.0, 0.3, 0.4), fill=fill, obstacle=[pier], particles={"spacing": D0})
    )
    advance(scheme, state, until=0.5)
    assert state.left.sum() > 20
    assert state.through_wall.sum() == 0
