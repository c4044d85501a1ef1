"""What stands around the flow: floor, walls and obstacles to be drawn."""

from __future__ import annotations

from itertools import pairwise, product
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import MeshObstacle, PolygonObstacle
from debrisflow.case.motion import Motion
from debrisflow.case.regions import runout_rise, surface_of
from debrisflow.case.shapes import ChannelShape, Tank, Tank3D, is_three_dimensional, plain_of
from debrisflow.case.tables import AnyObstacle
from debrisflow.space.domain import WALL_NAMES, domain, image_shifts
from debrisflow.space.fills import inflow_section
from debrisflow.space.floor import floor_level
from debrisflow.space.ground import ground_of
from debrisflow.space.trajectory import Trajectory

Floats = NDArray[np.float64]
MOST_FACES_ALONG = 200
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


class Scene(NamedTuple):
    """Surfaces around the flow.

    Attributes
    ----------
    floor, behind, before : list of (4, 3) float64 array, m
        Corners of rectangles: the floor, the walls behind it as seen from the front, on the right,
        and above, and those before it, which would hide the flow.
    obstacles : list of (n, 3 or 4, 3) float64 array, m
        The faces of each obstacle.
    """

    floor: list[Floats]
    behind: list[Floats]
    before: list[Floats]
    obstacles: list[Floats]

    @property
    def corners(self) -> Floats:
        """Return all corners, (n, 3) array, m."""
        faces = [*self.floor, *self.behind, *self.before, *self.obstacles]
        return np.concatenate([face.reshape(-1, 3) for face in faces])


def scene_of(case: ResolvedCase, wall_height: float) -> Scene:
    """Return the surfaces of a case in three dimensions.

    Parameters
    ----------
    case : ResolvedCase
    wall_height : float, m
        Up to which walls are shown.
    """
    if case.is_terrain:
        return Scene(ground_faces(case), [], [], obstacle_faces(case))
    profile, top = floor_profile(case), min(wall_height, case.geometry.height)
    floor: list[Floats] = []
    behind: list[Floats] = []
    before: list[Floats] = []
    for (x0, z0), (x1, z1) in pairwise(profile):
        front, back = edges_across(case, 0.5 * (x0 + x1))
        floor.append(_strip((x0, z0), (x1, z1), front, back))
        if x1 > x0 and has_sides(case, 0.5 * (x0 + x1)):
            rims = [top + _rise(case, x) for x in (x0, x1)]
            for side, y in ((before, front), (behind, back)):
                side.append(_wall((x0, y), (x1, y), (z0, z1), rims))
    ends = [(x, edges_across(case, x)) for x in closed_ends(case)]
    for x, (front, back) in ends:
        level = 0.0 if x == 0.0 else _rise(case, x)
        wall = _wall((x, front), (x, back), (level, level), (top + level, top + level))
        (behind if x == 0.0 else before).append(wall)
    behind += [_wall((x, y0), (x, y1), (0.0, 0.0), (top, top)) for x, y0, y1 in head_walls(case)]
    return Scene(floor, behind, before, obstacle_faces(case))


def ground_faces(case: ResolvedCase) -> list[Floats]:
    """Return the ground of a terrain as rectangles, at most a few ten thousand of them."""
    ground = ground_of(case)
    sizes = case.terrain.length, case.terrain.width
    width = max(ground.surface.width, max(sizes) / MOST_FACES_ALONG)
    lines = [np.linspace(0.0, size, max(2, ceil(size / width) + 1)) for size in sizes]
    x, y = np.meshgrid(*lines, indexing="ij")
    corner = np.stack([x, y, ground.surface.level(x, y)], axis=2)
    parts = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return list(np.stack(parts, axis=2).reshape(-1, 4, 3))


def floor_profile(case: ResolvedCase) -> list[tuple[float, float]]:
    """Return the corners of the fixed floor along x, (x, level) in m, its steps among them.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> from debrisflow.case import shapes
    >>> flume = shapes.Channel3D(
    ...     type="channel3d", length=4.0, width=0.5, height=1.0,
    ...     bed_start=1.0, bed_end=3.0, bed_thickness=0.25,
    ... )
    >>> floor_profile(Case(geometry=flume))
    [(0.0, 0.0), (1.0, 0.0), (1.0, -0.25), (3.0, -0.25), (3.0, 0.0), (4.0, 0.0)]
    """
    shape = case.geometry
    if not isinstance(shape, ChannelShape):
        return [(0.0, 0.0), (shape.length, 0.0)]
    inner = [shape.runout_start]
    if shape.bed_thickness > 0.0 or shape.weir_height > 0.0:
        inner += [shape.bed_start, shape.bed_end]
    breaks = sorted({x for x in inner if x is not None and 0.0 < x < shape.length})
    profile: list[tuple[float, float]] = []
    for start, end in zip([0.0, *breaks], [*breaks, shape.length], strict=True):
        # between breaks the floor is straight, and two points inside tell its ends
        inside = start + (end - start) * np.array([0.25, 0.75])
        low, high = floor_level(case, inside)
        slope = (high - low) / 2.0
        for place, level in ((start, low - slope), (end, high + slope)):
            point = (float(place), round(float(level), 12) + 0.0)
            if not profile or profile[-1] != point:
                profile.append(point)
    return profile


