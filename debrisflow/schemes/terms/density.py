"""Density and pressure of a weakly compressible fluid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.physics.compressible import SURFACE, Numbers, advance_density
from debrisflow.schemes.terms.fluid import fluid_of
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]


class Density(Term):
    """Continuity and the equation of state.

    Parameters
    ----------
    numbers : Numbers
    is_even : bool
        Whether all matter has the density of the numbers.
    """

    name = "density"

    def __init__(self, numbers: Numbers, is_even: bool) -> None:
        self._numbers, self._is_even = numbers, is_even

    def act(self, step: Step) -> None:
        """Advance the compression and find the pressure."""
        step.compression = self.advance(step.scene, step.dt, step.pressure)

    def advance(self, scene: Scene, dt: float, pressure: Floats) -> Floats:
        """Write number density and pressure, and return the compression after a step."""
        p, rows = scene.particles, scene.particles.moving
        compression = np.empty(rows.stop)
        advance_density(
            dt,
            fluid_of(scene, self._is_even, has_one_viscosity=True),  # density reads none
            scene.near,
            scene.solid,
            self._numbers,
            p.number_density[rows],
            compression,
            pressure,
        )
        p.on_free_surface[rows] = p.number_density[rows] < SURFACE * scene.near.number_density
        return compression
