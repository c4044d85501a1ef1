"""Turbulence: the eddy viscosity of Prandtl's mixing length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.physics.viscosity import eddy_viscosity
from debrisflow.schemes.terms.term import Scene, Term
from debrisflow.space.floor import floor_roughness, height_over_floor

Floats = NDArray[np.float64]


class Eddies(Term):
    """The viscosity of eddies, whose mixing length a rough floor limits.

    Parameters
    ----------
    case : ResolvedCase
    has_ground : bool
        Whether a ground lies over the floor, whose distance is not known: no wall limits l there.
    """

    name = "eddies"

    def __init__(self, case: ResolvedCase, has_ground: bool = False) -> None:
        self._case, self._length = case, case.rheology.mixing_length
        self._has_ground = has_ground

    def observe(self, scene: Scene) -> None:
        """Find the turbulent viscosity of the fluid and add it; supply has none."""
        p = scene.particles
        height, roughness = self._over_floor(scene)
        scene.eddies = np.zeros(p.moving.stop)
        eddy_viscosity(
            p.density[p.fluid],
            height,
            roughness,
            self._length,
            scene.shear_rate,
            scene.eddies[p.fluid],
        )
        scene.viscosity += scene.eddies

    def _over_floor(self, scene: Scene) -> tuple[Floats, Floats]:
        """Return height over and roughness of the floor under the particles, m."""
        p, case = scene.particles, self._case
        if self._has_ground:
            everywhere = np.full(p.fluid_count, np.inf)
            return everywhere, everywhere
        x, level = p.position[p.fluid, 0], p.position[p.fluid, case.dimension - 1]
        height = np.maximum(height_over_floor(case, x, level, x), 0.5 * scene.near.spacing)
        return height, floor_roughness(case, x)
