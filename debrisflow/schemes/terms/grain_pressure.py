"""The pressure between the grains of a bed, from their static balance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.case.materials import pore_density
from debrisflow.errors import NotConvergedError
from debrisflow.physics.grain_pressure import assemble_grain_pressure
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.system import SystemRoom
from debrisflow.schemes.terms.term import Step, Term

Floats = NDArray[np.float64]
TOLERANCE = 1.0e-3
WEIGHING = 0.5
"""Share of the concentration where strength begins from which on grains weigh on those below.

Too few for strength, they still do, and a flow carries them over others; less would take the first
row of water on a bed for part of it."""


class GrainPressure(Term):
    """Static balance of the buoyant grains, with walls as unknowns of their own.

    Parameters
    ----------
    case : Case
    gravity : (3,) float64 array, m/s2
    ramp_start : float
        Concentration where strength begins.
    room : SystemRoom
    """

    name = "grain pressure"

    def __init__(
        self, case: tables.Case, gravity: Floats, ramp_start: float, room: SystemRoom
    ) -> None:
        self._room = room
        self._gravity, self._least = gravity, WEIGHING * ramp_start
        self._submerged = case.sediment.density - pore_density(case.water, case.strength)
        self._solver = Solver(TOLERANCE)

    def refresh(self) -> None:
        """Forget the coarse levels of the solver."""
        self._solver.forget()

    def act(self, step: Step) -> None:
        """Write the pressure between the grains of fluid and walls."""
        scene, p = step.scene, step.particles
        system = self._room.fit(scene.near.neighbors.shape)
        assemble_grain_pressure(
            scene.level,
            self._least,
            p.on_free_surface,
            self._submerged,
            self._gravity,
            scene.near,
            scene.solid,
            system,
        )
        if self._solver.solve(system, p.grain_pressure[: p.unknown_count]) < 0:
            raise NotConvergedError("the balance of the grains")
        np.maximum(p.grain_pressure, 0.0, out=p.grain_pressure)
