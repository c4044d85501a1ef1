"""The rectangles that fills and bed cover, as far as the case file tells them."""

from __future__ import annotations

from typing import NamedTuple

from debrisflow.case.defaults import bed_end
from debrisflow.case.tables import Bed, Block, Channel, Particles, Tank


class Rectangle(NamedTuple):
    """An upright rectangle, m."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def area(self) -> float:
        """Area, m2; 0 where an interval is turned around."""
        return max(self.right - self.left, 0.0) * max(self.top - self.bottom, 0.0)

    def overlap(self, other: Rectangle) -> Rectangle:
        """Return what two rectangles share; its area is 0 if that is nothing."""
        return Rectangle(
            max(self.left, other.left),
            min(self.right, other.right),
            max(self.bottom, other.bottom),
            min(self.top, other.top),
        )

    def shrunk(self, margin: float) -> Rectangle:
        """Return the rectangle less a margin on every side."""
        return Rectangle(
            self.left + margin, self.right - margin, self.bottom + margin, self.top - margin
        )

    def holds(self, other: Rectangle) -> bool:
        """Tell whether the other rectangle lies within this one."""
        return (
            self.left <= other.left
            and other.right <= self.right
            and self.bottom <= other.bottom
            and other.top <= self.top
        )

    def __str__(self) -> str:
        """Return the extents as in a case file."""
        return (
            f"x = [{self.left:.6g}, {self.right:.6g}] m, y = [{self.bottom:.6g}, {self.top:.6g}] m"
        )


def recess(geometry: Tank | Channel, particles: Particles) -> Rectangle | None:
    """Return the recess of a channel, None where there is none."""
    if isinstance(geometry, Tank) or geometry.bed_thickness == 0:
        return None
    end = bed_end(geometry, particles)
    return Rectangle(geometry.bed_start, end, -geometry.bed_thickness, 0.0)


def covered(part: Block | Bed, geometry: Tank | Channel, particles: Particles) -> Rectangle | None:
    """Return what a fill covers, None for a bed without a recess."""
    if isinstance(part, Bed):
        return recess(geometry, particles)
    return Rectangle(*part.x, *part.y)


def open_space(geometry: Tank | Channel, particles: Particles) -> list[Rectangle]:
    """Return the rectangles in which a fill may lie, each on its own.

    A block over the weir starts at its crest; one that also fills the recess stays between its
    steps.
    """
    if isinstance(geometry, Tank):
        return [Rectangle(0.0, geometry.width, 0.0, geometry.height)]
    crest = 0.0 if geometry.periodic else geometry.weir_height
    end = bed_end(geometry, particles) if crest > 0 else geometry.length
    spaces = [
        Rectangle(0.0, end, 0.0, geometry.height),
        Rectangle(0.0, geometry.length, crest, geometry.height),
    ]
    hollow = recess(geometry, particles)
    if hollow is not None:
        spaces.append(hollow._replace(top=geometry.height))
    return spaces
