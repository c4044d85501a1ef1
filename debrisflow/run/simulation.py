"""A run from its start to its end: begun in a folder, or gone on with from its checkpoint."""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Any

from debrisflow.case import ResolvedCase, load_case
from debrisflow.errors import CaseError, OutputError
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.run.bar import Bar
from debrisflow.run.checkpoint import Checkpoint, check_fits
from debrisflow.run.disk import expect_space
from debrisflow.run.events import AT_REST, EMPTY, END_OF_TIME, Listener
from debrisflow.run.folder import RunFolder, read_summary
from debrisflow.run.listeners import Listeners
from debrisflow.run.lock import locked
from debrisflow.run.loop import Run, origin_of
from debrisflow.run.names import CASE
from debrisflow.run.own_files import must_be_own
from debrisflow.run.probe import Sampler
from debrisflow.run.probes import samplers
from debrisflow.run.progress import START_UP, Progress
from debrisflow.run.sound_state import must_be_sound
from debrisflow.run.status import StatusFile
from debrisflow.run.stop_signals import StopSignals
from debrisflow.schemes.clock import Clock

LOG = logging.getLogger(__name__)


def simulate(
    case: ResolvedCase,
    folder: Path | str,
    threads: int | None = None,
    overwrite: bool = False,
    on_event: Listener | None = None,
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
    overwrite : bool
    on_event : callable, optional
        Called with each event, a dict, as :mod:`debrisflow.run.events` lists them, about once a
        second; instead of a bar.

    Returns
    -------
    dict
        The summary, also in ``summary.json``.

    Raises
    ------
    CaseError, OutputError, DivergedError
    """
    clock = Clock()
    folder = Path(folder)
    with StopSignals() as signals:
        with clock.of(START_UP):
            state = initial_state(case)
            probes = samplers(case, state)  # refuses a misplaced probe before a folder is touched
        must_be_own(folder)
        with Listeners([StatusFile(folder), on_event or Bar()]) as listeners:
            expect_space(case, folder, state.particles.fluid_count)
            with (
                locked(folder),
                RunFolder.create(folder, case, overwrite) as results,
                Progress(case, state, clock, listeners) as shown,
            ):
                return _begin(case, results, state, probes, shown, signals, threads)


def _begin(
    case: ResolvedCase,
    results: RunFolder,
    state: State,
    probes: dict[str, Sampler],
    shown: Progress,
    signals: StopSignals,
    threads: int | None,
) -> dict[str, Any]:
    """Compute a case from its start, in a folder without results."""
    with shown.clock.of(START_UP):
        run = Run(case, results, state, probes, shown, signals, threads)
        run.scheme.fill_number_density(state)
    run.start()
    return run.finish()


def resume(
    folder: Path,
    threads: int | None = None,
    until: float | None = None,
    accept_changes: bool = False,
    on_event: Listener | None = None,
) -> dict[str, Any] | None:
    """Continue the run of a folder from its last checkpoint; see :func:`simulate`.

    Without a checkpoint it begins anew.  A run that has come to its end is left as it is, and None
    is returned; with a lower or no ``time.stop_energy`` in the case of the folder it goes on.

    Parameters
    ----------
    folder : Path
    threads : int, optional
    until : float, optional, s
        A new end of the simulated time, which the case of the folder gets.
    accept_changes : bool
        Go on although the case, a file that it names or the program is not what it was: the
        results are then those of no single case.
    on_event : callable, optional
        As for :func:`simulate`.

    Raises
    ------
    CaseError, OutputError, DivergedError
    """
    if not (folder / CASE).exists():
        raise OutputError(
            f"{folder} holds no {CASE}: it is no run folder, or its run was stopped before it "
            f"began; start it with: debrisflow run CASE -o {folder}"
        )
    must_be_own(folder)
    clock = Clock()
    with (
        StopSignals() as signals,
        Listeners([StatusFile(folder), on_event or Bar()]) as listeners,
        locked(folder),
    ):
        case = load_case(folder / CASE, [] if until is None else [f"time.end={until!r}"])
        if _has_ended(case, read_summary(folder)):
            return None
        with RunFolder.open(folder, case) as results:
            with clock.of(START_UP):
                state = initial_state(case)
                kept = results.checkpoints.load()
                if kept is not None:
                    _check(kept, results, state, accept_changes)
                    state = kept.state
                probes = samplers(case, state)
            expect_space(case, folder, state.particles.fluid_count)
            if until is not None:
                results.write_case()
            with Progress(case, state, clock, listeners) as shown:
                if kept is None:
                    LOG.warning("there is no checkpoint: the run begins anew")
                    results.rewind(-math.inf)
                    return _begin(case, results, state, probes, shown, signals, threads)
                with clock.of(START_UP):
                    results.rewind(state.time)
                    LOG.info("resumed at t = %g s, step %d", state.time, state.step)
                    run = Run(case, results, state, probes, shown, signals, threads)
                return run.finish()


def _check(kept: Checkpoint, results: RunFolder, start: State, accept_changes: bool) -> None:
    """Check that a run can go on from a checkpoint to the bits of a run without interruption."""
    case, particles, now = results.case, kept.state.particles, origin_of(results.content)
    if case.has_surfaces and particles.count > particles.moving.stop:
        raise OutputError(
            "the checkpoint was written by a version of debrisflow whose walls were particles and "
            "cannot be continued; start the run again with: debrisflow run"
        )
    changed = kept.origin.changes(now)
    if changed and not accept_changes:
        raise OutputError(
            "\n  ".join(["since the last checkpoint there have been changes:", *changed])
            + "\nThe results would be those of no single case.  Undo the changes, start a run of "
            "its own with: debrisflow run, or go on all the same with: debrisflow resume "
            "--accept-changes"
        )
    for line in changed:
        LOG.warning("changed since the last checkpoint: %s", line)
    if kept.origin.processor != now.processor:
        LOG.warning(
            "the checkpoint is from another kind of processor (%s, this one is %s): the run goes "
            "on, but may differ from one without interruption by rounding",
            kept.origin.processor,
            now.processor,
        )
    check_fits(kept.state, start)
    must_be_sound(kept.state, case, start)
    if case.time.end < kept.state.time:
        raise CaseError(
            f"time.end = {case.time.end:g} s is before the last checkpoint, at "
            f"t = {kept.state.time:g} s"
        )


def _has_ended(case: ResolvedCase, before: dict[str, Any]) -> bool:
    """Return whether a run with a summary has come to the end that its case has now."""
    reason = before.get("end_reason")
    if reason == AT_REST:
        return (
            case.time.stop_energy is not None
            and before.get("energy_share", 0.0) < case.time.stop_energy
        )
    return reason == EMPTY or (reason == END_OF_TIME and before.get("time", 0.0) >= case.time.end)
