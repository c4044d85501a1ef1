"""Walls made of boxes: what a particle near one feels of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.beyond import push_beyond, stretched
from debrisflow.neighbors.boundary import insert_face
from debrisflow.neighbors.octant import beyond_of, box_sums
from debrisflow.neighbors.pairs import BLOCK

Floats = NDArray[np.float64]
COPLANAR = 1e-6  # spacings


class Boxes(NamedTuple):
    """Bodies of the walls: boxes, turned or not, that touch but do not overlap.

    Attributes
    ----------
    origin : (b, 3) float64 array, m
        A point from which the ends are measured.
    axes : (b, 3, 3) float64 array
        Unit vectors along the box, by rows.
    lower, upper : (b, 3) float64 array, m
        Ends along these; infinite where the box has none.
    inner_lower, inner_upper : (b, 3) float64 array, m
        Ends of the solid of the sums, see :data:`debrisflow.neighbors.half_space.PULLED_BACK`.
    number : (b, 3, 2) int64 array
        Number of the wall that the face at each end belongs to; -1 where all of it lies in other
        boxes, so that it is no face.
    is_floor : (b,) bool array
        Parts of a floor that meet at a bend and reach on under each other: only the nearest part
        counts in the sums.
    is_thin : (b, 3) bool array
        Axes along which a box is thinner than the reach.  What is over a face across one feels a
        box that goes on behind, and nothing of the fluid there, see
        :func:`debrisflow.neighbors.near_boxes.cut_pairs`.
    """

    origin: Floats
    axes: Floats
    lower: Floats
    upper: Floats
    inner_lower: Floats
    inner_upper: Floats
    number: NDArray[np.int64]
    is_floor: NDArray[np.bool_]
    is_thin: NDArray[np.bool_]


@kernel
def place_in(b, x, y, z, boxes, here):
    """Write a place in the coordinates of a box, m."""
    dx, dy, dz = x - boxes.origin[b, 0], y - boxes.origin[b, 1], z - boxes.origin[b, 2]
    for k in range(3):
        here[k] = boxes.axes[b, k, 0] * dx + boxes.axes[b, k, 1] * dy + boxes.axes[b, k, 2] * dz


@kernel
def distance_to(b, here, boxes):
    """Return the distance to a box, m; in it the negative one to its nearest end."""
    square, most = 0.0, -np.inf
    for k in range(3):
        gap = max(boxes.lower[b, k] - here[k], here[k] - boxes.upper[b, k])
        square += max(gap, 0.0) ** 2
        most = max(most, gap)
    return np.sqrt(square) if square > 0.0 else most


@kernel
def face_of(b, here, boxes, normal):
    """Return distance to a box, m, wall number and kind; write the normal in its coordinates.

    The kind is how many ends the place lies beyond: 1 in front of a face, 2 or 3 off an edge or a
    corner, whose normal leads to the nearest point, 0 inside, where the distance is the negative
    one to the nearest face.  The number is -1 where an end beyond which the place lies is no face.
    """
    beyond, square, most, number, hidden = 0, 0.0, -np.inf, -1, False
    deepest, inner_axis, inner_number, inner_side = -np.inf, 0, -1, 1.0
    for k in range(3):
        normal[k] = 0.0
        for end in range(2):
            gap = here[k] - boxes.upper[b, k] if end else boxes.lower[b, k] - here[k]
            owner = boxes.number[b, k, end]
            if gap > 0.0:
                beyond += 1
                square += gap * gap
                normal[k] = gap if end else -gap
                hidden |= owner < 0
                if gap > most:
                    most, number = gap, owner
            elif owner >= 0 and gap > deepest:
                deepest, inner_axis, inner_number, inner_side = gap, k, owner, 2.0 * end - 1.0
    if beyond == 0:
        normal[inner_axis] = inner_side
        return deepest, inner_number, 0
    distance = np.sqrt(square)
    for k in range(3):
        normal[k] /= distance
    return distance, -1 if hidden else number, beyond


@kernel
def _is_seam(row, distance, normal, spacing, boundary):
    """Return whether the nearest point of an edge lies in the plane of a face in front.

    There two boxes meet that make one surface, and the edge is none.
    """
    for f in range(boundary.faces[row]):
        level = distance * (
            normal[0] * boundary.normal[row, f, 0]
            + normal[1] * boundary.normal[row, f, 1]
            + normal[2] * boundary.normal[row, f, 2]
        )
        if abs(level - boundary.distance[row, f]) < COPLANAR * spacing:
            return True
    return False


@kernel
def _turn_back(b, boxes, vector, turned):
    """Write a vector in the coordinates of a box in those of the space."""
    for k in range(3):
        turned[k] = (
            boxes.axes[b, 0, k] * vector[0]
            + boxes.axes[b, 1, k] * vector[1]
            + boxes.axes[b, 2, k] * vector[2]
        )


@kernel
def _add_sums(b, row, own, boxes, spacing, boundary):
    """Add the sums of a box in its own coordinates to those of a row."""
    axes, sums = boxes.axes, boundary.sums
    sums[row, 0] += own[0]
    sums[row, 1] += own[1]
    for k in range(3):
        pushed = axes[b, 0, k] * own[2] + axes[b, 1, k] * own[3] + axes[b, 2, k] * own[4]
        sums[row, 2 + k] += pushed / spacing
    for apart in range(3):  # xx, yy, zz, then xy, yz, then xz
        for k in range(3 - apart):
            m = k + apart
            place = 5 + k if apart == 0 else (9 if apart == 2 else (8 if k == 0 else 10))
            x, y, z = axes[b, 0, k], axes[b, 1, k], axes[b, 2, k]
            u, v, w = axes[b, 0, m], axes[b, 1, m], axes[b, 2, m]
            sums[row, place] += (
                own[5] * x * u
                + own[6] * y * v
                + own[7] * z * w
                + own[8] * (x * v + y * u)
                + own[9] * (x * w + z * u)
                + own[10] * (y * w + z * v)
            )
    for vector in range(11, own.size, 3):
        for k in range(3):
            turned = axes[b, 0, k] * own[vector] + axes[b, 1, k] * own[vector + 1]
            sums[row, vector + k] += turned / (1.0 if vector == 11 else spacing)


@kernel
def _write_ends(b, boxes, spacing, is_over_face, room, beyond):
    """Write the ends of the solid of a box as the sums see them from the place in the room."""
    for k in range(3):
        place = room.here[k]
        room.lower[k] = stretched((boxes.inner_lower[b, k] - place) / spacing, beyond)
        room.upper[k] = stretched((boxes.inner_upper[b, k] - place) / spacing, beyond)
        if boxes.is_thin[b, k] and is_over_face:
            if room.normal[k] > 0.0 and boxes.number[b, k, 0] >= 0:
                room.lower[k] = -np.inf
            elif room.normal[k] < 0.0 and boxes.number[b, k, 1] >= 0:
                room.upper[k] = np.inf


@kernel
def push_across(b, boxes, table, spacing, room):
    """Return the part of G that a box has across its face in front of a place, 1/m.

    Where other boxes go on beside or under it, so does it: along a free-slip wall beside it the
    fluid goes on as in a mirror, and the face with it.
    """
    normal, lower, upper, own = room.normal, room.lower, room.upper, room.own
    q, radius, ends = 0.0, table.radius, 0
    _write_ends(b, boxes, spacing, True, room, beyond_of(table))
    for k in range(3):
        lower[k] = lower[k] if boxes.number[b, k, 0] >= 0 else -np.inf
        upper[k] = upper[k] if boxes.number[b, k, 1] >= 0 else np.inf
        if normal[k] != 0.0:
            q = -upper[k] if normal[k] > 0.0 else lower[k]
        elif lower[k] > -radius or upper[k] < radius:
            ends += 1
    if ends == 0:
        return push_beyond(q, beyond_of(table)) / spacing
    box_sums(lower, upper, own, table)
    return abs(own[2] * normal[0] + own[3] * normal[1] + own[4] * normal[2]) / spacing


@kernel
def nearest_floor(x, y, z, boxes, listed, here):
    """Return which part of a floor that bends is nearest to a place, of those listed, or -1."""
    under, nearest = -1, np.inf
    for b in listed:
        if boxes.is_floor[b]:
            place_in(b, x, y, z, boxes, here)
            distance = distance_to(b, here, boxes)
            if distance < nearest:
                under, nearest = b, distance
    return under


class Room(NamedTuple):
    """Room for what is asked of one place after the other, of float64.

    Attributes
    ----------
    here : (3,) array, m
        The place in the coordinates of a box.
    normal, turned : (3,) arrays
        Normal of a face in these, and in those of the space.
    lower, upper : (3,) arrays
        Ends of the solid of the sums from there, in spacings as the sums see them.
    own : (11 or 17,) array
        Sums of a box.
    """

    here: Floats
    normal: Floats
    turned: Floats
    lower: Floats
    upper: Floats
    own: Floats


@kernel
def _is_behind(b, x, y, z, distance, boxes, listed, spacing, room):
    """Return whether another box stands on the face of box b where a place is over it.

    ``room.normal`` is that of the face in the coordinates of the box; ``room.turned`` is written.
    """
    if len(listed) == 1:
        return False
    _turn_back(b, boxes, room.normal, room.turned)
    off = COPLANAR * spacing - distance
    x, y, z = x + off * room.turned[0], y + off * room.turned[1], z + off * room.turned[2]
    for c in listed:
        if c != b and not (boxes.is_floor[b] and boxes.is_floor[c]):
            place_in(c, x, y, z, boxes, room.lower)
            if distance_to(c, room.lower, boxes) < 0.0:
                return True
    return False


@kernel
def survey_at(i, position, boxes, listed, table, spacing, boundary, room):
    """Write sums and faces of particle i, which has a row, before the listed boxes."""
    row, reach = boundary.row[i], table.radius * spacing
    here, normal, lower, upper, own = room.here, room.normal, room.lower, room.upper, room.own
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    for s in range(own.size):
        boundary.sums[row, s] = 0.0
    boundary.faces[row] = 0
    under = nearest_floor(x, y, z, boxes, listed, here)
    has_edges = False
    for b in listed:
        place_in(b, x, y, z, boxes, here)
        distance, number, kind = face_of(b, here, boxes, normal)
        # the parts of a floor hide each other where they go on beneath
        if distance >= reach or (boxes.is_floor[b] and b != under):
            continue
        _write_ends(b, boxes, spacing, kind < 2, room, beyond_of(table))
        is_half_space = box_sums(lower, upper, own, table)
        _add_sums(b, row, own, boxes, spacing, boundary)
        if kind > 1:
            has_edges = True
        elif number >= 0 and not _is_behind(b, x, y, z, distance, boxes, listed, spacing, room):
            push = -(own[2] * normal[0] + own[3] * normal[1] + own[4] * normal[2]) / spacing
            if not is_half_space:
                push = push_across(b, boxes, table, spacing, room)
            _turn_back(b, boxes, normal, room.turned)
            insert_face(row, distance, room.turned, number, push, False, boundary)
    if not has_edges:
        return
    for b in listed:  # edges last, since faces tell which of them are seams
        place_in(b, x, y, z, boxes, here)
        distance, number, kind = face_of(b, here, boxes, normal)
        if distance >= reach or (boxes.is_floor[b] and b != under) or kind < 2 or number < 0:
            continue
        _write_ends(b, boxes, spacing, False, room, beyond_of(table))
        box_sums(lower, upper, own, table)
        push = -(own[2] * normal[0] + own[3] * normal[1] + own[4] * normal[2]) / spacing
        _turn_back(b, boxes, normal, room.turned)
        if not _is_seam(row, distance, room.turned, spacing, boundary):
            insert_face(row, distance, room.turned, number, push, True, boundary)


@allocating_kernel
def _survey(first, last, position, boxes, nearby, table, spacing, boundary):
    a, b, c, d, e = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    room = Room(a, b, c, d, e, np.empty(boundary.sums.shape[1]))
    for i in range(first, last):
        if boundary.row[i] >= 0:
            listed = nearby.box[nearby.start[i] : nearby.start[i + 1]]
            survey_at(i, position, boxes, listed, table, spacing, boundary, room)


@loop
def survey(position, boxes, nearby, table, spacing, boundary):
    """Write sums and faces of all particles that have a row.

    Parameters
    ----------
    position : (n, 3) float64 array, m
    boxes : Boxes
    nearby : Nearby
        The boxes within reach of each particle.
    table : Octants or Quadrants
    spacing : float, m
    boundary : Boundary
        Changed.
    """
    n = boundary.row.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _survey(first, last, position, boxes, nearby, table, spacing, boundary)
