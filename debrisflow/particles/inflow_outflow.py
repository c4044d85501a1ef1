"""The supply at the inflow, and what leaves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.matter import set_fraction
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import Escaped, State, count_phases
from debrisflow.particles.supply import supply, supply_column, whole_sediment
from debrisflow.space.domain import Domain
from debrisflow.space.fills import inflow_section
from debrisflow.space.floor import floor_level
from debrisflow.space.ground import ground_of

Floats = NDArray[np.float64]
MOST_NOTED = 100
"""Escaped particles that are noted one by one; all are counted."""


def advance_supply(state: State, case: ResolvedCase, dt: float) -> None:
    """Move the supply by a step; what passes x = 0 turns into fluid, and new columns follow.

    In three dimensions all that waits has the concentration of the present supply, so that the
    sediment that enters is exact to the last column whatever the hydrograph.
    """
    particles = state.particles
    if particles.inflow_count == 0:
        return
    velocity, concentration = supply(case, state.time)
    rows = particles.inflow
    particles.position[rows, 0] += dt * velocity
    particles.velocity[rows, 0] = velocity
    if case.dimension == 3:
        set_fraction(particles, rows, concentration, case)
    passed = particles.position[rows, 0] >= 0.0
    if passed.any():
        _release(state, np.nonzero(passed)[0] + particles.fluid_count)
        _add_column(state, case, concentration)


def _release(state: State, rows: NDArray[np.int64]) -> None:
    """Turn inflow particles into fluid, behind the other fluid particles."""
    particles = state.particles
    fraction = particles.sediment_fraction[rows]
    pure = np.where(fraction == 0.0, Kind.LIQUID, Kind.SEDIMENT)
    kind = np.where((fraction > 0.0) & (fraction < 1.0), Kind.MIXTURE, pure)
    particles.kind[rows] = kind
    count_phases(kind, fraction, state.entered, state.entered_sediment)
    waiting = np.setdiff1d(np.arange(particles.count)[particles.inflow], rows)
    order = np.concatenate([rows, waiting]) - particles.fluid_count
    particles.reorder(particles.inflow, order)
    particles.fluid_count += rows.size
    particles.inflow_count -= rows.size


def _add_column(state: State, case: ResolvedCase, concentration: float) -> None:
    """Add a column of supply behind the last one; its sediment follows the concentration."""
    particles = state.particles
    section = inflow_section(case)
    count = section.wide * section.high
    state.supply_sediment += concentration * count
    due = whole_sediment(case, state.supply_sediment)
    state.supply_sediment -= due
    x = particles.position[particles.inflow, 0].min() - case.particles.spacing
    column = supply_column(case, state.supply_columns, x, due)
    column.velocity[:, 0] = supply(case, state.time)[0]
    column.id[:] = state.next_id + np.arange(count)
    particles.insert(particles.inflow.stop, column)
    particles.inflow_count += count
    state.supply_columns += 1
    state.next_id += count


def wrap(particles: Particles, domain: Domain) -> None:
    """Bring fluid particles that passed the end of a period back to its beginning."""
    for axis in np.nonzero(domain.period > 0.0)[0]:
        particles.position[particles.fluid, axis] %= domain.period[axis]


def remove_leaving(state: State, case: ResolvedCase, domain: Domain) -> None:
    """Remove fluid particles outside the domain and count them by phase.

    What is found under the floor, above a ceiling, or beside a closed side below its rim went
    through a wall; all else left through an open end or over the rim.
    """
    particles, d0, up = state.particles, case.particles.spacing, case.dimension - 1
    position = particles.position[particles.fluid]
    x, level = position[:, 0], position[:, up]
    # lenient by one spacing to the sides too, where the floor has a step
    y = position[:, 1]
    floor = np.minimum(floor_level(case, x - d0, y), floor_level(case, x + d0, y))
    sunk = level < floor - d0
    below = position < domain.lower
    beyond = position > domain.upper
    below[:, up] = sunk
    # beside a channel that opens to a plain, behind the head wall
    mouth, front, back = domain.mouth
    behind = (x < mouth) & ((position[:, 1] < front) | (position[:, 1] > back))
    gone = np.asarray((below | beyond).any(axis=1) | behind)
    if not gone.any():
        return
    aside = np.arange(3) != up
    outside = (below | beyond)[:, aside].any(axis=1) | behind
    through = (below & domain.closed[:, 0]) | (beyond & domain.closed[:, 1])
    through[:, aside] &= (level < domain.rim)[:, None]
    through[:, up] &= ~outside
    leaked = np.asarray(through.any(axis=1) | (behind & (level < domain.rim)))
    _remove(state, gone, leaked)


def remove_beyond_data(state: State, case: ResolvedCase) -> bool:
    """Remove what flows over cells of a terrain without a level; return whether there was any."""
    if not case.is_terrain:
        return False
    x, y, _ = state.particles.position[state.particles.fluid].T
    gone = ~ground_of(case).has_data(x, y)
    if gone.any():
        _remove(state, gone, np.zeros_like(gone))
    return bool(gone.any())


def remove_lost(state: State, lost: NDArray[np.bool_]) -> None:
    """Remove fluid particles that went through a wall and count them by phase."""
    _remove(state, lost, lost)


def _remove(state: State, gone: NDArray[np.bool_], leaked: NDArray[np.bool_]) -> None:
    particles = state.particles
    kind, fraction = particles.kind[particles.fluid], particles.sediment_fraction[particles.fluid]
    out = gone & ~leaked
    _note(state, np.flatnonzero(leaked))
    count_phases(kind[out], fraction[out], state.left, state.left_sediment)
    count_phases(kind[leaked], fraction[leaked], state.through_wall, state.through_wall_sediment)
    particles.keep(np.flatnonzero(~gone), particles.fluid_count)
    particles.fluid_count -= int(np.count_nonzero(gone))


def _note(state: State, rows: NDArray[np.int64]) -> None:
    """Note which particles go through a wall, and where."""
    p = state.particles
    for row in rows[: MOST_NOTED - len(state.escaped)]:
        speed = float(np.linalg.norm(p.velocity[row]))
        state.escaped.append(Escaped(int(p.id[row]), p.position[row].copy(), speed))
