"""Negative controls: the scheme with one part of the bed's mechanics as it must not be."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.schemes.terms.grain_pressure import GrainPressure
from debrisflow.schemes.terms.momentum_exchange import MomentumExchange
from debrisflow.schemes.terms.pressure import PressureEquation
from debrisflow.schemes.terms.term import Step, Term


class _Share(Term):
    """The share of the pressure of the mixture that grains carry by their buoyant weight."""

    name = "grain pressure"

    def __init__(self, case: ResolvedCase) -> None:
        self._water = case.water.density
        self._excess = case.sediment.density - case.water.density

    def act(self, step: Step) -> None:
        p, rows = step.particles, step.particles.moving
        buoyant = step.scene.level * self._excess
        p.grain_pressure[rows] = buoyant / (buoyant + self._water) * p.pressure[rows]


class ShareOfPressure(SemiImplicit):
    """Grains carry their share of the pressure of the mixture, water on top of them included."""

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        share = _Share(case)
        self.terms = tuple(
            share if isinstance(term, GrainPressure) else term for term in self.terms
        )


class FrictionBeforeProjection(SemiImplicit):
    """Friction acts on the predicted velocity, and the pressure has the last word."""

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        friction = [t for t in self.terms if isinstance(t, GrainPressure | MomentumExchange)]
        others = [term for term in self.terms if term not in friction]
        (projection,) = (k for k, t in enumerate(others) if isinstance(t, PressureEquation))
        self.terms = (*others[:projection], *friction, *others[projection:])
