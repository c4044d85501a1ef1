"""The explicit scheme: density by continuity, equation of state, forces, all at one position."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import LARGEST_PATH
from debrisflow.case.rheology import FrictionalStrength, NoStrength
from debrisflow.neighbors.boundary import find_inside
from debrisflow.neighbors.height_field import HeightField
from debrisflow.particles.inflow_outflow import remove_beyond_data, remove_lost
from debrisflow.particles.matter import concentrations, has_pore_pressure
from debrisflow.particles.state import State
from debrisflow.schemes.records import numbers_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.surfaces import record_of_ground
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.collision_stress import MixtureCollisions
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.contact import CONTACT, WallContact
from debrisflow.schemes.terms.density import Density
from debrisflow.schemes.terms.eddies import Eddies
from debrisflow.schemes.terms.forces import Forces
from debrisflow.schemes.terms.grain_pressure import GrainPressure, SharedPressure
from debrisflow.schemes.terms.momentum_exchange import MomentumExchange
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.pore_pressure import PorePressure
from debrisflow.schemes.terms.shear import Shear
from debrisflow.schemes.terms.term import Step, Term
from debrisflow.schemes.terms.viscosity import MixtureViscosity
from debrisflow.schemes.terms.wall_forces import WallForces, are_asked
from debrisflow.schemes.vicinity import ListAndSurfaces

RESIDUAL = 0.01
"""Share of gravity that the exchange of momentum may leave out of balance."""


class Explicit(Scheme):
    """Weakly compressible step, symplectic and with one evaluation of all terms.

        s' = s + dt ds/dt(r, u),  p = rho0 c^2 s',  u' = u + dt a(r, u, p),  r' = r + dt u'

    Each particle stands for water or for a mixture.  With a rheological law, and so with a
    viscosity that has no bound, momentum is exchanged implicitly between forces and motion:

        (1 + dt K / rho) u' = u + dt a(r, u, p)

    Parameters
    ----------
    case : ResolvedCase
    ground : HeightField, optional
        Ground over the floor of the case; that of a terrain is its own.
    """

    vicinity: ListAndSurfaces

    def __init__(self, case: ResolvedCase, ground: HeightField | None = None) -> None:
        super().__init__(case)
        if case.is_terrain:
            ground = record_of_ground(case)
        self.vicinity = ListAndSurfaces(
            case,
            self.lattice,
            self.domain,
            ground,
            shares_drag=not isinstance(case.rheology, NoStrength),
        )
        self.terms = self._terms(case, ground is not None)

    def _terms(self, case: ResolvedCase, has_ground: bool) -> tuple[Term, ...]:
        numbers, is_even = numbers_of(case, self.lattice), len(concentrations(case)) == 1
        gravity = numbers.gravity
        down = gravity / (float(np.linalg.norm(gravity)) or 1.0)
        # what the artificial viscosity along the line of two particles is in shear
        kinematic = numbers.artificial_viscosity * numbers.sound_speed * self.lattice.spacing
        least = numbers.density * kinematic / (case.dimension + 2.0)
        rheology, stress = case.rheology, case.collision_stress
        is_implicit = not isinstance(rheology, NoStrength)
        is_sheared = is_implicit or (stress.enabled and stress.granular_temperature == "algebraic")
        collisions = MixtureCollisions(case, numbers.density, numbers.sound_speed, is_implicit)
        frictions = BaseFrictions(case, is_implicit=is_implicit)
        has_friction = any(np.any(values) for values in frictions.friction)
        exchange = MomentumExchange(
            case,
            gravity,
            RESIDUAL,
            is_smooth=False,
            least_viscosity=least,
            walls=frictions if has_friction else None,
        )
        touch, grains = CONTACT * self.lattice.spacing, None
        if isinstance(rheology, FrictionalStrength):
            balance = SharedPressure if is_even else GrainPressure
            grains = balance(case, rheology, gravity)
        self._density = Density(numbers, is_even)
        forces = Forces(numbers, is_even, is_even and not stress.enabled, not is_implicit)
        wall_forces = WallForces() if are_asked(case) else None
        self._at_rest = (forces, wall_forces) if wall_forces else ()
        self._motion = Motion(case, self.domain, LARGEST_PATH)
        terms = (
            MixtureViscosity(case),
            Concentration(down, is_even),
            Shear() if is_sheared else None,
            collisions if stress.enabled else None,
            Eddies(case, has_ground) if is_implicit else None,
            self._density,
            forces,
            grains,
            exchange if is_implicit else None,
            WallContact(touch, frictions.friction.sliding) if is_implicit else None,
            frictions if has_friction else None,
            wall_forces,
            self._motion,
            PorePressure() if has_pore_pressure(case) else None,
        )
        return tuple(term for term in terms if term is not None)

    def fill_number_density(self, state: State) -> None:
        """Write number density, pressure and forces on walls of a state that no step has seen."""
        scene, p = self.observe(state), state.particles
        p.compression[p.moving] = self._density.advance(scene, 0.0, p.pressure[p.moving])
        velocity, pressure = p.velocity[p.moving].copy(), p.pressure[p.moving]
        still = Step(scene, self.stable_dt(state), velocity, pressure)
        for term in self._at_rest:
            term.act(still)

    def _update_neighbors(self, state: State) -> None:
        p = state.particles
        is_fresh = state.step % self.REFRESH == 0
        if is_fresh:
            fastest, _ = self._motion.survey(p)
            self.vicinity.choose_skin(fastest * self.case.time.largest_step / self.lattice.spacing)
        super()._update_neighbors(state)
        if is_fresh:
            lost = np.empty(p.fluid_count, dtype=np.bool_)
            find_inside(self.vicinity.near.spacing, self.vicinity.solid, lost)
            if lost.any():
                remove_lost(state, lost)
            if remove_beyond_data(state, self.case) or lost.any():
                self.vicinity.update(p, state.time, is_fresh)
