"""The forces of the explicit scheme: pressure, viscosity, gravity, and collisions."""

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
    is_viscous : bool
        Whether viscosity acts here, and not implicitly in the exchange of momentum, of which the
        artificial viscosity then is a part.
    """

    name = "forces"

    def __init__(self, numbers: Numbers, is_even: bool, is_viscous: bool) -> None:
        self._numbers = numbers if is_viscous else numbers._replace(artificial_viscosity=0.0)
        self._is_even, self._is_viscous = is_even, is_viscous

    def act(self, step: Step) -> None:
        """Change the velocity of the fluid particles by all forces and collisions."""
        scene, fluid = step.scene, fluid_of(step.scene, self._is_even, step.pressure)
        if not self._is_viscous:
            fluid = fluid._replace(viscosity=np.zeros(step.particles.moving.stop))
        advance_velocity(
            step.dt,
            fluid,
            scene.near,
            scene.solid,
            self._numbers,
            step.velocity[step.particles.fluid],
        )
