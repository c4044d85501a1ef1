"""The particles of a case at its start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, tables
from debrisflow.particles.matter import leave_out_unasked, set_material, set_pore_pressure
from debrisflow.particles.record import Kind, Particles, blank
from debrisflow.particles.supply import first_columns
from debrisflow.space.carving import filled
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.walls import WallPoints, wall_points

Floats = NDArray[np.float64]


def seed(case: ResolvedCase) -> Particles:
    """Return the particles of a case at its start.

    Parameters
    ----------
    case : ResolvedCase
        A checked case with its defaults resolved.
    """
    rng = np.random.default_rng(case.particles.seed)
    groups = [
        _filled(block, places, case, rng)
        for block, places in zip(case.fill, filled(case), strict=True)
    ]
    fluid_count = sum(g.count for g in groups)
    columns = first_columns(case) if case.inflow is not None else []
    inflow_count = sum(column.count for column in columns)
    groups += columns
    particles = blank(0) if case.has_surfaces else wall_particles(case)
    wall_count = int(np.count_nonzero(particles.kind == Kind.WALL))
    for group in reversed(groups):
        particles.insert(0, group)
    leave_out_unasked(particles, case)
    particles.id = np.arange(particles.count)
    particles.fluid_count = fluid_count
    particles.inflow_count = inflow_count
    particles.wall_count = wall_count
    return particles


def _placed(position: Floats) -> Particles:
    particles = blank(position.shape[0])
    particles.position = position
    return particles


def _filled(
    block: tables.AnyFill, places: Floats, case: ResolvedCase, rng: np.random.Generator
) -> Particles:
    particles = _placed(places)
    if block.material == "two-phase":
        is_sediment = _evenly_mixed(
            particles.position / case.particles.spacing, block.sediment_share, rng
        )
        set_material(particles, np.flatnonzero(is_sediment), Kind.SEDIMENT, case)
        set_material(particles, np.flatnonzero(~is_sediment), Kind.LIQUID, case)
    else:
        kind = {"water": Kind.LIQUID, "sediment": Kind.SEDIMENT, "mixture": Kind.MIXTURE}
        set_material(particles, slice(None), kind[block.material], case)
    set_pore_pressure(particles, slice(None), block.pore_pressure, block.pore_pressure_time)
    if not isinstance(block, tables.Bed):
        particles.velocity[:, : len(block.velocity)] = block.velocity
    return particles


def _evenly_mixed(position: Floats, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return which particles of a two-phase fill are sediment.

    They are drawn at random, but evenly over squares of four.  Up to the end of each square there
    are as many as its share of the particles so far, rounded up or down at random.  Particles are
    much larger than grains, whose mixture is even at the size of a particle; phases drawn without
    this care leave loose and dense places in a bed, which then packs, gives off water, and slides
    on it.

    Parameters
    ----------
    position : (n, 3) array
        In spacings.
    share : float
    rng : Generator
    """
    across, up = (position[:, :2] // 2).T.astype(np.int64)
    # columns of squares up and down in turn, so that the next square is a neighbor
    order = np.lexsort((rng.random(len(position)), up * (-1) ** across, across))
    square = np.stack([across, up])[:, order]
    ends = np.flatnonzero(np.any(np.diff(square, axis=1, append=square[:, -1:] + 1), axis=0)) + 1
    rounding = rng.random(ends.size)
    rounding[-1] = 0.5
    due = np.floor(ends * share + rounding).astype(np.int64)
    is_sediment = np.zeros(len(position), dtype=bool)
    start, placed = 0, 0
    for end, until in zip(ends.tolist(), due.tolist(), strict=True):
        count = min(max(until - placed, 0), end - start)
        is_sediment[order[start : start + count]] = True
        start, placed = end, placed + count
    return is_sediment


def wall_particles(case: ResolvedCase) -> Particles:
    """Return the walls of a case drawn by particles, those of the first layer first."""
    points = wall_points(case)
    order = np.argsort(points.layer > 1, kind="stable")
    points = WallPoints._make(field[order] for field in points)
    particles = _placed(points.position)
    particles.kind[:] = np.where(points.layer == 1, Kind.WALL, Kind.DUMMY)
    particles.density[:] = case.water.density
    particles.wall[:] = points.name
    particles.wall_normal[:] = points.normal
    particles.wall_depth[:] = points.depth
    for index, name in enumerate(WALL_NAMES):
        particles.velocity[points.name == index, :2] = getattr(case.walls, name).velocity
    return particles
