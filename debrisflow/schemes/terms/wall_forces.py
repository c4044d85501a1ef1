"""Forces on the walls, from all that they did to the fluid in a step."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.boundary import Boundary
from debrisflow.physics.wall_forces import room_for_forces, wall_forces
from debrisflow.schemes.terms.term import Step, Term


class WallForces(Term):
    """Keeps force and moment on each wall and obstacle: pressure, viscosity, friction, contact.

    They balance the momentum of the fluid to rounding.  Also the force on each patch of the state.
    """

    name = "wall forces"

    def act(self, step: Step) -> None:
        """Write the forces into the state."""
        p, scene = step.particles, step.scene
        if not isinstance(scene.solid, Boundary):
            raise TypeError("only walls that are surfaces keep their reaction")
        state, walls = step.state, scene.solid.slip.size
        partial = room_for_forces(p.fluid_count, scene.solid, state.patches)
        wall_forces(
            scene.near.spacing**scene.near.dimension,
            p.density[p.fluid],
            step.push,
            step.reaction,
            p.position[p.fluid],
            scene.solid,
            state.patches,
            partial,
        )
        forces = partial.sum(axis=0)
        state.wall_force, state.patch_force = forces[:walls], forces[walls:, :3]


def are_asked(case: ResolvedCase) -> bool:
    """Return whether a probe of the case reads what fluid does to walls."""
    return any(probe.reads_reactions for probe in case.probe)
