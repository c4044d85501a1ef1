"""Layered walls as lattice points (NumPy only).

In two dimensions y is up, in three z.

Solids are drawn on a grid of cells as wide as the particle spacing, so that a wall surface lies
half a spacing outside the first layer of wall particles and half a spacing below the first row of
fluid.  What a mesh encloses is drawn by the centers of cells, but felt by the true surface.
"""

from __future__ import annotations

from itertools import product
from math import ceil, cos, floor, sin, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import shapes
from debrisflow.case.bodies import BoxObstacle, MeshObstacle, PolygonObstacle
from debrisflow.case.regions import MESH_SLACK, surface_of
from debrisflow.case.resolved import (
    ResolvedCase,
    ResolvedChannel,
    ResolvedChannel3D,
    ResolvedChannelShape,
)
from debrisflow.case.shapes import Channel3D, Plain, Runout, Tank3D, plain_of, runout_of
from debrisflow.case.triangles import Surface, cells_inside, nearest_points
from debrisflow.space.domain import (
    BACK,
    BED,
    CEILING,
    FLOOR,
    FRONT,
    LEFT,
    RIGHT,
    WALL_NAMES,
    cells_along,
    wall_layers,
)
from debrisflow.space.fills import inflow_section
from debrisflow.space.floor import height_over_floor, runout_bend
from debrisflow.space.polygons import rows_of

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]


class WallPoints(NamedTuple):
    """Wall particles of one geometry.

    Attributes
    ----------
    position : (n, 3) float64 array, m
    layer : (n,) int array
        1 for the layer at the surface, which carries pressure; larger for dummies.
    name : (n,) int array
        Index into :func:`debrisflow.space.domain.wall_names`.
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


def wall_points(case: ResolvedCase) -> WallPoints:
    """Return the wall particles of a case, every layer that the fluid can feel."""
    shape, d0, layers = case.geometry, case.particles.spacing, wall_layers(case)
    points = _points_of_cells(*_cells_of(case), case)
    plain, runout = plain_of(shape), runout_of(shape)
    if plain is not None and isinstance(shape, ResolvedChannel3D):
        # both drawings reach beyond the border as far as the layers see
        border = (cells_along(plain.start, d0) - layers) * d0
        mouth = _points_of_cells(*_mouth_cells(shape, plain, case), case)
        points = _joined(
            _chosen(points, points.position[:, 0] < border),
            _chosen(mouth, mouth.position[:, 0] > border),
        )
    for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if isinstance(obstacle, MeshObstacle) and isinstance(shape, Tank3D | Channel3D):
            points = _felt_by_surface(points, points.name == number, obstacle, shape, case)
    if runout is not None and isinstance(shape, shapes.ChannelShape):
        points = _with_runout(points, shape, runout, case)
    polygons = [
        _points_of_polygon(obstacle, number, case)
        for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES))
        if isinstance(obstacle, PolygonObstacle)
    ]
    return _joined(points, *polygons)


def _points_of_polygon(part: PolygonObstacle, number: int, case: ResolvedCase) -> WallPoints:
    """Return wall particles in rows along the sides of a polygon, a spacing apart or nearly so."""
    d0, found = case.particles.spacing, []
    for layer, row in enumerate(rows_of(part, case), start=1):
        for start, end in row:
            along, length = end - start, float(np.hypot(*(end - start)))
            count = max(1, round(length / d0))
            position, normal = np.zeros((2, count, 3))
            position[:, :2] = start + (np.arange(count)[:, None] + 0.5) / count * along
            normal[:, :2] = np.array([along[1], -along[0]]) / length
            layers, depth = np.full(count, layer), np.full(count, (layer - 0.5) * d0)
            found.append(WallPoints(position, layers, np.full(count, number), normal, depth))
    return _joined(*found)


def _cells_of(case: ResolvedCase) -> tuple[tuple[int, ...], Cells]:
    """Return the first cell along each axis, and the number of the wall in every cell or -1."""
    shape = case.geometry
    if isinstance(shape, shapes.Tank):
        return _tank_cells(shape, case)
    if isinstance(shape, shapes.Tank3D):
        return _tank3d_cells(shape, case)
    if isinstance(shape, shapes.Channel):
        return _channel_cells(shape, case)
    if isinstance(shape, ResolvedChannel3D):
        return _channel3d_cells(shape, case)
    raise TypeError("the ground of a terrain is not drawn by particles")


def _points_of_cells(start: tuple[int, ...], name: Cells, case: ResolvedCase) -> WallPoints:
    """Return the wall particles among cells, of which the first and the walls' number are given."""
    d0, periodic_axis = case.particles.spacing, None
    if case.geometry.periodic:
        periodic_axis = 1 if isinstance(case.geometry, shapes.Tank3D) else 0
    cells, layer, normal, depth = _distance_to_open(name >= 0, wall_layers(case), periodic_axis)
    position = np.zeros((layer.size, 3))
    for axis, (first, cell) in enumerate(zip(start, cells, strict=True)):
        position[:, axis] = (first + cell + 0.5) * d0
    return WallPoints(position, layer, name[cells], normal, depth * d0)


