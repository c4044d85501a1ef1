"""The loop over time: steps, outputs, checkpoints and the end of a run."""

from __future__ import annotations

import json
import logging
import math
from time import perf_counter
from typing import Any

from debrisflow import __version__
from debrisflow._jit import KERNELS, PROCESSOR, THREADING_LAYER, cores, set_threads
from debrisflow.case import ResolvedCase
from debrisflow.case.built import HEAD
from debrisflow.case.content import Content
from debrisflow.case.doubts import doubts
from debrisflow.errors import DivergedError, Interrupted, NotConvergedError
from debrisflow.particles.releases import is_pending, waiting
from debrisflow.particles.state import State
from debrisflow.run.checkpoint import Origin
from debrisflow.run.events import AT_REST, EMPTY, END_OF_TIME, INTERRUPTED
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import history_row
from debrisflow.run.layer_recorder import recorder_of
from debrisflow.run.ledger import ledger_row
from debrisflow.run.measures import deposit_profile, flow
from debrisflow.run.pace import Pace, remember
from debrisflow.run.probe import Sampler
from debrisflow.run.progress import PROBES, WRITING, Progress
from debrisflow.run.schedule import Schedule
from debrisflow.run.stop import StopRule
from debrisflow.run.stop_signals import StopSignals
from debrisflow.run.summary import summary
from debrisflow.run.watchdogs.watch import Watchdogs
from debrisflow.schemes.choice import scheme_of
from debrisflow.space.encounters import encounters
from debrisflow.space.volumes import differences

LOG = logging.getLogger(__name__)
MOST_HALVINGS = 6
LEAST_REST = 1.0e-6  # of the largest step; shorter rests of halved steps to a due time are dropped
FEWEST_PARTICLES_A_THREAD = 4000
MOST_SAVING = 0.015  # of the wall time, for checkpoints by wall time


def program() -> str:
    """Return the program and what its machine code comes from, in words."""
    return f"debrisflow {__version__}, kernels {KERNELS}"


def origin_of(content: Content) -> Origin:
    """Return what a run computes by, and from, now."""
    return Origin(program(), PROCESSOR, json.dumps(content))


