"""The loop over time: steps, outputs, checkpoints and the end of a run."""

from __future__ import annotations

import logging
import math
import platform
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from threading import current_thread, main_thread
from time import perf_counter
from typing import Any

from tqdm import tqdm

from debrisflow._jit import THREADING_LAYER, cores, set_threads
from debrisflow.case import ResolvedCase, load_case
from debrisflow.errors import DivergedError, NotConvergedError
from debrisflow.particles.state import PHASES, State, initial_state
from debrisflow.run import checkpoint
from debrisflow.run.crossings import Crossings
from debrisflow.run.folder import CASE, CHECKPOINT, RunFolder
from debrisflow.run.history import history_row
from debrisflow.run.measures import deposit_profile, flow, particle_volume
from debrisflow.run.probes import WallForce, probe_measures
from debrisflow.run.schedule import Schedule
from debrisflow.schemes.explicit import Explicit
from debrisflow.schemes.semi_implicit import SemiImplicit

LOG = logging.getLogger("debrisflow.run.loop")
MOST_HALVINGS = 6
LEAST_STEP = 1.0e-5
INTERRUPTED = "interrupted"
FEWEST_PARTICLES_A_THREAD = 4000
SCHEMES: dict[str, type[SemiImplicit] | type[Explicit]] = {
    "semi-implicit": SemiImplicit,
    "explicit": Explicit,
}


def simulate(
    case: ResolvedCase, folder: Path | str, threads: int | None = None, overwrite: bool = False
) -> dict[str, Any]:
    """Compute a case and write its results into a folder.

    Parameters
    ----------
    case : ResolvedCase
        As :func:`debrisflow.case.load_case` returns it.
    folder : Path or str
        Holds the results afterwards; refused if it holds some already, unless ``overwrite``.
    threads : int, optional
        As many as the case can use by default; the result does not depend on it.

    Returns
    -------
    dict
        The summary, also in ``summary.json``.

    Raises
    ------
    CaseError, OutputError, DivergedError
    """
    state = initial_state(case)
    probe_measures(case, state.particles)  # what is wrong with a probe, before a folder is touched
    with RunFolder.create(Path(folder), case, overwrite) as results:
        run = _Run(case, results, state, threads)
        run.scheme.fill_number_density(state)
        run.write(0)
        run.sample(-math.inf)
        return run.finish()


def resume(folder: Path, threads: int | None = None) -> dict[str, Any]:
    """Continue the run of a folder from its last checkpoint; see :func:`simulate`."""
    case = load_case(folder / CASE)
    state = checkpoint.load(folder / CHECKPOINT)
    with RunFolder.open(folder, case) as results:
        results.rewind(state.time)
        LOG.info("resumed at t = %g s, step %d", state.time, state.step)
        return _Run(case, results, state, threads).finish()


