"""The forces of the explicit scheme: pressure, viscosity, gravity, collisions, bounces."""

from __future__ import annotations

import numpy as np

from debrisflow.physics.compressible import Numbers, advance_velocity
from debrisflow.schemes.terms.fluid import fluid_of
from debrisflow.schemes.terms.term import Step, Term


class Forces(Term):
    """Equation (13), all terms in one sum over the neighbors.

    Parameters
    ----------
    numbers : Numbers
    is_even : bool
        Whether all matter has the density of the numbers.
    has_one_viscosity : bool
        Whether all matter has the viscosity of the numbers.
    is_viscous : bool
        Whether viscosity acts here, and not implicitly in the exchange of momentum, of which the
        artificial viscosity then is a part.
    """

    name = "forces"

    def __init__(
        self, numbers: Numbers, is_even: bool, has_one_viscosity: bool, is_viscous: bool
    ) -> None:
        self._numbers = numbers
        if not is_viscous:
            self._numbers = numbers._replace(artificial_viscosity=0.0, viscosity=0.0)
        self._is_even, self._has_one_viscosity = is_even, has_one_viscosity or not is_viscous

    def act(self, step: Step) -> None:
        """Change the velocity of the fluid particles by all forces, collisions and bounces."""
        scene = step.scene
        fluid = fluid_of(scene, self._is_even, self._has_one_viscosity, step.pressure)
        step.reaction, step.push = np.empty((2, step.particles.fluid_count, 3))
        step.bounced = np.empty(step.particles.fluid_count, dtype=np.bool_)
        advance_velocity(
            step.dt,
            fluid,
            scene.near,
            scene.solid,
            self._numbers,
            step.velocity[step.particles.fluid],
            step.push,
            step.reaction,
            step.bounced,
        )
