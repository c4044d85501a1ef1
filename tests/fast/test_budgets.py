"""Budgets of mass, energy and momentum of runs in which they are known."""

import numpy as np
import pytest

from debrisflow.particles.record import Kind
from debrisflow.results.answers import answers
from tests.recording import cells, channel_case, placed, sliding, state_of, surveyed

D0 = 0.02
WATER, ROCK = 1000.0, 2650.0
CELL = D0**2
TIMES = 0.1 * np.arange(5)


def states(case, missing=None):
    """Yield states in which water and rock leave, are lost and come in, and all is counted.

    At t = 0 there are 60 of each; a row of ten of each leaves in every step, one of each is lost
    through a wall in the second, and four grains are supplied in the third.  A particle of the kind
    ``missing`` vanishes uncounted in the last.
    """
    columns = {kind: cells(case, range(20), range(3)) for kind in (Kind.LIQUID, Kind.SEDIMENT)}
    for step, time in enumerate(TIMES):
        count = dict.fromkeys(columns, 60 - 10 * step - (step >= 2))
        count[Kind.SEDIMENT] += 4 * (step >= 3)
        if missing is not None and step == 4:
            count[missing] -= 1
        position = np.vstack([columns[kind][:number] for kind, number in count.items()])
        kinds = np.repeat(list(count), list(count.values()))
        state = state_of(case, placed(case, position, kinds), time)
        state.left[:2], state.left_sediment[1] = 10 * step, 10.0 * step
        state.through_wall[:2], state.through_wall_sediment[1] = step >= 2, float(step >= 2)
        state.entered[1], state.entered_sediment[1] = 4 * (step >= 3), 4.0 * (step >= 3)
        yield state


def test_a_budget_in_which_everything_is_counted_closes(tmp_path):
    case = channel_case()
    found = surveyed(tmp_path, case, states(case))
    table = found.budget
    np.testing.assert_allclose(
        table["mass_inside_water"], WATER * CELL * np.array([60, 50, 39, 29, 19])
    )
    np.testing.assert_allclose(table["mass_out_sediment"], ROCK * CELL * 10 * np.arange(5))
    np.testing.assert_allclose(table["mass_in_sediment"], ROCK * CELL * np.array([0, 0, 0, 4, 4]))
    np.testing.assert_allclose(table["mass_in_water"], 0.0, atol=1e-6)
    np.testing.assert_allclose(table["mass_through_wall_water"][2:], WATER * CELL)
    for matter in ("water", "sediment"):
        # history has nine digits of some 60 kg
        np.testing.assert_allclose(table[f"closure_{matter}"], 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "matter", "density"),
    [(Kind.LIQUID, "water", WATER), (Kind.SEDIMENT, "sediment", ROCK)],
)
def test_the_closure_of_a_budget_is_the_mass_that_vanished(tmp_path, kind, matter, density):
    case = channel_case()
    found = surveyed(tmp_path, case, states(case, missing=kind))
    other = "sediment" if matter == "water" else "water"
    expected = [0.0, 0.0, 0.0, 0.0, -density * CELL]
    np.testing.assert_allclose(found.budget[f"closure_{matter}"], expected, atol=1e-6)
    np.testing.assert_allclose(found.budget[f"closure_{other}"], 0.0, atol=1e-6)
    told = {row.quantity: row.value for row in answers(found)}
    assert told[f"mass_closure_{matter}"] == pytest.approx(density * CELL, abs=1e-6)


def test_a_mixture_is_split_into_its_water_and_its_grains(tmp_path):
    case = channel_case()
    state = state_of(case, placed(case, cells(case, range(10), range(5))))
    table = surveyed(tmp_path, case, [state]).budget
    assert table["mass_inside_water"] == pytest.approx(50 * CELL * 0.6 * WATER)
    assert table["mass_inside_sediment"] == pytest.approx(50 * CELL * 0.4 * ROCK)


def test_a_balance_starts_with_the_state_at_zero_and_not_while_fills_settle(tmp_path):
    case = channel_case()

    def settled():
        for time, count in ((-0.2, 50), (-0.1, 45), (0.0, 40), (0.1, 40)):
            state = state_of(case, placed(case, cells(case, range(count), [0])), time)
            state.left[2], state.left_sediment[2] = 50 - count - 3, 0.4 * (50 - count - 3)
            yield state

    table = surveyed(tmp_path, case, settled()).budget
    np.testing.assert_array_equal(table["time"], [0.0, 0.1])
    np.testing.assert_allclose(table["closure_water"], 0.0, atol=1e-6)


def test_the_energy_of_a_block_that_slides_changes_from_potential_to_nothing(tmp_path):
    case = channel_case(slope=30.0)
    particles = placed(case, cells(case, range(20), range(10)), Kind.LIQUID, 2.0)
    table = surveyed(tmp_path, case, sliding(case, particles, TIMES)).budget
    mass = 200 * CELL * WATER
    np.testing.assert_allclose(table["kinetic_energy"], 0.5 * mass * 2.0**2)
    fall = mass * 9.81 * np.sin(np.radians(30.0)) * 2.0 * TIMES
    change = table["potential_energy"] - table["potential_energy"][0]
    np.testing.assert_allclose(change, -fall, rtol=1e-6, atol=1e-6)
    total = table["kinetic_energy"] + table["potential_energy"]
    np.testing.assert_allclose(table["total_energy"], total)
    np.testing.assert_array_equal(table["elastic_energy"], 0.0)


def test_a_block_at_constant_speed_is_held_back_by_its_weight_along_the_slope(tmp_path):
    case = channel_case(slope=25.0)
    particles = placed(case, cells(case, range(20), range(10)), Kind.SEDIMENT, 1.5)
    table = surveyed(tmp_path, case, sliding(case, particles, TIMES)).momentum
    mass = 200 * CELL * ROCK
    weight = mass * 9.81 * np.sin(np.radians(25.0))
    np.testing.assert_allclose(table["momentum_x"], mass * 1.5)
    np.testing.assert_allclose(table["momentum_y"], 0.0)
    np.testing.assert_allclose(table["gravity_x"], weight)
    np.testing.assert_allclose(table["resistance_x"], weight)


def test_a_block_in_free_fall_along_the_slope_meets_no_resistance(tmp_path):
    case = channel_case(slope=25.0)
    along = 9.81 * np.sin(np.radians(25.0))

    def falling():
        for time in TIMES:
            position = cells(case, range(20), range(10))
            yield state_of(case, placed(case, position, velocity=along * time), time)

    table = surveyed(tmp_path, case, falling()).momentum
    np.testing.assert_allclose(table["resistance_x"] / table["gravity_x"], 0.0, atol=1e-5)
