"""Walls as boxes that touch but do not overlap (NumPy only)."""

from __future__ import annotations

from math import cos, inf, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, shapes
from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.regions import surface_of
from debrisflow.case.resolved import (
    ResolvedChannel,
    ResolvedChannel3D,
    ResolvedChannelShape,
    ResolvedTerrain,
)
from debrisflow.case.shapes import plain_of, runout_of
from debrisflow.case.triangles import cells_inside
from debrisflow.space.domain import (
    BACK,
    BED,
    CEILING,
    FLOOR,
    FRONT,
    LEFT,
    RIGHT,
    WALL_NAMES,
    image_shifts,
)
from debrisflow.space.fills import inflow_section
from debrisflow.space.floor import runout_bend

Floats = NDArray[np.float64]
Ends = tuple[float, float]
ALL = (-inf, inf)
FEWEST_BEFORE_BEND = 4.0  # spacings, more than any reach, that a run-out goes on under the floor
TOUCHING = 1e-6  # spacings


class Body(NamedTuple):
    """A box of wall.

    Attributes
    ----------
    x, y, z : (float, float), m
        Its ends along its axes, measured from the origin.
    number : int
        Of the wall that it belongs to, or of its upper face.
    sides : int or None
        That of its other faces, where it is another.
    origin : (3,) sequence of float, m
    turn : float, rad
        By which its x axis rises above that of the space.
    up : int
        The axis that leads upward: z, or y in two dimensions.
    is_floor : bool
        See :class:`debrisflow.neighbors.boxes.Boxes`.
    """

    x: Ends
    y: Ends
    z: Ends
    number: int
    sides: int | None = None
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    turn: float = 0.0
    up: int = 2
    is_floor: bool = False

    @property
    def axes(self) -> Floats:
        """Unit vectors along the box, (3, 3), by rows."""
        along, rise = cos(self.turn), sin(self.turn)
        axes = np.eye(3)
        axes[0, 0], axes[0, self.up] = along, rise
        axes[self.up, 0], axes[self.up, self.up] = -rise, along
        return axes

    def holds(self, places: Floats, slack: float = 0.0) -> NDArray[np.bool_]:
        """Return which places, (n, 3) array, m, lie in the box or within a slack, m, of it."""
        own = (places - np.array(self.origin)) @ self.axes.T
        lower, upper = np.array([self.x, self.y, self.z]).T
        inside: NDArray[np.bool_] = np.all((own >= lower - slack) & (own <= upper + slack), axis=1)
        return inside


def in_walls(case: ResolvedCase, places: Floats, slack: float = 0.0) -> NDArray[np.bool_]:
    """Return which places, (n, 3) array, m, lie in a wall or obstacle; meshes by their cells.

    Or within a slack, m, of a box.
    """
    inside = np.zeros(len(places), dtype=bool)
    for body in bodies_of(case):
        inside |= body.holds(places, slack)
    d0 = case.particles.spacing
    cell = np.floor(places / d0).astype(np.int64)
    for obstacle in case.obstacle:
        if isinstance(obstacle, MeshObstacle):
            inside |= are_among(cell, cells_inside(surface_of(obstacle), d0))
    return inside


def bodies_of(case: ResolvedCase) -> list[Body]:
    """Return the walls and box obstacles of a case.

    A terrain has no walls but its ground, and boxes on it are cut into elements as meshes are.
    """
    shape = case.geometry
    if isinstance(shape, ResolvedTerrain):
        return []
    if isinstance(shape, ResolvedChannel3D):
        bodies = _channel(shape, case)
    elif isinstance(shape, ResolvedChannel):
        bodies = [*_section_of_channel(shape, ALL, case), *_around_supply(shape, ALL, case)]
    elif isinstance(shape, shapes.Tank3D):
        bodies = _tank(shape)
    else:
        bodies = _section_of_tank(shape)
    if case.dimension == 2:
        # the section of the walls of three dimensions, of which z is the y of two
        bodies = [body._replace(y=body.z, z=ALL, up=1) for body in bodies]
    return [*bodies, *_obstacles(case)]


def _tank(shape: shapes.Tank3D) -> list[Body]:
    high = (0.0, shape.height)
    bodies = [
        Body(ALL, ALL, (-inf, 0.0), FLOOR),
        Body((-inf, 0.0), ALL, high, LEFT),
        Body((shape.length, inf), ALL, high, RIGHT),
    ]
    if not shape.periodic:
        along = (0.0, shape.length)
        bodies += [
            Body(along, (-inf, 0.0), high, FRONT),
            Body(along, (shape.width, inf), high, BACK),
        ]
    return bodies


def _section_of_tank(shape: shapes.Tank) -> list[Body]:
    high = (0.0, shape.height)
    bodies = [Body(ALL, ALL, (-inf, 0.0), FLOOR)]
    if not shape.periodic:
        bodies.append(Body((-inf, 0.0), ALL, high, LEFT))
        bodies.append(Body((shape.length, inf), ALL, high, RIGHT))
    if shape.ceiling:
        bodies.append(Body(ALL, ALL, (shape.height, inf), CEILING))
    return bodies


