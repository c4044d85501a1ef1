"""The bar and the clock of a run: compiling is told, and is in no rate."""

from __future__ import annotations

import re
from math import sqrt
from time import perf_counter

import pytest

from debrisflow import _jit, load_case, simulate
from debrisflow._jit import COMPILATIONS
from debrisflow.particles.start import initial_state
from debrisflow.run import listeners
from debrisflow.run.bar import Bar
from debrisflow.run.events import COMPILING
from debrisflow.run.listeners import Listeners
from debrisflow.run.progress import OTHER, START_UP, WRITING, Progress
from debrisflow.run.work import speeds, step_at
from debrisflow.schemes import clock
from debrisflow.schemes.clock import Clock
from tests.building import tank_case


class Time:
    """A clock that stands still until it is moved, in all places that ask for the time."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        for module in (_jit, listeners, clock):
            monkeypatch.setattr(module, "perf_counter", lambda: self.now)

    def compile_for(self, seconds: float) -> None:
        COMPILATIONS.on_start(None)
        self.now += 0.5 * seconds
        COMPILATIONS.on_start(None)
        self.now += 0.5 * seconds
        COMPILATIONS.on_end(None)
        COMPILATIONS.on_end(None)


@pytest.fixture
def time(monkeypatch):
    return Time(monkeypatch)


@pytest.fixture
def state():
    return initial_state(tank_case(4, 4, "water"))


def test_compiling_is_told_and_counted_apart(time, state, capsys):
    with Progress(tank_case(4, 4, "water"), state, Clock(), Listeners([Bar()])) as shown:
        time.compile_for(80.0)
        time.now += 2.0
        state.time = 0.5
        shown.count(state)
        assert shown.clock.compile_seconds == pytest.approx(80.0)
        assert shown.seconds == pytest.approx(2.0)
        assert shown.particle_steps / shown.seconds == pytest.approx(8.0)
    told = capsys.readouterr().err
    assert "compiling kernels, once, about a minute: 40 s so far" in told
    assert "8 particle-steps/s" in told
    assert COMPILATIONS.watcher is None


def test_the_time_left_is_that_of_steps_alone(time, state, monkeypatch, capsys):
    monkeypatch.setattr("debrisflow.run.bar.PAUSE_IN_FILE", 0.0)
    case = tank_case(4, 4, "water")
    slow, fast = (step_at(case, speed) for speed in speeds(case))
    state.dt = sqrt(slow * fast)  # as foretold
    with Progress(case, state, Clock(), Listeners([Bar()])) as shown:
        time.compile_for(60.0)
        time.now += 5.0  # kernels are read
        for k in range(300):
            time.compile_for(30.0 if k == 50 else 0.0)
            time.now += 0.01
            state.time += state.dt
            shown.count(state)
        steps = (case.time.end - state.time) / state.dt
    told = capsys.readouterr().err.splitlines()
    assert "left" not in told[1]
    minutes, seconds = map(int, re.search(r"(\d+):(\d+) left", told[-2]).groups())
    assert 60 * minutes + seconds == pytest.approx(0.01 * steps, rel=0.05, abs=1.0)


def test_a_phase_is_without_its_compiling(time):
    seconds = Clock()
    with seconds.of("motion"):
        time.compile_for(10.0)
        time.now += 0.25
    assert seconds["motion"] == pytest.approx(0.25)


def test_a_phase_inside_another_counts_for_itself(time):
    seconds = Clock()
    with seconds.of("writing"):
        time.now += 1.0
        with seconds.of("frames"):
            time.now += 2.0
            with seconds.of("files"):
                time.now += 4.0
        time.now += 8.0
        with seconds.of("files"):
            time.now += 16.0
    assert seconds == {"files": 20.0, "frames": 2.0, "writing": 9.0}
    assert sum(seconds.values()) == seconds.seconds


def test_phases_add_up_to_the_whole_wall_time(time, state):
    clock = Clock()
    with clock.of(START_UP):
        time.now += 3.0
        time.compile_for(20.0)
    with Progress(tank_case(4, 4, "water"), state, clock, Listeners([])) as shown:
        with clock.of("motion"):
            time.now += 5.0
        time.now += 0.5
        phases = shown.phases()
        assert phases == pytest.approx({START_UP: 3.0, "motion": 5.0, COMPILING: 20.0, OTHER: 0.5})
        assert shown.seconds == pytest.approx(5.5)  # of steps: without start-up and compiling
    assert sum(phases.values()) == pytest.approx(time.now - 100.0)


def test_the_phases_of_a_run_add_up(tmp_path):
    case = load_case("cases/hydrostatic2d.toml", ["time.end=0.05", "output.interval=0.01"])
    before = perf_counter()
    told = simulate(case, tmp_path / "run")
    outside = perf_counter() - before
    phases = told["wall_seconds_by_phase"]
    whole = sum(phases.values())
    assert whole == pytest.approx(told["wall_seconds"] + told["compile_seconds"], rel=1e-9)
    assert 0.0 <= outside - whole < 2.0  # closing the files is not in it
    assert next(iter(phases)) == START_UP
    assert {"neighbors", "pressure equation", WRITING, COMPILING, OTHER} <= set(phases)
    assert min(phases.values()) > -1e-9  # of rounding
    assert phases[OTHER] < 0.5 * told["wall_seconds"]  # a few percent where the machine is free
    log = (tmp_path / "run/run.log").read_text()
    assert f"wall time: start-up {phases[START_UP]:.1f} s, " in log
    assert f"other {phases[OTHER]:.1f} s" in log
