"""The balance of a run: what was there and came in, what is inside, left or was lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.run.events import LEDGER
from debrisflow.run.measures import mass


class Balance:
    """Adds up particles and their mass by way, of a case of any kind.

    Parameters
    ----------
    case : ResolvedCase
    state : State
        At the start of the run or of its continuation, of which the sums are taken to be right.
    """

    def __init__(self, case: ResolvedCase, state: State) -> None:
        self._case = case
        entered, inside, left, lost = self._sums(state)
        self._initial = inside + left + lost - entered

    def of(self, state: State) -> tuple[dict[str, int], dict[str, float]]:
        """Return particles, and their mass, by the names in ``LEDGER``.

        Mass is in kg, in two dimensions kg per meter of width.  What enters is released on a
        terrain, and comes through the inflow elsewhere.
        """
        entered, inside, left, lost = self._sums(state)
        difference = self._initial + entered - inside - left - lost
        nothing = np.zeros(2)
        ways = (nothing, entered) if self._case.is_terrain else (entered, nothing)
        rows = np.array([self._initial, *ways, inside, left, lost, difference])
        particles = (int(count) for count in np.rint(rows[:, 0]))
        return (
            dict(zip(LEDGER, particles, strict=True)),
            dict(zip(LEDGER, map(float, rows[:, 1]), strict=True)),
        )

    def _sums(self, state: State) -> list[NDArray[np.float64]]:
        """Return number and mass, (2,) arrays, of what entered, is inside, left and was lost."""
        ways = (
            (state.entered, state.entered_sediment),
            state.inside(),
            (state.left, state.left_sediment),
            (state.through_wall, state.through_wall_sediment),
        )
        return [
            np.array([number.sum(), mass(self._case, number.sum(), share.sum())])
            for number, share in ways
        ]
