"""The state of a case at its start."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase, tables
from debrisflow.particles import hydrostatic_start
from debrisflow.particles.layers import no_layers
from debrisflow.particles.maxima import no_maxima
from debrisflow.particles.releases import release_due
from debrisflow.particles.seeding import seed
from debrisflow.particles.state import State
from debrisflow.particles.supply import supplied_sediment, whole_sediment
from debrisflow.space.carving import fitted
from debrisflow.space.domain import wall_layers
from debrisflow.space.ground import ground_of
from debrisflow.space.plan_grid import plan


def initial_state(case: ResolvedCase) -> State:
    """Return the state of a case at its start, before its fills relax."""
    particles = seed(case)
    if isinstance(case.scheme, tables.ExplicitScheme):
        hydrostatic_start.compress(particles, case)
    if case.obstacle and not case.is_terrain:
        particles.position[particles.fluid] = fitted(case, particles.position[particles.fluid])
    cells = 0 if case.is_terrain else plan(case).x.size
    state = State(
        particles, no_maxima(cells), time=0.0 - case.time.settling, next_id=particles.count
    )
    if case.is_terrain:
        state.released = np.zeros(len(case.release), dtype=np.int64)
        state.layers = no_layers(*ground_of(case).given.shape)
    release_due(state, case, 0.0)
    if isinstance(case.scheme, tables.ExplicitScheme):
        hydrostatic_start.jitter(particles, case)
    if case.inflow is not None:
        state.supply_columns = wall_layers(case)
        owed = supplied_sediment(case, state.supply_columns)
        state.supply_sediment = owed - whole_sediment(case, owed)
    return state
