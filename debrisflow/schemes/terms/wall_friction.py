"""Friction of rough walls by the law of the wall."""

from __future__ import annotations

from debrisflow.physics.wall_friction import slow_along_walls
from debrisflow.schemes.terms.term import Step, Term


class WallFriction(Term):
    """What rough walls take from the velocity along them, implicitly."""

    name = "wall friction"

    def act(self, step: Step) -> None:
        """Slow the fluid particles that touch a rough wall."""
        slowed = step.velocity.copy()
        slow_along_walls(
            step.dt,
            step.velocity,
            step.scene.near,
            step.scene.solid,
            slowed[step.particles.fluid],
        )
        step.velocity = slowed
