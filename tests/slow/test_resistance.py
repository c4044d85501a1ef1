"""Whole steps of the explicit scheme with a rheological law: what rests, slides and weighs."""

import shutil

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.errors import DivergedError, NotConvergedError
from debrisflow.run import simulation
from debrisflow.schemes.explicit import Explicit
from debrisflow.validation.marching import advance
from tests.building import momentum_of, started, tank3d_case
from tests.fast.test_checkpoint import identical

D0 = 0.02
G, WATER, ROCK, C = 9.81, 1000.0, 2650.0, 0.5
MIXTURE = WATER + C * (ROCK - WATER)
DEPTH = 5 * D0
ANGLE = 30.0
COULOMB = {"type": "coulomb", "friction_angle": ANGLE}
DRY = COULOMB | {"saturated": False}


def layer(slope=0.0, rheology=COULOMB, rows=(("mixture", 5),), floor="no-slip", **tables):
    """Return a case: layers of so many rows in a channel that repeats, with smooth side walls."""
    length, width, top, fill = 10 * D0, 4 * D0, 0.0, []
    for material, count in rows:
        block = {"type": "block", "x": [0.0, length], "y": [0.0, width], "material": material}
        fill.append(block | {"z": [top, top + count * D0]})
        top += count * D0
    walls = {name: {"slip": "free-slip"} for name in ("front", "back")}
    channel = {"type": "channel3d", "length": length, "width": width, "height": 2.0 * top}
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    return complete(
        Case(
            title="layer",
            particles={"spacing": D0},
            gravity={"slope": slope},
            geometry=channel | {"periodic": True},
            walls=walls | {"floor": {"slip": floor}},
            fill=fill,
            mixture={"concentration": C},
            rheology=rheology,
            **tables,
        )
    )


def by_id(particles, values):
    """Return values of the fluid in the order of the particles at the start."""
    return values[np.argsort(particles.id[particles.fluid])]


def moved(case, until):
    """Return how far each particle of a layer came, (n, 3) m, and the last state."""
    scheme, state = started(case)
    p = state.particles
    start = by_id(p, p.position[p.fluid])
    advance(scheme, state, until=until)
    way = by_id(p, p.position[p.fluid]) - start
    way[:, 0] -= case.geometry.length * np.rint(way[:, 0] / case.geometry.length)
    return way, state


@pytest.mark.parametrize("slope", [10.0, 15.0])
def test_dry_grains_stay_on_a_slope_below_their_friction_angle(slope):
    way, state = moved(layer(slope, DRY), until=0.2)
    # a mass without friction would have run 0.03 m or more, 1.7 d0
    assert 0.0 < way[:, 0].mean() < 0.01 * D0
    assert np.abs(way).max() < 0.1 * D0
    assert state.particles.velocity[state.particles.fluid, 0].mean() < 1e-3


def test_a_slurry_stays_below_its_yield_stress_and_runs_above():
    stress = MIXTURE * G * DEPTH * np.sin(np.radians(10.0))
    for share, law in ((1.5, "bingham"), (0.5, "bingham"), (1.5, "herschel-bulkley")):
        rheology = {"type": law, "yield_stress": share * stress}
        if law == "herschel-bulkley":
            rheology |= {"consistency": 1.0, "exponent": 0.5}
        way, state = moved(layer(10.0, rheology), until=0.4)
        if share > 1.0:
            assert np.abs(way[:, 0]).mean() < 0.01 * D0
        else:
            # the floor holds half of the weight along the slope, give or take as the lowest row
            # passes those of the floor
            p = state.particles
            expected = 0.5 * G * np.sin(np.radians(10.0)) * 0.4
            assert p.velocity[p.fluid, 0].mean() == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("slope", [34.0, 38.0])
def test_dry_grains_above_their_friction_angle_slide_with_what_friction_leaves(slope):
    scheme, state = started(layer(slope, DRY))
    p, angle = state.particles, np.radians(slope)
    advance(scheme, state, until=0.1)
    before, time = p.velocity[p.fluid, 0].mean(), state.time
    advance(scheme, state, until=0.4)
    acceleration = (p.velocity[p.fluid, 0].mean() - before) / (state.time - time)
    friction = np.tan(angle) - acceleration / (G * np.cos(angle))
    # that of the start of motion counts in full, so that little is left of the acceleration
    assert friction == pytest.approx(np.tan(np.radians(ANGLE)), rel=0.05)


