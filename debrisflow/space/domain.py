"""Tanks and channels: their walls by name, and the space that particles may occupy (NumPy only).

In two dimensions y is up, in three z.
"""

from __future__ import annotations

from math import floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, shapes
from debrisflow.case.regions import TOLERANCE, runout_rise
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import plain_of

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]
WALL_NAMES = ("floor", "bed", "left", "right", "ceiling", "front", "back")
FLOOR, BED, LEFT, RIGHT, CEILING, FRONT, BACK = range(len(WALL_NAMES))


def wall_names(case: ResolvedCase) -> tuple[str, ...]:
    """Return the names of walls, obstacles and zones, in the order of their numbers."""
    return (*WALL_NAMES, *(part.name for part in (*case.obstacle, *case.zone)))


def first_zone(case: ResolvedCase) -> int:
    """Return the number of the first zone of a terrain."""
    return len(WALL_NAMES) + len(case.obstacle)


def wall_layers(case: ResolvedCase) -> int:
    """Return the number of wall layers that the influence radius of a fluid particle can reach."""
    return int(case.particles.effective_radius) + 1


class Domain(NamedTuple):
    """The space that particles may occupy.

    Attributes
    ----------
    lower, upper : (3,) float64 array, m
        Corners of the box outside which a particle has left.
    period : (3,) float64 array, m
        Period along each axis; 0 where the domain does not repeat.
    rim : float
        Height of the side walls, m.
    closed : (3, 2) bool array
        Whether there is a wall at the lower and at the upper end of each axis.
    mouth : (3,) float64 array, m
        The x where a channel opens to a plain, before which a particle beside the channel has
        left, and the two y between which it has not; -inf and 0 without a plain.
    """

    lower: Floats
    upper: Floats
    period: Floats
    rim: float
    closed: NDArray[np.bool_]
    mouth: Floats


def domain(case: ResolvedCase) -> Domain:
    """Return the space that the particles of a case may occupy.

    A margin of one spacing outside the walls belongs to it: what is found beyond has passed a
    wall or its rim.
    """
    shape, d0 = case.geometry, case.particles.spacing
    closed = np.zeros((3, 2), dtype=bool)
    mouth = np.array([-np.inf, 0.0, 0.0])
    if isinstance(shape, shapes.Channel3D):
        length, width, plain = shape.length, shape.width, plain_of(shape)
        closed[0, 0] = not shape.periodic
        closed[1], closed[2, 0] = plain is None, True
        front, back = (plain.front, plain.back) if plain else (-d0, width + d0)
        lower = np.array([-d0, front, -shape.bed_thickness - d0])
        rise = runout_rise(shape, case.gravity) if plain else 0.0
        upper = np.array([length, back, shape.height + rise])
        period = np.array([length if shape.periodic else 0.0, 0.0, 0.0])
        if plain is not None:
            mouth = np.array([plain.start - d0, -d0, width + d0])
    elif isinstance(shape, ResolvedTerrain):
        closed[2, 0] = True
        period = np.zeros(3)
        lower = np.array([0.0, 0.0, -d0])
        upper = np.array([shape.length, shape.width, shape.height])
    elif isinstance(shape, shapes.Tank3D):
        closed[:] = True
        closed[1] = not shape.periodic
        closed[2, 1] = False
        period = np.array([0.0, shape.width if shape.periodic else 0.0, 0.0])
        lower = np.full(3, -d0)
        upper = np.array([shape.length + d0, shape.width + d0, 4.0 * shape.height])
    else:
        sides = not shape.periodic
        if isinstance(shape, shapes.Tank):
            length, lowest = shape.length, 0.0
            highest = shape.height + d0 if shape.ceiling else 4.0 * shape.height
            right = length + d0
            closed[:2] = (sides, sides), (True, shape.ceiling)
        else:
            length, lowest, highest = shape.length, -shape.bed_thickness, shape.height
            right = length
            closed[:2] = (sides, False), (True, False)
        lower = np.array([-d0, lowest - d0, -d0])
        upper = np.array([right, highest, d0])
        period = np.array([length if shape.periodic else 0.0, 0.0, 0.0])
    lower[period > 0.0], upper[period > 0.0] = -np.inf, np.inf
    return Domain(lower, upper, period, shape.height, closed, mouth)


def image_shifts(case: ResolvedCase) -> Floats:
    """Return where the images of a body stand beside it, (n, 3) array, m: 0, and by a period.

    0 alone in a space that does not repeat.
    """
    period = domain(case).period
    shifts = [np.zeros(3)]
    for axis in np.flatnonzero(period):
        shifts += [sign * period[axis] * np.eye(3)[axis] for sign in (-1.0, 1.0)]
    return np.array(shifts)


def cells_along(length: float, d0: float) -> int:
    """Return the number of cells of a length, m; halves are rounded up."""
    return floor(length / d0 + 0.5 + TOLERANCE)
