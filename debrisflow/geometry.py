"""Tanks and channels: their space, their floor, and the lattice points of fills (NumPy only).

In two dimensions y is up, in three z.
"""

from __future__ import annotations

from math import radians, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import shapes, tables
from debrisflow.case.bodies import MeshFill
from debrisflow.case.regions import extent_across, recess, runout_rise, surface_of
from debrisflow.case.shapes import is_three_dimensional, plain_edges
from debrisflow.surface import cells_inside

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]
WALL_NAMES = ("floor", "bed", "left", "right", "ceiling", "front", "back")
FLOOR, BED, LEFT, RIGHT, CEILING, FRONT, BACK = range(len(WALL_NAMES))


def wall_names(case: tables.Case) -> tuple[str, ...]:
    """Return the names of walls and obstacles, in the order of their numbers."""
    return (*WALL_NAMES, *(obstacle.name for obstacle in case.obstacle))


def wall_layers(case: tables.Case) -> int:
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


def domain(case: tables.Case) -> Domain:
    """Return the space that the particles of a case may occupy.

    A margin of one spacing outside the walls belongs to it: what is found beyond has passed a
    wall or its rim.
    """
    shape, d0 = case.geometry, case.particles.spacing
    closed = np.zeros((3, 2), dtype=bool)
    mouth = np.array([-np.inf, 0.0, 0.0])
    if isinstance(shape, shapes.Channel3D):
        length, width, edges = shape.length, shape.width, plain_edges(shape)
        closed[0, 0] = not shape.periodic
        closed[1], closed[2, 0] = edges is None, True
        front, back = edges or (-d0, width + d0)
        lower = np.array([-d0, front, -shape.bed_thickness - d0])
        rise = runout_rise(shape, case.gravity) if edges else 0.0
        upper = np.array([length, back, shape.height + rise])
        period = np.array([length if shape.periodic else 0.0, 0.0, 0.0])
        if edges is not None:
            assert shape.runout_start is not None
            mouth = np.array([shape.runout_start - d0, -d0, width + d0])
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
            length, lowest = shape.width, 0.0
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


def floor_level(case: tables.Case, x: Floats) -> Floats:
    """Return the level y of the fixed floor at x, the bottom of the recess under a bed, m.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> channel = shapes.Channel(
    ...     type="channel", length=4.0, height=1.0, bed_start=1.0, bed_end=3.0, bed_thickness=0.2
    ... )
    >>> floor_level(Case(geometry=channel), np.array([0.5, 2.0, 3.5]))
    array([ 0. , -0.2,  0. ])
    """
    shape = case.geometry
    level = np.zeros_like(np.asarray(x, dtype=float))
    if isinstance(shape, shapes.ChannelShape) and shape.bed_end is not None:
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
    assert isinstance(case.geometry, shapes.ChannelShape)
    return case.gravity.fall - radians(case.geometry.runout_slope)


def floor_bend(case: tables.Case, x: Floats) -> Floats:
    """Return the angle by which the floor at x rises above the x axis, rad."""
    shape, x = case.geometry, np.asarray(x, dtype=float)
    if not isinstance(shape, shapes.ChannelShape) or shape.runout_start is None:
        return np.zeros_like(x)
    return np.where(x > shape.runout_start, runout_bend(case), 0.0)


def driving_gravity(case: tables.Case, x: Floats, normal: Floats) -> Floats:
    """Return the part of gravity that drives the flow along walls of a channel, (m, 3) m/s2.

    Neither across the wall nor across the floor at x, where pressure balances it.  0 in a tank, in
    which the fluid comes to rest.  In three dimensions.

    Parameters
    ----------
    case : Case
    x : (m,) float64 array, m
        Of particles of the walls.
    normal : (m, 3) float64 array
        Out of the walls.
    """
    if not isinstance(case.geometry, shapes.ChannelShape):
        return np.zeros_like(normal)
    bend = floor_bend(case, x)
    floor = np.column_stack([-np.sin(bend), np.zeros_like(bend), np.cos(bend)])
    rest = normal - np.sum(normal * floor, axis=1)[:, None] * floor
    size = np.linalg.norm(rest, axis=1)[:, None]
    other = np.divide(rest, size, out=np.zeros_like(rest), where=size > 1e-9)
    along, upward = case.gravity.components
    driving = np.tile([along, 0.0, upward], (len(normal), 1))
    for axis in (floor, other):
        driving -= np.sum(driving * axis, axis=1)[:, None] * axis
    return driving


