"""The records of walls that are surfaces, as kernels take them."""

from __future__ import annotations

from collections.abc import Container

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.boundary import Walls
from debrisflow.neighbors.boxes import Boxes
from debrisflow.neighbors.elements import Elements
from debrisflow.neighbors.half_space import PULLED_BACK
from debrisflow.neighbors.height_field import HeightField
from debrisflow.neighbors.octant import octants
from debrisflow.neighbors.quadrant import quadrants
from debrisflow.neighbors.surfaces import Surfaces
from debrisflow.schemes.moving_walls import MovingWalls
from debrisflow.schemes.wall_particles import roughnesses, slips
from debrisflow.space.bodies import Body, bodies_of
from debrisflow.space.domain import domain
from debrisflow.space.ground import ground_of
from debrisflow.space.mesh_pieces import area_vectors, pieces_of
from debrisflow.space.polygons import Sides, sides_of
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]
SAMPLES = 5  # least number of places along each side of a face by which it is found to be covered
TOUCHING = 1e-6  # spacings


def walls_of(
    case: ResolvedCase, skin: float, ground: HeightField | None = None
) -> tuple[Surfaces, MovingWalls]:
    """Return the walls of a case, for lists with at most a skin, spacings, and what moves of them.

    In three dimensions a ground may lie over its floor.
    """
    radius, boxes = case.particles.effective_radius, boxes_of(case)
    if case.dimension == 3:
        elements = elements_from(*pieces_of(case, PULLED_BACK))
    else:
        elements = elements_of_sides(sides_of(case))
    moving = MovingWalls(case, boxes, elements)
    surfaces = Surfaces(
        boxes=boxes,
        table=octants(radius) if case.dimension == 3 else quadrants(radius),
        spacing=case.particles.spacing,
        walls=Walls(slips(case), roughnesses(case), moving.motion),
        elements=elements,
        ground=ground,
        skin=skin,
        period=domain(case).period,
    )
    return surfaces, moving


def record_of_ground(case: ResolvedCase) -> HeightField:
    """Return the ground of a case on a terrain."""
    ground = ground_of(case)
    width, coefficients = ground.surface
    return HeightField(np.zeros(2), width, coefficients, ground.grid.cell, ground.number)


def boxes_of(case: ResolvedCase) -> Boxes:
    """Return the record of the walls and box obstacles of a case."""
    bodies = bodies_of(case)
    ends = np.array([(body.x, body.y, body.z) for body in bodies]).reshape(-1, 3, 2)
    reach = case.particles.effective_radius * case.particles.spacing
    number = np.empty(ends.shape, dtype=np.int64)
    for b, body in enumerate(bodies):
        number[b] = body.number if body.sides is None else body.sides
        number[b, body.up, 1] = body.number
    boxes = Boxes(
        origin=np.array([body.origin for body in bodies]).reshape(-1, 3),
        axes=np.array([body.axes for body in bodies]).reshape(-1, 3, 3),
        lower=ends[:, :, 0].copy(),
        upper=ends[:, :, 1].copy(),
        inner_lower=ends[:, :, 0].copy(),
        inner_upper=ends[:, :, 1].copy(),
        number=number,
        is_floor=np.array([body.is_floor for body in bodies], dtype=bool),
        is_thin=ends[:, :, 1] - ends[:, :, 0] < reach,
    )
    _pull_back(boxes, bodies, case)
    return boxes


def _pull_back(boxes: Boxes, bodies: list[Body], case: ResolvedCase) -> None:
    """Move the faces of the solid of the sums behind the surface that the fluid sees.

    Where two boxes touch there is no surface: the face of one follows that of the other.  What an
    obstacle that moves covers comes out when it has moved away, and so do its own faces but those
    along which it slides.
    """
    d0, ways = case.particles.spacing, trajectories(case)
    back = PULLED_BACK * d0 if case.dimension == 3 else 0.0
    covered = np.array(
        [
            [[_is_covered(b, axis, end, bodies, ways, case) for end in (0, 1)] for axis in range(3)]
            for b in range(len(boxes.origin))
        ],
        dtype=bool,
    ).reshape(-1, 3, 2)
    for b, axis, end in np.ndindex(covered.shape):
        outward = 2.0 * end - 1.0
        faces = (boxes.inner_lower, boxes.inner_upper)[end]
        if not covered[b, axis, end]:
            faces[b, axis] -= outward * back
        elif bodies[b].number not in ways or axis not in ways[bodies[b].number].axes:
            boxes.number[b, axis, end] = -1
    for b, axis, end in 2 * list(np.argwhere(covered)):  # twice, along three in a row
        surface = (boxes.lower, boxes.upper)[end][b, axis]
        faces = (boxes.inner_lower, boxes.inner_upper)[end]
        faces[b, axis] = surface + _shift_beside(b, axis, end, boxes, d0)


