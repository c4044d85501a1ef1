"""The boxes that fills and bed cover, as far as the case file tells them."""

from __future__ import annotations

from math import prod
from typing import NamedTuple

from debrisflow.case.tables import Bed, Block, Channel, Particles, Tank, Tank3D

Geometry = Tank | Channel | Tank3D
WEIR_SPACINGS = 4


class Region(NamedTuple):
    """An upright rectangle or box, m: its lower and upper end along each axis."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @property
    def volume(self) -> float:
        """Area, m2, or volume, m3; 0 where an interval is turned around."""
        return prod(max(b - a, 0.0) for a, b in zip(self.lower, self.upper, strict=True))

    def overlap(self, other: Region) -> Region:
        """Return what two regions share; its volume is 0 if that is nothing."""
        return Region(
            tuple(map(max, self.lower, other.lower)), tuple(map(min, self.upper, other.upper))
        )

    def shrunk(self, margin: float) -> Region:
        """Return the region less a margin on every side."""
        return Region(tuple(a + margin for a in self.lower), tuple(b - margin for b in self.upper))

    def holds(self, other: Region) -> bool:
        """Tell whether the other region lies within this one."""
        return self.overlap(other) == other

    def __str__(self) -> str:
        """Return the extents as in a case file."""
        ends = zip("xyz", self.lower, self.upper, strict=False)
        return ", ".join(f"{axis} = [{a:.6g}, {b:.6g}] m" for axis, a, b in ends)


def bed_end(geometry: Channel, particles: Particles) -> float:
    """Return the x at which the recess ends, m: given, or a weir before the run-out or the end."""
    if geometry.bed_end is not None:
        return geometry.bed_end
    if geometry.periodic:
        return geometry.length
    end = geometry.length if geometry.runout_start is None else geometry.runout_start
    # Rounded to picometers so that 7 - 4 * 0.02 is written as 6.92.
    return round(end - WEIR_SPACINGS * particles.spacing, 12)


def recess(geometry: Geometry, particles: Particles) -> Region | None:
    """Return the recess of a channel, None where there is none."""
    if not isinstance(geometry, Channel) or geometry.bed_thickness == 0:
        return None
    end = bed_end(geometry, particles)
    return Region((geometry.bed_start, -geometry.bed_thickness), (end, 0.0))


def covered(part: Block | Bed, geometry: Geometry, particles: Particles) -> Region | None:
    """Return what a fill covers, None for a bed without a recess.

    A block in three dimensions that states no z covers nothing.
    """
    if isinstance(part, Bed):
        return recess(geometry, particles)
    extents = [part.x, part.y]
    if isinstance(geometry, Tank3D):
        extents.append(part.z or (0.0, 0.0))
    return Region(tuple(e[0] for e in extents), tuple(e[1] for e in extents))


def open_space(geometry: Geometry, particles: Particles) -> list[Region]:
    """Return the regions in which a fill may lie, each on its own.

    A block over the weir starts at its crest; one that also fills the recess stays between its
    steps.
    """
    if isinstance(geometry, Tank3D):
        return [Region((0.0, 0.0, 0.0), (geometry.length, geometry.width, geometry.height))]
    if isinstance(geometry, Tank):
        return [Region((0.0, 0.0), (geometry.width, geometry.height))]
    crest = 0.0 if geometry.periodic else geometry.weir_height
    end = bed_end(geometry, particles) if crest > 0 else geometry.length
    spaces = [
        Region((0.0, 0.0), (end, geometry.height)),
        Region((0.0, crest), (geometry.length, geometry.height)),
    ]
    hollow = recess(geometry, particles)
    if hollow is not None:
        spaces.append(Region(hollow.lower, (hollow.upper[0], geometry.height)))
    return spaces
