"""Collisions of particles that come too close to each other or to a wall."""

from __future__ import annotations

from debrisflow.physics.contact import collide
from debrisflow.schemes.terms.term import Step, Term


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