@pytest.mark.parametrize("rheology", [{"type": "none"}, DRY], ids=["fluid", "coulomb"])
def test_a_layer_on_a_smooth_slope_gains_what_gravity_gives(rheology):
    scheme, state = started(layer(35.0, rheology, floor="free-slip"))
    p = state.particles
    advance(scheme, state, until=0.2)
    expected = G * np.sin(np.radians(35.0)) * state.time
    # the rows of the wall's particles are felt as the layer runs over them
    assert p.velocity[p.fluid, 0].mean() == pytest.approx(expected, rel=0.02)


def test_grains_of_a_saturated_mixture_carry_the_buoyant_share():
    _, state = moved(layer(), until=0.05)
    p = state.particles
    rows = p.fluid
    share = C * (ROCK - WATER) / MIXTURE
    half_row = 0.5 * D0 * C * (ROCK - WATER) * G
    expected = np.maximum(share * p.pressure[rows], half_row)
    # the step after that of the pressure
    np.testing.assert_array_equal(p.grain_pressure[rows], expected)
    deep = p.position[rows, 2] < 0.5 * DEPTH
    weight = C * (ROCK - WATER) * G * (DEPTH - p.position[rows, 2])
    assert p.grain_pressure[rows][deep].mean() == pytest.approx(weight[deep].mean(), rel=0.1)


def test_dry_grains_carry_all_of_the_pressure():
    _, state = moved(layer(rheology=DRY), until=0.02)
    p = state.particles
    half_row = 0.5 * D0 * C * ROCK * G
    np.testing.assert_allclose(
        p.grain_pressure[p.fluid], np.maximum(p.pressure[p.fluid], half_row), rtol=1e-14
    )


def by_row(particles, case, values, rows):
    """Return the mean of values over each row of the start, from the floor up."""
    _, initial = started(case)
    q = initial.particles
    row = (by_id(q, q.position[q.fluid, 2]) / D0).astype(int)
    of_start = by_id(particles, values)
    return np.array([of_start[row == k].mean() for k in range(rows)])


def test_water_over_a_bed_adds_nothing_to_what_its_grains_carry():
    weight = C * (ROCK - WATER) * G * D0 * np.arange(4.5, 0.0, -1.0)
    for water in (3, 7):
        case = layer(rows=(("mixture", 5), ("water", water)))
        _, state = moved(case, until=0.1)
        p = state.particles
        found = by_row(p, case, p.grain_pressure[p.fluid], 5 + water)
        # to within a quarter of a row, over which the surface of the bed is known
        np.testing.assert_allclose(found[:5], weight, atol=0.25 * weight[-1] * 2.0)
        assert found[6:].max() < 0.01 * weight[0]


def test_layers_of_different_density_start_at_rest_and_stay():
    rows = (("mixture", 5), ("water", 4))
    case = layer(rows=rows)
    way, state = moved(case, until=0.3)
    p = state.particles
    density = np.array([MIXTURE] * 5 + [WATER] * 4)
    load = G * D0 * (np.cumsum(density[::-1])[::-1] - 0.5 * density)
    error = by_row(p, case, p.pressure[p.fluid], 9) - load
    # half a row of water
    assert np.sqrt(np.mean(error**2)) < 0.05 * load[0]
    # the bed stands where it stood, and its surface with it
    bed = by_id(p, p.sediment_fraction[p.fluid]) > 0.0
    assert np.abs(way[bed, 2]).max() < 0.05 * D0
    assert np.abs(way[bed, :2]).max() < 0.05 * D0
    # sqrt(2 g d0), 0.6 m/s, is the speed of falling by one row
    assert np.abs(p.velocity[p.fluid]).max() < 0.1 * np.sqrt(2 * G * D0)


