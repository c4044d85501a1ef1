"""Fronts, arrivals and mobility of what is placed where it is known."""

import numpy as np
import pytest

from debrisflow.particles.record import Kind
from debrisflow.results import open_run
from debrisflow.results.answers import answers
from debrisflow.results.fronts import arrival, front_table
from debrisflow.results.postprocess import postprocess
from debrisflow.results.survey import survey
from debrisflow.run.probes import columns_of
from tests.recording import (
    cells,
    channel3d_case,
    channel_case,
    placed,
    record,
    sliding,
    state_of,
    surveyed,
)

D0 = 0.02


def figures(found):
    """Return the answers of a survey by quantity."""
    return {row.quantity: row.value for row in answers(found)}


def rotated(x, y, slope):
    """Return the true horizontal and vertical place of a point over a slope, degrees."""
    angle = np.radians(slope)
    return x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)


@pytest.mark.parametrize(("count", "ahead", "outer_ahead"), [(1000, 5, 1), (2000, 10, 2)])
def test_the_fronts_leave_their_share_of_the_particles_ahead(tmp_path, count, ahead, outer_ahead):
    case = channel_case(length=44.0)
    state = state_of(case, placed(case, cells(case, range(count), [0]), velocity=1.0))
    fronts = surveyed(tmp_path, case, [state]).fronts
    assert fronts["front_all"] == pytest.approx((count - ahead - 0.5) * D0)
    assert fronts["outer_front_all"] == pytest.approx((count - outer_ahead - 0.5) * D0)
    assert np.isnan(fronts["speed_all"]).all()


def test_every_phase_has_its_own_front_and_what_rests_has_none(tmp_path):
    case = channel_case()
    position = cells(case, range(180), [0])
    kind = np.full(180, Kind.MIXTURE)
    kind[:60], kind[60:100] = Kind.LIQUID, Kind.SEDIMENT
    velocity = np.where(np.arange(180) < 90, 1.0, 0.0)
    state = state_of(case, placed(case, position, kind, velocity))
    fronts = surveyed(tmp_path, case, [state]).fronts
    assert fronts["front_liquid"] == pytest.approx(59.5 * D0)
    assert fronts["front_sediment"] == pytest.approx(89.5 * D0)
    assert np.isnan(fronts["front_mixture"]).all()
    assert fronts["front_all"] == pytest.approx(89.5 * D0)


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """Return the survey of a block that slides at 1.5 m/s, with its foremost particle at 0.49 m."""
    case = channel_case()
    particles = placed(case, cells(case, range(25), range(6)), velocity=1.5)
    states = sliding(case, particles, np.arange(0.0, 1.05, 0.1))
    return surveyed(tmp_path_factory.mktemp("block"), case, states, (0.3, 1.0, 1.75, 3.0))


def test_the_front_of_a_block_has_the_speed_of_the_block(block):
    np.testing.assert_allclose(block.fronts["front_all"], 0.49 + 1.5 * block.fronts["time"])
    for name in ("speed_mixture", "speed_all"):
        np.testing.assert_allclose(block.fronts[name], 1.5)
    assert figures(block)["front_speed_greatest"] == pytest.approx(1.5)


def test_a_block_arrives_at_stations_when_its_front_does(block):
    x = np.array([0.3, 1.0, 1.75, 3.0])
    expected = np.where((x > 0.49) & (x < 2.0), (x - 0.49) / 1.5, np.nan)  # it was at the first
    np.testing.assert_array_equal(block.station_figures["station"], x)
    np.testing.assert_allclose(block.station_figures["arrival"], expected)


def test_the_farthest_front_is_where_the_flow_turned_back(tmp_path):
    case = channel_case()
    places = [0.0, 0.6, 1.0, 0.8]

    def states():
        for k, x in enumerate(places):
            particles = placed(case, cells(case, range(25), range(4)), velocity=1.0)
            particles.position[:, 0] += x
            yield state_of(case, particles, 0.1 * k)

    found = figures(surveyed(tmp_path, case, states()))
    assert found["front_farthest"] == pytest.approx(0.49 + 1.0)
    assert found["front_farthest_time"] == pytest.approx(0.2)