def use_threads(state: State, given: int | None) -> int:
    """Use the number of threads given, or as many as the particles keep busy, and return it."""
    useful = max(1, state.particles.unknown_count // FEWEST_PARTICLES_A_THREAD)
    return set_threads(given or min(cores(), useful))


class Run:
    """One run: its case, folder, state, scheme, probes and schedules."""

    def __init__(
        self,
        case: ResolvedCase,
        results: RunFolder,
        state: State,
        probes: dict[str, Sampler],
        progress: Progress,
        signals: StopSignals,
        threads: int | None,
    ) -> None:
        self.case, self.results, self.state = case, results, state
        self.probes, self.progress = probes, progress
        self.clock, self.rule = progress.clock, StopRule(case)
        self.scheme = scheme_of(case)
        self.scheme.seconds = self.clock  # one clock for the steps and what is around them
        self.watchdogs = Watchdogs(case, self.scheme, state, results.checkpoints.last)
        self._given_threads, self.threads = threads, 0
        self._set_threads()
        start, end, output = -case.time.settling, case.time.end, case.output
        self.frames = Schedule(output.interval, 0.0, end)
        self.deposits = Schedule(output.deposit_interval, 0.0, end)
        self.histories = Schedule(output.history_interval, start, end)
        self.depths: Schedule | None = None
        if case.is_terrain and output.layer_interval is not None:
            self.depths = Schedule(output.layer_interval, 0.0, end)
        self.checkpoints: Schedule | None = None
        if output.checkpoint_interval is not None:
            self.checkpoints = Schedule(output.checkpoint_interval, start, end)
        self.samples = {probe.name: Schedule(probe.interval, 0.0, end) for probe in case.probe}
        self.recorder = recorder_of(case)
        self._origin, self._saved, self._saving = origin_of(results.content), perf_counter(), 0.0
        self._checkpoint_is_due = self._is_at_rest = False
        self._signals = signals
        LOG.info(
            "%s: %d fluid of %d particles, threads by %s",
            case.title,
            state.particles.fluid_count,
            state.particles.count,
            THREADING_LAYER,
        )
        for doubt in (*doubts(case), *encounters(case)):
            LOG.warning("%s", doubt)
        if rounded := differences(case):
            LOG.info("built otherwise than asked:\n%s", "\n".join([HEAD, *map(str, rounded)]))

    def _set_threads(self) -> None:
        """Use as many threads as the particles keep busy, and keep the greatest number used.

        Results do not depend on it.
        """
        used = use_threads(self.state, self._given_threads)
        if used > self.threads:
            LOG.info("%d threads at t = %g s", used, self.state.time)
        self.threads = max(self.threads, used)

    def start(self) -> None:
        """Write what there is before the first step."""
        try:
            self._record(0.0)
            self.write(iterations=0)
            self.sample(before=-math.inf)
        except DivergedError as error:
            raise self._failed(error) from error

    def finish(self) -> dict[str, Any]:
        """Run to the end of the simulated time and return the summary."""
        try:
            reason = self._loop()
        except DivergedError as error:
            raise self._failed(error) from error
        figures = self._conclude(reason)
        if self._signals.received is not None and reason == INTERRUPTED:
            raise Interrupted(self._signals.received)
        return figures

    def _failed(self, error: DivergedError) -> DivergedError:
        """Write the particles at a failure and the summary; the checkpoint stays as it is.

        Returns the error with where the last good state is.
        """
        LOG.error("%s", error)  # before anything is written, which may fail too
        failed = self.results.write_failed(self.state)
        self._conclude(error.what)
        kept = self.watchdogs.where_kept(failed)
        LOG.info("%s", kept)
        return DivergedError(error.what, error.cause, error.remedy, kept)

    def _loop(self) -> str:
        """Take steps until the end, and return why the run ended."""
        state = self.state
        while state.time < self.case.time.end:
            if state.particles.moving.stop == 0 and not is_pending(self.case, state):
                return EMPTY
            if self._stops_at_checkpoint():
                return INTERRUPTED
            before = state.time
            iterations = self._advance(self._next_due())
            self.watchdogs.after_step()
            with self.clock.of(PROBES):
                for probe in self.probes.values():
                    probe.add_step(state)
                self._record(state.time - before)
            self.write(iterations)
            self.sample(before)
            if self.checkpoints and self.checkpoints.passed_due(before, state.time):
                self._checkpoint_is_due = True
            self.progress.is_stopping = self._signals.received is not None
            self.progress.count(state)
            if self._is_at_rest:
                self._write_last()
                return AT_REST
        return END_OF_TIME

    def _record(self, dt: float) -> None:
        """Take the flow after a step of a length, s, into the layers of a map."""
        if self.recorder is not None and self.state.time >= 0.0:
            self.recorder.add_step(self.state.layers, self.state.particles, self.state.time, dt)

    def _stops_at_checkpoint(self) -> bool:
        """Save a checkpoint that is due, and return whether the run is to stop there.

        A checkpoint is saved only where the scheme starts afresh, so that a resumed run repeats
        the bits.
        """
        if self.state.step % self.scheme.REFRESH != 0:
            return False
        is_asked = self._signals.received is not None
        pause = max(self.case.output.checkpoint_wall_time, self._saving / MOST_SAVING)
        if self._checkpoint_is_due or is_asked or perf_counter() - self._saved > pause:
            self._save_checkpoint()
        return is_asked

    def _save_checkpoint(self) -> None:
        self.watchdogs.before_save()
        start = perf_counter()
        with self.clock.of(WRITING):
            self.results.flush()
            self.results.checkpoints.save(self.state, self._origin)
        self._saved, self._checkpoint_is_due = perf_counter(), False
        self._saving = self._saved - start
        self.progress.count_checkpoint()
        LOG.debug("checkpoint at t = %g s", self.state.time)

    def _next_due(self) -> float:
        """Return the next time at which a step must end, s."""
        schedules = [self.frames, self.deposits, self.histories]
        schedules += [self.depths] if self.depths else []
        return min(schedule.next_after(self.state.time) for schedule in schedules)

    def _advance(self, due: float) -> int:
        """Take one step that ends at or before a due time, s; return the solver's iterations."""
        state = self.state
        longest = self.scheme.stable_dt(state)
        self.watchdogs.before_step(longest)
        unsolved = NotConvergedError("a linear system")
        for _ in range(MOST_HALVINGS):
            steps = max(1, math.ceil((due - state.time) / longest * (1.0 - 1e-12)))
            dt = (due - state.time) / steps
            try:
                iterations = self.scheme.step(state, dt)
            except NotConvergedError as error:
                self.watchdogs.halved(error, dt)
                unsolved, longest = error, 0.5 * dt
                continue
            is_last = steps == 1 or (steps - 1) * dt < LEAST_REST * self.case.time.largest_step
            state.time = due if is_last else state.time + dt
            state.dt = dt
            state.step += 1
            LOG.debug("step %d: t = %g s, dt = %g s", state.step, state.time, dt)
            return iterations
        raise self.watchdogs.not_solved(unsolved, dt)

    def write(self, iterations: int) -> None:
        """Write the outputs that are due at the time of the state."""
        time = self.state.time
        with self.clock.of(WRITING):
            if self.histories.is_due(time):
                self._write_history(iterations)
            if self.deposits.is_due(time):
                self._write_deposit()
            if self.depths and self.depths.is_due(time):
                self._write_depth()
            if self.frames.is_due(time):
                self.results.write_frame(self.state)
                # near the end, from which `resume --until` goes on
                is_last_but_one = self.frames.next_after(time) >= self.case.time.end
                self._checkpoint_is_due |= is_last_but_one and time < self.case.time.end

    def _write_last(self) -> None:
        """Write deposit, depth and frame of a run that ends early, unless they are there."""
        time = self.state.time
        with self.clock.of(WRITING):
            if not self.deposits.is_due(time):
                self._write_deposit()
            if self.depths and not self.depths.is_due(time):
                self._write_depth()
            if not self.frames.is_due(time):
                self.results.write_frame(self.state)

    def _write_history(self, iterations: int) -> None:
        self.watchdogs.at_row()
        state, lattice, d0 = self.state, self.scheme.lattice, self.case.particles.spacing
        reached = None
        if self.case.is_terrain:
            self.results.write_ledger(ledger_row(self.case, state))
        else:
            found = flow(self.case, state.particles, lattice.number_density)
            if state.time >= 0.0:
                state.maxima.include(state.time, *found, spacing=d0)
            reached = state.maxima.reached(found.depth, d0)
        row = history_row(self.case, state, iterations, lattice, reached)
        self.results.write_history(row)
        self._is_at_rest = self.rule.is_met(state, row["kinetic_energy"])
        self._set_threads()

    def _write_depth(self) -> None:
        if self.recorder is not None:
            depth = self.recorder.depth(self.state.particles)
            self.results.write_depth(self.state.time, depth)

    def _write_deposit(self) -> None:
        p = self.state.particles
        if self.recorder is not None:
            rest_speed = self.case.output.rest_speed
            self.results.write_deposit(self.state.time, self.recorder.profile(p, rest_speed))
            return
        profile = deposit_profile(
            self.case,
            p.position,
            p.velocity,
            p.kind,
            p.concentration,
            p.sediment_fraction,
            p.number_density,
            self.scheme.lattice.number_density,
        )
        self.results.write_deposit(self.state.time, profile)

    def sample(self, before: float) -> None:
        """Write the samples of the probes that became due after a time, s.

        Steps are not shortened for probes, so that probes do not change the solution.
        """
        with self.clock.of(PROBES):
            for name, schedule in self.samples.items():
                if schedule.passed_due(before, self.state.time):
                    rows = self.probes[name].rows(self.state)
                    self.results.write_probe(name, self.state.time, rows)

    def _conclude(self, reason: str) -> dict[str, Any]:
        """Write the maxima and the summary, and return the summary."""
        state, self.progress.reason = self.state, reason
        lost = int(state.through_wall.sum())
        if lost:
            LOG.warning("%d particles went through a wall", lost)
        for k, count in enumerate(waiting(self.case, state)):
            if count:
                LOG.warning("release.%d: %d particles found no room to come in", k, count)
        with self.clock.of(WRITING):
            self.results.write_maxima(state)
            if self.recorder is not None:
                lying = self.recorder.depth(state.particles, self.case.output.rest_speed)
                self.results.write_layers(state, lying, self.recorder.depth(state.particles))
        figures = summary(self.case, state, reason, self.threads, self.progress)
        done = self.progress
        pace = Pace(done.particle_steps, done.steps, done.seconds, self.threads)
        remember(self.case, pace)
        self.results.write_summary(figures)
        LOG.info(
            "%s: t = %g s after %d steps, %.1f s",
            reason,
            state.time,
            state.step,
            figures["wall_seconds"],
        )
        phases = figures["wall_seconds_by_phase"].items()
        LOG.info("wall time: %s", ", ".join(f"{name} {spent:.1f} s" for name, spent in phases))
        return figures