def height_over_floor(case: tables.Case, x: Floats, y: Floats, at: Floats) -> Floats:
    """Return the heights of points over the floor that is under ``at``, along its normal, m."""
    bend = floor_bend(case, at)
    return (y - floor_level(case, at) - np.tan(bend) * (x - at)) * np.cos(bend)


def is_over_floor(case: tables.Case, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which places have the floor of the space under them; in two dimensions y is not used.

    Examples
    --------
    A channel 0.5 m wide that opens at x = 2 m to a plain three times as wide:

    >>> from types import SimpleNamespace as Case
    >>> flume = shapes.Channel3D(
    ...     type="channel3d", length=4.0, width=0.5, height=1.0, runout_start=2.0, runout_width=1.5
    ... )
    >>> is_over_floor(Case(geometry=flume), np.array([1.0, 1.0, 3.0]), np.array([0.2, 0.8, 0.8]))
    array([ True, False,  True])
    """
    shape = case.geometry
    length = shape.width if isinstance(shape, shapes.Tank) else shape.length
    repeats_along_x = shape.periodic and not isinstance(shape, shapes.Tank3D)
    over = np.full(np.shape(x), fill_value=True)
    if not repeats_along_x:
        over &= (x > 0.0) & (x < length)
    if not is_three_dimensional(shape):
        return over
    edges = plain_edges(shape)
    between = (y > 0.0) & (y < shape.width)
    if isinstance(shape, shapes.Channel3D) and edges is not None:
        assert shape.runout_start is not None
        between |= (x > shape.runout_start) & (y > edges[0]) & (y < edges[1])
    elif isinstance(shape, shapes.Tank3D) and shape.periodic:
        return over
    return np.asarray(over & between)


def floor_roughness(case: tables.Case, x: Floats) -> Floats:
    """Return the roughness of the fixed floor at x, under a bed that of its recess, m.

    Infinite where the floor has none, so that no law of the wall acts.
    """
    shape, x = case.geometry, np.asarray(x, dtype=float)
    roughness = np.full_like(x, case.walls.floor.roughness)
    if isinstance(shape, shapes.Channel):
        assert shape.bed_end is not None
        if shape.periodic:
            x = np.mod(x, shape.length)
        elif shape.weir_height > 0.0:
            roughness[x >= shape.bed_end] = case.walls.right.roughness
        if shape.bed_thickness > 0.0:
            in_bed = (x >= shape.bed_start) & (x < shape.bed_end)
            roughness[in_bed] = case.walls.bed.roughness
    return np.where(roughness > 0.0, roughness, np.inf)


def fill(block: tables.AnyFill, case: tables.Case) -> Floats:
    """Return the lattice points inside a fill as (n, 3) positions, m."""
    d0 = case.particles.spacing
    if isinstance(block, MeshFill):
        return (cells_inside(surface_of(block), d0).astype(float) + 0.5) * d0
    if isinstance(block, tables.Block):
        extents = [block.x, block.y, block.z][: case.dimension]
    else:
        hollow = recess(case.geometry, case.particles)
        assert hollow is not None
        extents = list(zip(hollow.lower, hollow.upper, strict=True))
    ends = [(cells_along(e[0], d0), cells_along(e[1], d0)) for e in extents if e is not None]
    axes = [np.arange(*end) + 0.5 for end in ends]
    position = np.zeros((int(np.prod([axis.size for axis in axes])), 3))
    for k, points in enumerate(np.meshgrid(*axes, indexing="ij")):
        position[:, k] = points.ravel() * d0
    return position


class Opening(NamedTuple):
    """The cells of the section through which the supply enters.

    Attributes
    ----------
    first : int
        First cell across the channel.
    wide, high : int
        Number of cells across, 1 in two dimensions, and upward.
    """

    first: int
    wide: int
    high: int


def inflow_section(case: tables.Case) -> Opening:
    """Return the section of the supply; it stands on the floor."""
    assert case.inflow is not None
    d0 = case.particles.spacing
    high = max(1, cells_along(case.inflow.depth, d0))
    if not isinstance(case.geometry, shapes.Channel3D):
        return Opening(0, 1, high)
    first, last = (cells_along(y, d0) for y in extent_across(case.inflow, case.geometry))
    return Opening(first, last - first, high)


def cells_along(length: float, d0: float) -> int:
    """Return the number of cells of a length, m."""
    return round(length / d0)