class _Run:
    """One run: its case, folder, state, scheme and schedules."""

    def __init__(
        self, case: ResolvedCase, results: RunFolder, state: State, threads: int | None
    ) -> None:
        self.case, self.results, self.state = case, results, state
        self.scheme = SCHEMES[case.scheme.type](case)
        useful = max(1, state.particles.unknown_count // FEWEST_PARTICLES_A_THREAD)
        self.threads = set_threads(threads or min(cores(), useful))
        start, end, output = -case.time.relaxation, case.time.end, case.output
        self.frames = Schedule(output.interval, 0.0, end)
        self.deposits = Schedule(output.deposit_interval, 0.0, end)
        self.histories = Schedule(output.history_interval, start, end)
        self.probes = probe_measures(case, state.particles)
        self.forces = [probe for probe in self.probes.values() if isinstance(probe, WallForce)]
        self.crossings = Crossings(case, state)
        self.samples = {probe.name: Schedule(probe.interval, 0.0, end) for probe in case.probe}
        self._owes_checkpoint = False
        self._asked_to_stop = False
        self._particle_steps = 0
        self._first_step = state.step
        self._start = perf_counter()
        LOG.info(
            "%s: %d fluid of %d particles, %d threads (%s)",
            case.title,
            state.particles.fluid_count,
            state.particles.count,
            self.threads,
            THREADING_LAYER,
        )

    def finish(self) -> dict[str, Any]:
        """Run to the end of the simulated time and return the summary."""
        try:
            with self._polite_interrupt():
                reason = self._loop()
        except DivergedError as error:
            checkpoint.save(self.results.checkpoint_path, self.state)
            self._conclude(str(error))
            message = f"{error}; the last good state is in {self.results.checkpoint_path}"
            raise DivergedError(message) from error
        summary = self._conclude(reason)
        if reason == INTERRUPTED:
            raise KeyboardInterrupt
        return summary

    @contextmanager
    def _polite_interrupt(self) -> Iterator[None]:
        """Let the first Ctrl-C end the run where it can be resumed bit for bit."""

        def ask(*_: object) -> None:
            self._asked_to_stop = True
            signal.signal(signal.SIGINT, former)

        if current_thread() is not main_thread():
            yield
            return
        former = signal.signal(signal.SIGINT, ask)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, former)

    def _loop(self) -> str:
        state, end = self.state, self.case.time.end
        total = end + self.case.time.relaxation
        with tqdm(
            total=total,
            initial=state.time + self.case.time.relaxation,
            bar_format="{percentage:3.0f}% |{bar:20}| {desc}, {remaining} left",
            mininterval=0.5,
        ) as bar:
            while state.time < end:
                if state.particles.fluid_count + state.particles.inflow_count == 0:
                    return "no fluid is left"
                at_fresh_start = state.step % self.scheme.REFRESH == 0
                if at_fresh_start and (self._owes_checkpoint or self._asked_to_stop):
                    # there the scheme starts afresh, so that a resumed run repeats the bits
                    checkpoint.save(self.results.checkpoint_path, state)
                    self._owes_checkpoint = False
                if at_fresh_start and self._asked_to_stop:
                    return INTERRUPTED
                due = min(s.next_after(state.time) for s in self._schedules)
                before = state.time
                iterations = self._advance(due)
                self.crossings.count(state)
                for wall in self.forces:
                    wall.add_impulse(state)
                self.write(iterations)
                self.sample(before)
                self._show(bar)
        return "end of the simulated time"

    @property
    def _schedules(self) -> tuple[Schedule, Schedule, Schedule]:
        return self.frames, self.deposits, self.histories

    def _advance(self, due: float) -> int:
        """Take one step, landing exactly on a due time; return the iterations of the pressure."""
        state = self.state
        longest = self.scheme.stable_dt(state)
        if longest < LEAST_STEP * self.case.time.largest_step:
            raise DivergedError(
                f"at t = {state.time:g} s, step {state.step}, the time step has fallen to "
                f"{longest:.3g} s: a particle is too fast or the collision stress too stiff"
            )
        for _ in range(MOST_HALVINGS):
            steps = max(1, math.ceil((due - state.time) / longest * (1.0 - 1e-12)))
            dt = (due - state.time) / steps
            try:
                iterations = self.scheme.step(state, dt)
            except NotConvergedError as error:
                LOG.warning("%s not solved at t = %g s, dt = %g s; halved", error, state.time, dt)
                longest = 0.5 * dt
                continue
            state.time = due if steps == 1 else state.time + dt
            state.dt = dt
            state.step += 1
            self._particle_steps += state.particles.fluid_count
            return iterations
        raise DivergedError(
            f"at t = {state.time:g} s, step {state.step}, a linear system was not solved even with "
            f"a time step of {longest:.3g} s"
        )

    def write(self, iterations: int) -> None:
        """Write what is due at the time of the state."""
        state, p = self.state, self.state.particles
        n0 = self.scheme.lattice.number_density
        if self.histories.is_due(state.time):
            row = history_row(self.case, state, iterations, self.scheme.lattice)
            self.results.write_history(row)
            if state.time >= 0.0:
                found = flow(self.case, p, n0)
                state.maxima.include(state.time, *found, spacing=self.case.particles.spacing)
        if self.deposits.is_due(state.time):
            profile = deposit_profile(
                self.case,
                p.position,
                p.velocity,
                p.kind,
                p.concentration,
                p.sediment_fraction,
                p.number_density,
                n0,
            )
            self.results.write_deposit(state.time, profile)
        if self.frames.is_due(state.time):
            self.results.write_frame(state)
            self._owes_checkpoint = True

    def sample(self, before: float) -> None:
        """Write the probes that were due after a time, s, and up to that of the state.

        Steps are not shortened for them, so that they leave the solution as it is.
        """
        for name, schedule in self.samples.items():
            if schedule.passed_due(before, self.state.time):
                row = self.probes[name].sample(self.state)
                self.results.write_probe(name, self.state.time, row)

    def _show(self, bar: Any) -> None:
        state = self.state
        rate = self._particle_steps / (perf_counter() - self._start)
        bar.set_description_str(
            f"t = {state.time:.3f} s, dt = {state.dt:.1e} s, "
            f"{state.particles.fluid_count} particles, {rate:.2g} particle-steps/s",
            refresh=False,
        )
        bar.update(state.time + self.case.time.relaxation - bar.n)

    def _conclude(self, reason: str) -> dict[str, Any]:
        state, seconds = self.state, perf_counter() - self._start
        lost = int(state.through_wall.sum())
        if lost:
            LOG.warning("%d particles went through a wall", lost)
        summary = {
            "title": self.case.title,
            "end_reason": reason,
            "time": state.time,
            "steps": state.step,
            "wall_seconds": seconds,
            "wall_seconds_by_phase": self.scheme.seconds,
            "particle_steps_per_second": self._particle_steps / seconds,
            "seconds_per_step": seconds / max(1, state.step - self._first_step),
            "threads": self.threads,
            "threading_layer": THREADING_LAYER,
            "particles": state.particles.count,
            "entered": dict(zip(PHASES, state.entered.tolist(), strict=True)),
            "left": dict(zip(PHASES, state.left.tolist(), strict=True)),
            "through_wall": dict(zip(PHASES, state.through_wall.tolist(), strict=True)),
            "sediment_volume": {
                way: float(sediment.sum()) * particle_volume(self.case)
                for way, sediment in (
                    ("entered", state.entered_sediment),
                    ("left", state.left_sediment),
                    ("through_wall", state.through_wall_sediment),
                )
            },
            "versions": {"python": platform.python_version()}
            | {name: version(name) for name in ("debrisflow", "numpy", "numba", "scipy")},
        }
        self.results.write_maxima(state)
        self.results.write_summary(summary)
        LOG.info("%s: t = %g s after %d steps, %.1f s", reason, state.time, state.step, seconds)
        return summary
