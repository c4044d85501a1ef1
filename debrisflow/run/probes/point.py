"""The sampler of the flow at a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.point import PointProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_statistics
from debrisflow.run.flow_at_points import flow_at, space_of
from debrisflow.run.probe import Column, Sampler, extreme_columns

Floats = NDArray[np.float64]


class PointFlow(Sampler):
    """Velocity, pressure and concentration at a point, of the steps since the row before.

    See :func:`debrisflow.run.flow_at_points.flow_at`.  Steps in which the point is dry count in
    ``wet`` alone.
    """

    sum_shape = row_statistics.sum_shape(6)
    averaged = ("velocity", "pressure", "concentration", "wet")

    def __init__(self, probe: PointProbe, case: ResolvedCase, particles: Particles) -> None:
        self._name, self._space = probe.name, space_of(case)
        self._place = np.array([[probe.x, probe.y, probe.z or 0.0]])

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return velocity, pressure, concentration, and the share of time that it was wet."""
        mean = "mean since the row before over the time that the point was wet, nan if it was dry"
        means = [
            *(Column(f"velocity_{axis}", "m/s", mean) for axis in "xyz"[:dimension]),
            Column("pressure", "Pa", mean),
        ]
        return (
            *means,
            Column("concentration", "", f"volumetric, of sediment; {mean}"),
            Column("wet", "", "share of the time since the row before in which it was"),
            *extreme_columns(means),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return tuple(f"velocity_{axis}" for axis in "xyz"[:dimension])

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the means since the sample before, and the least and greatest values."""
        flow, axes = self._flow(state), self._space.dimension
        row = row_statistics.since_row(state.sums[self._name], state, flow, seen=flow[0] > 0.0)
        wet, values = row.mean[0], np.full(5, np.nan)
        if wet > 0.0:
            values = row.mean[1:] / wet
        shown = [*range(1, 1 + axes), 4]  # of velocity and pressure
        extremes = np.column_stack([row.least, row.greatest])[shown]
        means = (*values[:axes], *values[3:], wet)
        return tuple(map(float, (*means, *extremes.ravel())))

    def add_step(self, state: State) -> None:
        """Add the last step."""
        flow = self._flow(state)
        row_statistics.add_step(state.sums[self._name], state, flow, seen=flow[0] > 0.0)

    def _flow(self, state: State) -> Floats:
        """Return 1 and velocity, pressure and concentration at the point; zeros where it is dry."""
        wet, flow = flow_at(self._place, state, self._space)
        return np.concatenate([wet.astype(float), flow[0]])
