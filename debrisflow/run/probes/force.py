"""The sampler of the force on a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.force import ForceProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_statistics
from debrisflow.run.probe import Column, Sampler, extreme_columns
from debrisflow.run.wall_pressure import force, pressure_on, wall_faces
from debrisflow.space.domain import wall_names

Floats = NDArray[np.float64]


class WallForce(Sampler):
    """Force and moment on a whole wall: mean, least, greatest of the steps since the row before.

    What the wall does to the fluid; where walls are particles, the pressure on its faces.
    """

    sum_shape = row_statistics.sum_shape(6)
    averaged = ("force", "moment")

    def __init__(self, probe: ForceProbe, case: ResolvedCase, particles: Particles) -> None:
        self._case, self._name = case, probe.name
        self._number = wall_names(case).index(probe.wall)
        self._about = np.zeros(3)
        self._about[: len(probe.about)] = probe.about
        if not case.has_surfaces:
            self._faces = wall_faces(case, particles, probe.wall)

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return not case.has_surfaces

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the components of force, moment and impulse."""
        if dimension == 2:
            axes, turning, at_start = "xy", "z", "that of the step before"
            about, width = "counterclockwise about the given point", "per meter of width"
        else:
            axes = turning = "xyz"
            at_start, about, width = "that at rest", "about the given point", ""
        push = "of all that the fluid does to the wall: pressure, shear, friction, contact"
        push += "; in the form study of the pressure"
        push += f"; mean since the row before, in the first row {at_start}"
        impulse = "of that force since t = 0, summed over all steps"
        pushes = [Column(f"force_{axis}", "N", push, width) for axis in axes]
        pushes += [Column(f"moment_{axis}", "N m", about, width) for axis in turning]
        impulses = [Column(f"impulse_{axis}", "N s", impulse, width) for axis in axes]
        return (*pushes, *impulses, *extreme_columns(pushes))

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return tuple(f"force_{axis}" for axis in "xyz"[:dimension])

    def sample(self, state: State) -> tuple[float, ...]:
        """Return force, moment and impulse, N, N m, N s, in two dimensions per meter of width."""
        kept, axes = state.sums[self._name], self._case.dimension
        shown = [0, 1, 2, 3, 4, 5] if axes == 3 else [0, 1, 5]
        row = row_statistics.since_row(kept, state, self._push(state))
        extremes = np.column_stack([row.least, row.greatest])[shown]
        return (
            *map(float, row.mean[shown]),
            *map(float, row_statistics.integrals(kept)[:axes]),
            *map(float, extremes.ravel()),
        )

    def add_step(self, state: State) -> None:
        """Add the impulse of the last step; before t = 0 nothing is added."""
        row_statistics.add_step(state.sums[self._name], state, self._push(state))

    def _push(self, state: State) -> Floats:
        """Return the three components of the force, N, and of its moment, N m."""
        if len(state.wall_force) == 0 and self._case.has_surfaces:
            return np.zeros(6)  # before any step in two dimensions
        if self._case.has_surfaces:
            push, moment = np.split(state.wall_force[self._number], 2)
            return np.concatenate([push, moment - np.cross(self._about, push)])
        area = self._case.particles.spacing ** (self._case.dimension - 1)
        pressure = pressure_on(self._faces, self._case, state)
        return np.concatenate(force(self._faces, pressure, area, self._about))
