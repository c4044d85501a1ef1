"""Profiles and hydrographs at a station, of flows that are known exactly."""

import numpy as np
import pytest

from debrisflow.particles.record import Kind
from debrisflow.results.answers import answers
from debrisflow.results.postprocess import postprocess
from debrisflow.results.references import dilatant_profile, distances
from debrisflow.results.report import report
from tests.recording import (
    cells,
    channel3d_case,
    channel_case,
    placed,
    sliding,
    state_of,
    surveyed,
)

D0 = 0.02
LAYERS = 20


def sheared(path, speed, layers=LAYERS, stations=(1.0, 2.0), **options):
    """Return the survey of a channel full of sediment whose velocity is given over the height."""
    case = channel_case(**options)
    position = cells(case, range(200), range(layers))
    particles = placed(case, position, Kind.SEDIMENT, speed(position[:, 1]))
    return surveyed(path, case, [state_of(case, particles)], stations)


def at(table, station):
    """Return the rows of a station."""
    here = table["station"] == station
    return {name: values[here] for name, values in table.items()}


def test_a_linear_profile_is_found_layer_by_layer(tmp_path):
    found = at(sheared(tmp_path, lambda y: 5.0 * y).mean_profiles, 1.0)
    y = (np.arange(LAYERS) + 0.5) * D0
    np.testing.assert_allclose(found["y"], y)
    np.testing.assert_allclose(found["velocity"], 5.0 * y, rtol=1e-6)
    np.testing.assert_allclose(found["shear_rate"], 5.0, rtol=1e-5)
    np.testing.assert_allclose(found["concentration"], 1.0)
    np.testing.assert_array_equal(found["samples"], 2)
    np.testing.assert_allclose(found["density"], 2650.0)


def test_a_linear_profile_is_scaled_from_a_tenth_of_its_surface_velocity(tmp_path):
    found = at(sheared(tmp_path, lambda y: 5.0 * y).mean_profiles, 2.0)
    y, surface = found["y"], (LAYERS - 0.5) * D0
    foot = 0.1 * surface
    moving = y > foot
    exact = (y - foot) / (surface - foot)
    np.testing.assert_allclose(found["y_over_h"], np.where(moving, exact, np.nan), rtol=1e-6)
    scaled = np.where(moving, y / surface, np.nan)
    np.testing.assert_allclose(found["u_over_us"], scaled, rtol=1e-6)


def test_an_even_velocity_is_scaled_from_the_floor(tmp_path):
    found = at(sheared(tmp_path, lambda y: 0.7 + 0.0 * y).mean_profiles, 1.0)
    np.testing.assert_allclose(found["y_over_h"], found["y"] / ((LAYERS - 0.5) * D0))
    np.testing.assert_allclose(found["u_over_us"], 1.0)
    np.testing.assert_allclose(found["shear_rate"], 0.0, atol=1e-6)


def test_what_rests_has_no_scaled_profile(tmp_path):
    found = sheared(tmp_path, lambda y: 0.0 * y).mean_profiles
    assert np.isnan(found["y_over_h"]).all()
    assert np.isnan(found["u_over_us"]).all()


def dilatant(y, foot, depth):
    """Return the velocity of colliding grains over a bed at rest."""
    return 2.0 * (1.0 - (1.0 - np.clip((y - foot) / depth, 0.0, 1.0)) ** 1.5)


def test_a_dilatant_profile_is_a_tenth_of_its_lower_part_from_the_formula(tmp_path):
    # y = 0 is put where u = u_s / 10, which leaves u/u_s = 1 - 0.9 (1 - y/h)^1.5
    layers, surface = 80, 79.5 * D0
    found = sheared(tmp_path, lambda y: dilatant(y, 0.0, surface), layers)
    scaled = at(found.mean_profiles, 1.0)
    known = ~np.isnan(scaled["y_over_h"])
    height = scaled["y_over_h"][known]
    exact = 1.0 - 0.9 * (1.0 - height) ** 1.5
    np.testing.assert_allclose(scaled["u_over_us"][known], exact, atol=2e-4)
    below = height[height < 1.0]  # at the surface both are 1
    for row in distances(found, dilatant_profile()):
        assert row.rms == pytest.approx(0.1 * np.sqrt(np.mean((1.0 - below) ** 3)), abs=2e-4)
        assert row.points == below.size
        assert row.share == pytest.approx(row.rms)


