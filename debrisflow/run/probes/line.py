"""The sampler of the flow along a line."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.line import LineProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.flow_at_points import flow_columns, flow_rows, space_of
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.tables import Row


class LineFlow(Sampler):
    """Velocity, pressure and concentration at points along a line, at the time of a sample.

    See :func:`debrisflow.run.flow_at_points.flow_at`; a row for each point.
    """

    has_many_points = True

    def __init__(self, probe: LineProbe, case: ResolvedCase, particles: Particles) -> None:
        self._space = space_of(case)
        count = probe.count(case.particles.spacing)
        ends = np.zeros((2, 3))
        ends[:, : case.dimension] = probe.start, probe.end
        share = np.linspace(0.0, 1.0, count)[:, None]
        self._points = (1.0 - share) * ends[0] + share * ends[1]
        self._along = share * np.linalg.norm(ends[1] - ends[0])

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the place of a point and the flow there."""
        return (
            Column("s", "m", "distance from the start of the line; a row for each point"),
            *(Column(axis, "m", "place of the point") for axis in "xyz"[:dimension]),
            *flow_columns(dimension),
        )

    def rows(self, state: State) -> Iterable[Row]:
        """Return a row for each point."""
        place = self._points[:, : self._space.dimension]
        flow = flow_rows(self._points, state, self._space)
        return np.column_stack([self._along, place, flow])