def test_a_front_that_retreats_has_a_negative_speed():
    rows = [(0.1 * k, *[x] * 8, 1.0) for k, x in enumerate((1.0, 1.2, 1.1))]
    np.testing.assert_allclose(front_table(rows)["speed_all"], [2.0, 0.5, -1.0])


def test_without_samples_nothing_arrives():
    assert np.isnan(arrival(np.empty(0), np.empty(0), 1.0))
    assert np.isnan(arrival(np.array([0.0, 1.0]), np.full(2, np.nan), 1.0))


@pytest.mark.parametrize("slope", [0.0, 18.0, 35.0])
def test_fall_and_travel_of_a_block_on_an_incline(tmp_path, slope):
    case = channel_case(slope=slope)
    particles = placed(case, cells(case, range(10, 30), range(15)), velocity=2.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.5, 1.0])).mobility
    # the upper left particle is d0 / 2 below the top of the block; the toe is on the floor
    source = rotated(10.5 * D0, 15 * D0, slope)
    toe = rotated(29.5 * D0 + 2.0, 0.0, slope)
    assert found.toe == pytest.approx(29.5 * D0 + 2.0)
    assert found.time == 1.0
    assert found.runout == pytest.approx(19.0 * D0 + 2.0)
    assert found.travel == pytest.approx(toe[0] - source[0])
    assert found.fall == pytest.approx(source[1] - toe[1])
    expected = (source[1] - toe[1]) / (toe[0] - source[0])
    assert found.equivalent_friction == pytest.approx(expected)


def test_a_long_slide_has_the_friction_of_its_slope(tmp_path):
    case = channel_case(length=400.0, slope=20.0)
    particles = placed(case, cells(case, range(5), range(3)), velocity=390.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 1.0])).mobility
    assert found.equivalent_friction == pytest.approx(np.tan(np.radians(20.0)), rel=1e-3)


def test_fall_and_travel_in_three_dimensions_are_those_along_the_channel(tmp_path):
    case = channel3d_case(slope=25.0)
    d0 = case.particles.spacing
    particles = placed(case, cells(case, range(4, 12), range(8), range(6)), velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 1.0])).mobility
    source = rotated(4.5 * d0, 6 * d0, 25.0)
    # of 384 particles two may be ahead; they stand in the foremost row
    toe = rotated(11.5 * d0 + 1.0, 0.0, 25.0)
    assert found.fall == pytest.approx(source[1] - toe[1])
    assert found.travel == pytest.approx(toe[0] - source[0])


def test_a_toe_on_a_run_out_is_on_its_floor(tmp_path):
    shape = {"runout_start": 2.0, "runout_slope": 5.0}
    case = channel_case(slope=20.0, shape=shape)
    particles = placed(case, cells(case, range(10), range(10)), velocity=2.8)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 1.0])).mobility
    toe_x = 9.5 * D0 + 2.8
    toe = rotated(toe_x, (toe_x - 2.0) * np.tan(np.radians(15.0)), 20.0)
    source = rotated(0.5 * D0, 10 * D0, 20.0)
    assert found.fall == pytest.approx(source[1] - toe[1])
    assert found.travel == pytest.approx(toe[0] - source[0])


def test_the_source_of_a_supply_is_its_top_at_the_inflow(tmp_path):
    inflow = {"depth": 0.1, "velocity": 1.0}
    case = channel_case(slope=30.0, inflow=inflow)
    particles = placed(case, cells(case, range(10), range(5)), Kind.LIQUID, 2.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 1.0])).mobility
    source, toe = rotated(0.0, 0.1, 30.0), rotated(9.5 * D0 + 2.0, 0.0, 30.0)
    assert found.runout == pytest.approx(9.5 * D0 + 2.0)
    assert found.fall == pytest.approx(source[1] - toe[1])
    assert found.travel == pytest.approx(toe[0] - source[0])


