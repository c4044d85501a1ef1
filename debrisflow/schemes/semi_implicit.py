"""The semi-implicit scheme: predictor, pressure equation, corrector, exchange of momentum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.case.rheology import NoStrength
from debrisflow.physics.pressure import higher_order_factor
from debrisflow.physics.virtual_air import VirtualAir, virtual_air
from debrisflow.schemes.fractional_step import FractionalStep
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.contact import CONTACT, WallBounce, WallContact
from debrisflow.schemes.terms.pressure import PressurePush
from debrisflow.schemes.terms.term import Term
from debrisflow.schemes.terms.wall_forces import WallForces, are_asked
from debrisflow.schemes.vicinity import ListAndSurfaces
from debrisflow.space.domain import wall_names


class SemiImplicit(FractionalStep):
    """The stable form: walls are surfaces, and the free surface has virtual air."""

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        self.vicinity = ListAndSurfaces(case, self.lattice, self.domain)

    def _surface(self, scheme: ResolvedScheme) -> VirtualAir:
        return virtual_air(self.lattice, higher_order_factor(self.lattice.dimension))

    def _contact(self, scheme: ResolvedScheme) -> Term:
        return WallBounce(CONTACT * self.lattice.spacing, scheme.collision_restitution)

    def _correction(self, scheme: ResolvedScheme, gravity: NDArray[np.float64]) -> Term:
        return PressurePush(gravity)

    def _held(self, case: ResolvedCase) -> BaseFrictions | None:
        has_strength = not isinstance(case.rheology, NoStrength)
        frictions = BaseFrictions(case, is_implicit=has_strength)
        return frictions if any(np.any(values) for values in frictions.friction) else None

    def _walls(self, case: ResolvedCase, held: BaseFrictions | None) -> tuple[Term, ...]:
        sliding = held.friction.sliding if held else np.zeros(len(wall_names(case)))
        terms = (
            WallContact(CONTACT * self.lattice.spacing, sliding),
            held,
            WallForces() if are_asked(case) else None,
        )
        return tuple(term for term in terms if term is not None)
