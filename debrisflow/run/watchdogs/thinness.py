"""A flow thinner than a spacing over most of its area: it is not resolved."""

from __future__ import annotations

import logging

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.released import volume
from debrisflow.particles.place import moment, place_of
from debrisflow.particles.state import State
from debrisflow.run.measures import particle_volume

LOG = logging.getLogger(__name__)
CELL = 2.0  # spacings; of a flow one spacing deep it holds four particles, in two dimensions two
MOST = 0.5
"""Share of the area."""
LEAST_MOVING = 0.1
"""Share of the fluid; when less moves, what is thin is a rest that does not count."""
LEAST_RELEASED = 0.1
"""Share of what a terrain's releases bring in all; before, a flood only begins."""
LOOKS, LASTING = 100, 5
"""Looks in a run, and how many in a row must find the flow thin."""


class Thinness:
    """Looks a hundred times in a run at the thickness of what flows; tells of it once.

    The thickness is the volume of the particles over a cell of the plan, two spacings wide, by
    its area.  Cells count in which anything moves faster than ``output.rest_speed``.

    Parameters
    ----------
    case : ResolvedCase
    """

    def __init__(self, case: ResolvedCase) -> None:
        self._case = case
        self._interval = case.time.end / LOOKS
        self._fewest = LEAST_RELEASED * sum(map(volume, case.release)) / particle_volume(case)
        self._next, self._thin, self._has_told = 0.0, 0, False

    def check(self, state: State) -> None:
        """Warn if the flow is thin over most of its area for the fifth time in a row."""
        if self._has_told or state.time < self._next or state.entered.sum() < self._fewest:
            return
        self._next = state.time + self._interval
        share, place = self._thin_share(state)
        self._thin = self._thin + 1 if share > MOST else 0
        if self._thin == LASTING:
            self._has_told = True
            LOG.warning(
                "%s, the flow is thinner than a spacing over %.0f %% of its area, so near %s; "
                "depth, speed and friction are poor there; likely cause: the spacing is too large "
                "for the depth; what to do: particles.spacing = %.3g m, half of it, or less",
                moment(state),
                100.0 * share,
                place,
                0.5 * self._case.particles.spacing,
            )

    def _thin_share(self, state: State) -> tuple[float, str]:
        """Return on what share of its area the flow is thin, and one such place."""
        p, d0 = state.particles, self._case.particles.spacing
        position = p.position[p.fluid]
        moves = np.linalg.norm(p.velocity[p.fluid], axis=1) > self._case.output.rest_speed
        if np.count_nonzero(moves) <= LEAST_MOVING * p.fluid_count:
            return 0.0, ""
        axes = self._case.dimension - 1
        column = np.floor(position[:, :axes] / (CELL * d0)).astype(np.int64)
        column -= column.min(axis=0)
        code = np.ravel_multi_index(tuple(column.T), tuple(column.max(axis=0) + 1))
        _, cell = np.unique(code, return_inverse=True)  # a wide terrain has more cells than fluid
        count, moving = np.bincount(cell), np.bincount(cell[moves], minlength=cell.max() + 1)
        flows, thin = moving > 0, (moving > 0) & (count < CELL**axes)
        if not thin.any():
            return 0.0, ""
        there = position[np.flatnonzero(moves & thin[cell])[0]]
        share = float(np.count_nonzero(thin) / np.count_nonzero(flows))
        return share, place_of(self._case, there)
