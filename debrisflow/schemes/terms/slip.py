"""The slip between sediment and water particles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.neighbors.boundary import Boundary
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.slip import (
    MOST_OWED,
    Surroundings,
    advance,
    drag_phases,
    pair_up,
    pressure_gradient,
    pressure_gradient_before_surfaces,
    survey_surroundings,
)
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]


class Slip(Term):
    """Slip between sediment and water, see :mod:`debrisflow.physics.slip`.

    All that follows in the step acts on the velocity of the mixture.

    Parameters
    ----------
    drag : DragLaw
    gravity : (3,) float64 array, m/s2

    Attributes
    ----------
    velocity : (fluid particles, 3) float64 array, m/s
        ``s_i``; zero where there is only one phase.
    surroundings : Surroundings
    """

    name = "slip"

    def __init__(self, drag: DragLaw, gravity: Floats) -> None:
        self._drag, self._gravity = drag, gravity
        self.velocity = np.zeros((0, 3))

    def observe(self, scene: Scene) -> None:
        """Find surroundings, slip, and the velocity of the mixture."""
        p, n = scene.particles, scene.particles.fluid_count
        fraction = p.sediment_fraction[p.fluid]
        self._has_two_phases = bool(np.any(fraction == 1.0) and np.any(fraction == 0.0))
        self.surroundings = Surroundings(np.zeros(n), np.zeros(n), np.zeros(n))
        if self._has_two_phases:
            survey_surroundings(
                p.sediment_fraction, p.concentration, scene.near, *self.surroundings
            )
        is_pure = self._has_two_phases & ((fraction == 0.0) | (fraction == 1.0))
        self._part = np.where(is_pure, fraction - self.surroundings.share, 0.0)
        self._relative = p.relative_velocity[p.fluid]
        self.velocity = self._part[:, None] * self._relative
        scene.velocity = p.velocity[p.moving].copy()
        scene.velocity[p.fluid] -= self.velocity

    def act(self, step: Step) -> None:
        """Advance the relative velocity, add the drag, and go on with that of the mixture.

        The particles stay as they are until :meth:`move`.
        """
        p = step.particles
        if self._has_two_phases:
            self._advance(step)
        step.velocity[p.fluid] -= self.velocity

    def _advance(self, step: Step) -> None:
        scene, p = step.scene, step.particles
        gradient, force = np.empty((2, p.fluid_count, 3))
        fraction = p.sediment_fraction
        self._relative = p.relative_velocity[p.fluid].copy()
        near, solid = scene.near, scene.solid
        if isinstance(solid, Boundary):
            pressure_gradient_before_surfaces(
                p.pressure, p.density, self._gravity, near, solid, gradient
            )
        else:
            pressure_gradient(p.pressure, near, solid, gradient)
        advance(
            step.dt,
            gradient,
            scene.collision_acceleration,
            fraction,
            self.surroundings.concentration,
            self._part,
            p.owed_displacement,
            self._drag,
            scene.near,
            self._relative,
            force,
        )
        drag_phases(
            step.dt,
            force,
            p.density,
            fraction,
            self.surroundings.weight,
            scene.near,
            step.velocity,
        )
        self.velocity = self._part[:, None] * self._relative

    def move(self, step: Step) -> None:
        """Give the particles what the slip of a step owes them, by exchange of places."""
        if not self._has_two_phases:
            return
        p, near = step.particles, step.scene.near
        p.relative_velocity[p.fluid] = self._relative
        owed = p.owed_displacement[p.fluid]
        owed += step.dt * self.velocity
        length = np.linalg.norm(owed, axis=1)
        most = MOST_OWED * near.spacing
        owed[length > most] *= (most / length[length > most])[:, None]
        partner = np.empty(p.fluid_count, dtype=np.int64)
        pair_up(
            owed,
            p.sediment_fraction[p.fluid].copy(),
            self.surroundings.concentration,
            self._drag.packing_limit,
            near,
            partner,
        )
        one = np.flatnonzero(partner > np.arange(partner.size))
        p.exchange(one, partner[one])