def _chosen(points: WallPoints, rows: NDArray[np.bool_]) -> WallPoints:
    return WallPoints._make(field[rows] for field in points)


def _joined(*parts: WallPoints) -> WallPoints:
    return WallPoints._make(np.concatenate(fields) for fields in zip(*parts, strict=True))


def _felt_by_surface(
    points: WallPoints,
    own: NDArray[np.bool_],
    mesh: MeshObstacle,
    shape: shapes.Tank3D | shapes.Channel3D,
    case: ResolvedCase,
) -> WallPoints:
    """Return wall points of which those of a mesh have normal and depth of its triangles.

    The staircase of cells has normals along the axes only, whereas the nearest point of a slanted
    face lies along its normal.  Faces in the plane of a wall are left out, as the base of a body
    that stands on the floor: no fluid comes there.  A point on the
    surface itself takes the normal of its triangle, on the side of the staircase's.
    """
    shown = _faces_in_space(surface_of(mesh), shape, case)
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


def _faces_in_space(
    surface: Surface, shape: shapes.Tank3D | shapes.Channel3D, case: ResolvedCase
) -> Surface:
    """Return the triangles that do not lie in a side or the floor of the space, walled or not."""
    slack = MESH_SLACK * case.particles.spacing
    ends = np.array([[0.0, shape.length], [0.0, shape.width], [0.0, shape.height]])
    hidden = np.zeros(len(surface.corners), dtype=bool)
    for axis, end in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 0)):
        away = np.abs(surface.corners[:, :, axis] - ends[axis, end])
        hidden |= np.all(away < slack, axis=1)
    return Surface(surface.corners[~hidden])


def _with_runout(
    points: WallPoints, shape: shapes.ChannelShape, runout: Runout, case: ResolvedCase
) -> WallPoints:
    """Return the floor with the part beyond the bend as rows of points parallel to its surface.

    The rows of both parts meet on the plane that halves the angle between them.  In three
    dimensions they repeat across the channel, whose side walls stay cells, or across its plain.
    """
    bend, start, up = runout_bend(case), runout.start, case.dimension - 1
    layers, d0 = wall_layers(case), case.particles.spacing
    miter = tan(0.5 * bend)
    x, level = points.position[:, 0], points.position[:, up]
    kept = (level > 0.0) | (x < start - level * miter)
    across: Floats = np.zeros(1)
    if isinstance(shape, shapes.Channel3D):
        first, last = _cells_across(shape, case)
        across = (np.arange(first, last, dtype=float) + 0.5) * d0
        if plain_of(shape) is None:
            points, kept = _beside_runout(points, kept, shape, start, case)
    parts = [_chosen(points, kept)]
    end = shape.length + 2 * layers * d0
    for layer in range(1, layers + 1):
        depth = (layer - 0.5) * d0
        along = np.arange(
            0.5 * d0 - depth * miter, (end - start - depth * sin(bend)) / cos(bend), d0
        )
        row = np.zeros((along.size, 1, 3))
        row[:, 0, 0] = start + along * cos(bend) + depth * sin(bend)
        row[:, 0, up] = along * sin(bend) - depth * cos(bend)
        position = np.tile(row, (1, across.size, 1))
        position[:, :, 3 - up] += across
        normal = np.zeros(3)
        normal[[0, up]] = -sin(bend), cos(bend)
        count = along.size * across.size
        parts.append(
            WallPoints(
                position.reshape(count, 3),
                np.full(count, layer),
                np.full(count, FLOOR),
                np.tile(normal, (count, 1)),
                np.full(count, depth),
            )
        )
    return _joined(*parts)


