"""The semi-implicit scheme of the study, with walls of particles, for comparison."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.case.strength import FrictionalStrength, NoStrength
from debrisflow.particles.state import State
from debrisflow.physics.free_surface import FreeSurface
from debrisflow.physics.pressure import find_free_surface
from debrisflow.schemes.records import drag_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.semi_implicit import RESIDUAL
from debrisflow.schemes.terms.collision_stress import PhaseCollisions
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.contact import Contact
from debrisflow.schemes.terms.eddies import Eddies
from debrisflow.schemes.terms.grain_pressure import GrainPressure
from debrisflow.schemes.terms.gravity import Gravity
from debrisflow.schemes.terms.momentum_exchange import MomentumExchange
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.pressure import PressureEquation, PressureGradient
from debrisflow.schemes.terms.shear import Shear
from debrisflow.schemes.terms.slip import Slip
from debrisflow.schemes.terms.term import Term
from debrisflow.schemes.terms.viscosity import ExplicitViscosity, NewtonianViscosity
from debrisflow.schemes.terms.wall_friction import WallFriction
from debrisflow.schemes.vicinity import OneList
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.gravity import gravity_vector


class StudySemiImplicit(Scheme):
    """Fractional step with the operators of the study, each of which the case may replace.

    What holds and slows the fluid along walls, and lets it slip and yield, is as in
    :class:`debrisflow.schemes.semi_implicit.SemiImplicit`.
    """

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        self.vicinity = OneList(case, self.lattice, self.domain)
        self.terms = self._terms(case, case.semi_implicit_scheme)

    def _terms(self, case: ResolvedCase, scheme: ResolvedScheme) -> tuple[Term, ...]:
        gravity, strength = gravity_vector(case), case.strength
        has_strength = not isinstance(strength, NoStrength)
        has_collisions = case.collision_stress.enabled
        slip = None
        if case.drag.law != "none":
            slip = Slip(drag_of(case), gravity)
        is_rough = any(getattr(case.walls, name).roughness > 0.0 for name in WALL_NAMES)
        is_sheared = has_strength or (
            has_collisions and case.collision_stress.granular_temperature == "algebraic"
        )
        exchange = MomentumExchange(
            case,
            gravity,
            RESIDUAL,
            is_smooth=isinstance(strength, FrictionalStrength),
            least_viscosity=0.0,
        )
        surface = (
            FreeSurface(lower=0.8, upper=0.97, asymmetry=0.1)
            if scheme.free_surface == "asymmetry"
            else FreeSurface(lower=0.97, upper=0.97, asymmetry=np.inf)
        )
        self._pressure = PressureEquation(scheme, case.dimension, surface, gravity)
        terms = (
            Gravity(gravity),
            Concentration(gravity / (np.linalg.norm(gravity) or 1.0), is_even=False),
            slip,
            Shear() if is_sheared else None,
            NewtonianViscosity(case) if has_strength else ExplicitViscosity(case),
            Eddies(case) if has_strength else None,
            PhaseCollisions(case, case.water.density, np.inf) if has_collisions else None,
            Contact(scheme.collision_distance * self.lattice.spacing, scheme.collision_restitution),
            self._pressure,
            PressureGradient(is_conservative=scheme.gradient == "sum"),
            GrainPressure(case, strength, gravity)
            if isinstance(strength, FrictionalStrength)
            else None,
            exchange if has_strength else None,
            WallFriction() if is_rough else None,
            Motion(case, self.domain, scheme.courant, slip),
        )
        return tuple(term for term in terms if term is not None)

    def fill_number_density(self, state: State) -> None:
        """Write number density and free surface of a state that no step has seen yet."""
        scene, p, m = self.observe(state), state.particles, state.particles.unknown_count
        find_free_surface(
            scene.near,
            scene.solid,
            self._pressure.surface,
            p.number_density[:m],
            p.on_free_surface[:m],
        )
