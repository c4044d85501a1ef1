"""Collisions of particles that come too close to each other or to a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.physics.contact import bounce_off_walls, collide, hold_off_walls
from debrisflow.schemes.terms.pore_pressure import borne_by_grains
from debrisflow.schemes.terms.term import Step, Term

CONTACT = 0.3
"""Spacings from a wall nearer than which a particle touches it."""


class Contact(Term):
    """Collisions after all explicit forces.

    Parameters
    ----------
    distance : float, m
        Within which particles collide.
    restitution : float
    """

    name = "contact"

    def __init__(self, distance: float, restitution: float) -> None:
        self._distance, self._restitution = distance, restitution

    def act(self, step: Step) -> None:
        """Change the velocities of the fluid particles by their collisions."""
        scene, collided = step.scene, step.velocity.copy()
        collide(
            step.velocity,
            step.particles.density,
            self._distance,
            self._restitution,
            scene.near,
            scene.solid,
            collided[step.particles.fluid],
        )
        step.velocity = collided


class WallBounce(Term):
    """What has come too near to a wall as a surface and approaches it bounces off.

    Parameters
    ----------
    reach : float, m
        Nearer than which a particle bounces.
    restitution : float
    """

    name = "contact"

    def __init__(self, reach: float, restitution: float) -> None:
        self._reach, self._restitution = reach, restitution

    def act(self, step: Step) -> None:
        """Change the velocities of the fluid particles by their bounces."""
        p = step.particles
        before = step.velocity[p.fluid].copy()
        solid, velocity = step.scene.solid, step.velocity[p.fluid]
        bounce_off_walls(self._reach, self._restitution, solid, velocity)
        step.bounced = np.any(velocity != before, axis=1)
        step.react((velocity - before) / step.dt)


class WallContact(Term):
    """What touches a wall as a surface does not go into it, whatever the terms before have done.

    Parameters
    ----------
    reach : float, m
        Nearer than which a particle touches a wall.
    sliding : (walls,) float64 array
        Coefficient of friction of each wall.
    """

    name = "wall contact"

    def __init__(self, reach: float, sliding: NDArray[np.float64]) -> None:
        self._reach, self._sliding = reach, sliding

    def act(self, step: Step) -> None:
        """Take what leads into walls from the velocities of the fluid particles."""
        p = step.particles
        before = step.velocity[p.fluid].copy()
        hold_off_walls(
            self._reach, self._sliding, borne_by_grains(p), step.scene.solid, step.velocity[p.fluid]
        )
        step.reaction += (step.velocity[p.fluid] - before) / step.dt
