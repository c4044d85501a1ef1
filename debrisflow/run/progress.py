"""The progress bar of a run, its wall time by phase, and its rates."""

from __future__ import annotations

from time import perf_counter
from types import TracebackType
from typing import Self

from debrisflow._jit import COMPILATIONS
from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.run.bar import bar, pause
from debrisflow.run.work import TimeLeft
from debrisflow.schemes.clock import Clock

START_UP, WRITING, PROBES = "start-up", "writing", "probes"
COMPILING, OTHER = "compiling", "other"
BAR = "{percentage:3.0f}% |{bar:20}| {desc}"


class Progress:
    """Shows a run while it is open, and counts its seconds, steps and particles.

    While kernels are compiled, which happens once for each version of the package, the bar says
    so.  That time is in neither the time left nor the rates.

    Parameters
    ----------
    case : ResolvedCase
    state : State
        At the start of the run or of its continuation.
    clock : Clock
        Started with the run; phases of the step and of the run are added to it.

    Attributes
    ----------
    particle_steps : int
        Sum of the fluid particles over the steps.
    steps : int
        Steps of this run, without those before it was continued.
    is_stopping : bool
        Whether the run is only going on to where it can be resumed.
    """

    def __init__(self, case: ResolvedCase, state: State, clock: Clock) -> None:
        self.particle_steps = self.steps = 0
        self.is_stopping = False
        self.clock = clock
        self._settling = case.time.settling
        self._left = TimeLeft(case, state.particles.fluid_count)
        self._drawn = perf_counter()
        self._seen = COMPILATIONS.seconds
        self._compiled = self._seen - clock.compile_seconds
        self._bar = bar(
            total=case.time.end + self._settling,
            initial=state.time + self._settling,
            bar_format=BAR,
        )

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
        """Count the step that led to a state, and show the state."""
        number, was_compiling = state.particles.fluid_count, COMPILATIONS.seconds > self._seen
        self._seen = COMPILATIONS.seconds
        self.steps += 1
        self.particle_steps += number
        written = self.clock.get(WRITING, 0.0)
        elapsed = self.seconds - written
        self._left.count(state.time, state.dt, number, elapsed, written, was_compiling)
        left = self._left.seconds
        self._bar.set_description_str(
            ("stopping: " if self.is_stopping else "")
            + f"t = {state.time:.3f} s, dt = {state.dt:.1e} s, {number} particles, "
            f"{self.particle_steps / self.seconds:.2g} particle-steps/s"
            + ("" if left is None else f", {self._bar.format_interval(left)} left"),
            refresh=False,
        )
        self._bar.update(state.time + self._settling - self._bar.n)

    def _show_compiling(self, seconds: float) -> None:
        now = perf_counter()
        if now - self._drawn >= pause():
            self._drawn = now
            self._bar.set_description_str(
                f"compiling kernels, once, about a minute: {seconds - self._compiled:.0f} s so far"
            )

    def __enter__(self) -> Self:
        """Return the progress itself."""
        COMPILATIONS.watcher = self._show_compiling
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the bar as it is."""
        COMPILATIONS.watcher = None
        self._bar.close()