def _channel(shape: ResolvedChannel3D, case: ResolvedCase) -> list[Body]:
    """Return floor, recess, weir, side walls and the wall around the supply of a channel.

    Between walls the floor ends at these, which reach down beside it; on a plain the walls stand on
    it.
    """
    plain, within = plain_of(shape), (0.0, shape.width)
    bodies = _section_of_channel(shape, within if plain is None else ALL, case)
    if plain is not None and shape.bed_thickness > 0.0:
        bodies += [
            Body(recess, aside, (-inf, 0.0), wall)
            for recess in _recesses(shape)
            for aside, wall in (((-inf, 0.0), FRONT), ((shape.width, inf), BACK))
        ]
    sides = ALL if plain is None else (-inf, plain.start)
    high = (-inf if plain is None else 0.0, shape.height)
    bodies += [
        Body(sides, (-inf, 0.0), high, FRONT),
        Body(sides, (shape.width, inf), high, BACK),
    ]
    return bodies + _around_supply(shape, within, case)


def _section_of_channel(
    shape: ResolvedChannelShape, across: Ends, case: ResolvedCase
) -> list[Body]:
    """Return the floor of a channel, its run-out and its weir."""
    runout, down = runout_of(shape), (-inf, 0.0)
    bodies = _floor(shape, across)
    if runout is not None:
        # under the last of the floor before the bend too, but not under the recess
        before = -min(FEWEST_BEFORE_BEND * case.particles.spacing, runout.start - shape.bed_end)
        rising, origin = runout_bend(case), (runout.start, 0.0, 0.0)
        if shape.bed_thickness == 0.0:
            before = -inf
        bodies.append(
            Body((before, inf), across, down, FLOOR, origin=origin, turn=rising, is_floor=True)
        )
    if not shape.periodic and shape.weir_height > 0.0:
        bodies.append(Body((shape.bed_end, inf), across, (0.0, shape.weir_height), RIGHT))
    return bodies


def _recesses(shape: ResolvedChannelShape) -> list[Ends]:
    """Return where along a channel its recess lies, with the images of one that repeats."""
    shifts = (-shape.length, 0.0, shape.length) if shape.periodic else (0.0,)
    return [(shape.bed_start + shift, shape.bed_end + shift) for shift in shifts]


def _floor(shape: ResolvedChannelShape, across: Ends) -> list[Body]:
    """Return the floor of a channel, with the recess under its bed."""
    deep, start, end = -shape.bed_thickness, shape.bed_start, shape.bed_end
    down = (-inf, 0.0)
    if deep == 0.0:
        return [Body(ALL, across, down, FLOOR, is_floor=True)]
    inside = (0.0, shape.width) if isinstance(shape, ResolvedChannel3D) else ALL
    bodies = [Body(recess, inside, (-inf, deep), BED) for recess in _recesses(shape)]
    lands = [(-inf, start), (end, inf)]
    if shape.periodic:
        lands = [(end + (k - 1) * shape.length, start + k * shape.length) for k in (0, 1)]
    bodies += [
        Body(land, across, down, FLOOR, sides=BED, is_floor=land[1] == inf)
        for land in lands
        if land[0] < land[1]
    ]
    return bodies


def _around_supply(shape: ResolvedChannelShape, across: Ends, case: ResolvedCase) -> list[Body]:
    """Return the wall at x = 0, with the opening of the supply in it, if there is one."""
    if shape.periodic:
        return []
    d0, opening = case.particles.spacing, inflow_section(case)
    before, top = (-inf, 0.0), opening.high * d0
    bodies = [Body(before, across, (top, shape.height), LEFT)]
    if across == ALL:
        return bodies
    for aside in (
        (across[0], opening.first * d0),
        ((opening.first + opening.wide) * d0, across[1]),
    ):
        if top > 0.0 and aside[1] - aside[0] > TOUCHING * d0:
            bodies.append(Body(before, aside, (0.0, top), LEFT))
    return bodies


def _obstacles(case: ResolvedCase) -> list[Body]:
    """Return the box obstacles, with their images in a domain that repeats."""
    bodies = []
    for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if not isinstance(obstacle, BoxObstacle):
            continue
        bodies += [
            Body(
                obstacle.x,
                obstacle.y,
                obstacle.z or ALL,
                number,
                origin=tuple(shift.tolist()),
                up=case.dimension - 1,
            )
            for shift in image_shifts(case)
        ]
    return bodies


def are_among(cells: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which of the (n, 3) cells stand among the (m, 3) others."""
    every = np.concatenate([cells, others])
    every -= every.min(axis=0)
    sides = every.max(axis=0) + 1
    keys = (every[:, 0] * sides[1] + every[:, 1]) * sides[2] + every[:, 2]
    found: NDArray[np.bool_] = np.isin(keys[: len(cells)], keys[len(cells) :])
    return found
