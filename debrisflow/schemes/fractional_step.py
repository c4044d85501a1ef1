"""The step that both forms of the semi-implicit scheme have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.case.rheology import FrictionalStrength, NoStrength
from debrisflow.particles.state import State
from debrisflow.physics.free_surface import FreeSurface
from debrisflow.physics.pressure import find_free_surface
from debrisflow.physics.virtual_air import VirtualAir
from debrisflow.schemes.records import drag_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.collision_stress import PhaseCollisions
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.eddies import Eddies
from debrisflow.schemes.terms.grain_pressure import GrainPressure
from debrisflow.schemes.terms.gravity import Gravity
from debrisflow.schemes.terms.momentum_exchange import MomentumExchange
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.pressure import PressureEquation
from debrisflow.schemes.terms.shear import Shear
from debrisflow.schemes.terms.slip import Slip
from debrisflow.schemes.terms.term import Term
from debrisflow.schemes.terms.viscosity import ExplicitViscosity, NewtonianViscosity
from debrisflow.space.gravity import gravity_vector

RESIDUAL = 1.0e-5
"""Share of gravity that the exchange of momentum may leave out of balance.

With 1e-3 the last iteration, which rounding decides, moved the energy of a bed by 1 % in 0.6 s."""


class FractionalStep(Scheme):
    """Fractional step with variable density, everything evaluated at the old positions.

    Predict the velocity from gravity, viscosity, collision stress and drag; let what touches
    collide; solve the pressure equation and correct by its gradient; exchange momentum implicitly
    by viscosity and friction; move.  With a drag law all that follows the drag is done with the
    velocity of the mixture, and the slip moves particles by exchange of places, see
    :mod:`debrisflow.physics.slip`; without one each particle moves by its own velocity.

    A form says what its walls and its free surface are.
    """

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        scheme, gravity = case.semi_implicit_scheme, gravity_vector(case)
        surface = self._surface(scheme)
        self._pressure = PressureEquation(scheme, case.dimension, surface, gravity)
        self.terms = self._terms(case, scheme, gravity)

    def _surface(self, scheme: ResolvedScheme) -> FreeSurface | VirtualAir:
        """Return what the free surface is."""
        raise NotImplementedError

    def _contact(self, scheme: ResolvedScheme) -> Term:
        """Return what keeps particles apart from walls, or from each other, before the pressure."""
        raise NotImplementedError

    def _correction(self, scheme: ResolvedScheme, gravity: NDArray[np.float64]) -> Term:
        """Return the correction by the gradient of the pressure."""
        raise NotImplementedError

    def _held(self, case: ResolvedCase) -> BaseFrictions | None:
        """Return the friction along walls that acts within the exchange of momentum."""
        raise NotImplementedError

    def _walls(self, case: ResolvedCase, held: BaseFrictions | None) -> tuple[Term, ...]:
        """Return what walls do after the exchange of momentum."""
        raise NotImplementedError

    def _terms(
        self, case: ResolvedCase, scheme: ResolvedScheme, gravity: NDArray[np.float64]
    ) -> tuple[Term, ...]:
        rheology, stress = case.rheology, case.collision_stress
        has_strength = not isinstance(rheology, NoStrength)
        is_frictional = isinstance(rheology, FrictionalStrength)
        slip = Slip(drag_of(case), gravity) if case.drag.law != "none" else None
        is_sheared = has_strength or (stress.enabled and stress.granular_temperature == "algebraic")
        held = self._held(case)
        exchange = MomentumExchange(
            case, gravity, RESIDUAL, is_smooth=is_frictional, least_viscosity=0.0, walls=held
        )
        grains = None
        if isinstance(rheology, FrictionalStrength):
            grains = GrainPressure(case, rheology, gravity)
        terms = (
            Gravity(gravity),
            Concentration(gravity / (np.linalg.norm(gravity) or 1.0), is_even=False),
            slip,
            Shear() if is_sheared else None,
            NewtonianViscosity(case) if has_strength else ExplicitViscosity(case),
            Eddies(case) if has_strength else None,
            PhaseCollisions(case, case.water.density, np.inf) if stress.enabled else None,
            self._contact(scheme),
            self._pressure,
            self._correction(scheme, gravity),
            grains,
            exchange if has_strength else None,
            *self._walls(case, held),
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
