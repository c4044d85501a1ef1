"""The semi-implicit scheme: predictor, pressure equation, corrector, exchange of momentum."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.case.strength import FrictionalStrength, NoStrength
from debrisflow.particles.state import State
from debrisflow.physics.pressure import find_free_surface, higher_order_factor
from debrisflow.physics.virtual_air import virtual_air
from debrisflow.schemes.records import drag_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.collision_stress import PhaseCollisions
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.contact import WallBounce, WallContact
from debrisflow.schemes.terms.eddies import Eddies
from debrisflow.schemes.terms.grain_pressure import GrainPressure
from debrisflow.schemes.terms.gravity import Gravity
from debrisflow.schemes.terms.momentum_exchange import MomentumExchange
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.pressure import PressureEquation, PressurePush
from debrisflow.schemes.terms.shear import Shear
from debrisflow.schemes.terms.slip import Slip
from debrisflow.schemes.terms.term import Term
from debrisflow.schemes.terms.viscosity import ExplicitViscosity, NewtonianViscosity
from debrisflow.schemes.terms.wall_forces import WallForces
from debrisflow.schemes.vicinity import ListAndSurfaces
from debrisflow.space.gravity import gravity_vector

RESIDUAL = 1.0e-5
"""Share of gravity that the exchange of momentum may leave out of balance.

With 1e-3 the last iteration, which rounding decides, moved the energy of a bed by 1 % in 0.6 s."""


CONTACT = 0.3
"""Spacings from a wall nearer than which a particle touches it."""


class SemiImplicit(Scheme):
    """Fractional step with variable density, everything evaluated at the old positions.

    Predict the velocity from gravity, viscosity, collision stress and drag; bounce off walls; solve
    the pressure equation, with virtual air at the free surface, and correct by its gradient and by
    what walls as surfaces push; exchange momentum implicitly by viscosity and friction, that of
    rough walls too; move.  With a drag law all that follows the drag is done with the velocity of
    the mixture, and the slip moves particles by exchange of places, see
    :mod:`debrisflow.physics.slip`; without one each particle moves by its own velocity.
    """

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        self.vicinity = ListAndSurfaces(case, self.lattice, self.domain)
        self.terms = self._terms(case, case.semi_implicit_scheme)

    def _terms(self, case: ResolvedCase, scheme: ResolvedScheme) -> tuple[Term, ...]:
        gravity, strength = gravity_vector(case), case.strength
        has_strength = not isinstance(strength, NoStrength)
        has_collisions = case.collision_stress.enabled
        slip = None
        if case.drag.law != "none":
            slip = Slip(drag_of(case), gravity)
        is_sheared = has_strength or (
            has_collisions and case.collision_stress.granular_temperature == "algebraic"
        )
        frictions = BaseFrictions(case, is_implicit=has_strength)
        has_friction = any(np.any(values) for values in frictions.friction)
        exchange = MomentumExchange(
            case,
            gravity,
            RESIDUAL,
            is_smooth=isinstance(strength, FrictionalStrength),
            least_viscosity=0.0,
            walls=frictions if has_friction else None,
        )
        surface = virtual_air(self.lattice, higher_order_factor(case.dimension))
        self._pressure = PressureEquation(scheme, case.dimension, surface, gravity)
        reach = CONTACT * self.lattice.spacing
        terms = (
            Gravity(gravity),
            Concentration(gravity / (np.linalg.norm(gravity) or 1.0), is_even=False),
            slip,
            Shear() if is_sheared else None,
            NewtonianViscosity(case) if has_strength else ExplicitViscosity(case),
            Eddies(case) if has_strength else None,
            PhaseCollisions(case, case.water.density, np.inf) if has_collisions else None,
            WallBounce(reach, scheme.collision_restitution),
            self._pressure,
            PressurePush(gravity),
            GrainPressure(case, strength, gravity)
            if isinstance(strength, FrictionalStrength)
            else None,
            exchange if has_strength else None,
            WallContact(reach, frictions.friction.sliding),
            frictions if has_friction else None,
            WallForces() if any(p.type == "force" for p in case.probe) else None,
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
