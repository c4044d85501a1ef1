"""Gravity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.schemes.terms.term import Step, Term

Floats = NDArray[np.float64]


class Gravity(Term):
    """``u + dt g`` of the fluid particles.

    Parameters
    ----------
    gravity : (3,) float64 array, m/s2
    """

    name = "gravity"

    def __init__(self, gravity: Floats) -> None:
        self._gravity = gravity

    def act(self, step: Step) -> None:
        """Add the acceleration of gravity."""
        step.velocity[step.particles.fluid] += step.dt * self._gravity
