"""When and where something happened, as a person is told it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.floor import floor_level
from debrisflow.space.scene import faces_of, trajectories

Floats = NDArray[np.float64]


def moment(state: State) -> str:
    """Return time and step of a state.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> moment(SimpleNamespace(time=0.25, step=100))
    'at t = 0.25 s, step 100'
    """
    return f"at t = {state.time:g} s, step {state.step}"


def place_of(case: ResolvedCase, position: Floats) -> str:
    """Return a place in words: its coordinates, on a terrain those of the map.

    Parameters
    ----------
    case : ResolvedCase
    position : (3,) float64 array, m

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> place_of(Case(is_terrain=False, dimension=2), np.array([0.25, 1.0 / 3.0, 0.0]))
    'x = 0.25, y = 0.33333 m'
    >>> alps = Case(is_terrain=True, terrain=Case(origin=(2600000.0, 1200000.0, 1500.0)))
    >>> place_of(alps, np.array([10.5, 20.0, 3.0]))
    'easting 2600010.50, northing 1200020.00, level 1503.00 m'
    """
    if case.is_terrain:
        east, north, level = np.asarray(position) + np.array(case.terrain.origin)
        return f"easting {east:.2f}, northing {north:.2f}, level {level:.2f} m"
    named = zip("xyz", position[: case.dimension], strict=False)
    return ", ".join(f"{axis} = {value:.5g}" for axis, value in named) + " m"


def named_particle(case: ResolvedCase, state: State, row: int) -> str:
    """Return which particle stands in a row, and where it is."""
    p = state.particles
    return f"particle {p.id[row]} at {place_of(case, p.position[row])}"


def wall_passed(case: ResolvedCase, position: Floats, time: float) -> str:
    """Return which wall a particle went through that was found at a place at a time, s.

    Parameters
    ----------
    case : ResolvedCase
    position : (3,) float64 array, m
    time : float, s
    """
    d0, up, space = case.particles.spacing, case.dimension - 1, domain(case)
    ways = trajectories(case)
    for number, part in enumerate(case.obstacle, start=len(WALL_NAMES)):
        corners = faces_of(part).reshape(-1, 3)
        if number in ways:
            corners = ways[number].pose(time).moved(corners)
        low, high = corners.min(axis=0) - d0, corners.max(axis=0) + d0
        axes = slice(0, case.dimension)
        if np.all((position >= low)[axes] & (position <= high)[axes]):
            return f"obstacle {part.name}"
    if position[up] < floor_level(case, position[:1], position[1:2])[0]:
        return "the ground" if case.is_terrain else "the floor"
    ends = zip(("left", "front", "floor"), ("right", "back", "ceiling"), strict=True)
    for axis, (first, last) in enumerate(ends):
        if case.dimension == 2 and axis == 1:
            first, last = "floor", "ceiling"
        if position[axis] < space.lower[axis] + d0:
            return f"wall {first}"
        if position[axis] > space.upper[axis] - d0:
            return f"wall {last}"
    return "a wall"