def _cells_across(shape: shapes.Channel3D, case: ResolvedCase) -> tuple[int, int]:
    """Return the first row of the run-out's floor across, and the one after the last."""
    d0, plain = case.particles.spacing, plain_of(shape)
    if plain is None:
        return 0, cells_along(shape.width, d0)
    beyond = 2 * wall_layers(case)
    return floor(plain.front / d0) - beyond, ceil(plain.back / d0) + beyond


def _beside_runout(
    points: WallPoints,
    kept: NDArray[np.bool_],
    shape: shapes.Channel3D,
    start: float,
    case: ResolvedCase,
) -> tuple[WallPoints, NDArray[np.bool_]]:
    """Return the points with the side walls along a run-out from x = start, and which are kept.

    Below the floor that bends up, the nearest point of the surface is its edge along the wall.
    """
    bend, d0, layers = runout_bend(case), case.particles.spacing, wall_layers(case)
    x, y, z = points.position.T
    beside = ((y < 0.0) | (y > shape.width)) & (x > start)
    below = -height_over_floor(case, x, z, x)
    sunk = np.flatnonzero(beside & (below > 0.0))
    aside, below_edge = np.maximum(-y, y - shape.width)[sunk], below[sunk]
    way = np.column_stack(
        [
            -sin(bend) * below_edge,
            np.where(y[sunk] < 0.0, aside, -aside),
            cos(bend) * below_edge,
        ]
    )
    layer, name = points.layer.copy(), points.name.copy()
    normal, depth = points.normal.copy(), points.depth.copy()
    depth[sunk] = np.linalg.norm(way, axis=1)
    normal[sunk] = way / depth[sunk, None]
    layer[sunk] = np.maximum(np.rint(aside / d0 + 0.5), np.ceil(below_edge / d0))
    name[sunk] = FLOOR
    kept = np.where(beside, below < layers * d0, kept)
    return WallPoints(points.position, layer, name, normal, depth), kept


def _tank_cells(shape: shapes.Tank, case: ResolvedCase) -> tuple[tuple[int, ...], Cells]:
    d0, layers = case.particles.spacing, wall_layers(case)
    length, height = cells_along(shape.length, d0), cells_along(shape.height, d0)
    margin = 0 if shape.periodic else layers
    x = np.arange(-margin, length + margin)
    y = np.arange(-layers, height + (layers if shape.ceiling else 0))
    name = np.full((x.size, y.size), -1)
    name[x < 0] = LEFT
    name[x >= length] = RIGHT
    name[:, y < 0] = FLOOR
    name[:, y >= height] = CEILING
    _draw_obstacles(name, (x, y), case)
    return (x[0], y[0]), name


def _tank3d_cells(shape: shapes.Tank3D, case: ResolvedCase) -> tuple[tuple[int, ...], Cells]:
    d0, layers = case.particles.spacing, wall_layers(case)
    length, width, height = (cells_along(s, d0) for s in (shape.length, shape.width, shape.height))
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
    _draw_obstacles(name, (x, y, z), case)
    return (x[0], y[0], z[0]), name


def _draw_obstacles(name: Cells, axes: tuple[Cells, ...], case: ResolvedCase) -> None:
    """Write the numbers of boxes and meshes into the cells that they cover."""
    d0, start = case.particles.spacing, np.array([axis[0] for axis in axes])
    for number, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if isinstance(obstacle, MeshObstacle):
            cell = cells_inside(surface_of(obstacle), d0) - start
            name[tuple(cell[np.all((cell >= 0) & (cell < name.shape), axis=1)].T)] = number
        if not isinstance(obstacle, BoxObstacle):
            continue
        inside = [
            (axis >= cells_along(extent[0], d0)) & (axis < cells_along(extent[1], d0))
            for axis, extent in zip(axes, obstacle.extents, strict=True)
        ]
        name[np.ix_(*inside)] = number


