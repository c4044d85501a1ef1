"""The slip of a mix of sediment and water particles, as a term of the semi-implicit scheme."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow.neighbors.stencil import Stencil
from debrisflow.particles.record import Particles
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.slip import (
    MOST_OWED,
    Floats,
    Surroundings,
    advance,
    drag_phases,
    pair_up,
    pressure_gradient,
    survey_surroundings,
)


class Materials(NamedTuple):
    """Densities of rock and water, kg/m3."""

    rock: float
    water: float


class Slip:
    """The slip of a mix of sediment and water particles.

    Parameters
    ----------
    drag : DragLaw
    materials : Materials

    Attributes
    ----------
    velocity : (fluid particles, 3) float64 array, m/s
        ``s_i``; zero where there is only one phase.
    """

    def __init__(self, drag: DragLaw, materials: Materials) -> None:
        self._drag = drag
        self._materials = materials
        self.velocity = np.zeros((0, 3))

    def observe(self, particles: Particles, stencil: Stencil) -> None:
        """Bring surroundings and slip up to the places of the particles."""
        n = particles.fluid_count
        fraction = particles.sediment_fraction[particles.fluid]
        self._has_two_phases = bool(np.any(fraction == 1.0) and np.any(fraction == 0.0))
        self._around = Surroundings(np.zeros(n), np.zeros(n), np.zeros(n))
        self._stencil = stencil
        if self._has_two_phases:
            survey_surroundings(
                particles.sediment_fraction, particles.concentration, stencil, *self._around
            )
        is_pure = self._has_two_phases & ((fraction == 0.0) | (fraction == 1.0))
        self._part = np.where(is_pure, fraction - self._around.share, 0.0)
        self._relative = particles.relative_velocity[particles.fluid]
        self.velocity = self._part[:, None] * self._relative

    def act(self, particles: Particles, thrown: Floats, dt: float, velocity: Floats) -> None:
        """Advance relative velocity and slip by a step, and add the drag to the velocities.

        The particles stay as they are until :meth:`move`.

        Parameters
        ----------
        thrown : (fluid particles or 0, 3) float64 array, m/s2
            Acceleration of the grains by collisions.
        velocity : (n, 3) float64 array, m/s
            Velocities of the phases; changed.
        """
        if not self._has_two_phases:
            return
        gradient, force = np.empty((2, particles.fluid_count, 3))
        fraction = particles.sediment_fraction
        self._relative = particles.relative_velocity[particles.fluid].copy()
        pressure_gradient(particles.pressure, self._stencil, gradient)
        advance(
            dt,
            gradient,
            thrown,
            fraction,
            self._around.concentration,
            self._part,
            particles.owed_displacement,
            self._drag,
            *self._materials,
            self._stencil,
            self._relative,
            force,
        )
        drag_phases(
            dt, force, particles.density, fraction, self._around.weight, self._stencil, velocity
        )
        self.velocity = self._part[:, None] * self._relative

    def move(self, particles: Particles, dt: float) -> None:
        """Give the particles what the slip of a step owes them, by exchange of places."""
        if not self._has_two_phases:
            return
        particles.relative_velocity[particles.fluid] = self._relative
        owed = particles.owed_displacement[particles.fluid]
        owed += dt * self.velocity
        length = np.linalg.norm(owed, axis=1)
        most = MOST_OWED * self._stencil.spacing
        owed[length > most] *= (most / length[length > most])[:, None]
        partner = np.empty(particles.fluid_count, dtype=np.int64)
        pair_up(
            owed,
            particles.sediment_fraction[particles.fluid].copy(),
            self._around.concentration,
            self._drag.packing_limit,
            self._stencil,
            partner,
        )
        one = np.flatnonzero(partner > np.arange(partner.size))
        particles.exchange(one, partner[one])
