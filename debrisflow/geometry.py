"""Tanks and channels as lattice points: fills, inflow columns and layered walls (NumPy only).

Solids are drawn on a grid of cells as wide as the particle spacing, so that a wall surface lies
half a spacing outside the first layer of wall particles and half a spacing below the first row of
fluid.
"""

from __future__ import annotations

from math import cos, radians, sin, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]
WALL_NAMES = ("floor", "bed", "left", "right", "ceiling")
FLOOR, BED, LEFT, RIGHT, CEILING = range(len(WALL_NAMES))


def wall_layers(case: tables.Case) -> int:
    """Return the number of wall layers that the influence radius of a fluid particle can reach."""
    return int(case.particles.effective_radius) + 1


class WallPoints(NamedTuple):
    """Wall particles of one geometry.

    Attributes
    ----------
    position : (n, 3) float64 array, m
    layer : (n,) int array
        1 for the layer at the surface, which carries pressure; larger for dummies.
    name : (n,) int array
        Index into ``WALL_NAMES``.
    normal : (n, 3) float64 array
        Unit vector out of the wall at the nearest point of its surface.
    depth : (n,) float64 array, m
        Distance to that point.
    """

    position: Floats
    layer: NDArray[np.int64]
    name: NDArray[np.int64]
    normal: Floats
    depth: Floats


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
    closed : tuple of bool
        Whether there is a wall on the left, on the right and on top.
    """

    lower: Floats
    upper: Floats
    period: Floats
    rim: float
    closed: tuple[bool, bool, bool]


def domain(case: tables.Case) -> Domain:
    """Return the space that the particles of a case may occupy.

    A margin of one spacing outside the walls belongs to it: what is found beyond has passed a
    wall or its rim.
    """
    shape, d0 = case.geometry, case.particles.spacing
    sides = not shape.periodic
    if isinstance(shape, tables.Tank):
        length, lowest = shape.width, 0.0
        highest = shape.height + d0 if shape.ceiling else 4.0 * shape.height
        right, closed = length + d0, (sides, sides, shape.ceiling)
    else:
        length, lowest, highest = shape.length, -shape.bed_thickness, shape.height
        right, closed = length, (sides, False, False)
    lower = np.array([-d0, lowest - d0, -d0])
    upper = np.array([right, highest, d0])
    period = np.array([length if shape.periodic else 0.0, 0.0, 0.0])
    if shape.periodic:
        lower[0], upper[0] = -np.inf, np.inf
    return Domain(lower, upper, period, shape.height, closed)


def floor_level(case: tables.Case, x: Floats) -> Floats:
    """Return the level y of the fixed floor at x, the bottom of the recess under a bed, m.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> channel = tables.Channel(
    ...     type="channel", length=4.0, height=1.0, bed_start=1.0, bed_end=3.0, bed_thickness=0.2
    ... )
    >>> floor_level(Case(geometry=channel), np.array([0.5, 2.0, 3.5]))
    array([ 0. , -0.2,  0. ])
    """
    shape = case.geometry
    level = np.zeros_like(np.asarray(x, dtype=float))
    if isinstance(shape, tables.Channel) and shape.bed_end is not None:
        if shape.periodic:
            x = np.mod(x, shape.length)
        level[(x >= shape.bed_start) & (x < shape.bed_end)] = -shape.bed_thickness
        if not shape.periodic:
            level[x >= shape.bed_end] = shape.weir_height
        if shape.runout_start is not None:
            level += np.maximum(x - shape.runout_start, 0.0) * tan(runout_bend(case))
    return level


def runout_bend(case: tables.Case) -> float:
    """Return the angle by which the floor of a channel with a run-out bends up, rad."""
    assert isinstance(case.geometry, tables.Channel)
    return case.gravity.fall - radians(case.geometry.runout_slope)


def floor_bend(case: tables.Case, x: Floats) -> Floats:
    """Return the angle by which the floor at x rises above the x axis, rad."""
    shape, x = case.geometry, np.asarray(x, dtype=float)
    if isinstance(shape, tables.Tank) or shape.runout_start is None:
        return np.zeros_like(x)
    return np.where(x > shape.runout_start, runout_bend(case), 0.0)


def height_over_floor(case: tables.Case, x: Floats, y: Floats, at: Floats) -> Floats:
    """Return the heights of points over the floor that is under ``at``, along its normal, m."""
    bend = floor_bend(case, at)
    return (y - floor_level(case, at) - np.tan(bend) * (x - at)) * np.cos(bend)


def floor_roughness(case: tables.Case, x: Floats) -> Floats:
    """Return the roughness of the fixed floor at x, under a bed that of its recess, m.

    Infinite where the floor has none, so that no law of the wall acts.
    """
    shape, x = case.geometry, np.asarray(x, dtype=float)
    roughness = np.full_like(x, case.walls.floor.roughness)
    if isinstance(shape, tables.Channel):
        assert shape.bed_end is not None
        if shape.periodic:
            x = np.mod(x, shape.length)
        elif shape.weir_height > 0.0:
            roughness[x >= shape.bed_end] = case.walls.right.roughness
        if shape.bed_thickness > 0.0:
            in_bed = (x >= shape.bed_start) & (x < shape.bed_end)
            roughness[in_bed] = case.walls.bed.roughness
    return np.where(roughness > 0.0, roughness, np.inf)


def walls(case: tables.Case) -> WallPoints:
    """Return the wall particles of a case, every layer that the fluid can feel."""
    shape, d0, layers = case.geometry, case.particles.spacing, wall_layers(case)
    cells = _tank_cells(case) if isinstance(shape, tables.Tank) else _channel_cells(case)
    x, y, name, solid = cells
    layer, normal, depth = _distance_to_open(solid, layers, periodic=shape.periodic)
    i, j = np.nonzero(layer > 0)
    position = np.zeros((i.size, 3))
    position[:, 0], position[:, 1] = (x[i] + 0.5) * d0, (y[j] + 0.5) * d0
    points = WallPoints(position, layer[i, j], name[i, j], normal[i, j], depth[i, j] * d0)
    if isinstance(shape, tables.Channel) and shape.runout_start is not None:
        return _with_runout(points, shape, runout_bend(case), d0, layers)
    return points


def _with_runout(
    points: WallPoints, shape: tables.Channel, bend: float, d0: float, layers: int
) -> WallPoints:
    """Return the floor with the part beyond the bend as rows of points parallel to its surface.

    The rows of both parts meet on the plane that halves the angle between them.
    """
    assert shape.runout_start is not None
    miter = tan(0.5 * bend)
    x, y, _ = points.position.T
    kept = (y > 0.0) | (x < shape.runout_start - y * miter)
    parts = [WallPoints._make(field[kept] for field in points)]
    end = shape.length + 2 * layers * d0
    for layer in range(1, layers + 1):
        depth = (layer - 0.5) * d0
        along = np.arange(
            0.5 * d0 - depth * miter, (end - shape.runout_start - depth * sin(bend)) / cos(bend), d0
        )
        position = np.zeros((along.size, 3))
        position[:, 0] = shape.runout_start + along * cos(bend) + depth * sin(bend)
        position[:, 1] = along * sin(bend) - depth * cos(bend)
        parts.append(
            WallPoints(
                position,
                np.full(along.size, layer),
                np.full(along.size, FLOOR),
                np.tile([-sin(bend), cos(bend), 0.0], (along.size, 1)),
                np.full(along.size, depth),
            )
        )
    return WallPoints._make(np.concatenate(fields) for fields in zip(*parts, strict=True))


def fill(block: tables.Block | tables.Bed, case: tables.Case) -> Floats:
    """Return the lattice points inside a fill as (n, 3) positions, m."""
    d0 = case.particles.spacing
    if isinstance(block, tables.Block):
        x, y = block.x, block.y
    else:
        assert isinstance(case.geometry, tables.Channel)
        assert case.geometry.bed_end is not None
        x = (case.geometry.bed_start, case.geometry.bed_end)
        y = (-case.geometry.bed_thickness, 0.0)
    return _lattice(_cells(x[0], d0), _cells(x[1], d0), _cells(y[0], d0), _cells(y[1], d0), d0)


def inflow_rows(case: tables.Case) -> int:
    """Return the number of particles in a column of the supply."""
    assert case.inflow is not None
    return max(1, _cells(case.inflow.depth, case.particles.spacing))


def _cells(length: float, d0: float) -> int:
    return round(length / d0)


def _lattice(i0: int, i1: int, j0: int, j1: int, d0: float) -> Floats:
    x, y = np.meshgrid(np.arange(i0, i1) + 0.5, np.arange(j0, j1) + 0.5, indexing="ij")
    return np.column_stack([x.ravel() * d0, y.ravel() * d0, np.zeros(x.size)])


def _tank_cells(case: tables.Case) -> tuple[Cells, Cells, Cells, NDArray[np.bool_]]:
    shape, d0, layers = case.geometry, case.particles.spacing, wall_layers(case)
    assert isinstance(shape, tables.Tank)
    width, height = _cells(shape.width, d0), _cells(shape.height, d0)
    margin = 0 if shape.periodic else layers
    x = np.arange(-margin, width + margin)
    y = np.arange(-layers, height + (layers if shape.ceiling else 0))
    name = np.full((x.size, y.size), -1)
    name[x < 0] = LEFT
    name[x >= width] = RIGHT
    name[:, y < 0] = FLOOR
    name[:, y >= height] = CEILING
    return x, y, name, name >= 0


def _channel_cells(
    case: tables.Case,
) -> tuple[Cells, Cells, Cells, NDArray[np.bool_]]:
    shape, d0, layers = case.geometry, case.particles.spacing, wall_layers(case)
    assert isinstance(shape, tables.Channel)
    assert shape.bed_end is not None
    length, height, recess = (
        _cells(s, d0) for s in (shape.length, shape.height, shape.bed_thickness)
    )
    start, end = _cells(shape.bed_start, d0), _cells(shape.bed_end, d0)
    margin = 0 if shape.periodic else 2 * layers
    x = np.arange(-margin, length + margin)
    y = np.arange(-recess - layers, height)
    level = np.zeros(x.size, dtype=int)
    level[(x >= start) & (x < end)] = -recess
    if not shape.periodic:
        level[x >= end] = _cells(shape.weir_height, d0)
    solid = y[None, :] < level[:, None]
    name = np.where(solid, FLOOR, -1)
    if recess > 0:
        # beside the recess what is nearer to its step than to the floor belongs to the bed
        shifts = (-length, 0, length) if shape.periodic else (0,)
        aside = np.min(
            [np.maximum(np.maximum(start - x - s, x + s - end + 1), 0) for s in shifts], 0
        )
        below = -y[None, :] - (level[:, None] <= 0)
        name[solid & (aside[:, None] <= np.minimum(below, layers))] = BED
    if not shape.periodic:
        name[np.ix_(x >= end, y >= 0)] = np.where(solid[np.ix_(x >= end, y >= 0)], RIGHT, -1)
        # the supply comes through an opening in the wall, so that nothing flows back over it
        sill = 0 if case.inflow is None else inflow_rows(case)
        name[np.ix_(x < 0, y >= sill)] = LEFT
    return x, y, name, name >= 0


def _distance_to_open(
    solid: NDArray[np.bool_], layers: int, periodic: bool
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return layer, unit normal and depth (in cells) of solid cells near an open one.

    The surface of an open cell is its square, so that depth and normal are those of the nearest
    point of the wall surface; among equally near points the mean direction counts.
    """
    nx, ny = solid.shape
    reach = range(-layers, layers + 1)
    padded = np.pad(solid, layers, constant_values=True)
    if periodic:
        padded[:, layers:-layers] = np.pad(solid, ((layers, layers), (0, 0)), mode="wrap")
    layer = np.zeros(solid.shape, dtype=int)
    depth = np.full(solid.shape, np.inf)
    normal = np.zeros((nx, ny, 3))
    for a in reach:
        for b in reach:
            is_open = ~padded[layers + a : layers + a + nx, layers + b : layers + b + ny] & solid
            gap = np.array(
                [np.sign(a) * max(abs(a) - 0.5, 0), np.sign(b) * max(abs(b) - 0.5, 0), 0]
            )
            distance = float(np.hypot(gap[0], gap[1]))
            ring = max(abs(a), abs(b))
            layer[is_open & ((layer == 0) | (layer > ring))] = ring
            closer = is_open & (distance < depth - 1e-9)
            tied = is_open & ~closer & (distance < depth + 1e-9)
            depth[closer] = distance
            normal[closer] = gap
            normal[tied] += gap
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    return layer, np.divide(normal, length, where=length > 0, out=normal), depth