def _channel_cells(shape: ResolvedChannel, case: ResolvedCase) -> tuple[tuple[int, ...], Cells]:
    x, y = _axes_of_section(shape, case)
    name = _section_of_channel(shape, case, x, y)
    _draw_obstacles(name, (x, y), case)
    return (x[0], y[0]), name


def _axes_of_section(shape: shapes.ChannelShape, case: ResolvedCase) -> tuple[Cells, Cells]:
    """Return the cells along a channel and upward."""
    d0, layers = case.particles.spacing, wall_layers(case)
    margin = 0 if shape.periodic else 2 * layers
    x = np.arange(-margin, cells_along(shape.length, d0) + margin)
    recess = cells_along(shape.bed_thickness, d0)
    return x, np.arange(-recess - layers, cells_along(shape.height, d0))


def _section_of_channel(
    shape: ResolvedChannelShape, case: ResolvedCase, x: Cells, y: Cells
) -> Cells:
    """Return the number of the wall, or -1, in cells of a section along a channel; y is up."""
    d0, layers = case.particles.spacing, wall_layers(case)
    length, recess = cells_along(shape.length, d0), cells_along(shape.bed_thickness, d0)
    start, end = cells_along(shape.bed_start, d0), cells_along(shape.bed_end, d0)
    level = np.zeros(x.size, dtype=int)
    level[(x >= start) & (x < end)] = -recess
    if not shape.periodic:
        level[x >= end] = cells_along(shape.weir_height, d0)
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
        name[np.ix_(x < 0, y >= inflow_section(case).high)] = LEFT
    return np.asarray(name)


def _channel3d_cells(shape: ResolvedChannel3D, case: ResolvedCase) -> tuple[tuple[int, ...], Cells]:
    d0, layers, plain = case.particles.spacing, wall_layers(case), plain_of(shape)
    x, z = _axes_of_section(shape, case)
    if plain is not None:
        x = x[x < cells_along(plain.start, d0)]
    y = np.arange(-layers, cells_along(shape.width, d0) + layers)
    return (x[0], y[0], z[0]), _cells_of_channel(shape, case, x, y, z)


def _mouth_cells(
    shape: ResolvedChannel3D, plain: Plain, case: ResolvedCase
) -> tuple[tuple[int, ...], Cells]:
    """Return the cells around the mouth on a plain, among them its head wall."""
    mouth, layers = cells_along(plain.start, case.particles.spacing), wall_layers(case)
    x, z = np.arange(mouth - 2 * layers, mouth + 2 * layers), _axes_of_section(shape, case)[1]
    y = np.arange(*_cells_across(shape, case))
    return (x[0], y[0], z[0]), _cells_of_channel(shape, case, x, y, z)


def _cells_of_channel(
    shape: ResolvedChannel3D, case: ResolvedCase, x: Cells, y: Cells, z: Cells
) -> Cells:
    """Return the number of the wall, or -1, in cells of a channel in three dimensions.

    The section of the channel repeats across it; what is open in it is side wall beside it.
    """
    plain = plain_of(shape)
    within = (y >= 0) & (y < cells_along(shape.width, case.particles.spacing))
    name = np.repeat(_section_of_channel(shape, case, x, z)[:, None, :], y.size, axis=1)
    if case.inflow is not None:
        opening = inflow_section(case)
        supplied = (y >= opening.first) & (y < opening.first + opening.wide)
        name[np.ix_(x < 0, within & ~supplied, z >= 0)] = LEFT
    walled = np.ones(x.size, dtype=bool)
    if plain is not None:
        walled = x < cells_along(plain.start, case.particles.spacing)
    beside = (name < 0) & (walled[:, None] & ~within)[:, :, None]
    name = np.where(beside, np.where(y < 0, FRONT, BACK)[:, None], name)
    _draw_obstacles(name, (x, y, z), case)
    return name


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
