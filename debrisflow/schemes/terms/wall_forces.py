"""Forces on the walls, from all that they did to the fluid in a step."""

from __future__ import annotations

from debrisflow.neighbors.boundary import Boundary
from debrisflow.physics.wall_forces import room_for_forces, wall_forces
from debrisflow.schemes.terms.term import Step, Term


class WallForces(Term):
    """Keeps force and moment on each wall and obstacle: pressure, viscosity, friction, contact.

    They balance the momentum of the fluid to rounding.
    """

    name = "wall forces"

    def act(self, step: Step) -> None:
        """Write the forces into the state."""
        p, scene = step.particles, step.scene
        if not isinstance(scene.solid, Boundary):
            raise TypeError("only walls that are surfaces keep their reaction")
        partial = room_for_forces(p.fluid_count, scene.solid)
        wall_forces(
            scene.near.spacing**scene.near.dimension,
            p.density[p.fluid],
            step.push,
            step.reaction,
            p.position[p.fluid],
            scene.solid,
            partial,
        )
        step.state.wall_force = partial.sum(axis=0)
