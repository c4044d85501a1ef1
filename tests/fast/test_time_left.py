"""The time left of a run, by synthetic clocks: near the truth, and without jumps."""

from math import exp

import numpy as np
import pytest

from debrisflow import build_case
from debrisflow.run.work import TimeLeft, growth, mean_number, speeds, step_at
from tests.building import tank3d_case, tank_case

COST = 2.0e-6  # s of wall time of a particle in a step


def tank(**tables):
    return tank_case(40, 40, "water", tank=(80, 80), **tables)


def flume(length, end):
    """Return a case: a channel that is empty at first and gets 100 particles a second."""
    return build_case(
        {
            "title": "flume",
            "particles": {"spacing": 0.02},
            "gravity": {"slope": 15.0},
            "geometry": {"type": "channel", "length": length, "height": 0.4},
            "inflow": {"depth": 0.04, "velocity": 1.0},
            "time": {"end": end},
            "output": {"interval": 1.0},
        }
    )


def told(case, dt_of, number_of, files=(), first=0.0, stop=None, cost=COST):
    """Return wall times, s, the time told to be left and that truly left, once each half second.

    Parameters
    ----------
    case : ResolvedCase
    dt_of, number_of : function of the simulated time
    files : sequence of (simulated time, s of wall time)
        What is written at these times, the first at the start.
    stop : (simulated time, s of wall time), optional
        When the machine stands still, and how long.
    first : float, s
        By which the first step takes longer.
    cost : float, s
    """
    left = TimeLeft(case, number_of(0.0))
    time, wall, rows, files = 0.0, first, [], list(files)
    written = files.pop(0)[1] if files else 0.0
    while time < case.time.end:
        dt = min(dt_of(time), case.time.end - time)
        time += dt
        wall += cost * (number_of(time) + 100)
        while files and files[0][0] <= time:
            written += files.pop(0)[1]
        if stop is not None and time >= stop[0]:
            wall, stop = wall + stop[1], None
        left.count(time, dt, number_of(time), wall, written, odd=False)
        if left.seconds is not None:
            rows.append((wall + written, left.seconds))
    wall, seconds = np.array(rows).T
    shown = np.unique(np.searchsorted(wall, np.arange(wall[0], wall[-1], 0.5)))
    return wall[shown], seconds[shown], wall[-1] - wall[shown]


def must_be_calm(wall, seconds, left, within):
    """Assert that no drawing differs by a third from that before, and none is far from the truth.

    The last tenth is left out, in which a second is much.
    """
    early = left > 0.1 * (wall[-1] - wall[0])
    change = (seconds[1:] + np.diff(wall)) / seconds[:-1]
    assert np.abs(np.log(change[early[1:]])).max() < np.log(1.33)
    ratio = seconds[early] / left[early]
    assert ratio.max() < within
    assert ratio.min() > 1.0 / within


def steady(_):
    return 7.5e-4  # between the steps at the start and in free fall


def test_even_steps_are_foretold_at_once():
    case = tank(time={"end": 4.0})
    wall, seconds, left = told(case, lambda _: 0.9 * step_at(case, speeds(case)[0]), lambda _: 1600)
    must_be_calm(wall, seconds, left, within=2.0)
    late = wall > 0.3 * wall[-1]
    assert seconds[late] == pytest.approx(left[late], rel=0.1, abs=0.2)


def test_reading_kernels_in_the_first_step_is_no_time_of_steps():
    case = tank(time={"end": 4.0})
    with_reading = told(case, steady, lambda _: 1600, first=5.0)
    must_be_calm(*with_reading, within=2.0)


def test_a_step_with_compiling_is_no_time_of_steps():
    left = TimeLeft(tank(), 1600)
    for k in range(20):
        left.count(
            0.001 * (k + 1),
            0.001,
            1600,
            0.5 * (k + 1) + 30.0 * (k >= 10),
            written=0.0,
            odd=k == 10,
        )
        if k == 9:
            before = left.seconds
    assert left.seconds == pytest.approx(before, rel=0.05)


def test_a_fall_that_shortens_the_steps_makes_no_jump():
    case = tank(time={"end": 4.0})
    slow, fast = (step_at(case, speed) for speed in speeds(case))
    assert slow / fast > 1.3

    def falling(time):
        return fast + (slow - fast) * exp(-time / 0.1)

    must_be_calm(*told(case, falling, lambda _: 1600), within=1.6)
    must_be_calm(*told(case, lambda t: falling(abs(t - 2.0)), lambda _: 1600), within=1.6)


def test_files_that_are_written_make_no_jump():
    case = tank(time={"end": 4.0}, output={"interval": 0.1})
    frames = [(0.1 * k, 0.8) for k in range(41)]
    must_be_calm(*told(case, steady, lambda _: 1600, files=frames), within=1.6)


def test_a_pause_of_the_machine_makes_no_jump_by_a_factor():
    case = tank(time={"end": 40.0})
    must_be_calm(*told(case, steady, lambda _: 1600, stop=(8.0, 5.0)), within=1.6)


def test_a_supply_that_fills_a_channel_is_foretold():
    case = flume(length=20.0, end=2.0)
    first, rate = 8, growth(case, 0.0)
    assert rate == pytest.approx(1.0 * 0.04 / 0.02**2)

    def number(time):
        return first + int(rate * time)

    must_be_calm(*told(case, lambda _: 1e-3, number, cost=40 * COST), within=2.0)


def test_a_channel_that_is_full_grows_no_further():
    case = flume(length=2.0, end=10.0)
    rate = growth(case, 0.0)

    def number(time):
        return 8 + int(rate * min(time, 2.0))

    must_be_calm(*told(case, lambda _: 1e-3, number, cost=20 * COST), within=2.0)


def test_a_tank_that_runs_empty_ends_sooner():
    case = tank(time={"end": 4.0})
    must_be_calm(*told(case, steady, lambda time: int(1600 * (1.0 - 0.2 * time))), within=1.6)


def test_nothing_is_told_before_steps_were_counted():
    left = TimeLeft(tank(), 1600)
    assert left.seconds is None
    left.count(0.001, 0.001, 1600, 9.0, written=0.0, odd=False)
    assert left.seconds is None


def test_at_the_end_nothing_is_left():
    left = TimeLeft(tank(), 0)
    for k in range(10):
        left.count(0.1 * (k + 1), 0.1, 0, float(k), written=0.0, odd=False)
    assert left.seconds == pytest.approx(0.0, abs=1e-9)


def test_without_supply_the_number_stays_and_with_it_fills_the_channel():
    assert growth(tank(), 0.5) == growth(tank3d_case(), 0.5) == 0.0
    assert mean_number(tank(), 1600) == 1600
    open_end = flume(length=20.0, end=1.0)
    assert mean_number(open_end, 8) == pytest.approx(8 + 0.5 * growth(open_end, 0.0), rel=1e-6)
    short = flume(length=1.0, end=1000.0)
    assert 100 < mean_number(short, 0) < 1.2 * (1.0 / 0.02) * (0.04 / 0.02)
