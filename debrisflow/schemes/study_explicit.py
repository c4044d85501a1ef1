"""The explicit scheme of the study: its equations as written, with walls of particles."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import LARGEST_PATH
from debrisflow.particles.matter import concentrations
from debrisflow.particles.state import State
from debrisflow.schemes.records import grains_of, numbers_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.schemes.terms.collision_stress import MixtureCollisions
from debrisflow.schemes.terms.concentration import Concentration
from debrisflow.schemes.terms.motion import Motion
from debrisflow.schemes.terms.shear import Shear
from debrisflow.schemes.terms.study_forces import StudyForces
from debrisflow.schemes.terms.viscosity import MixtureViscosity
from debrisflow.schemes.vicinity import OneList


class StudyExplicit(Scheme):
    """Density by summation, equation of state, gradient (14) and Laplacian (15), explicit.

    p = c^2 rho0 (n/n0 - 1),  u' = u + dt a(r, u, p),  r' = r + dt u'
    """

    def __init__(self, case: ResolvedCase) -> None:
        super().__init__(case)
        self.vicinity = OneList(case, self.lattice, self.domain)
        numbers, stress = numbers_of(case, self.lattice), case.collision_stress
        down = numbers.gravity / (float((numbers.gravity**2).sum()) ** 0.5 or 1.0)
        collisions = MixtureCollisions(case, numbers.density, numbers.sound_speed, False)
        self._forces = StudyForces(numbers, grains_of(case) if stress.enabled else None)
        terms = (
            MixtureViscosity(case),
            Concentration(down, len(concentrations(case)) == 1),
            Shear() if stress.enabled else None,
            collisions if stress.enabled else None,
            self._forces,
            Motion(case, self.domain, LARGEST_PATH),
        )
        self.terms = tuple(term for term in terms if term is not None)

    def fill_number_density(self, state: State) -> None:
        """Write number density and pressure of a state that no step has seen yet."""
        self._forces.sum_densities(self.observe(state))
