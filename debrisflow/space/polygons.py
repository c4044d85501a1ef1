"""The polygons of a case that are obstacles: their faces, and rows that fill them (NumPy, Shapely).

A wall in two dimensions is rows of particles at the depths 1/2, 3/2, ... spacings under its
surface, see :mod:`debrisflow.neighbors.half_plane`.  Those of a polygon are the sides of the
polygons inside it and the walls that it stands on, whose corners lie on the bisectors of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import PolygonObstacle
from debrisflow.space.bodies import bodies_of
from debrisflow.space.domain import WALL_NAMES, image_shifts, wall_layers

Floats = NDArray[np.float64]
WIDEST = 0.5
"""Longest piece of a side, in spacings."""
SHARPEST = 20.0
"""Depths by which a corner of a row may lie behind that of the polygon."""
SLACK = 1e-3  # spacings within which a side lies on a wall


class Sides(NamedTuple):
    """Pieces of sides, of which the wall lies on the left.

    Attributes
    ----------
    ends : (n, 2, 2) float64 array, m
        Both ends of each, (x, y).
    number : (n,) int64 array
        Of the wall that they belong to.
    is_face : (n,) bool array
        True on the surface of a polygon, False in the rows under it.
    """

    ends: Floats
    number: NDArray[np.int64]
    is_face: NDArray[np.bool_]


def sides_of(case: ResolvedCase) -> Sides:
    """Return the polygons that are obstacles by their sides, and by the rows under these.

    A side that lies on a wall of the space, as the base of a wedge, is no face: no fluid comes
    there, unless the polygon moves.
    """
    d0 = case.particles.spacing
    ends, number, is_face = [np.zeros((0, 2, 2))], [], []
    for wall, part in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if not isinstance(part, PolygonObstacle):
            continue
        shape = shapely.Polygon(part.corners)
        surface = _cut(_sides(shape), d0)
        if part.motion is None:
            surface = surface[~_on_walls(surface, case)]
        rows = _cut(np.concatenate(rows_of(part, case)), d0)
        for shift in image_shifts(case):
            for pieces, are_faces in ((surface, True), (rows, False)):
                ends.append(pieces + shift[:2])
                number.append(np.full(len(pieces), wall))
                is_face.append(np.full(len(pieces), are_faces))
    return Sides(
        np.concatenate(ends),
        np.concatenate([np.zeros(0, dtype=np.int64), *number]),
        np.concatenate([np.zeros(0, dtype=np.bool_), *is_face]),
    )


def rows_of(part: PolygonObstacle, case: ResolvedCase) -> list[Floats]:
    """Return the rows that fill a polygon, layer by layer from its surface, (n, 2, 2) arrays, m.

    A polygon that stands still and the walls that it touches have one surface: under its base there
    are no rows, for which a wedge would have no room at its toe.
    """
    shape, d0 = shapely.Polygon(part.corners), case.particles.spacing
    whole = shapely.union_all([shape, *(_walls(shape, case) if part.motion is None else ())])
    room = shape.buffer(-SLACK * d0, join_style="mitre", mitre_limit=SHARPEST)
    depths = (np.arange(wall_layers(case)) + 0.5) * d0
    inner = [whole.buffer(-depth, join_style="mitre", mitre_limit=SHARPEST) for depth in depths]
    return [_within(_sides(one), room) for one in inner]


def _within(sides: Floats, shape: shapely.Polygon) -> Floats:
    """Return the parts of sides that lie in a polygon, turned as they are."""
    kept = [np.zeros((0, 2, 2))]
    for start, end in sides:
        way = (end - start) / np.sum((end - start) ** 2)
        for part in shapely.get_parts(shapely.LineString((start, end)) & shape):
            ends = (shapely.get_coordinates(part) - start) @ way
            if ends.size > 1:
                kept.append(start + np.sort(ends[[0, -1], None], axis=0) * (end - start))
    return np.concatenate([part.reshape(-1, 2, 2) for part in kept])


def _walls(shape: shapely.Polygon, case: ResolvedCase) -> list[shapely.Polygon]:
    """Return the walls and boxes that stand still, as far as they come near a polygon."""
    reach = (wall_layers(case) + 1) * case.particles.spacing
    x, y, far_x, far_y = shape.buffer(reach, join_style="mitre").bounds
    size, around = 4.0 * (far_x - x + far_y - y), shapely.box(x, y, far_x, far_y)
    obstacles = enumerate(case.obstacle, start=len(WALL_NAMES))
    moving = {number for number, part in obstacles if part.motion is not None}
    found = []
    for body in bodies_of(case):
        if body.number in moving:
            continue
        middle = (np.array([0.5 * (x + far_x), 0.5 * (y + far_y), 0.0]) - body.origin) @ body.axes.T
        lower = np.maximum([body.x[0], body.y[0]], middle[:2] - size)
        upper = np.minimum([body.x[1], body.y[1]], middle[:2] + size)
        if np.all(lower < upper):
            own = shapely.get_coordinates(shapely.box(*lower, *upper))
            corners = np.array(body.origin)[:2] + own @ body.axes[:2, :2]
            found.append(shapely.Polygon(corners) & around)
    return found


def in_polygon(part: PolygonObstacle, places: Floats) -> NDArray[np.bool_]:
    """Return which places, (n, 3) array, m, lie in a polygon."""
    inside: NDArray[np.bool_] = shapely.contains_xy(
        shapely.Polygon(part.corners), places[:, 0], places[:, 1]
    )
    return inside


def push_off_polygon(places: Floats, part: PolygonObstacle, clearance: float) -> None:
    """Move places, (n, 3) array, m, that are nearer than a clearance, m, to a polygon off it."""
    points, shape = shapely.points(places[:, :2]), shapely.Polygon(part.corners)
    rows = np.flatnonzero(shapely.distance(points, shape) < clearance)
    way = shapely.get_coordinates(shapely.shortest_line(shape, points[rows])).reshape(-1, 2, 2)
    off = way[:, 1] - way[:, 0]
    distance = np.hypot(*off.T)
    outside = distance > 0.0
    places[rows[outside], :2] += (off * (clearance / np.maximum(distance, 1e-300) - 1.0)[:, None])[
        outside
    ]


def _sides(shape: shapely.Geometry) -> Floats:
    """Return the sides of a polygon, or of several, with the inside on the left, (n, 2, 2)."""
    parts = [part for part in shapely.get_parts(shape) if part.area > 0.0]
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    found = [np.zeros((0, 2, 2))]
    for ring, is_outer in zip(rings, _outer(parts), strict=True):
        corners = shapely.get_coordinates(ring)
        if shapely.is_ccw(ring) != is_outer:
            corners = corners[::-1]
        found.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(found)


def _outer(parts: list[shapely.Polygon]) -> list[bool]:
    """Return, for all rings of polygons in a row, whether they are their outer ones."""
    return [k == 0 for part in parts for k in range(1 + len(part.interiors))]


def _cut(sides: Floats, spacing: float) -> Floats:
    """Return sides in pieces of equal length that are not too wide."""
    pieces = [np.zeros((0, 2, 2))]
    for start, end in sides:
        count = max(1, int(np.ceil(np.hypot(*(end - start)) / (WIDEST * spacing))))
        places = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
        pieces.append(np.stack([places[:-1], places[1:]], axis=1))
    return np.concatenate(pieces)


def _on_walls(pieces: Floats, case: ResolvedCase) -> NDArray[np.bool_]:
    """Return which pieces lie in another wall or on its surface."""
    places = np.pad(pieces.reshape(-1, 2), ((0, 0), (0, 1)))
    inside = np.zeros(len(pieces), dtype=bool)
    for body in bodies_of(case):
        held = body.holds(places, SLACK * case.particles.spacing)
        inside |= held.reshape(-1, 2).all(axis=1)
    return inside
