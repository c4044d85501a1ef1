"""Step a case and look at its state now and then."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.run.measures import elastic_energy, energies
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.scheme import Scheme


def states(case: ResolvedCase, interval: float = 0.0) -> Iterator[State]:
    """Yield the state at the start, and at the end of each step in which an interval, s, ends.

    It is one object that changes.  Steps are not shortened for the intervals; 0 is every step.
    """
    scheme, state = scheme_of(case), initial_state(case)
    scheme.fill_number_density(state)
    yield state
    count = 0
    while state.time < case.time.end:
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time, state.dt = state.time + dt, dt
        state.step += 1
        if interval == 0.0 or int(state.time / interval) > count:
            count = int(state.time / interval) if interval > 0.0 else 0
            yield state


def energy(case: ResolvedCase, state: State) -> float:
    """Return kinetic, potential and elastic energy of the fluid, J, in two dimensions J/m."""
    p = state.particles
    moving = energies(case, p.position, p.velocity, p.density, p.kind)
    stored = elastic_energy(case, p.density, p.kind, p.compression)
    return moving.kinetic + moving.potential + stored


def advance(
    scheme: Scheme, state: State, steps: int | None = None, until: float | None = None
) -> State:
    """Take a number of steps, or steps of about one length up to a time, and return the state."""
    last = np.inf if steps is None else state.step + steps
    while state.step < last and (until is None or state.time < until):
        dt = scheme.stable_dt(state)
        if until is not None:
            # a last step much shorter than the others would kick: errors of density over dt^2
            dt = (until - state.time) / ceil((until - state.time) / dt * (1.0 - 1e-12))
        scheme.step(state, dt)
        state.time = until if until is not None and dt == until - state.time else state.time + dt
        state.step += 1
    return state