@pytest.mark.parametrize("quiet", [10, 25])
def test_a_quiet_bed_is_left_out(tmp_path, quiet):
    flowing = 40
    foot, surface = quiet * D0, (quiet + flowing - 0.5) * D0

    def velocity(y):
        return dilatant(y, foot, surface - foot)

    found = sheared(tmp_path, velocity, quiet + flowing, shape={"height": 2.0})
    scaled = at(found.mean_profiles, 1.0)
    moving = ~np.isnan(scaled["y_over_h"])
    lowest = scaled["y"][moving][0]
    tenth = foot + (1.0 - 0.9 ** (2.0 / 3.0)) * (surface - foot)
    assert tenth <= lowest <= tenth + D0
    slope = np.diff(scaled["y"][moving])[0] / np.diff(scaled["y_over_h"][moving])[0]
    assert surface - slope == pytest.approx(tenth, abs=0.1 * D0)
    (row, _, pooled) = distances(found, dilatant_profile())
    assert pooled.ours == "mean of the stations"
    assert row.rms == pooled.rms == pytest.approx(0.05, abs=0.005)


def test_drops_above_the_flow_do_not_make_its_surface(tmp_path):
    case = channel_case()
    block, drop = cells(case, range(200), range(LAYERS)), cells(case, [50], [30])
    states = [
        state_of(case, placed(case, position, velocity=3.0 * position[:, 1]), 0.1 * k)
        for k, position in enumerate([np.vstack([block, drop]), block])
    ]
    found = surveyed(tmp_path, case, states, [1.0], window=(0.0, 0.1)).mean_profiles
    assert np.isnan(found["u_over_us"][-1])
    assert found["samples"][-1] == 1
    assert found["u_over_us"][-2] == pytest.approx(1.0)


def test_profiles_are_averaged_over_the_frames_of_the_window_alone(tmp_path):
    case = channel_case()
    position = cells(case, range(200), range(5))
    states = [
        state_of(case, placed(case, position, velocity=speed), 0.1 * k)
        for k, speed in enumerate((9.0, 1.0, 2.0, 6.0))
    ]
    found = surveyed(tmp_path, case, states, [1.0], window=(0.1, 0.3)).mean_profiles
    np.testing.assert_allclose(found["velocity"], 3.0)
    np.testing.assert_array_equal(found["samples"], 6)


def test_a_mean_profile_keeps_the_station_to_the_last_digit(tmp_path):
    stations = (2.86, 2.88, 2.9, 2.92, 2.94)
    found = sheared(tmp_path, lambda y: 5.0 * y, stations=stations)
    assert set(found.mean_profiles["station"]) == set(stations)


def test_the_pooled_profile_is_the_mean_of_the_stations(tmp_path):
    case = channel_case()
    position = cells(case, range(200), range(5))
    velocity = np.where(position[:, 0] < 1.5, 1.0, 3.0)
    states = [state_of(case, placed(case, position, velocity=velocity))]
    found = surveyed(tmp_path, case, states, (1.0, 2.0))
    np.testing.assert_allclose(found.pooled_profile["velocity"], 2.0)
    np.testing.assert_allclose(found.pooled_profile["station"], 1.5)
    np.testing.assert_allclose(found.pooled_profile["u_over_us"], 1.0)


def test_the_velocity_on_a_run_out_is_along_its_floor(tmp_path):
    shape = {"runout_start": 1.0, "runout_slope": 0.0}
    case = channel_case(slope=20.0, shape=shape)
    along, up = cells(case, range(10, 120), range(5))[:, :2].T
    position, velocity = np.zeros((2, along.size, 3))
    cos, sin = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    position[:, :2] = np.column_stack([1.0 + along * cos - up * sin, along * sin + up * cos])
    velocity[:, :2] = 2.0 * np.array([cos, sin])
    state = state_of(case, placed(case, position, velocity=velocity))
    found = surveyed(tmp_path, case, [state], [2.0]).profiles
    np.testing.assert_allclose(found["velocity"], 2.0, rtol=1e-6)
    np.testing.assert_allclose(found["y"], (np.arange(5) + 0.5) * D0)


SPEED = 1.0
TIMES = np.arange(0.0, 4.5, 0.1)


