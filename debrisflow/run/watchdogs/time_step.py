"""A time step that collapses, or stays so short that the run stalls."""

from __future__ import annotations

import logging

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import State
from debrisflow.schemes.choice import AnyScheme

LOG = logging.getLogger(__name__)
LEAST_STEP = 1.0e-5
"""Of the largest step that the case allows; below, the step has collapsed."""
SHORT, SHORT_STEPS = 0.05, 300
"""A warning is due if the step is shorter than this share of the largest for so many in a row."""
STALLED, STALLED_STEPS = 0.01, 3000
"""The run stops after so many steps in a row shorter than this share: it would take more than a
hundred times its forecast.  The least share in the shipped cases is 0.28."""


class TimeStep:
    """Checks the longest time step that the scheme allows, not what outputs cut from it.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    """

    def __init__(self, case: ResolvedCase, scheme: AnyScheme) -> None:
        self._case, self._scheme = case, scheme
        self._short = self._stalled = 0
        self._stalled_since = 0.0

    def check(self, state: State, longest: float) -> None:
        """Check a time step, s.

        Raises
        ------
        DivergedError
            If it has collapsed or the run has stalled.
        """
        share = longest / self._case.time.largest_step
        if not share >= LEAST_STEP:
            reason, cause, remedy = self._reason(state)
            what = f"{moment(state)}, the time step has fallen to {longest:.3g} s: {reason}"
            raise DivergedError(what, cause, remedy)
        self._short = self._short + 1 if share < SHORT else 0
        if share < STALLED:
            if self._stalled == 0:
                self._stalled_since = state.time
            self._stalled += 1
        else:
            self._stalled = 0
        if self._short == SHORT_STEPS and not self._is_by_walls(state):
            reason, cause, remedy = self._reason(state)
            LOG.warning(
                "%s, the time step has been below %g %% of time.largest_step for %d steps; it is "
                "%.3g s: %s; likely cause: %s; what to do: %s",
                moment(state),
                100.0 * SHORT,
                SHORT_STEPS,
                longest,
                reason,
                cause,
                remedy,
            )
        if self._stalled >= STALLED_STEPS and not self._is_by_walls(state):
            reason, cause, remedy = self._reason(state)
            raise DivergedError(
                f"{moment(state)}, the run stalls: the last {self._stalled} steps advanced it by "
                f"{state.time - self._stalled_since:.3g} s, the time step is {longest:.3g} s where "
                f"the case allows {self._case.time.largest_step:.3g} s: {reason}",
                cause,
                remedy,
            )

    def _is_by_walls(self, state: State) -> bool:
        """Return whether a wall that moves by its schedule is the reason."""
        scene = self._scheme.observe(state)
        fastest = float(np.linalg.norm(scene.velocity, axis=1).max(initial=0.0))
        return scene.wall_speed > fastest

    def _reason(self, state: State) -> tuple[str, str, str]:
        """Return what limits the step and where, the likely cause, and what to do."""
        scene, p = self._scheme.observe(state), state.particles
        if p.fluid_count == 0:
            return "there is no fluid", "the supply is too fast", "check the inflow"
        limits = {term.name: term.limit(scene) for term in self._scheme.terms}
        name = min(limits, key=lambda term: limits[term])
        speed = np.linalg.norm(p.velocity[p.fluid], axis=1)
        row = int(np.argmax(speed))
        fastest = f"{named_particle(self._case, state, row)} moves at {speed[row]:.3g} m/s"
        if name == "motion" or not len(scene.viscosity):
            return (
                f"the term {name} limits it; {fastest}",
                "a particle was thrown out by a pressure peak, a sharp corner of an obstacle or an "
                "earlier step too long for the scheme; or the inflow or a wall is far too fast",
                "look at the place in the particles at the failure; smooth the obstacle there, or "
                "halve scheme.courant or time.largest_step",
            )
        row = int(np.argmax(scene.viscosity[p.fluid]))
        return (
            f"the term {name} limits it; {named_particle(self._case, state, row)} has the "
            f"viscosity {scene.viscosity[row]:.3g} Pa s, {fastest}",
            "viscosity or collision stress of the grains are too stiff for this spacing there: "
            "grains near their packing limit, or a value of the case out of its range",
            "check viscosity, sediment.packing_limit and collision_stress of the case, or use a "
            "greater particles.spacing",
        )
