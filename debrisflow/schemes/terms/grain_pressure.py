"""The pressure between the grains of a bed, from their static balance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.materials import pore_density
from debrisflow.case.rheology import FrictionalStrength
from debrisflow.physics.grain_pressure import carried_depths, couple_grains
from debrisflow.schemes.pair_solver import couplings_of, solve_pairs
from debrisflow.schemes.terms.pore_pressure import borne_by_grains
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]
RESIDUAL = 1e-3  # of the weight of the grains, that their static balance leaves
WEIGHING = 0.5
"""Share of the concentration where strength begins from which on grains weigh on those below.

Too few for strength, they still do, and a flow carries them over others; less would take the first
row of water on a bed for part of it."""


class GrainPressure(Term):
    """The effective pressure between the grains: the static balance of their buoyant weight.

    Parameters
    ----------
    case : ResolvedCase
    rheology : FrictionalStrength
    gravity : (3,) float64 array, m/s2
    """

    name = "grain pressure"

    def __init__(self, case: ResolvedCase, rheology: FrictionalStrength, gravity: Floats) -> None:
        self._case, self._gravity = case, gravity
        self._g = float(np.linalg.norm(gravity))
        self._least = WEIGHING * rheology.concentration_ramp[0]
        self._submerged = case.sediment.density - pore_density(case.water, rheology)

    def act(self, step: Step) -> None:
        """Write the pressure between the grains of fluid and supply."""
        scene, p, rows = step.scene, step.particles, step.particles.moving
        is_bed, surface = scene.level >= self._least, p.on_free_surface[rows]
        is_surface = is_bed & surface
        system, right = couplings_of(scene.near, is_bed & ~surface), np.empty((rows.stop, 1))
        couple_grains(scene.near, scene.level, self._submerged * self._gravity, system, right)
        depth = np.empty(rows.stop)
        carried_depths(self._gravity, is_surface, scene.near, depth)
        pressure = np.where(system.is_free, p.grain_pressure[rows], 0.0)
        pressure[is_surface] = (depth * grain_weight(scene, self._case, self._g))[is_surface]
        goal = RESIDUAL**2 * float(np.sum(right[system.is_free] ** 2))
        solution = pressure[:, None].copy()
        solve_pairs("the balance of the grains", system, scene.near, right, goal, solution)
        np.maximum(solution[:, 0], 0.0, out=p.grain_pressure[rows])
        self._relieve(step)

    def _relieve(self, step: Step) -> None:
        """Leave to the grains no more than what their pore water does not bear.

        Of the pressure, or of the weight of half a row where that is more.
        """
        p, share = step.particles, borne_by_grains(step.particles, step.particles.moving)
        if share is not None:
            held = p.grain_pressure[: share.size]
            least = 0.5 * step.scene.near.spacing * self._g * p.density[: share.size]
            np.minimum(held, share * np.maximum(step.pressure[: share.size], least), out=held)


class SharedPressure(GrainPressure):
    """The share of the pressure that the grains carry, where all matter is alike.

    No less than the weight of half a row, which ties the uppermost one.
    """

    def act(self, step: Step) -> None:
        """Write the pressure between the grains of fluid and supply."""
        scene, p, rows = step.scene, step.particles, step.particles.moving
        weight = grain_weight(scene, self._case, self._g)
        share = weight / (p.density[rows] * (self._g or 1.0))
        least = 0.5 * scene.near.spacing * weight
        np.maximum(share * step.pressure, least, out=p.grain_pressure[rows])
        self._relieve(step)


def grain_weight(scene: Scene, case: ResolvedCase, g: float) -> Floats:
    """Return the weight that the grains carry, N/m3: that less buoyancy, where water is."""
    pores = pore_density(case.water, case.rheology)
    return np.asarray(scene.level * (case.sediment.density - pores) * g)
