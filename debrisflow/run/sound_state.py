"""Whether the numbers of a state can be those of a run: kernels trust them, and look no further."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.errors import OutputError
from debrisflow.particles.matter import leave_out_unasked
from debrisflow.particles.record import Kind, Particles, blank
from debrisflow.particles.state import State
from debrisflow.space.domain import domain

COUNTED = ("entered", "left", "through_wall", "released")
MARGIN = 1.0
"""Sizes of the domain by which particles may lie outside: what has left it is removed at once."""


def must_be_sound(state: State, case: ResolvedCase, start: State) -> None:
    """Refuse a state whose numbers no run of a case can have come to.

    A number of a kind or a wall that does not exist would be looked up beyond the end of an array,
    and a particle far away takes memory for all the space until there.

    Parameters
    ----------
    state : State
        Of the shapes that :func:`debrisflow.run.checkpoint.check_fits` demands.
    case : ResolvedCase
    start : State
        Of the case at its start.

    Raises
    ------
    OutputError
    """
    if wrong := [*_wrong_particles(state.particles, case, start.particles), *_wrong_numbers(state)]:
        raise OutputError(
            f"the checkpoint is none of a run: {', '.join(wrong)}; "
            "start the run again with: debrisflow run"
        )


def _wrong_particles(held: Particles, case: ResolvedCase, start: Particles) -> Iterator[str]:
    needed = blank(1)
    leave_out_unasked(needed, case)
    if short := [name for name in needed.arrays() if len(getattr(held, name)) != held.count]:
        yield from short
        return
    fluid, inflow, walls = held.fluid, held.inflow, held.kind[held.moving.stop :]
    kinds = held.kind
    if (
        not _among(kinds[fluid], Kind.LIQUID, Kind.MIXTURE)
        or not _among(kinds[inflow], Kind.INFLOW, Kind.INFLOW)
        or not _among(walls, Kind.WALL, Kind.DUMMY)
    ):
        yield "kind"
    if not _among(held.wall, -1, int(start.wall.max(initial=-1))):
        yield "wall"
    if np.any(held.density <= 0.0):
        yield "density"
    space = domain(case)
    repeats = space.period > 0.0
    lower = np.where(repeats, 0.0, space.lower)
    upper = np.where(repeats, space.period, space.upper)
    margin = MARGIN * float((upper - lower).max())
    if np.any(held.position < lower - margin) or np.any(held.position > upper + margin):
        yield "position"
    for name in ("velocity", "density", "sediment_fraction"):
        if not np.isfinite(getattr(held, name)).all():
            yield name


def _among(numbers: NDArray[np.integer], least: int, greatest: int) -> bool:
    return bool(np.all((numbers >= least) & (numbers <= greatest)))


def _wrong_numbers(state: State) -> Iterator[str]:
    """Yield the names of numbers that are not finite, and of counters that are negative."""
    for field in fields(state):
        value = getattr(state, field.name)
        is_count = isinstance(value, int) or field.name in COUNTED
        is_endless = isinstance(value, float) and not math.isfinite(value)
        if is_endless or (is_count and np.any(np.asarray(value) < 0)):
            yield field.name
