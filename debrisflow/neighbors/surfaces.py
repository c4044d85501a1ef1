"""The walls of a run as surfaces: who is near them, and what they make the particles feel."""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.boundary import (
    Boundary,
    Walls,
    boundary_of,
    insert_face,
    write_velocities,
)
from debrisflow.neighbors.boxes import Boxes, survey
from debrisflow.neighbors.elements import Elements, add_elements, add_sphere, face_of_elements
from debrisflow.neighbors.half_space import PULLED_BACK, STRETCH
from debrisflow.neighbors.height_field import HeightField, add_ground, find_near_ground
from debrisflow.neighbors.lists import FixedNeighbors, Neighbors
from debrisflow.neighbors.near_boxes import cut_pairs, near_boxes
from debrisflow.neighbors.octant import Octants, beyond_of
from debrisflow.neighbors.pairs import BLOCK, repeats_of
from debrisflow.neighbors.quadrant import HX, N, Quadrants
from debrisflow.neighbors.rows import add_rows

Floats = NDArray[np.float64]


@kernel
def survey_elements_at(i, position, listed, count, elements, radius, spacing, boundary, room):
    """Add what particle i, which has a row, feels of the elements of closed surfaces.

    The nearest face, and in a hollow of a body a second one that turns away from it.  In two
    dimensions the toe of a flat wedge, ahead, is none while no row of the wedge is in reach: as a
    face it would stop what runs up the wedge.
    """
    row, first, normal, own = boundary.row[i], room[0], room[1], room[2]
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    total, reach = boundary.sums[row], radius * spacing
    own[:] = 0.0
    first[:] = 0.0
    if boundary.dimension < 3.0:
        add_rows(x, y, listed, count, elements, radius, spacing, own)
    else:
        add_elements(x, y, z, listed, count, elements, radius, spacing, STRETCH, own)
    for f in range(2):
        distance, number, is_edge = face_of_elements(
            x, y, z, listed, count, elements, reach, f == 1, first, normal
        )
        is_inside = f == 0 and number >= 0 and distance < -PULLED_BACK * spacing
        if is_inside and boundary.dimension == 3.0:
            add_sphere(radius, own)
        is_toe = boundary.dimension < 3.0 and is_edge and own[N] == 0.0
        if number >= 0 and not is_toe:
            push = -(own[2] * normal[0] + own[3] * normal[1] + own[4] * normal[2]) / spacing
            insert_face(row, distance, normal, number, push, is_edge, boundary)
        for k in range(3):
            first[k] = normal[k]
    for s in range(own.size):
        total[s] += own[s] / spacing if 2 <= s <= 4 or s >= HX else own[s]


@allocating_kernel
def _survey_elements(begin, end, position, index, row, count, elements, radius, spacing, boundary):
    room = (np.empty(3), np.empty(3), np.empty(boundary.sums.shape[1]))
    for i in range(begin, end):
        if count[i] > 0:
            listed = index[row[i]]
            survey_elements_at(
                i, position, listed, count[i], elements, radius, spacing, boundary, room
            )


@loop
def survey_elements(position, index, row, count, elements, radius, spacing, boundary):
    """Add to sums and faces of all particles what they feel of closed surfaces.

    ``index``, ``row`` and ``count`` are the lists of
    :class:`debrisflow.neighbors.lists.FixedNeighbors` among the elements.
    """
    for block in prange((count.size + BLOCK - 1) // BLOCK):
        begin, end = block * BLOCK, min(block * BLOCK + BLOCK, count.size)
        _survey_elements(
            begin, end, position, index, row, count, elements, radius, spacing, boundary
        )


class Surfaces:
    """The walls of a case, and what the particles feel of them at a step.

    Parameters
    ----------
    boxes : Boxes
    table : Octants or Quadrants
    spacing : float, m
    walls : Walls
    elements : Elements
        Of closed surfaces, with their images in a domain that repeats.
    ground : HeightField or None
    skin : float
        The greatest skin of the lists, in spacings.
    period : (3,) float64 array, m
        Of the domain, 0 along axes along which it does not repeat.
    """

    def __init__(
        self,
        boxes: Boxes,
        table: Octants | Quadrants,
        spacing: float,
        walls: Walls,
        elements: Elements,
        ground: HeightField | None,
        skin: float,
        period: Floats,
    ) -> None:
        self._boxes, self._table, self._spacing = boxes, table, spacing
        self._walls, self._elements, self._ground = walls, elements, ground
        self._period, self._greatest_skin = period, skin
        self._lists: FixedNeighbors | None = None
        self.sort_elements()

    def sort_elements(self) -> None:
        """Sort the elements anew, which have moved."""
        if self._elements.area.size:
            reach = self._table.radius * self._spacing
            self._lists = FixedNeighbors(
                self._elements.middle, reach, self._spacing, np.zeros(3), self._greatest_skin
            )

    def build(self, position: Floats, skin: float) -> None:
        """Find who comes near a wall before the lists, which have a skin, m, are built again."""
        reach = self._table.radius * self._spacing + skin
        self._built_at = position.copy()
        self._nearby = near_boxes(position, self._boxes, reach)
        is_near = np.diff(self._nearby.start) > 0
        if self._ground is not None:
            find_near_ground(position, self._ground, reach, is_near)
        if self._lists is not None:
            self._lists.set_skin(skin / self._spacing)
            self._lists.build(position)
            is_near |= self._lists.count > 0
        row = np.where(is_near, np.cumsum(is_near) - 1, -1).astype(np.int32)
        sums = self._table.sums.shape[-1]
        self._boundary = boundary_of(row, self._walls, beyond_of(self._table), sums)

    def cut(self, position: Floats, lists: Neighbors) -> None:
        """Take from fresh lists of the fluid the pairs that plates keep apart."""
        if np.any(self._boxes.is_thin):
            row, boxes = self._boundary.row, self._boxes
            cut_pairs(position, row, repeats_of(lists.period), boxes, lists.index, lists.count)

    def survey(self, position: Floats) -> Boundary:
        """Return what the particles feel at their present places.

        A particle that has since come in again at the other end of a domain that repeats is looked
        up where it left it, since its list holds the images of walls beyond that end.
        """
        if self._period.any():
            repeat = np.where(self._period > 0.0, self._period, np.inf)
            moved = position - self._built_at
            position = position - np.where(self._period > 0.0, self._period, 0.0) * np.rint(
                moved / repeat
            )
        radius, spacing = self._table.radius, self._spacing
        survey(position, self._boxes, self._nearby, self._table, spacing, self._boundary)
        if self._ground is not None:
            add_ground(position, self._ground, spacing, self._boundary)
        if self._lists is not None:
            survey_elements(
                position,
                self._lists.index,
                self._lists.row,
                self._lists.count,
                self._elements,
                radius,
                spacing,
                self._boundary,
            )
        if self._walls.motion is not None:
            write_velocities(position, self._walls.motion, self._boundary)
        return self._boundary