def edges_across(case: ResolvedCase, x: float) -> tuple[float, float]:
    """Return the two y between which there is a floor at x, m."""
    shape = case.geometry
    if not is_three_dimensional(shape):
        raise TypeError("a floor has edges across in three dimensions only")
    plain = plain_of(shape)
    return (plain.front, plain.back) if plain and x > plain.start else (0.0, shape.width)


def has_sides(case: ResolvedCase, x: float) -> bool:
    """Return whether walls stand beside the floor at x: not on a plain nor where it repeats."""
    shape = case.geometry
    if isinstance(shape, Tank3D):
        return not shape.periodic
    plain = plain_of(shape)
    return plain is None or edges_across(case, x) == (0.0, plain.mouth)


def closed_ends(case: ResolvedCase) -> list[float]:
    """Return the x at which walls close the space, m."""
    shape = case.geometry
    if isinstance(shape, Tank3D):
        return [0.0, shape.length]
    if shape.periodic:
        return []
    return [0.0, shape.length] if isinstance(shape, Tank) else [0.0]


def section_lines(case: ResolvedCase) -> list[Floats]:
    """Return the walls of a case in two dimensions as lines, each (n, 2) array, m.

    The floor with its steps, the walls at the ends, that around a supply, and the ceiling.
    """
    shape, lines = case.geometry, [np.array(floor_profile(case))]
    foot = inflow_section(case).high * case.particles.spacing
    for x in closed_ends(case):
        lines.append(np.array([(x, foot if x == 0.0 else 0.0), (x, shape.height)]))
    if isinstance(shape, Tank) and shape.ceiling:
        lines.append(np.array([(0.0, shape.height), (shape.length, shape.height)]))
    return lines


def head_walls(case: ResolvedCase) -> list[tuple[float, float, float]]:
    """Return x and the two y of the walls beside the mouth of a channel onto a plain, m."""
    plain = plain_of(case.geometry)
    if plain is None:
        return []
    ends = [(plain.front, 0.0), (plain.mouth, plain.back)]
    return [(plain.start, start, end) for start, end in ends if end > start]


def obstacle_faces(case: ResolvedCase, time: float = 0.0) -> list[Floats]:
    """Return the faces of each obstacle at a time, s, as arrays of corners, m.

    They are (n, 4, 3) of a box and (n, 3, 3) of a mesh; in two dimensions (1, n, 3), a polygon.
    """
    faces, ways = [], trajectories(case)
    for number, part in enumerate(case.obstacle, start=len(WALL_NAMES)):
        at_start = faces_of(part)
        moved = ways[number].pose(max(time, 0.0)).moved(at_start) if number in ways else at_start
        faces.append(moved)
    return faces


def faces_with_images(case: ResolvedCase, time: float) -> list[Floats]:
    """Return :func:`obstacle_faces`, and those of images that reach into a space that repeats."""
    period, found = domain(case).period, obstacle_faces(case, time)
    repeats = np.flatnonzero(period)
    images = [faces + shift for faces in found for shift in image_shifts(case)[1:]]
    for faces in images:
        ends = faces.reshape(-1, 3)[:, repeats]
        if np.all((ends.max(axis=0) > 0.0) & (ends.min(axis=0) < period[repeats])):
            found.append(faces)
    return found


def faces_of(part: AnyObstacle) -> Floats:
    """Return the faces of an obstacle at the start, (n, 3 or 4, 3) array, m."""
    if isinstance(part, MeshObstacle):
        return surface_of(part).corners
    if isinstance(part, PolygonObstacle):
        return np.pad(np.array([part.corners]), ((0, 0), (0, 0), (0, 1)))
    corner = np.array(list(product(*part.extents)))
    corner[:, 0], corner[:, 1] = part.turned(corner[:, 0], corner[:, 1], part.turn)
    return corner[BOX_FACES] if part.z else np.pad(corner[[[0, 1, 3, 2]]], ((0, 0), (0, 0), (0, 1)))


def trajectories(case: ResolvedCase) -> dict[int, Trajectory]:
    """Return the ways of the obstacles that move, by the numbers of their walls."""
    return {
        number: Trajectory(part.motion, faces_of(part).reshape(-1, 3), case)
        for number, part in enumerate(case.obstacle, start=len(WALL_NAMES))
        if isinstance(part.motion, Motion)
    }


def _rise(case: ResolvedCase, x: float) -> float:
    """Return by how much a run-out has risen at x, m; a recess and a weir do not count."""
    shape = case.geometry
    if not isinstance(shape, ChannelShape) or shape.runout_start is None:
        return 0.0
    share = (x - shape.runout_start) / (shape.length - shape.runout_start)
    return max(share, 0.0) * runout_rise(shape, case.gravity)


def _strip(
    start: tuple[float, float], end: tuple[float, float], front: float, back: float
) -> Floats:
    (x0, z0), (x1, z1) = start, end
    return np.array([(x0, front, z0), (x1, front, z1), (x1, back, z1), (x0, back, z0)])


def _wall(
    start: tuple[float, float],
    end: tuple[float, float],
    feet: tuple[float, float],
    rims: tuple[float, float] | list[float],
) -> Floats:
    corners = [(*start, feet[0]), (*end, feet[1]), (*end, rims[1]), (*start, rims[0])]
    return np.array(corners)
