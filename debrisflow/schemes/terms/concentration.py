"""Concentration of sediment around the particles and at their level."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.physics.concentration import concentrations
from debrisflow.schemes.terms.term import Scene, Term

Floats = NDArray[np.float64]
PASSES = 2  # the second smooths the first


class Concentration(Term):
    """C of the particles, and that at their level, both smoothed once.

    Parameters
    ----------
    down : (3,) float64 array
        Unit vector of gravity, or 0.
    is_even : bool
        Whether all matter has the same concentration, which then is that of every particle.
    """

    name = "concentration"

    def __init__(self, down: Floats, is_even: bool) -> None:
        self._down, self._is_even = down, is_even

    def observe(self, scene: Scene) -> None:
        """Write the concentration of the particles, and that at their level."""
        p = scene.particles
        around = level = p.sediment_fraction[p.moving]
        if not self._is_even and np.any(around > 0.0):
            for _ in range(PASSES):
                smoothed, leveled = np.empty((2, p.moving.stop))
                concentrations(around, level, self._down, scene.near, smoothed, leveled)
                around, level = smoothed, leveled
        p.concentration[p.moving], scene.level = around, level
