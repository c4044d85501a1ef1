"""Particles that went through a wall, an obstacle or the ground, told when it happens."""

from __future__ import annotations

import logging

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.neighbors.boundary import Boundary, find_inside
from debrisflow.particles.place import moment, named_particle, place_of, wall_passed
from debrisflow.particles.state import State
from debrisflow.schemes.choice import AnyScheme
from debrisflow.schemes.explicit import Explicit

LOG = logging.getLogger(__name__)
FIRST = 5
"""Escapes that are told one by one; after these only their number, each time it has doubled."""
MOST_LOST = 0.01
"""Share of all fluid so far beyond which a run stops.

Balances of experiments close to a few percent, so that results with a hundredth of the fluid lost
at places where nothing can flow answer nothing.  The shipped cases lose none."""
FEWEST_LOST = 10
"""Particles that may be lost at least, however few there are."""
CAUSE = (
    "a wall thinner than a spacing, a hole or a face turned over in a mesh, two walls that meet at "
    "a sharp angle, or a particle so fast that a step carries it across"
)
REMEDY = (
    "make the wall two spacings thick or more, close the mesh, or halve scheme.courant and "
    "particles.spacing"
)


class Escapes:
    """Tells of the first particles lost, and stops the run when they are too many.

    The explicit scheme removes what is half a spacing deep in a wall, both schemes remove what is
    outside the domain.  In the semi-implicit scheme with walls as surfaces, particles deep in an
    obstacle stay; they count here all the same.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    state : State
    """

    def __init__(self, case: ResolvedCase, scheme: AnyScheme, state: State) -> None:
        self._case, self._scheme = case, scheme
        self._told, self._next_told = 0, 2 * FIRST
        self._counted = self._lost = int(state.through_wall.sum())
        self._inside: set[int] = set()
        self._stay = not isinstance(scheme, Explicit)
        self._initial = state.particles.fluid_count + self._counted - int(state.entered.sum())
        self._initial += int(state.left.sum())

    def check(self, state: State) -> None:
        """Tell of what was lost in the last step.

        Raises
        ------
        DivergedError
            If it is too much in all.
        """
        if not state.escaped:
            return
        for particle in state.escaped:
            where = place_of(self._case, particle.position)
            wall = wall_passed(self._case, particle.position, state.time)
            self._tell(
                f"{moment(state)}, particle {particle.id} went through {wall} at {where}, at "
                f"{particle.speed:.3g} m/s, and was removed"
            )
        state.escaped.clear()
        self._lost = int(state.through_wall.sum())
        self._check_number(state)

    def look_into_walls(self, state: State) -> None:
        """Tell of particles that stay deep in a wall, whenever neighbors are found anew."""
        if not self._stay or state.step % self._scheme.REFRESH != 0:
            return
        vicinity, p = self._scheme.vicinity, state.particles
        if not isinstance(vicinity.solid, Boundary):
            return
        inside = np.zeros(p.fluid_count, dtype=np.bool_)
        find_inside(vicinity.near.spacing, vicinity.solid, inside)
        for row in np.flatnonzero(inside):
            if int(p.id[row]) not in self._inside:
                self._inside.add(int(p.id[row]))
                wall = wall_passed(self._case, p.position[row], state.time)
                named = named_particle(self._case, state, int(row))
                self._tell(f"{moment(state)}, {named} is half a spacing deep in {wall}")
        self._check_number(state)

    def _tell(self, what: str) -> None:
        self._told += 1
        if self._told <= FIRST:
            LOG.warning("%s; likely cause: %s; what to do: %s", what, CAUSE, REMEDY)
        elif self._told == self._next_told:
            self._next_told *= 2
            LOG.warning("%s; it is the %dth so far", what, self._told)

    def _check_number(self, state: State) -> None:
        lost = self._lost + len(self._inside)
        ever = self._initial + int(state.entered.sum())
        if lost <= max(FEWEST_LOST, MOST_LOST * ever):
            return
        raise DivergedError(
            f"{moment(state)}, {lost} of {ever} particles, {100.0 * lost / max(ever, 1):.2g} %, "
            f"have gone through walls, more than {100.0 * MOST_LOST:g} %; the first ones and "
            "their places are in run.log",
            CAUSE,
            REMEDY,
        )
