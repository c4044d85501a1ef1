"""A few steps of a case, to measure how fast this machine computes it."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.errors import NotConvergedError
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.run.loop import use_threads
from debrisflow.run.pace import TRIAL, Pace
from debrisflow.run.work import SETTLED
from debrisflow.schemes.choice import AnyScheme, scheme_of
from debrisflow.schemes.clock import Clock

SECONDS = 2.0


def measured_pace(case: ResolvedCase, threads: int | None = None) -> Pace | None:
    """Return the pace of two seconds of steps from the start of a case.

    Kernels are compiled and read from the cache before, in steps that do not count.  One step
    at least counts, however long it takes.  None if the first steps fail.

    Parameters
    ----------
    case : ResolvedCase
    threads : int, optional
        As many as the case can use by default.
    """
    scheme, state = scheme_of(case), initial_state(case)
    used = use_threads(state, threads)
    scheme.fill_number_density(state)
    particle_steps = steps = 0
    try:
        for _ in range(SETTLED):
            take_step(scheme, state)
        clock = Clock()
        while steps == 0 or clock.seconds < SECONDS:
            take_step(scheme, state)
            particle_steps += state.particles.fluid_count
            steps += 1
    except NotConvergedError:
        if steps == 0:
            return None
    return Pace(particle_steps, steps, clock.seconds, used, TRIAL)


def take_step(scheme: AnyScheme, state: State) -> None:
    """Take the longest step that a scheme allows."""
    dt = scheme.stable_dt(state)
    scheme.step(state, dt)
    state.time, state.step = state.time + dt, state.step + 1
