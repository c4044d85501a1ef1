"""Linear systems that are not solved: the step is tried again with half the time step."""

from __future__ import annotations

import logging

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError, NotConvergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import State
from debrisflow.schemes.choice import AnyScheme

LOG = logging.getLogger(__name__)
FIRST = 3
"""Halvings that are told one by one."""
WINDOW, OFTEN = 1000, 50
"""Halvings within so many steps are frequent from so many on.  The shipped cases have none."""
CAUSE = (
    "particles on top of each other, materials whose viscosity or density differ by many orders "
    "of magnitude, or a time step too long for the flow"
)
REMEDY = (
    "try half of time.largest_step; check viscosity, friction and density of what stands at that "
    "place"
)


class Halvings:
    """Counts halved steps, and tells when they become frequent.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    """

    def __init__(self, case: ResolvedCase, scheme: AnyScheme) -> None:
        self._case, self._reference = case, scheme.lattice.number_density
        self._steps: list[int] = []
        self._told, self._has_told = 0, False

    def count(self, state: State, error: NotConvergedError, dt: float) -> None:
        """Count a step of a length, s, that is to be halved."""
        self._told += 1
        if self._told <= FIRST:
            LOG.warning("%s not solved %s, dt = %g s; halved", error, moment(state), dt)
        self._steps = [step for step in self._steps if step > state.step - WINDOW] + [state.step]
        if len(self._steps) >= OFTEN and not self._has_told:
            self._has_told = True
            LOG.warning(
                "%s, %s was not solved %d times within %d steps, each time the step was halved; %s;"
                " likely cause: %s; what to do: %s",
                moment(state),
                error,
                len(self._steps),
                WINDOW,
                self._closest(state),
                CAUSE,
                REMEDY,
            )

    def fault(self, state: State, error: NotConvergedError, dt: float) -> DivergedError:
        """Return the fault of a system that no time step down to a length, s, solves."""
        return DivergedError(
            f"{moment(state)}, {error} was not solved even with a time step of {dt:.3g} s, "
            f"{self._case.time.largest_step / dt:.0f} times shorter than time.largest_step; "
            f"{self._closest(state)}",
            CAUSE,
            REMEDY,
        )

    def _closest(self, state: State) -> str:
        """Return the particle that others are closest to, in words."""
        p = state.particles
        if p.fluid_count == 0:
            return "there is no fluid"
        row = int(np.argmax(p.number_density[p.fluid]))
        ratio = p.number_density[row] / self._reference
        named = named_particle(self._case, state, row)
        return f"the densest place is that of {named}, n/n0 = {ratio:.3g}"
