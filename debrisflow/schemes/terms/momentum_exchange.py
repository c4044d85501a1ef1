"""Implicit exchange of momentum by viscosity and strength, after the pressure projection."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.errors import NotConvergedError
from debrisflow.physics.momentum_exchange import Matter, assemble_exchange
from debrisflow.physics.viscosity import eddy_viscosity
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.records import law_of
from debrisflow.schemes.system import SystemRoom, residual
from debrisflow.schemes.terms.term import Scene, Step, Term
from debrisflow.space.floor import floor_roughness, height_over_floor

Floats = NDArray[np.float64]
TOLERANCE = 1.0e-5
"""Tight, because what is left undone is given back to particles that had no part in it."""


class MomentumExchange(Term):
    """Viscosity, eddies and strength of phases that share one arrangement.

    Before the projection the same friction would leave the noise of the pressure in the bed and
    fluidize it.

    Parameters
    ----------
    case : Case
    room : SystemRoom
    """

    name = "exchange of momentum"

    def __init__(self, case: tables.Case, room: SystemRoom) -> None:
        self._case, self._room, self._law = case, room, law_of(case)
        self._solver = Solver(TOLERANCE)

    def refresh(self) -> None:
        """Forget the coarse levels of the solver."""
        self._solver.forget()

    def observe(self, scene: Scene) -> None:
        """Find the turbulent viscosity of the fluid, of Prandtl's mixing length over the floor."""
        p, case = scene.particles, self._case
        x, y = p.position[p.fluid, 0], p.position[p.fluid, 1]
        self._eddies = np.zeros(p.moving.stop)
        eddy_viscosity(
            p.density[p.fluid],
            np.maximum(height_over_floor(case, x, y, x), 0.5 * scene.near.spacing),
            floor_roughness(case, x),
            case.strength.mixing_length,
            scene.shear_rate,
            self._eddies[p.fluid],
        )

    def act(self, step: Step) -> None:
        """Change the velocity of the fluid particles; their momentum changes at walls alone."""
        scene, p = step.scene, step.particles
        n = p.fluid_count
        if n == 0:
            return
        system, right = self._room.fit(scene.near.neighbors.shape), np.zeros((p.unknown_count, 3))
        system.entries[n:], system.diagonal[n:] = 0, 1.0
        matter = Matter(
            velocity=step.velocity,
            density=p.density,
            viscosity=scene.viscosity,
            turbulent_viscosity=self._eddies,
            concentration=scene.level,
            shear_rate=scene.shear_rate,
            grain_pressure=p.grain_pressure,
        )
        assemble_exchange(step.dt, matter, self._law, scene.near, scene.solid, system, right)
        exchanged, rest = step.velocity.copy(), np.empty(p.unknown_count)
        for axis in range(self._case.dimension):
            system.right[:] = right[:, axis]
            # nearer to the solution than the projected velocity: half the iterations
            solution = np.zeros(p.unknown_count)
            solution[p.moving] = scene.velocity[:, axis]
            if self._solver.solve(system, solution) < 0:
                raise NotConvergedError("the exchange of momentum")
            residual(system, system.right, solution, rest)
            # what the solver left undone is given back evenly, so that none is lost
            solution[p.fluid] += rest[p.fluid].sum() / p.density[p.fluid].sum()
            exchanged[p.fluid, axis] = solution[p.fluid]
        step.velocity = exchanged
