"""Newtonian viscosity: of the particles, and as an explicit force in the semi-implicit scheme."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.particles.record import Kind
from debrisflow.physics.viscosity import viscous_acceleration
from debrisflow.schemes.terms.term import Scene, Step, Term


class NewtonianViscosity(Term):
    """The dynamic viscosity of the matter of each particle: mu_l of equation (2), mu_s of (3).

    Parameters
    ----------
    case : ResolvedCase
    """

    name = "viscosity"

    def __init__(self, case: ResolvedCase) -> None:
        self._of_kind = np.zeros(len(Kind))
        self._of_kind[Kind.LIQUID] = case.water.viscosity
        self._of_kind[Kind.SEDIMENT] = case.sediment.viscosity
        self._of_kind[Kind.MIXTURE] = case.mixture.viscosity
        self._of_kind[Kind.INFLOW] = case.water.viscosity

    def observe(self, scene: Scene) -> None:
        """Find the viscosity of fluid and supply; that of supply is water's."""
        p = scene.particles
        scene.viscosity = self._of_kind[p.kind[p.moving]]


class MixtureViscosity(Term):
    """The dynamic viscosity of water and of the mixture.

    Parameters
    ----------
    case : ResolvedCase
    """

    name = "viscosity"

    def __init__(self, case: ResolvedCase) -> None:
        self._water, self._mixture = case.water.viscosity, case.mixture.viscosity

    def observe(self, scene: Scene) -> None:
        """Find the viscosity of fluid and supply."""
        fraction = scene.particles.sediment_fraction[scene.particles.moving]
        scene.viscosity = np.where(fraction > 0.0, self._mixture, self._water)


class ExplicitViscosity(NewtonianViscosity):
    """Newtonian viscosity as a force at the beginning of the step."""

    def act(self, step: Step) -> None:
        """Add ``dt div(mu grad u) / rho``; the mixture shears, not its phases."""
        scene, p = step.scene, step.particles
        if not self._of_kind.any():
            return
        acceleration = np.empty((p.fluid_count, 3))
        viscous_acceleration(
            scene.velocity, p.density, scene.viscosity, scene.near, scene.solid, acceleration
        )
        step.velocity[p.fluid] += step.dt * acceleration
        step.react_to_shear(scene.velocity, scene.viscosity)
