"""The sampler of the force on a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.force import ForceProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.wall_pressure import OF_STEP, force, pressure_on, wall_faces

Floats = NDArray[np.float64]


class WallForce(Sampler):
    """Force and moment of the pressure on a whole wall: the sum over its faces.

    The impulse since t = 0 is the sum of force and time step over all steps, whatever the interval.
    """

    sum_shape = (3,)

    def __init__(self, probe: ForceProbe, case: ResolvedCase, particles: Particles) -> None:
        self._case, self._name = case, probe.name
        self._faces = wall_faces(case, particles, probe.wall)
        self._area = case.particles.spacing ** (case.dimension - 1)
        self._about = np.zeros(3)
        self._about[: len(probe.about)] = probe.about

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the components of force, moment and impulse."""
        axes, about, width = "xyz", "about the given point", ""
        if dimension == 2:
            axes, about, width = "xy", f"counterclockwise {about}", "per meter of width"
        turning = "z" if dimension == 2 else axes
        push = f"of the pressure on the wall; {OF_STEP}"
        impulse = "of that force since t = 0, summed over all steps"
        return (
            *(Column(f"force_{axis}", "N", push, width) for axis in axes),
            *(Column(f"moment_{axis}", "N m", about, width) for axis in turning),
            *(Column(f"impulse_{axis}", "N s", impulse, width) for axis in axes),
        )

    def sample(self, state: State) -> tuple[float, ...]:
        """Return force, moment and impulse, N, N m, N s, in two dimensions per meter of width."""
        push, moment = self._push(state)
        axes = self._case.dimension
        impulse = state.sums[self._name][:axes]
        turning = moment if axes == 3 else moment[2:]
        return (*map(float, push[:axes]), *map(float, turning), *map(float, impulse))

    def add_step(self, state: State) -> None:
        """Add the impulse of the last step; before t = 0 nothing is added."""
        if state.time > 0.0:
            state.sums[self._name] += state.dt * self._push(state)[0]

    def _push(self, state: State) -> tuple[Floats, Floats]:
        pressure = pressure_on(self._faces, self._case, state)
        return force(self._faces, pressure, self._area, self._about)
