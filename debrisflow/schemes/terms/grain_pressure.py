"""The pressure between the grains of a bed, from their static balance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.materials import pore_density
from debrisflow.case.strength import FrictionalStrength
from debrisflow.errors import NotConvergedError
from debrisflow.physics.grain_pressure import assemble_grain_pressure, couple_grains
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.pair_solver import couplings_of, solve_pairs
from debrisflow.schemes.system import SystemRoom
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]
TOLERANCE = 1.0e-3
GRAIN_RESIDUAL = 1e-3  # of the weight of the grains, that their static balance leaves
WEIGHING = 0.5
"""Share of the concentration where strength begins from which on grains weigh on those below.

Too few for strength, they still do, and a flow carries them over others; less would take the first
row of water on a bed for part of it."""


class GrainPressure(Term):
    """Static balance of the buoyant grains, with walls as unknowns of their own.

    Parameters
    ----------
    case : ResolvedCase
    gravity : (3,) float64 array, m/s2
    strength : FrictionalStrength
    room : SystemRoom
    """

    name = "grain pressure"

    def __init__(
        self,
        case: ResolvedCase,
        strength: FrictionalStrength,
        gravity: Floats,
        room: SystemRoom,
    ) -> None:
        self._room, self._gravity = room, gravity
        self._least = WEIGHING * strength.concentration_ramp[0]
        self._submerged = case.sediment.density - pore_density(case.water, strength)
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


class MixtureGrainPressure(Term):
    """The effective pressure between the grains of a mixture.

    Where all matter is alike it is the share of the pressure that the grains carry; under water
    that of the static balance of the buoyant grains, as water on a bed adds nothing.  No less than
    the weight of half a row, which ties the uppermost one.

    Parameters
    ----------
    case : ResolvedCase
    strength : FrictionalStrength
    gravity : (3,) float64 array, m/s2
    is_even : bool
        Whether all matter has the same concentration.
    """

    name = "grain pressure"

    def __init__(
        self,
        case: ResolvedCase,
        strength: FrictionalStrength,
        gravity: Floats,
        is_even: bool,
    ) -> None:
        self._case, self._is_even = case, is_even
        self._least = WEIGHING * strength.concentration_ramp[0]
        self._gravity = gravity

    def act(self, step: Step) -> None:
        """Write the pressure between the grains of the mixture."""
        scene, p, rows = step.scene, step.particles, step.particles.moving
        g = float(np.linalg.norm(self._gravity))
        weight, half = grain_weight(scene, self._case, g), 0.5 * scene.near.spacing
        if self._is_even:
            share = weight / (p.density[rows] * (g or 1.0))
            np.maximum(share * step.pressure, half * weight, out=p.grain_pressure[rows])
            return
        is_bed = scene.level >= self._least
        surface = p.on_free_surface[rows]
        system = couplings_of(scene.near, is_bed & ~surface)
        right = np.empty((rows.stop, 1))
        excess = (self._case.sediment.density - self._case.water.density) * self._gravity
        couple_grains(scene.near, scene.level, excess, system, right)
        pressure = np.where(system.is_free, p.grain_pressure[rows], 0.0)
        pressure[is_bed & surface] = half * weight[is_bed & surface]
        goal = GRAIN_RESIDUAL**2 * float(np.sum(right[system.is_free] ** 2))
        solution = pressure[:, None].copy()
        solve_pairs("the balance of the grains", system, scene.near, right, goal, solution)
        np.maximum(solution[:, 0], 0.0, out=p.grain_pressure[rows])


def grain_weight(scene: Scene, case: ResolvedCase, g: float) -> Floats:
    """Return the weight that the grains carry, N/m3: that less buoyancy, where water is."""
    pores = pore_density(case.water, case.strength)
    return np.asarray(scene.level * (case.sediment.density - pores) * g)
