"""Density and forces of the explicit scheme as the study writes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.neighbors.wall_access import Solid
from debrisflow.physics.compressible import SURFACE, Numbers
from debrisflow.physics.kinetic_theory import Grains, bulk_viscosity
from debrisflow.physics.study_form import accelerate, sum_densities
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]


class StudyForces(Term):
    """Equations (12) to (15), and the pressure, the bulk and the shear part of (19).

    Parameters
    ----------
    numbers : Numbers
    grains : Grains or None
        None without the stress of colliding grains.
    """

    name = "forces"

    def __init__(self, numbers: Numbers, grains: Grains | None) -> None:
        self._numbers, self._grains = numbers, grains

    def sum_densities(self, scene: Scene) -> None:
        """Write number density and pressure of all particles that have neighbors."""
        p, rows, numbers = scene.particles, scene.near.fluid_count.size, self._numbers
        sum_densities(
            scene.near,
            numbers.density,
            numbers.sound_speed,
            p.number_density[:rows],
            p.pressure[:rows],
        )
        p.on_free_surface[:rows] = p.number_density[:rows] < SURFACE * scene.near.number_density

    def act(self, step: Step) -> None:
        """Find the pressure and change the velocity of the fluid particles."""
        scene, p = step.scene, step.particles
        if not isinstance(scene.solid, Solid):
            raise TypeError("the study's form has walls of particles")
        self.sum_densities(scene)
        rows = step.pressure.size
        step.pressure = p.pressure[:rows].copy()
        step.compression = np.maximum(p.number_density / scene.near.number_density - 1.0, 0.0)
        step.compression = step.compression[p.moving]
        total = step.pressure.copy()
        total[p.moving] += self._of_grains(scene)
        accelerate(
            step.dt,
            p.velocity,
            total,
            scene.viscosity,
            p.density[p.moving],
            self._numbers.gravity,
            scene.near,
            scene.solid.slip,
            step.velocity[p.fluid],
        )

    def _of_grains(self, scene: Scene) -> Floats:
        """Return the pressure of colliding grains less what resists their expansion, Pa."""
        p, rows = scene.particles, scene.particles.moving
        if self._grains is None:
            return np.zeros(rows.stop)
        expands = scene.gradient[:, 0] + scene.gradient[:, 4] + scene.gradient[:, 8]
        bulk = bulk_viscosity(p.concentration[rows], p.granular_temperature[rows], self._grains)
        found: Floats = p.collision_pressure[rows] - bulk * expands
        return found
