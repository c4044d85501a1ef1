"""Velocity gradient and shear rate of the mixture."""

from __future__ import annotations

import numpy as np

from debrisflow.physics.operators import velocity_gradients
from debrisflow.schemes.terms.term import Scene, Term


class Shear(Term):
    """The velocity gradient, on which strength, eddies and colliding grains depend."""

    name = "shear"

    def observe(self, scene: Scene) -> None:
        """Find velocity gradient and shear rate of fluid and supply."""
        n = scene.particles.moving.stop
        scene.gradient, scene.shear_rate = np.empty((n, 9), np.float32), np.empty(n)
        velocity_gradients(
            scene.velocity, scene.near, scene.solid, scene.gradient, scene.shear_rate
        )