def test_without_gravity_there_is_a_run_out_but_no_fall(tmp_path):
    case = channel_case(gravity={"acceleration": 0.0})
    particles = placed(case, cells(case, range(10), range(5)), velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 1.0])).mobility
    assert found.runout == pytest.approx(9.0 * D0 + 1.0)
    assert np.isnan([found.fall, found.travel, found.equivalent_friction]).all()


def wave(case, times, speed=1.0):
    """Yield states of a bed five rows deep over the whole length, with a wave that comes along it.

    The bed rests in the first state; then all of it moves, as water before a wave does.
    """
    bed = cells(case, range(200), range(5))
    for time in times:
        columns = np.arange(40) + round(speed * time / D0)
        position = np.vstack([bed, cells(case, columns, range(5, 9))])
        velocity = 0.0 if time == 0.0 else 0.3
        yield state_of(case, placed(case, position, Kind.LIQUID, velocity), time)


def test_a_wave_over_water_that_was_there_arrives_when_the_level_rises(tmp_path):
    case = channel_case()
    states = wave(case, np.arange(0.0, 1.55, 0.1))
    found = surveyed(tmp_path, case, states, (0.5, 1.2, 2.0, 3.5))
    arrived = found.station_figures["arrival"]
    np.testing.assert_allclose(arrived[1:3], [1.2 - 0.8, 2.0 - 0.8], atol=2 * D0)
    assert np.isnan(arrived[[0, 3]]).all()  # it was at the first, and not yet at the last
    cell = found.run.maxima
    came = cell["arrival_time"][np.isclose(cell["x"], 1.22)]
    np.testing.assert_allclose(came, 1.22 - 0.8, atol=0.1)
    assert np.isnan(cell["arrival_time"][cell["x"] > 2.5]).all()


@pytest.mark.parametrize(("standing", "arrival"), [(0.1, 0.3), (0.0, 0.1)])
def test_at_a_section_water_arrives_when_it_is_deeper_than_what_was_there(
    tmp_path, standing, arrival
):
    probe = {"type": "section", "name": "gate", "x": 1.0, "interval": 0.1}
    case = channel_case(probe=[probe])
    folder = record(tmp_path, case, wave(case, [0.0, 0.5]))
    time = 0.1 * np.arange(5)
    depth = standing + np.array([0.0, 0.005, 0.009, 0.02, 0.04])
    passed = np.array([0.0, 1e-4, 2e-4, 3e-4, 4e-4])
    names = [column.name for column in columns_of(case.probe[0], 2)]
    known = {"depth": depth, "volume": passed}
    rows = np.column_stack([time, *(known.get(name, 0.0 * time) for name in names)])
    head = ",".join(["time", *names])
    np.savetxt(folder / "probes/gate.csv", rows, delimiter=",", header=head, comments="")
    assert figures(survey(open_run(folder)))["gate_arrival"] == pytest.approx(arrival)


def test_what_fills_the_whole_length_has_no_run_out(tmp_path):
    case = channel_case()
    found = surveyed(tmp_path, case, wave(case, [0.0, 0.5, 1.0]))
    told = figures(found)
    assert found.mobility is None
    assert [name for name in told if name.startswith(("runout", "front_farthest", "equi"))] == []
    assert told["front_speed_greatest"] == pytest.approx(1.0, rel=0.05)
    _, lines = postprocess(found)
    assert "no run-out: there was fluid over the whole length from the start" in lines


def test_what_is_supplied_over_a_bed_has_a_run_out(tmp_path):
    case = channel_case(inflow={"depth": 0.1, "velocity": 1.0})
    found = surveyed(tmp_path, case, wave(case, [0.0, 0.5, 1.0]))
    assert found.mobility.toe == pytest.approx(40 * D0 + 1.0, abs=D0)


