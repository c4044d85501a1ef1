"""The obstacles of a case that move: their surfaces, put where they are at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.boundary import WallMotion
from debrisflow.neighbors.boxes import Boxes
from debrisflow.neighbors.elements import Elements
from debrisflow.space.bodies import bodies_of
from debrisflow.space.domain import WALL_NAMES, wall_names
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]


class MovingWalls:
    """Moves the boxes and elements of obstacles, in place.

    Parameters
    ----------
    case : ResolvedCase
    boxes : Boxes
        Of all bodies of the case, in their order.
    elements : Elements
        Both as at the start; changed by :meth:`place`.

    Attributes
    ----------
    motion : WallMotion or None
        None where no wall moves.
    moves_elements : bool
    speed : float, m/s
        The greatest of a moving obstacle at the time of the last :meth:`place`.
    """

    def __init__(self, case: ResolvedCase, boxes: Boxes, elements: Elements) -> None:
        self._ways = trajectories(case)
        self._boxes, self._elements = boxes, elements
        self._at_start = boxes.origin.copy(), boxes.axes.copy()
        surface = elements.corners, elements.middle, elements.inner, elements.normal
        self._elements_at_start = tuple(array.copy() for array in surface)
        number = np.array([body.number for body in bodies_of(case)])
        self._own = {wall: np.flatnonzero(number == wall) for wall in self._ways}
        self._own_elements = {wall: elements.number == wall for wall in self._ways}
        self.moves_elements = any(own.any() for own in self._own_elements.values())
        self.motion = self._motion(case)
        self.speed = 0.0
        self._corners: list[Floats] = []
        self._listed: list[Floats] = []

    def _motion(self, case: ResolvedCase) -> WallMotion | None:
        velocity = np.zeros((len(wall_names(case)), 3))
        for number, name in enumerate(WALL_NAMES):
            velocity[number, :2] = getattr(case.walls, name).velocity
        if not (self._ways or velocity.any()):
            return None
        return WallMotion(velocity, np.zeros_like(velocity), np.zeros_like(velocity))

    def place(self, time: float) -> None:
        """Put all that moves where it is at a time, s; before 0 it stands as at 0."""
        if not self._ways or self.motion is None:
            return
        time, self.speed, self._corners = max(time, 0.0), 0.0, []
        for wall, way in self._ways.items():
            pose = way.pose(time)
            rows, own = self._own[wall], self._own_elements[wall]
            origin, axes = self._at_start
            self._boxes.origin[rows] = pose.moved(origin[rows])
            self._boxes.axes[rows] = pose.turned(axes[rows])
            corners, middle, inner, normal = self._elements_at_start
            self._elements.corners[own] = pose.moved(corners[own])
            self._elements.middle[own] = pose.moved(middle[own])
            self._elements.inner[own] = pose.moved(inner[own])
            self._elements.normal[own] = pose.turned(normal[own])
            self.motion.velocity[wall], self.motion.spin[wall] = way.velocity(time)
            self.motion.axis[wall] = pose.axis + pose.displacement
            self.speed = max(self.speed, way.speed(time))
            self._corners.append(pose.moved(way.corners))

    def remember(self) -> None:
        """Remember where all stands, since the lists are built there."""
        self._listed = self._corners

    @property
    def path(self) -> float:
        """By how much a point of an obstacle has moved since the lists were built, m."""
        return max(
            (
                float(np.linalg.norm(now - before, axis=1).max())
                for now, before in zip(self._corners, self._listed, strict=True)
            ),
            default=0.0,
        )
