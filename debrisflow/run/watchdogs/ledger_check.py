"""The ledger of particles: what was there and what came is there, or has left, or was lost."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import PHASES, State

LARGEST_MISFIT = 1e-6
"""Of the sediment, in particles for each particle: rounding of its sum."""


class LedgerCheck:
    """initial + entered + released = in the domain + left + lost, to the particle.

    What a release of a terrain brings counts as entered.  The initial number is that which closes
    the ledger when a run starts or resumes; on a terrain it is 0.

    Parameters
    ----------
    case : ResolvedCase
    state : State
    """

    def __init__(self, case: ResolvedCase, state: State) -> None:
        self._case = case
        if case.is_terrain:
            self._initial, self._initial_sediment = np.zeros(3, dtype=np.int64), 0.0
        else:
            self._initial, self._initial_sediment = _open_sums(state)
        self._total = int(self._initial.sum())

    def check_total(self, state: State) -> None:
        """Compare the numbers of all particles; this costs nothing.

        Raises
        ------
        DivergedError
        """
        entered, left, lost = _totals(state)
        inside = state.particles.fluid_count
        if self._total + entered != inside + left + lost:
            raise self._fault(state, "particles", self._total, entered, inside, left, lost)

    def check(self, state: State) -> None:
        """Compare numbers by phase, the sediment, and whether all particles differ by their id.

        Raises
        ------
        DivergedError
        """
        self.check_total(state)
        initial, sediment = _open_sums(state)
        for k in np.flatnonzero(initial != self._initial):
            entered, left, lost = (
                int(number[k]) for number in (state.entered, state.left, state.through_wall)
            )
            inside, first = int(initial[k]) + entered - left - lost, int(self._initial[k])
            raise self._fault(state, f"{PHASES[k]} particles", first, entered, inside, left, lost)
        counted = max(1, state.particles.fluid_count + int(state.entered.sum()))
        if abs(sediment - self._initial_sediment) > LARGEST_MISFIT * counted:
            raise DivergedError(
                f"{moment(state)}, the ledger of sediment does not close: "
                f"{sediment - self._initial_sediment:+.6g} particles of sediment of {counted}",
                *EXPLAINED,
            )
        self._check_ids(state)

    def _check_ids(self, state: State) -> None:
        ids = state.particles.id[state.particles.fluid]
        times = np.bincount(ids, minlength=1)
        if times.max() > 1:
            rows = np.flatnonzero(times[ids] > 1)
            raise DivergedError(
                f"{moment(state)}, {rows.size} particles are there more than once, one of them "
                f"{named_particle(self._case, state, int(rows[0]))}",
                *EXPLAINED,
            )

    def _fault(
        self, state: State, what: str, first: int, entered: int, inside: int, left: int, lost: int
    ) -> DivergedError:
        missing = first + entered - inside - left - lost
        word = f"{missing} are missing" if missing > 0 else f"{-missing} are too many"
        return DivergedError(
            f"{moment(state)}, the ledger of {what} does not close: {word}; {first} at the start "
            f"+ {entered} entered, but {inside} in the domain + {left} left + {lost} lost through "
            f"walls{self._newest(state)}",
            *EXPLAINED,
        )

    def _newest(self, state: State) -> str:
        """Return the particle with the greatest id, near which a wrong count arises mostly."""
        p = state.particles
        if p.fluid_count == 0:
            return ""
        row = int(np.argmax(p.id[p.fluid]))
        return f"; the last that came is {named_particle(self._case, state, row)}"


EXPLAINED = (
    "particles were added or removed without being counted: a fault of the program, or the state "
    "of a damaged or foreign checkpoint",
    "please report it with case.toml and run.log; start the run again with: debrisflow run",
)
"""Cause and remedy."""


def _totals(state: State) -> tuple[int, int, int]:
    # a list of three numbers adds up faster than an array; this is done in every step
    counters = (state.entered, state.left, state.through_wall)
    entered, left, lost = (sum(counter.tolist()) for counter in counters)
    return entered, left, lost


def _open_sums(state: State) -> tuple[np.ndarray, float]:
    """Return what must have been there at the start: particles by phase, and their sediment."""
    number, sediment = state.inside()
    number += state.left + state.through_wall - state.entered
    sediment += state.left_sediment + state.through_wall_sediment - state.entered_sediment
    return number, float(sediment.sum())
