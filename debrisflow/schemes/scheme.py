"""What both schemes are: a list of terms, in the order of the theory."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import order_by_cell
from debrisflow.particles.state import State
from debrisflow.schemes.clock import Clock
from debrisflow.schemes.terms.term import Scene, Step, Term
from debrisflow.schemes.vicinity import Vicinity
from debrisflow.space.domain import domain


class Scheme:
    """A step is made of terms: each observes, limits the time step, and acts, in their order.

    Parameters
    ----------
    case : ResolvedCase
        A checked case with its defaults resolved.

    Attributes
    ----------
    lattice : Reference
    domain : Domain
    terms : tuple of Term
    seconds : Clock
        Wall time by term.
    """

    REFRESH = 40
    """Steps after which particles are sorted and what terms keep is built anew; a resumed run
    begins at such a step and so repeats the bits of an uninterrupted one."""

    terms: tuple[Term, ...]
    vicinity: Vicinity

    def __init__(self, case: ResolvedCase) -> None:
        self.case = case
        self.lattice = reference(
            case.dimension, case.particles.effective_radius, case.particles.spacing
        )
        self.domain = domain(case)
        self.seconds = Clock()
        self._scene: Scene | None = None
        self._observed_step = -1

    def observe(self, state: State) -> Scene:
        """Return what the terms find out about the particles at their present places."""
        known = self._scene
        if known is not None and known.state is state and self._observed_step == state.step:
            return known
        with self.seconds.of("neighbors"):
            self._update_neighbors(state)
        p = state.particles
        vicinity = self.vicinity
        scene = Scene(
            state, vicinity.near, vicinity.solid, p.velocity[p.moving], vicinity.wall_speed
        )
        for term in self.terms:
            with self.seconds.of(term.name):
                term.observe(scene)
        self._scene, self._observed_step = scene, state.step
        return scene

    def _update_neighbors(self, state: State) -> None:
        p, is_fresh = state.particles, state.step % self.REFRESH == 0
        if is_fresh:
            p.reorder(p.fluid, order_by_cell(p.position[p.fluid], self.lattice.spacing))
            for term in self.terms:
                term.refresh()
        self.vicinity.update(p, state.time, is_fresh)

    def stable_dt(self, state: State) -> float:
        """Return the greatest time step, s, that the state allows."""
        scene = self.observe(state)
        return min(self.case.time.largest_step, *(term.limit(scene) for term in self.terms))

    def step(self, state: State, dt: float) -> int:
        """Advance a state by a time step that :meth:`stable_dt` allows.

        Returns
        -------
        int
            Iterations of the linear system that counts; 0 where there is none.

        Raises
        ------
        NotConvergedError
            If a linear system was not solved.
        DivergedError
            If a velocity is not finite.  Time, positions, velocities and pressures are then as
            before in both cases.
        """
        scene, p = self.observe(state), state.particles
        rows = scene.near.fluid_count.size
        step = Step(scene, dt, p.velocity[p.moving].copy(), p.pressure[:rows].copy())
        for term in self.terms:
            with self.seconds.of(term.name):
                term.act(step)
        return step.iterations

    def fill_number_density(self, state: State) -> None:
        """Write number density and free surface of a state that no step has seen yet."""
        raise NotImplementedError
