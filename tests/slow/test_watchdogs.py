"""Planted faults: each is found early, told with its place, and spares the last checkpoint."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import pyvista

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.particles.state import State
from debrisflow.run import checkpoint, simulation
from debrisflow.run.checkpoint import Checkpoints
from debrisflow.run.events import END_OF_TIME
from debrisflow.run.names import CHECKPOINT, FAILURE, HISTORY, LOG
from debrisflow.run.watchdogs import time_step
from debrisflow.run.watchdogs.density import DensityBounds
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.term import Step, Term
from tests.building import started, tank3d_case, tank_case

AT = 60  # steps after which the fault is planted; the last checkpoint before is of step 40
SAVED, END = 40, 100
MOST_LATE = 13  # steps: rows of the history are checked every ten steps at most
D0 = 0.05
PILLAR = {"type": "box", "name": "pillar", "x": [0.4, 0.5], "y": [0.1, 0.2], "z": [0.0, 0.3]}

Spoil = Callable[[Any, State, pytest.MonkeyPatch], None]


def timed(build: Callable[..., ResolvedCase]) -> ResolvedCase:
    """Return a case of some hundred steps, with rows every two and frames every twenty."""
    step = build().time.largest_step
    output = {"interval": 20 * step, "checkpoint_interval": 20 * step}
    return build(time={"end": END * step}, output=output)


def tank() -> ResolvedCase:
    """Return water in the left half of a tank in two dimensions."""
    return timed(lambda **tables: tank_case(8, 8, "water", tank=(16, 16), **tables))


def cube() -> ResolvedCase:
    """Return a block of mixture that falls apart beside a pillar."""
    block = {"type": "block", "x": [0.0, 0.3], "y": [0.0, 0.3], "z": [0.0, 0.3]}
    return timed(
        lambda **tables: tank3d_case(
            size=(1.0, 0.3, 0.4),
            fill=[block | {"material": "mixture"}],
            particles={"spacing": D0},
            obstacle=[PILLAR],
            **tables,
        )
    )


class Fault(NamedTuple):
    """A fault, how it is planted, and what the message must say."""

    case: Callable[[], ResolvedCase]
    spoil: Spoil
    says: str
    has_particle: bool = True
    at: int = AT


class NoNumber(Term):
    """A term that finds no number for the force on one particle."""

    name = "fault"

    def act(self, step: Step) -> None:
        step.velocity[3, 0] = np.nan


class Gain(Term):
    """A term with the wrong sign: it drives what it should damp."""

    name = "fault"

    def __init__(self, factor: float) -> None:
        self._factor = factor

    def act(self, step: Step) -> None:
        step.velocity *= self._factor


def with_term(term: Term) -> Spoil:
    def spoil(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
        *others, motion = scheme.terms
        scheme.terms = (*others, term, motion)

    return spoil


def concentration_overflows(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    observe = Concentration.observe

    def observe_and_spoil(term: Concentration, scene: Any) -> None:
        observe(term, scene)
        scene.particles.concentration[7] = np.inf

    patch.setattr(Concentration, "observe", observe_and_spoil)


def floor_with_a_hole(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    state.particles.position[:12, 1] = -2.5 * scheme.case.particles.spacing


def speeds_up(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    state.particles.velocity[3, 0] = 1.0e7


def stalls(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    least = 0.005 * scheme.case.time.largest_step
    patch.setattr(Motion, "limit", lambda term, scene: least)
    patch.setattr(time_step, "STALLED_STEPS", 4)


def solves_nothing(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Solver, "MOST_ITERATIONS", 0)


def is_soft(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    """Forget the sound speed: the fluid is compressed."""
    state.particles.compression[: state.particles.fluid_count // 20] = 0.4


def piles_up(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    p = state.particles
    p.position[:8] = p.position[20:28] + 1e-4


def loses_one(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    p = state.particles
    p.keep(np.arange(1, p.fluid_count), p.fluid_count)
    p.fluid_count -= 1


def counts_one_too_many(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    state.entered[0] += 1


def is_there_twice(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    state.particles.id[5] = state.particles.id[6]


def turns_to_sediment(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
    state.particles.kind[5] = 1


FAULTS = {
    "velocity is no number": Fault(tank, with_term(NoNumber()), r"got the velocity \[ *nan"),
    "velocity is no number 3D": Fault(cube, with_term(NoNumber()), r"got the velocity \[ *nan"),
    "concentration is infinite": Fault(tank, concentration_overflows, "has the concentration inf"),
    "hole in the floor": Fault(tank, floor_with_a_hole, "12 of 64 particles, 19 %, .*walls", False),
    "step collapses": Fault(
        tank, speeds_up, r"step has fallen to .* moves at 1e\+07 m/s", at=AT + 1
    ),
    "step stalls": Fault(cube, stalls, "the run stalls: the last 4 steps advanced it by"),
    "pressure": Fault(tank, solves_nothing, "the pressure equation was not solved .* n/n0 = "),
    "compressed": Fault(cube, is_soft, r"% of the particles are compressed by more than 25 %"),
    "crowded": Fault(tank, piles_up, r"\d+ % of the particles are crowded, n/n0 above 1.5"),
    "energy": Fault(
        cube, with_term(Gain(1.3)), "more energy than gravity, inflow and moving walls"
    ),
    "energy 2D": Fault(tank, with_term(Gain(1.1)), "J/m more energy than gravity, inflow and"),
    "lost and not counted": Fault(tank, loses_one, "ledger of particles .*: 1 are missing"),
    "counted and not there": Fault(cube, counts_one_too_many, "1 are missing; 216 at the start"),
    "there twice": Fault(cube, is_there_twice, "2 particles are there more than once"),
    "phase": Fault(tank, turns_to_sediment, "ledger of liquid particles does not close: 1 are"),
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[Any, bytes]:
    """Return the history of each case without a fault; no watchdog barks."""
    histories = {}
    for build in (tank, cube):
        folder = tmp_path_factory.mktemp("sound") / "run"
        assert simulation.simulate(build(), folder, threads=1)["steps"] >= END
        assert "WARNING" not in (folder / LOG).read_text()
        assert not (folder / FAILURE).exists()
        histories[build] = (folder / HISTORY).read_bytes()
    return histories


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> Callable[..., pytest.MonkeyPatch]:
    """Return a function that lets a fault arise at the end of a step."""

    def planted(spoil: Spoil, at: int = AT) -> pytest.MonkeyPatch:
        step = Scheme.step

        def step_and_spoil(scheme: Any, state: State, dt: float) -> int:
            iterations = step(scheme, state, dt)
            if state.step == at - 1:
                spoil(scheme, state, monkeypatch)
            return iterations

        monkeypatch.setattr(Scheme, "step", step_and_spoil)
        return monkeypatch

    return planted


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_found(
    name: str,
    plant: Callable[..., pytest.MonkeyPatch],
    sound: dict[Any, bytes],
    tmp_path: Path,
) -> None:
    fault, folder = FAULTS[name], tmp_path / "run"
    saved = saved_checkpoints(plant(fault.spoil, fault.at))
    with pytest.raises(DivergedError, match=fault.says) as found:
        simulation.simulate(fault.case(), folder, threads=1)
    text = str(found.value)

    moment = re.match(r"at t = ([\d.e+-]+) s, step (\d+), ", text)
    assert moment is not None
    assert AT <= int(moment[2]) <= AT + MOST_LATE
    assert "\nlikely cause: " in text
    assert "\nwhat to do: " in text

    frame = pyvista.read(folder / FAILURE)
    assert set(frame["kind"]) <= {0, 1, 2, 3, 4}
    if fault.has_particle:
        who, place = re.search(r"particle (\d+) at (x = [^m]*) m", text).groups()
        there = frame.points[np.flatnonzero(frame["id"] == int(who))[0]]
        told = [float(value) for value in re.findall(r"= ([-\d.e+]+)", place)]
        np.testing.assert_allclose(there[: len(told)], told, rtol=1e-4)

    kept = folder / CHECKPOINT
    assert kept.read_bytes() == saved[-1]
    assert checkpoint.load(kept).state.step == SAVED
    assert f"last good state: {kept}, t = " in text
    told = (folder / LOG).read_text()
    assert all(line in told for line in text.splitlines())


def saved_checkpoints(patch: pytest.MonkeyPatch) -> list[bytes]:
    """Return a list that takes the bytes of every checkpoint when it is saved."""
    saved, save = [], Checkpoints.save

    def save_and_keep(checkpoints: Checkpoints, *what: Any) -> None:
        save(checkpoints, *what)
        saved.append(checkpoints.last.read_bytes())

    patch.setattr(Checkpoints, "save", save_and_keep)
    return saved


@pytest.mark.parametrize("name", ["energy", "lost and not counted", "pressure"])
def test_a_run_goes_on_from_the_checkpoint_before_a_fault(
    name: str,
    plant: Callable[..., pytest.MonkeyPatch],
    sound: dict[Any, bytes],
    tmp_path: Path,
) -> None:
    fault, folder = FAULTS[name], tmp_path / "run"
    patch = plant(fault.spoil)
    with pytest.raises(DivergedError):
        simulation.simulate(fault.case(), folder, threads=1)
    patch.undo()
    assert simulation.resume(folder, threads=1)["end_reason"] == END_OF_TIME
    assert (folder / HISTORY).read_bytes() == sound[fault.case]
    assert not (folder / FAILURE).exists()


def test_a_fault_before_the_first_checkpoint_leaves_none(
    plant: Callable[..., pytest.MonkeyPatch], tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    patch = plant(with_term(NoNumber()), at=3)
    with pytest.raises(DivergedError, match=r"no checkpoint was saved yet: .* begins anew"):
        simulation.simulate(tank(), folder, threads=1)
    assert not (folder / CHECKPOINT).exists()
    patch.undo()
    assert simulation.resume(folder, threads=1)["end_reason"] == END_OF_TIME


def test_a_particle_lost_in_an_obstacle_is_told_and_the_run_goes_on(
    plant: Callable[..., pytest.MonkeyPatch], tmp_path: Path
) -> None:
    def into_the_pillar(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
        state.particles.position[3] = 0.45, 0.15, 0.15

    plant(into_the_pillar)
    summary = simulation.simulate(cube(), tmp_path / "run", threads=1)
    assert sum(summary["through_wall"].values()) == 1
    told = warnings_of(tmp_path / "run")
    assert re.search(r"step 81, particle \d+ went through obstacle pillar at x = 0\.4", told[0])
    assert "likely cause: " in told[0]
    assert "what to do: " in told[0]


def test_a_particle_deep_in_a_wall_of_the_semi_implicit_scheme_is_told_once(
    plant: Callable[..., pytest.MonkeyPatch], tmp_path: Path
) -> None:
    def into_the_floor(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
        state.particles.position[3, 1] = -0.008
        state.particles.velocity[3] = 0.0

    plant(into_the_floor, at=2 * SAVED)
    simulation.simulate(tank(), tmp_path / "run", threads=1)
    told = [line for line in warnings_of(tmp_path / "run") if "deep in" in line]
    assert len(told) == 1
    assert re.search(r"step 80, particle \d+ at .* is half a spacing deep in the floor", told[0])


def test_steps_that_are_halved_often_are_told(
    plant: Callable[..., pytest.MonkeyPatch], tmp_path: Path
) -> None:
    def fails_at_first(scheme: Any, state: State, patch: pytest.MonkeyPatch) -> None:
        solve, calls = Solver.solve, [0]

        def fail_every_other(solver: Solver, *system: Any) -> int:
            calls[0] += 1
            return -1 if calls[0] % 2 else solve(solver, *system)

        patch.setattr(Solver, "solve", fail_every_other)

    plant(fails_at_first, at=2)
    simulation.simulate(tank(), tmp_path / "run", threads=1)
    told = warnings_of(tmp_path / "run")
    assert sum("; halved" in line for line in told) == 3  # no flood of lines
    often = [line for line in told if "50 times within 1000 steps" in line]
    assert len(often) == 1
    assert re.search(r"particle \d+ at x = .*likely cause: .*what to do: ", often[0])


def test_a_soft_fluid_is_told_before_it_ends_the_run(caplog: pytest.LogCaptureFixture) -> None:
    case = cube()
    scheme, state = started(case)
    state.particles.compression[:20] = 0.15
    bounds = DensityBounds(case, scheme)
    bounds.check(state)
    bounds.check(state)
    (told,) = caplog.messages
    assert re.search(r"compressed by more than 10 %.* particle \d+ at x = ", told)
    assert re.search(r"set scheme\.sound_speed = \d+", told)


def test_a_film_thinner_than_a_spacing_is_told_once(tmp_path: Path) -> None:
    case = tank_case(
        4, 4, "water", tank=(80, 8), time={"end": 1.0}, output={"interval": 0.1, "rest_speed": 0.01}
    )
    simulation.simulate(case, tmp_path / "run", threads=1)
    told = warnings_of(tmp_path / "run")
    assert len(told) == 1
    assert re.search(r"at t = .* thinner than a spacing over \d+ % .* near x = ", told[0])
    assert "particles.spacing = 0.005 m" in told[0]


def warnings_of(folder: Path) -> list[str]:
    return [line for line in (folder / LOG).read_text().splitlines() if " WARNING " in line]
