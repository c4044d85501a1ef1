"""The semi-implicit scheme of the study, with walls of particles, for comparison."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.physics.free_surface import FreeSurface
from debrisflow.schemes.fractional_step import FractionalStep
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.contact import Contact
from debrisflow.schemes.terms.pressure import PressureGradient
from debrisflow.schemes.terms.term import Term
from debrisflow.schemes.terms.wall_friction import WallFriction
from debrisflow.schemes.vicinity import OneList
from debrisflow.space.domain import WALL_NAMES


class StudySemiImplicit(FractionalStep):
    """The form of the study: each of its operators may be replaced by the case."""

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        self.vicinity = OneList(case, self.lattice, self.domain)

    def _surface(self, scheme: ResolvedScheme) -> FreeSurface:
        if scheme.free_surface == "asymmetry":
            return FreeSurface(lower=0.8, upper=0.97, asymmetry=0.1)
        return FreeSurface(lower=0.97, upper=0.97, asymmetry=np.inf)

    def _contact(self, scheme: ResolvedScheme) -> Term:
        distance = scheme.collision_distance * self.lattice.spacing
        return Contact(distance, scheme.collision_restitution)

    def _correction(self, scheme: ResolvedScheme, gravity: NDArray[np.float64]) -> Term:
        return PressureGradient(is_conservative=scheme.gradient == "sum")

    def _held(self, case: ResolvedCase) -> BaseFrictions | None:
        return None

    def _walls(self, case: ResolvedCase, held: BaseFrictions | None) -> tuple[Term, ...]:
        is_rough = any(getattr(case.walls, name).roughness > 0.0 for name in WALL_NAMES)
        return (WallFriction(),) if is_rough else ()
