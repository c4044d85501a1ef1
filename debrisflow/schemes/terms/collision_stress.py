"""Stress of colliding grains: granular temperature, pressure, viscosity."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import VISCOUS_LIMIT
from debrisflow.physics.collision_stress import (
    collide_grains,
    collision_acceleration,
    largest_pressure_step,
)
from debrisflow.physics.granular_temperature import (
    algebraic_temperatures,
    fluctuation_temperatures,
    neighborhood_temperatures,
)
from debrisflow.physics.operators import number_density
from debrisflow.schemes.records import grains_of
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]


class CollisionStress(Term):
    """Pressure and viscosity of colliding grains; by the chosen law of their temperature.

    Parameters
    ----------
    case : ResolvedCase
    density, sound_speed : float, kg/m3, m/s
        Of a weakly compressible fluid, by which the study's temperature is capped; an infinite
        speed caps nothing.
    """

    name = "collision stress"

    def __init__(self, case: ResolvedCase, density: float, sound_speed: float) -> None:
        self._law = case.collision_stress.granular_temperature
        self._given = case.collision_stress.concentration
        self._grains = grains_of(case)
        self._density, self._sound_speed = density, sound_speed
        self._spacing = case.particles.spacing

    def _concentration(self, scene: Scene) -> Floats:
        p = scene.particles
        c = p.concentration[p.moving]
        return c if self._given is None else np.full(c.size, self._given)

    def _find_temperature(self, scene: Scene, c: Floats) -> None:
        p, rows = scene.particles, scene.particles.moving
        fraction, temperature = p.sediment_fraction[rows], p.granular_temperature[rows]
        if self._law == "algebraic":
            algebraic_temperatures(scene.shear_rate, fraction, self._grains, temperature)
        elif self._law == "neighborhood":
            clipped = np.minimum(c, self._grains.largest_concentration)
            neighborhood_temperatures(
                scene.velocity,
                fraction,
                clipped,
                self._density,
                self._sound_speed,
                self._grains,
                scene.near,
                temperature,
            )
        else:
            fluctuation_temperatures(scene.velocity, fraction, scene.near, temperature)


class MixtureCollisions(CollisionStress):
    """Colliding grains of a mixture: their pressure joins that of the fluid, as their viscosity.

    Parameters
    ----------
    case, density, sound_speed
        See :class:`CollisionStress`.
    is_implicit : bool
        Whether viscosity acts implicitly, and so limits no time step.
    """

    def __init__(
        self, case: ResolvedCase, density: float, sound_speed: float, is_implicit: bool
    ) -> None:
        super().__init__(case, density, sound_speed)
        self._is_implicit = is_implicit

    def observe(self, scene: Scene) -> None:
        """Write temperature and pressure of the grains, and add their viscosity."""
        p, rows, c = scene.particles, scene.particles.moving, self._concentration(scene)
        self._find_temperature(scene, c)
        collide_grains(
            c,
            self._grains,
            scene.near.number_density,
            p.number_density[rows],
            p.granular_temperature[rows],
            p.collision_pressure[rows],
            scene.viscosity,
        )

    def limit(self, scene: Scene) -> float:
        """Return the time step that explicit viscosity and the push of the grains allow, s."""
        p, rows = scene.particles, scene.particles.moving
        viscous = (
            inf
            if self._is_implicit
            else viscous_step(scene.viscosity, p.density[rows], self._spacing)
        )
        return min(
            viscous,
            largest_pressure_step(
                p.concentration[rows],
                p.density[rows],
                p.collision_pressure[rows],
                self._spacing,
                self._grains,
            ),
        )


class PhaseCollisions(CollisionStress):
    """Colliding grains among particles of sediment and water: an explicit force between grains.

    Attributes
    ----------
    pressure, viscosity : (moving particles,) float64 array, Pa, Pa s
        Of the grains; 0 where there are none.
    """

    def observe(self, scene: Scene) -> None:
        """Write the temperature of the grains, and find their stress and its acceleration.

        Slip, which is no agitation, does not count.
        """
        p, rows, c = scene.particles, scene.particles.moving, self._concentration(scene)
        self._find_temperature(scene, c)
        fraction, n = p.sediment_fraction[rows], np.empty(rows.stop)
        number_density(scene.near, scene.solid, n)
        self.pressure, self.viscosity = np.empty(rows.stop), np.zeros(rows.stop)
        collide_grains(
            c,
            self._grains,
            scene.near.number_density,
            n,
            p.granular_temperature[rows],
            self.pressure,
            self.viscosity,
        )
        scene.collision_acceleration = np.empty((p.fluid_count, 3))
        collision_acceleration(
            scene.velocity,
            p.density,
            fraction,
            self.pressure,
            self.viscosity,
            scene.near,
            scene.solid,
            scene.collision_acceleration,
        )

    def limit(self, scene: Scene) -> float:
        """Return the time step that viscosity and pressure of the grains allow, s."""
        p, fluid = scene.particles, scene.particles.fluid
        density, c = p.density[fluid], self._concentration(scene)[fluid]
        return min(
            viscous_step(self.viscosity[fluid], density, self._spacing),
            largest_pressure_step(c, density, self.pressure[fluid], self._spacing, self._grains),
        )

    def act(self, step: Step) -> None:
        """Add the acceleration by collisions."""
        p, scene = step.particles, step.scene
        step.velocity[p.fluid] += step.dt * scene.collision_acceleration
        of_grains = np.where(p.sediment_fraction[p.moving] > 0.0, self.viscosity, 0.0)
        step.react_to_shear(scene.velocity, of_grains)


def viscous_step(viscosity: Floats, density: Floats, spacing: float) -> float:
    """Return ``0.2 d0^2 rho / mu``, the time step that an explicit viscosity allows, s."""
    diffusivity = float(np.max(viscosity / density, initial=0.0))
    return VISCOUS_LIMIT * spacing**2 / diffusivity if diffusivity > 0.0 else inf
