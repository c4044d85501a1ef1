"""The whole state of a run: what a checkpoint must carry so that the run goes on bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from debrisflow import hydrostatic
from debrisflow.case import tables
from debrisflow.geometry import wall_layers
from debrisflow.grid import plan
from debrisflow.maxima import Maxima, no_maxima
from debrisflow.particles import Particles, seed, supplied_sediment

PHASES = ("liquid", "sediment", "mixture")


def _counts() -> NDArray[np.int64]:
    return np.zeros(len(PHASES), dtype=np.int64)


def _crossings(sections: int = 0) -> NDArray[np.int64]:
    return np.zeros((sections, len(PHASES)), dtype=np.int64)


@dataclass
class State:
    """Particles, maxima, clock and counters of a run.

    Attributes
    ----------
    particles : Particles
    maxima : Maxima
        The greatest depth, speed and momentum flux since t = 0.
    time : float
        Simulated time, s; negative while the fills relax.
    step : int
        Steps taken since the start of the run.
    dt : float
        Length of the last step, s.
    entered, left, through_wall : (3,) int64 array
        Particles by phase that came in through the inflow, left through an open end or over a
        rim, and were lost through a wall.
    supply_columns : int
        Columns of inflow particles seeded so far.
    supply_sediment : float
        Sediment particles that the supply still owes to its concentration.
    next_id : int
        The number that the next new particle gets.
    crossed : (sections, 3) int64 array
        Particles by phase that went through each section along x since t = 0, less those that
        went back.
    """

    particles: Particles
    maxima: Maxima
    time: float = 0.0
    step: int = 0
    dt: float = 0.0
    entered: NDArray[np.int64] = field(default_factory=_counts)
    left: NDArray[np.int64] = field(default_factory=_counts)
    through_wall: NDArray[np.int64] = field(default_factory=_counts)
    supply_columns: int = 0
    supply_sediment: float = 0.0
    next_id: int = 0
    crossed: NDArray[np.int64] = field(default_factory=_crossings)


def initial_state(case: tables.Case) -> State:
    """Return the state of a case at its start, before its fills relax."""
    particles = seed(case)
    if isinstance(case.scheme, tables.ExplicitScheme):
        hydrostatic.compress(particles, case)
        hydrostatic.jitter(particles, case)
    maxima = no_maxima(plan(case).x.size)
    state = State(particles, maxima, time=0.0 - case.time.relaxation, next_id=particles.count)
    state.crossed = _crossings(sum(probe.type == "section" for probe in case.probe))
    if case.inflow is not None:
        state.supply_columns = wall_layers(case)
        state.supply_sediment = supplied_sediment(case, state.supply_columns) % 1.0
    return state
