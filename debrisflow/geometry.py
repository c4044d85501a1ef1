"""Tanks and channels as lattice points: fills, inflow columns and layered walls (NumPy only).

In two dimensions y is up, in three z.

Solids are drawn on a grid of cells as wide as the particle spacing, so that a wall surface lies
half a spacing outside the first layer of wall particles and half a spacing below the first row of
fluid.  What a mesh encloses is drawn by the centers of cells, but felt by the true surface.
"""

from __future__ import annotations

from itertools import product
from math import cos, radians, sin, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.case.bodies import MeshFill, MeshObstacle
from debrisflow.case.regions import MESH_SLACK, surface_of
from debrisflow.surface import Surface, cells_inside, nearest_points

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


class WallPoints(NamedTuple):
    """Wall particles of one geometry.

    Attributes
    ----------
    position : (n, 3) float64 array, m
    layer : (n,) int array
        1 for the layer at the surface, which carries pressure; larger for dummies.
    name : (n,) int array
        Index into :func:`wall_names`.
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
    closed : (3, 2) bool array
        Whether there is a wall at the lower and at the upper end of each axis.
    """

    lower: Floats
    upper: Floats
    period: Floats
    rim: float
    closed: NDArray[np.bool_]


def domain(case: tables.Case) -> Domain:
    """Return the space that the particles of a case may occupy.

    A margin of one spacing outside the walls belongs to it: what is found beyond has passed a
    wall or its rim.
    """
    shape, d0 = case.geometry, case.particles.spacing
    closed = np.zeros((3, 2), dtype=bool)
    if isinstance(shape, tables.Tank3D):
        closed[:] = True
        closed[1] = not shape.periodic
        closed[2, 1] = False
        period = np.array([0.0, shape.width if shape.periodic else 0.0, 0.0])
        lower = np.full(3, -d0)
        upper = np.array([shape.length + d0, shape.width + d0, 4.0 * shape.height])
    else:
        sides = not shape.periodic
        if isinstance(shape, tables.Tank):
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
    if not isinstance(shape, tables.Channel) or shape.runout_start is None:
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
    build = {"tank": _tank_cells, "channel": _channel_cells, "tank3d": _tank3d_cells}[shape.type]
    axes, name = build(case)
    periodic_axis = None
    if shape.periodic:
        periodic_axis = 1 if isinstance(shape, tables.Tank3D) else 0
    cells, layer, normal, depth = _distance_to_open(name >= 0, layers, periodic_axis)
    position = np.zeros((layer.size, 3))
    for axis, (start, cell) in enumerate(zip(axes, cells, strict=True)):
        position[:, axis] = (start + cell + 0.5) * d0
    points = WallPoints(position, layer, name[cells], normal, depth * d0)
    for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if isinstance(obstacle, MeshObstacle):
            points = _felt_by_surface(points, points.name == number, obstacle, case)
    if isinstance(shape, tables.Channel) and shape.runout_start is not None:
        return _with_runout(points, shape, runout_bend(case), d0, layers)
    return points


def _felt_by_surface(
    points: WallPoints, own: NDArray[np.bool_], mesh: MeshObstacle, case: tables.Case
) -> WallPoints:
    """Return wall points of which those of a mesh have normal and depth of its triangles.

    The staircase of cells has normals along the axes only, whereas the nearest point of a slanted
    face lies along its normal.  Faces in the plane of a wall are left out, as the base of a body
    that stands on the floor: no fluid comes there.  A point on the
    surface itself takes the normal of its triangle, on the side of the staircase's.
    """
    shown = _faces_in_space(surface_of(mesh), case)
    rows = np.flatnonzero(own)
    if not (rows.size and len(shown.corners)):
        return points
    nearest, flat = nearest_points(shown, points.position[rows])
    outward = nearest - points.position[rows]
    depth = np.linalg.norm(outward, axis=1)
    clear = depth > MESH_SLACK * case.particles.spacing
    side = np.sum(flat * points.normal[rows], axis=1, keepdims=True)
    toward = np.where(side < 0.0, -flat, flat)
    toward[clear] = outward[clear] / depth[clear, None]
    normal, depths = points.normal.copy(), points.depth.copy()
    normal[rows], depths[rows] = toward, depth
    return points._replace(normal=normal, depth=depths)


def _faces_in_space(surface: Surface, case: tables.Case) -> Surface:
    """Return the triangles that do not lie in a side or the floor of the tank, walled or not."""
    shape, slack = case.geometry, MESH_SLACK * case.particles.spacing
    assert isinstance(shape, tables.Tank3D)
    ends = np.array([[0.0, shape.length], [0.0, shape.width], [0.0, shape.height]])
    hidden = np.zeros(len(surface.corners), dtype=bool)
    for axis, end in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 0)):
        away = np.abs(surface.corners[:, :, axis] - ends[axis, end])
        hidden |= np.all(away < slack, axis=1)
    return Surface(surface.corners[~hidden])


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