def two_phases(case, times):
    """Yield states in which water runs ahead of sediment."""
    position = cells(case, range(20), range(10))
    kind = np.where(position[:, 1] < 0.1, Kind.SEDIMENT, Kind.LIQUID)
    velocity = np.where(kind == Kind.SEDIMENT, 1.0, 2.0)
    return sliding(case, placed(case, position, kind, velocity), times)


def test_the_run_out_of_two_phases_is_that_of_the_sediment_and_the_water_is_beside_it(tmp_path):
    case = channel_case()
    found = surveyed(tmp_path, case, two_phases(case, [0.0, 0.5, 1.0]), (1.0, 2.0))
    told = figures(found)
    assert found.headline == "sediment"
    assert told["front_farthest"] == pytest.approx(19.5 * D0 + 1.0)
    assert told["water_front_farthest"] == pytest.approx(19.5 * D0 + 2.0)
    assert told["runout_length"] == pytest.approx(19.0 * D0 + 1.0)
    assert told["water_runout_length"] == pytest.approx(19.0 * D0 + 2.0)
    assert told["front_speed_greatest"] == pytest.approx(1.0)
    table = found.station_figures
    np.testing.assert_allclose(table["sediment_arrival"], [1.0 - 0.39, np.nan])
    np.testing.assert_allclose(table["water_arrival"], [(1.0 - 0.39) / 2, (2.0 - 0.39) / 2])
    np.testing.assert_array_equal(table["arrival"], table["water_arrival"])


def test_what_never_moves_has_no_mobility(tmp_path):
    case = channel_case()
    state = state_of(case, placed(case, cells(case, range(10), range(5))))
    found = surveyed(tmp_path, case, [state])
    *lengths, bound = found.mobility
    assert np.isnan([*lengths, found.mobility.equivalent_friction]).all()
    assert bound == ""
    told = figures(found)
    assert np.isnan([told["front_farthest"], told["runout_length"], told["fall_height"]]).all()


def test_the_source_of_a_block_that_has_settled_is_its_upstream_end(tmp_path):
    case = channel_case()
    position = cells(case, range(20, 40), range(10))
    position[:, 1] += np.random.default_rng(3).uniform(-0.2, 0.2, len(position)) * D0
    states = sliding(case, placed(case, position, velocity=1.0), [0.0, 0.5])
    found = surveyed(tmp_path, case, states).mobility
    assert found.runout == pytest.approx(0.5 + 19 * D0)


def test_a_run_out_that_may_go_on_is_a_lower_bound(tmp_path):
    case = channel_case(length=2.0)
    block = placed(case, cells(case, range(20), range(5)), velocity=1.0)
    early = surveyed(tmp_path / "early", case, sliding(case, block, [0.0, 0.5, 1.0]))
    assert early.mobility.bound == "a lower bound: the front still advances in the last frame"
    block.position[:] = cells(case, range(20), range(5))
    late = surveyed(tmp_path / "late", case, sliding(case, block, [0.0, 0.8, 1.59]))
    assert late.mobility.bound == "a lower bound: it reached the end of the domain"
    assert any(row.meaning.endswith(late.mobility.bound) for row in answers(late))


def test_a_flow_is_at_rest_from_when_nothing_moves(tmp_path):
    case = channel_case()
    states = []
    for time, speed in ((0.0, 0.0), (0.1, 1.0), (0.2, 0.0), (0.3, 0.0)):
        block = placed(case, cells(case, range(20), range(5)), velocity=speed)
        states.append(state_of(case, block, time))
    found = surveyed(tmp_path, case, states)
    np.testing.assert_array_equal(found.fronts["moving_share"], [0.0, 1.0, 0.0, 0.0])
    assert found.rest_time == 0.2
