"""Counts what goes through the sections of a case at every step, whatever their interval."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probes import SectionProbe
from debrisflow.particles.state import State, count_phases
from debrisflow.space.domain import domain


class Crossings:
    """Counts particles through the sections of a case, step by step, into the state.

    Parameters
    ----------
    case : ResolvedCase
    state : State
        At the start of the run or of its continuation.
    """

    def __init__(self, case: ResolvedCase, state: State) -> None:
        self._planes = [probe.x for probe in case.probe if isinstance(probe, SectionProbe)]
        self._period = domain(case).period[0]
        self._remember(state)

    def count(self, state: State) -> None:
        """Count who went through since the last call; before t = 0 nobody is counted.

        Particles are known by their number, as they change rows and, by slip, places.
        """
        if not self._planes:
            return
        if state.time > 0.0:
            self._count(state)
        self._remember(state)

    def _count(self, state: State) -> None:
        p = state.particles
        known = p.id[p.fluid] < self._x.size
        identity, kind = p.id[p.fluid][known], p.kind[p.fluid][known]
        fraction = p.sediment_fraction[p.fluid][known]
        before, now = self._x[identity], p.position[p.fluid, 0][known]
        if self._period > 0.0:
            now = (
                before
                + np.remainder(now - before + 0.5 * self._period, self._period)
                - 0.5 * self._period
            )
        for number, x in enumerate(self._planes):
            if self._period > 0.0:
                passed = np.floor((now - x) / self._period) - np.floor((before - x) / self._period)
            else:
                passed = (now >= x).astype(float) - (before >= x)
            count_phases(
                kind, fraction, state.crossed[number], state.crossed_sediment[number], passed
            )

    def _remember(self, state: State) -> None:
        p = state.particles
        rows = slice(0, p.inflow.stop)
        self._x = np.full(int(p.id[rows].max(initial=-1)) + 1, np.nan)
        self._x[p.id[rows]] = p.position[rows, 0]