def test_a_fall_with_a_strength_law_gains_the_momentum_of_gravity():
    block = {"type": "block", "x": [0.2, 0.32], "y": [0.2, 0.32], "z": [0.4, 0.52]}
    case = tank3d_case(
        size=(0.52, 0.52, 0.6),
        particles={"spacing": D0},
        fill=[block | {"material": "mixture"}],
        rheology={"type": "bingham", "yield_stress": 100.0},
    )
    scheme, state = started(case)
    p = state.particles
    p.velocity[p.fluid] = np.random.default_rng(3).uniform(-0.1, 0.1, (6**3, 3))
    before, mass = momentum_of(p), p.density[p.fluid].sum()
    advance(scheme, state, steps=50)
    gained = (momentum_of(p) - before) / (mass * G * state.time)
    # rounding of 50 steps
    np.testing.assert_allclose(gained, [0.0, 0.0, -1.0], atol=1e-12)


def test_a_slurry_without_gravity_comes_to_rest_in_itself():
    block = {"type": "block", "x": [0.2, 0.32], "y": [0.2, 0.32], "z": [0.2, 0.32]}
    case = tank3d_case(
        size=(0.52, 0.52, 0.6),
        gravity={"acceleration": 0.0},
        particles={"spacing": D0},
        fill=[block | {"material": "mixture", "velocity": [1.0, 0.0, 0.0]}],
        rheology={"type": "bingham", "yield_stress": 100.0},
        scheme={"sound_speed": 10.0},
    )
    scheme, state = started(case)
    p = state.particles
    advance(scheme, state, steps=3)
    np.testing.assert_allclose(p.velocity[p.fluid], np.tile([1.0, 0, 0], (216, 1)), atol=1e-3)
    p.velocity[p.fluid, 2] += 2.0 * (p.position[p.fluid, 0] - p.position[p.fluid, 0].mean())
    sheared = np.ptp(p.velocity[p.fluid, 2])
    advance(scheme, state, steps=20)
    assert np.ptp(p.velocity[p.fluid, 2]) < 0.9 * sheared


def test_a_resumed_run_with_a_strength_law_repeats_the_bits(tmp_path, ends, interrupt):
    block = {"type": "block", "x": [0.0, 0.12], "y": [0.0, 0.08], "z": [0.0, 0.12]}
    water = block | {"x": [0.12, 0.2], "z": [0.0, 0.04], "material": "water"}
    case = tank3d_case(
        size=(0.4, 0.08, 0.2),
        particles={"spacing": D0},
        fill=[block | {"material": "mixture"}, water],
        rheology=COULOMB | {"friction_angle": 20.0, "mixing_length": 0.005},
        collision_stress={"enabled": True},
        time={"end": 0.05},
        output={"interval": 0.025},
    )
    simulation.simulate(case, tmp_path / "whole", threads=1)
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(case, tmp_path / "broken", threads=1)
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    simulation.resume(tmp_path / "rest", threads=1)
    assert ends[0].step > 2 * Explicit.REFRESH
    assert identical(ends[0], ends[-1])


def kept_by(error, spoil):
    """Assert that a step that ends by an error leaves positions and velocities as before."""
    scheme, state = started(layer(35.0))
    advance(scheme, state, steps=7)
    dt, p = scheme.stable_dt(state), state.particles
    spoil(scheme, p)
    position, velocity = p.position.copy(), p.velocity.copy()
    compression = p.compression.copy()
    with pytest.raises(error):
        scheme.step(state, dt)
    np.testing.assert_array_equal(p.position, position)
    np.testing.assert_array_equal(p.velocity, velocity)
    np.testing.assert_array_equal(p.compression, compression)


def test_an_exchange_that_is_not_solved_ends_the_step_before_it_spoils_the_state(monkeypatch):
    def spoil(scheme, p):
        monkeypatch.setattr("debrisflow.schemes.pair_solver.MOST_ITERATIONS", 0)

    kept_by(NotConvergedError, spoil)


def test_a_velocity_that_is_no_number_ends_a_step_with_a_strength_law():
    def spoil(scheme, p):
        p.velocity[20, 1] = np.nan

    kept_by(DivergedError, spoil)