def fill(block: tables.AnyFill, case: tables.Case) -> Floats:
    """Return the lattice points inside a fill as (n, 3) positions, m."""
    d0 = case.particles.spacing
    if isinstance(block, MeshFill):
        return (cells_inside(surface_of(block), d0).astype(float) + 0.5) * d0
    if isinstance(block, tables.Block):
        extents = [block.x, block.y, block.z][: case.dimension]
    else:
        assert isinstance(case.geometry, tables.Channel)
        assert case.geometry.bed_end is not None
        extents = [
            (case.geometry.bed_start, case.geometry.bed_end),
            (-case.geometry.bed_thickness, 0.0),
        ]
    axes = [np.arange(_cells(e[0], d0), _cells(e[1], d0)) + 0.5 for e in extents if e is not None]
    position = np.zeros((int(np.prod([axis.size for axis in axes])), 3))
    for k, points in enumerate(np.meshgrid(*axes, indexing="ij")):
        position[:, k] = points.ravel() * d0
    return position


def inflow_rows(case: tables.Case) -> int:
    """Return the number of particles in a column of the supply."""
    assert case.inflow is not None
    return max(1, _cells(case.inflow.depth, case.particles.spacing))


def _cells(length: float, d0: float) -> int:
    return round(length / d0)


def _tank_cells(case: tables.Case) -> tuple[tuple[int, ...], Cells]:
    """Return the first cell along each axis, and the number of the wall in every cell or -1."""
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
    return (x[0], y[0]), name


def _tank3d_cells(case: tables.Case) -> tuple[tuple[int, ...], Cells]:
    shape, d0, layers = case.geometry, case.particles.spacing, wall_layers(case)
    assert isinstance(shape, tables.Tank3D)
    length, width, height = (_cells(s, d0) for s in (shape.length, shape.width, shape.height))
    margin = 0 if shape.periodic else layers
    x = np.arange(-layers, length + layers)
    y = np.arange(-margin, width + margin)
    z = np.arange(-layers, height)
    name = np.full((x.size, y.size, z.size), -1)
    name[:, y < 0] = FRONT
    name[:, y >= width] = BACK
    name[x < 0] = LEFT
    name[x >= length] = RIGHT
    name[:, :, z < 0] = FLOOR
    for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if isinstance(obstacle, MeshObstacle):
            name[tuple((cells_inside(surface_of(obstacle), d0) - (x[0], y[0], z[0])).T)] = number
            continue
        inside = [
            (axis >= _cells(extent[0], d0)) & (axis < _cells(extent[1], d0))
            for axis, extent in zip((x, y, z), (obstacle.x, obstacle.y, obstacle.z), strict=True)
        ]
        name[np.ix_(*inside)] = number
    return (x[0], y[0], z[0]), name


def _channel_cells(case: tables.Case) -> tuple[tuple[int, ...], Cells]:
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
    return (x[0], y[0]), name


def _distance_to_open(
    solid: NDArray[np.bool_], layers: int, periodic_axis: int | None
) -> tuple[tuple[Cells, ...], Cells, Floats, Floats]:
    """Return the solid cells near an open one: cells, layer, unit normal and depth (in cells).

    The surface of an open cell is its square or cube, so that depth and normal are those of the
    nearest point of the wall surface; among equally near points the mean direction counts.
    """
    padded = np.pad(solid, layers, constant_values=True)
    if solid.ndim == 3:
        padded[:, :, -layers:] = False  # rims and obstacles as high as the tank carry what lands
    if periodic_axis is not None:
        own = [slice(None) if k == periodic_axis else slice(layers, -layers) for k in range(2)]
        own += [slice(layers, -layers)] * (solid.ndim - 2)
        ends = [(layers, layers) if k == periodic_axis else (0, 0) for k in range(solid.ndim)]
        padded[tuple(own)] = np.pad(solid, ends, mode="wrap")
    cells = np.nonzero(solid & _near_open(padded, layers))
    layer = np.zeros(cells[0].size, dtype=np.int64)
    depth = np.full(layer.size, np.inf)
    normal = np.zeros((layer.size, 3))
    for shift in product(range(-layers, layers + 1), repeat=solid.ndim):
        moved = tuple(cell + layers + step for cell, step in zip(cells, shift, strict=True))
        is_open = ~padded[moved]
        gap = np.zeros(3)
        gap[: solid.ndim] = [np.sign(step) * max(abs(step) - 0.5, 0.0) for step in shift]
        distance = float(np.sqrt(gap @ gap))
        ring = max(map(abs, shift))
        layer[is_open & ((layer == 0) | (layer > ring))] = ring
        closer = is_open & (distance < depth - 1e-9)
        tied = is_open & ~closer & (distance < depth + 1e-9)
        depth[closer] = distance
        normal[closer] = gap
        normal[tied] += gap
    near = layer > 0
    length = np.linalg.norm(normal[near], axis=1, keepdims=True)
    direction = np.divide(normal[near], length, where=length > 0, out=normal[near])
    return tuple(cell[near] for cell in cells), layer[near], direction, depth[near]


def _near_open(padded: NDArray[np.bool_], layers: int) -> NDArray[np.bool_]:
    """Return which cells within the padding have an open cell at most some layers away.

    Axis by axis, so that the inside of a large obstacle costs little.
    """
    near = ~padded
    for axis in range(near.ndim):
        size = near.shape[axis] - 2 * layers
        shifted = [near.take(range(k, k + size), axis) for k in range(2 * layers + 1)]
        near = np.logical_or.reduce(shifted)
    return near
