"""The sampler of the flow on a grid."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probe import Probe
from debrisflow.case.probes.grid import GridProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.flow_at_points import flow_columns, flow_rows, space_of
from debrisflow.run.grid_file import GridWriter
from debrisflow.run.probe import Column, ProbeOutput, Sampler
from debrisflow.run.tables import Row


class GridFlow(Sampler):
    """Velocity, pressure and concentration on a plane or in a box, at the time of a sample.

    See :func:`debrisflow.run.flow_at_points.flow_at`; a row for each point, x the fastest.
    """

    has_many_points = True

    def __init__(self, probe: GridProbe, case: ResolvedCase, particles: Particles) -> None:
        self._space, spacing = space_of(case), case.particles.spacing
        step, counts = probe.distance(spacing), probe.counts(spacing)
        axes = [
            low + step * np.arange(count)
            for (_, (low, _)), count in zip(probe.extents(), counts, strict=True)
        ]
        self._points = np.zeros((int(np.prod(counts)), 3))
        for axis, values in enumerate(np.meshgrid(*axes, indexing="ij")):
            self._points[:, axis] = values.ravel(order="F")

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the flow at a point."""
        return flow_columns(dimension)

    @classmethod
    def writer(cls, folder: Path, probe: Probe, dimension: int) -> ProbeOutput:
        """See :meth:`Sampler.writer`."""
        assert isinstance(probe, GridProbe)
        return GridWriter(folder, probe, [column.name for column in cls.columns(dimension)])

    def rows(self, state: State) -> Iterable[Row]:
        """Return a row for each point."""
        return flow_rows(self._points, state, self._space)