def passing(case, position, kind, length):
    """Yield states of a block that slides at SPEED, and leaves over the end of the channel."""
    start = placed(case, position, kind, SPEED)
    for time in TIMES:
        particles = placed(case, position, kind, SPEED)
        particles.position[:, 0] += SPEED * time
        outside = particles.position[:, 0] >= length
        state = state_of(case, particles, time)
        state.left[:] = np.bincount(start.kind[outside], minlength=3)
        fraction = start.sediment_fraction[outside]
        state.left_sediment[:] = np.bincount(start.kind[outside], fraction, minlength=3)
        particles.keep(np.flatnonzero(~outside), particles.count)
        particles.fluid_count = particles.count
        yield state


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_passes_a_station_to_the_particle_and_after_it_left(tmp_path, dimension):
    if dimension == 2:
        case = channel_case()
        position, section = cells(case, range(50), range(10)), 10 * D0
    else:
        case = channel3d_case()
        position, section = cells(case, range(20), range(8), range(4)), 4 * 0.05 * 8 * 0.05
    rng = np.random.default_rng(3)
    kind = rng.choice([Kind.LIQUID, Kind.SEDIMENT], len(position), p=[0.7, 0.3])
    grains = np.count_nonzero(kind == Kind.SEDIMENT)
    volume = case.particles.spacing**dimension
    found = surveyed(tmp_path, case, passing(case, position, kind, 4.0), [2.0])
    table = at(found.hydrographs, 2.0)
    # the block, 1 m long, is at the station from 1 to 2 s, and leaves from 3 to 4 s
    within = (table["time"] > 1.15) & (table["time"] < 1.85)
    np.testing.assert_allclose(table["discharge"][within], section * SPEED)
    outside = (table["time"] < 0.85) | (table["time"] > 2.15)
    np.testing.assert_allclose(table["discharge"][outside], 0.0, atol=1e-12)
    done = table["time"] > 2.05
    np.testing.assert_allclose(table["volume"][done], len(position) * volume)
    np.testing.assert_allclose(table["sediment_volume"][done], grains * volume)
    np.testing.assert_allclose(table["speed"][within], SPEED)
    depth = section if dimension == 2 else section / (8 * 0.05)
    np.testing.assert_allclose(table["depth"][within], depth)
    assert np.isnan(table["speed"][outside]).all()
    np.testing.assert_array_equal(table["depth"][outside], 0.0)
    told = found.station_figures
    assert told["volume"] == pytest.approx(len(position) * volume)
    assert told["sediment_volume"] == pytest.approx(grains * volume)
    assert told["discharge_peak"] == pytest.approx(section * SPEED)
    assert told["greatest_depth"] == pytest.approx(depth)
    total = np.trapezoid(table["sediment_discharge"], table["time"])
    assert total == pytest.approx(grains * volume, rel=0.02)


def test_a_flow_on_half_the_width_has_its_own_depth(tmp_path):
    case = channel3d_case()
    position = cells(case, range(80), range(2, 6), range(5))
    state = state_of(case, placed(case, position, velocity=1.0))
    table = surveyed(tmp_path, case, [state], [2.0]).hydrographs
    assert table["depth"] == pytest.approx(5 * 0.05)
    assert table["speed"] == pytest.approx(1.0)


def test_what_flows_back_is_taken_off(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(100, 110), range(5)), velocity=-1.0)
    table = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.1, 0.2]), [2.0]).hydrographs
    np.testing.assert_allclose(table["volume"], -np.array([0, 5, 10]) * 5 * D0**2)
    np.testing.assert_allclose(table["discharge"], -5 * D0)


def test_a_case_that_repeats_has_depth_and_speed_but_no_volumes(tmp_path):
    case = channel_case(shape={"periodic": True})
    particles = placed(case, cells(case, range(200), range(5)), velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.1]), [0.0])
    np.testing.assert_allclose(found.hydrographs["depth"], 5 * D0)
    np.testing.assert_allclose(found.hydrographs["speed"], 1.0)
    assert np.isnan(found.hydrographs["volume"]).all()
    assert np.isnan(found.station_figures["volume"]).all()


def test_stations_are_a_table_with_a_row_each(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(50), range(5)), Kind.LIQUID, velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, np.arange(0.0, 1.05, 0.1)))
    _, lines = postprocess(found)
    head = next(k for k, line in enumerate(lines) if line.split()[:3] == ["x,", "m", "arrival,"])
    rows = [line.split() for line in lines[head + 1 : head + 8]]
    assert [float(row[0]) for row in rows] == pytest.approx(found.stations)
    assert [row[1] == "none" for row in rows] == [x < 1.0 or x > 1.99 for x in found.stations]
    assert "grains" not in lines[head]
    assert "sediment" not in lines[head]
    assert not [row for row in answers(found) if row.quantity.startswith(("at_", "arrival_at"))]
    page = report(found).read_text()
    table = page.split("<h3>Stations</h3>")[1].split("</table>")[0]
    assert table.count("<tr>") == 1 + len(found.stations)


def test_a_station_given_twice_is_one(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(50), range(5)), velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.1]), (1.0, 0.5, 1.0))
    assert found.stations == (1.0, 0.5)
    assert np.isfinite(found.hydrographs["discharge"]).all()


def test_an_empty_station_has_no_profile_and_no_discharge(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(50), range(5)), velocity=1.0)
    found = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.1]), [3.0])
    assert found.profiles["time"].size == found.mean_profiles["y"].size == 0
    assert found.pooled_profile["y"].size == 0
    np.testing.assert_array_equal(found.hydrographs["discharge"], 0.0)
    assert distances(found, dilatant_profile()) == []