def _is_covered(
    b: int,
    axis: int,
    end: int,
    bodies: list[Body],
    moving: Container[int],
    case: ResolvedCase,
) -> bool:
    """Return whether all of a face of a box, as far as the space reaches, lies in other boxes.

    Those that are parts of walls that move do not count.
    """
    body, space, d0 = bodies[b], domain(case), case.particles.spacing
    ends = (body.x, body.y, body.z)
    if not np.isfinite(ends[axis][end]):
        return True
    margin = 2.0 * case.particles.effective_radius * d0
    lower = np.where(np.isfinite(space.lower), space.lower, 0.0) - margin - body.origin
    upper = np.where(np.isfinite(space.upper), space.upper, space.period) + margin - body.origin
    lines = []
    for k, (first, last) in enumerate(ends):
        first, last = max(first, lower[k]), min(last, upper[k])
        parts = np.linspace(first, last, SAMPLES + 1)
        # each part of the face between the ends of other bodies, however narrow
        others = [_ends_along(body, k, other) for other in bodies]
        cuts = np.concatenate([parts, *others])
        cuts = np.unique(cuts[(cuts >= first) & (cuts <= last)])
        lines.append(0.5 * (cuts[1:] + cuts[:-1]))
    lines[axis] = np.array([ends[axis][end] + (2.0 * end - 1.0) * TOUCHING * d0])
    own = np.stack([grid.ravel() for grid in np.meshgrid(*lines, indexing="ij")], axis=1)
    places = np.array(body.origin) + own @ body.axes
    inside = np.zeros(len(places), dtype=bool)
    for other in bodies[:b] + bodies[b + 1 :]:
        if not (body.is_floor and other.is_floor) and other.number not in moving:
            inside |= other.holds(places)
    return bool(inside.all())


def _ends_along(body: Body, axis: int, other: Body) -> Floats:
    """Return the ends of another body along an axis of a body, m, if their axes are the same."""
    if not np.allclose(other.axes[axis], body.axes[axis]):
        return np.zeros(0)
    apart = (np.array(other.origin) - np.array(body.origin)) @ body.axes[axis]
    ends = np.array((other.x, other.y, other.z)[axis]) + apart
    found: Floats = ends[np.isfinite(ends)]
    return found


def _shift_beside(b: int, axis: int, end: int, boxes: Boxes, d0: float) -> float:
    """Return by how much the face of another box in the plane of a covered one was moved, m."""
    across = boxes.axes[b, axis]
    origin = boxes.origin @ across
    level = (boxes.lower, boxes.upper)[end][b, axis] + origin[b]
    if np.isfinite(level):
        facing = (boxes.upper, boxes.lower)[end][:, axis] + origin
        moved = (boxes.inner_upper, boxes.inner_lower)[end][:, axis] + origin
        parallel = np.all(boxes.axes[:, axis] == across, axis=1)
        touching = parallel & (np.abs(facing - level) < TOUCHING * d0)
        shifts = moved[touching] - facing[touching]
        if np.any(shifts):
            return float(shifts[np.argmax(np.abs(shifts))])
    return 0.0


def elements_from(
    pieces: Floats, number: NDArray[np.int64], is_face: NDArray[np.bool_]
) -> Elements:
    """Return the elements of small triangles.

    Parameters
    ----------
    pieces : (n, 3, 6) float64 array, m
        Three corners on the surface, and on the solid of the sums.
    number : (n,) int64 array
        Of the wall that they belong to.
    is_face : (n,) bool array
        See :class:`debrisflow.neighbors.elements.Elements`.
    """
    surface, inner = pieces[:, :, :3], pieces[:, :, 3:]
    area, inner_area = area_vectors(surface), area_vectors(inner)
    size = np.linalg.norm(area, axis=1)
    farthest = np.linalg.norm(surface - surface.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    solid = size > 0.0
    return Elements(
        corners=np.ascontiguousarray(surface[solid]),
        middle=surface[solid].mean(axis=1),
        inner=inner[solid].mean(axis=1),
        normal=area[solid] / size[solid, None],
        area=np.linalg.norm(inner_area[solid], axis=1),
        size=farthest[solid],
        number=number[solid],
        is_face=is_face[solid],
    )


def elements_of_sides(sides: Sides) -> Elements:
    """Return the elements of polygons in two dimensions: faces, and rows, which are no faces.

    A side is that of a triangle that rises out of the plane.
    """
    corners = np.zeros((len(sides.ends), 3, 3))
    corners[:, :2, :2] = sides.ends
    middle = corners[:, :2].mean(axis=1)
    corners[:, 2] = middle + np.array([0.0, 0.0, 1.0])
    along = sides.ends[:, 1] - sides.ends[:, 0]
    length = np.hypot(*along.T)
    normal = np.zeros((len(length), 3))
    normal[:, 0], normal[:, 1] = along[:, 1] / length, -along[:, 0] / length
    size = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    return Elements(corners, middle, middle, normal, length, size, sides.number, sides.is_face)
