"""The progress of a run: its wall time by phase, its rates, and the events that tell of it."""

from __future__ import annotations

import os
import socket
from datetime import UTC, datetime, timedelta
from types import TracebackType
from typing import Self

from debrisflow import __version__
from debrisflow._jit import COMPILATIONS, threads
from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.run.balance import Balance
from debrisflow.run.events import (
    CHECKPOINT,
    COMPILING,
    ENDED,
    FAILED,
    INTERRUPTED,
    PROGRESS,
    RUNNING,
    START,
    STARTING,
    STOPPING,
    Event,
)
from debrisflow.run.listeners import Listeners
from debrisflow.run.work import TimeLeft
from debrisflow.schemes.clock import Clock

START_UP, WRITING, PROBES = "start-up", "writing", "probes"
OTHER = "other"


class Progress:
    """Counts the seconds, steps and particles of a run, and tells listeners of them.

    Compiling, which happens once for each version of the package, is a state of its own; that time
    is in neither the time left nor the rates.

    Parameters
    ----------
    case : ResolvedCase
    state : State
        At the start of the run or of its continuation.
    clock : Clock
        Started with the run; phases of the step and of the run are added to it.
    listeners : Listeners

    Attributes
    ----------
    particle_steps : int
        Sum of the fluid particles over the steps.
    steps : int
        Steps of this run, without those before it was continued.
    is_stopping : bool
        Whether the run is only going on to where it can be resumed; set by the loop.
    reason : str
        Why the run is over; set by the loop.
    """

    def __init__(
        self, case: ResolvedCase, state: State, clock: Clock, listeners: Listeners
    ) -> None:
        self.particle_steps = self.steps = 0
        self.clock, self.is_stopping, self.reason = clock, False, ""
        self._case, self._state, self._phase = case, state, STARTING
        self._start_time = state.time
        self._left = TimeLeft(case, state.particles.fluid_count)
        self._balance = Balance(case, state)
        self._seen = COMPILATIONS.seconds
        self._compiled = self._seen - clock.compile_seconds
        self._checkpoint: tuple[float, str] | None = None
        self._listeners = listeners

    @property
    def seconds(self) -> float:
        """Wall time since start-up, without that in which kernels were compiled, s."""
        return max(self.clock.seconds - self.clock.get(START_UP, 0.0), 1e-9)

    def phases(self) -> dict[str, float]:
        """Return the wall time by phase until now, s, in the order of the first times.

        With what was spent compiling kernels and in no phase they add up to the whole.
        """
        seconds, compiling = self.clock.seconds, self.clock.compile_seconds
        other = seconds - sum(self.clock.values())
        return dict(self.clock) | {COMPILING: compiling, OTHER: other}

    def count(self, state: State) -> None:
        """Count the step that led to a state."""
        number, was_compiling = state.particles.fluid_count, COMPILATIONS.seconds > self._seen
        self._seen = COMPILATIONS.seconds
        self.steps += 1
        self.particle_steps += number
        written = self.clock.get(WRITING, 0.0)
        elapsed = self.seconds - written
        self._left.count(state.time, state.dt, number, elapsed, written, was_compiling)
        before, self._phase = self._phase, STOPPING if self.is_stopping else RUNNING
        self._tell(PROGRESS, at_once=self._phase != before)

    def count_checkpoint(self) -> None:
        """Note that a checkpoint of the present state was written."""
        self._checkpoint = self._state.time, _iso(datetime.now(UTC))
        self._tell(CHECKPOINT)

    def _show_compiling(self, seconds: float) -> None:
        before, self._phase = self._phase, COMPILING
        compiling = seconds - self._compiled
        self._tell(PROGRESS, before != COMPILING, compile_seconds=compiling)

    def _tell(self, kind: str, at_once: bool = True, **newer: float) -> None:
        self._listeners.tell(lambda: {"event": kind} | self._figures() | newer, at_once)

    def _figures(self) -> Event:
        """Return where the run is, by the names in ``FIELDS``."""
        state, now = self._state, datetime.now(UTC)
        left = self._left.seconds if self._phase == RUNNING else None
        particles, mass = self._balance.of(state)
        at, saved = self._checkpoint or (None, None)
        return {
            "state": self._phase,
            "reason": self.reason,
            "title": self._case.title,
            "dimension": self._case.dimension,
            "version": __version__,
            "host": socket.gethostname(),
            "process": os.getpid(),
            "threads": threads(),
            "begin": 0.0 - self._case.time.settling,  # not -0.0
            "time": state.time,
            "end": self._case.time.end,
            "step": state.step,
            "dt": state.dt,
            "particles": state.particles.fluid_count,
            "rate": self.particle_steps / self.seconds,
            "speed": (state.time - self._start_time) / self.seconds,
            "seconds_left": left,
            "ends_at": None if left is None else _iso(now + timedelta(seconds=left)),
            "wall_seconds": self.clock.seconds,
            "compile_seconds": self.clock.compile_seconds,
            "checkpoint_time": at,
            "checkpoint_at": saved,
            "ledger_particles": particles,
            "ledger_mass": mass,
            "updated": _iso(now),
        }

    def __enter__(self) -> Self:
        """Tell the start."""
        COMPILATIONS.watcher = self._show_compiling
        self._tell(START)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Tell the end."""
        COMPILATIONS.watcher = None
        self._phase = ENDED if error is None else FAILED
        if isinstance(error, KeyboardInterrupt):
            self._phase = INTERRUPTED
        elif error is not None:
            self.reason = str(error) or type(error).__name__
        self._tell(PROGRESS)


def _iso(time: datetime) -> str:
    return time.isoformat(timespec="seconds")
