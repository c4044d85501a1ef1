"""All watchdogs of a run: called around each step, at rows of the history, before a save."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError, NotConvergedError
from debrisflow.particles.state import State
from debrisflow.run.names import CASE
from debrisflow.run.watchdogs.density import DensityBounds
from debrisflow.run.watchdogs.energy import EnergyBudget
from debrisflow.run.watchdogs.escapes import Escapes
from debrisflow.run.watchdogs.finite import check_finite
from debrisflow.run.watchdogs.ledger_check import LedgerCheck
from debrisflow.run.watchdogs.solver import Halvings
from debrisflow.run.watchdogs.thinness import Thinness
from debrisflow.run.watchdogs.time_step import TimeStep
from debrisflow.schemes.choice import AnyScheme

FEWEST_STEPS = 10
"""Between two checks of all particles, each of which takes a few percent of a step."""


class Watchdogs:
    """Finds faults while a run goes on.

    A fault raises :class:`debrisflow.errors.DivergedError`; what only makes results doubtful is
    logged as a warning.  Nothing here changes the state, so that results are the same bits without
    them.  After each step they compare a few numbers; what looks at all particles waits for the
    next row of the history.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    state : State
        At the start, or where a run is resumed.
    checkpoint : Path
        Of the run; one that exists is that from which the run is resumed.
    """

    def __init__(
        self, case: ResolvedCase, scheme: AnyScheme, state: State, checkpoint: Path
    ) -> None:
        self._case, self._state, self._checkpoint = case, state, checkpoint
        self._saved = (state.time, state.step) if checkpoint.exists() else None
        self._checked = state.step - FEWEST_STEPS
        self._time_step = TimeStep(case, scheme)
        self._halvings = Halvings(case, scheme)
        self._escapes = Escapes(case, scheme, state)
        self._ledger = LedgerCheck(case, state)
        self._density = DensityBounds(case, scheme)
        self._energy = EnergyBudget(case, scheme)
        self._thinness = Thinness(case)

    def before_step(self, longest: float) -> None:
        """Check the longest time step that the scheme allows, s; it has found the neighbors."""
        self._time_step.check(self._state, longest)
        self._escapes.look_into_walls(self._state)

    def halved(self, error: NotConvergedError, dt: float) -> None:
        """Count a step of a length, s, whose linear system was not solved."""
        self._halvings.count(self._state, error, dt)

    def not_solved(self, error: NotConvergedError, dt: float) -> DivergedError:
        """Return the fault of a system that no time step down to a length, s, solves."""
        return self._halvings.fault(self._state, error, dt)

    def after_step(self) -> None:
        """Check what costs nothing: particles lost, and the ledger of particles."""
        self._escapes.check(self._state)
        self._ledger.check_total(self._state)

    def at_row(self) -> None:
        """Check all particles at a row of the history, before it is written.

        Rows less than ten steps after the last check are passed over, so that a short
        ``output.history_interval`` costs nothing; the last row of a run is not.
        """
        step, is_last = self._state.step, self._state.time >= self._case.time.end
        if step - self._checked < FEWEST_STEPS and not is_last:
            return
        self._checked = step
        check_finite(self._case, self._state)
        self._ledger.check(self._state)
        if step > 0:  # before, number densities are those of the start
            self._density.check(self._state)
        self._energy.check(self._state)
        self._thinness.check(self._state)

    def before_save(self) -> None:
        """Check what a checkpoint is to hold: a state that failed replaces none."""
        check_finite(self._case, self._state)
        self._ledger.check(self._state)
        self._saved = self._state.time, self._state.step

    def where_kept(self, failed: Path) -> str:
        """Return what to look at after a fault, and what to go on from, in lines."""
        lines = [f"particles at the failure: {failed} (for ParaView)"]
        folder = self._checkpoint.parent
        if self._saved is None:
            lines.append(f"no checkpoint was saved yet: debrisflow resume {folder} begins anew")
        else:
            time, step = self._saved
            lines.append(
                f"last good state: {self._checkpoint}, t = {time:g} s, step {step}; debrisflow "
                f"resume {folder} goes on from it, and repeats the failure unless {CASE} there is "
                "edited; then add --accept-changes"
            )
        return "\n".join(lines)
