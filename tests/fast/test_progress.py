"""The bar and the clock of a run: compiling is told, and is in no rate."""

from __future__ import annotations

import pytest

from debrisflow import _jit
from debrisflow._jit import COMPILATIONS
from debrisflow.particles.state import initial_state
from debrisflow.run import progress
from debrisflow.run.progress import Progress
from debrisflow.schemes import clock
from debrisflow.schemes.clock import Clock
from tests.building import tank_case


class Time:
    """A clock that stands still until it is moved, in all places that ask for the time."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        for module in (_jit, progress, clock):
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
    with Progress(tank_case(4, 4, "water"), state) as shown:
        time.compile_for(80.0)
        time.now += 2.0
        state.time = 0.5
        shown.count(state)
        assert shown.compile_seconds == pytest.approx(80.0)
        assert shown.seconds == pytest.approx(2.0)
        assert shown.particle_steps / shown.seconds == pytest.approx(8.0)
    told = capsys.readouterr().err
    assert "compiling kernels, once, about a minute: 40 s so far" in told
    assert "8 particle-steps/s" in told
    assert COMPILATIONS.watcher is None


def test_the_time_left_is_that_of_steps_alone(time, state):
    case = tank_case(4, 4, "water")
    with Progress(case, state) as shown:
        bar = shown._bar
        bar._time = lambda: time.now
        bar.start_t = bar.last_print_t = time.now
        time.compile_for(60.0)
        time.now += 0.5
        shown.count(state)
        time.now += 1.0
        state.time = 0.1
        shown.count(state)
        assert bar.format_dict["elapsed"] == pytest.approx(1.0)


def test_a_phase_is_without_its_compiling(time):
    seconds = Clock()
    with seconds.of("motion"):
        time.compile_for(10.0)
        time.now += 0.25
    assert seconds["motion"] == pytest.approx(0.25)
