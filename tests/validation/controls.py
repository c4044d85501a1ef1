"""Negative controls: the scheme with one part of the bed's mechanics as it must not be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit

Floats = NDArray[np.float64]


class ShareOfPressure(SemiImplicit):
    """Grains carry their share of the pressure of the mixture, water on top of them included."""

    def _balance_grains(self, p: Particles) -> None:
        water = self.case.water.density
        buoyant = self._level_concentration * (self.case.sediment.density - water)
        p.grain_pressure[:] = 0.0
        p.grain_pressure[p.fluid] = buoyant / (buoyant + water) * p.pressure[p.fluid]
        m = p.unknown_count
        limit = self.case.sediment.packing_limit * (self.case.sediment.density - water)
        p.grain_pressure[p.fluid_count : m] = (
            limit / (limit + water) * p.pressure[p.fluid_count : m]
        )


class FrictionBeforeProjection(SemiImplicit):
    """Friction acts on the predicted velocity, and the pressure has the last word."""

    def step(self, state: State, dt: float) -> int:
        self._dt = dt
        return super().step(state, dt)

    def _collide(self, p: Particles, velocity: Floats) -> Floats:
        self._balance_grains(p)
        return super()._exchange_momentum(p, super()._collide(p, velocity), self._dt)

    def _exchange_momentum(self, p: Particles, velocity: Floats, dt: float) -> Floats:
        return velocity
