"""The table of a probe of the flow on a grid."""

from __future__ import annotations

from collections.abc import Iterator
from math import floor, prod
from typing import Literal, Self

from debrisflow.case.fields import Interval, quantity
from debrisflow.case.probe import TOLERANCE, Fault, Faults, Probe, Space
from debrisflow.case.words import ABSENT

EXTENT = "extent along {}; a plane where both numbers are the same"
MOST_POINTS = 2_000_000


class GridProbe(Probe):
    """Velocity, pressure and concentration of the fluid on a plane, or in a box."""

    type: Literal["grid"]
    x: Interval = quantity("m", EXTENT.format("x"))
    y: Interval = quantity("m", EXTENT.format("y"))
    z: Interval | None = quantity("m", EXTENT.format("z, in three dimensions"), None)
    step: float | None = quantity("m", "distance of the points; a spacing if left out", None, gt=0)

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the box, which is to be in the space, and with its step."""
        yield from space.coordinate_faults("z", self.z)
        for axis, extent in self.extents():
            if extent[0] > extent[1]:
                yield Fault(axis, "the first number must not be greater than the second", extent)
                return
            for at in extent:
                for fault in space.place_faults(**{axis: at}):
                    yield fault._replace(value=extent)
                    return
        count = prod(self.counts(space.spacing))
        if count > MOST_POINTS:
            message = f"the grid has {count} points; at most {MOST_POINTS}, with a greater step"
            yield Fault("step", message, ABSENT if self.step is None else self.step)

    def complete(self, spacing: float) -> Self:
        """Return the probe with its step."""
        return self.model_copy(update={"step": self.distance(spacing)})

    def distance(self, spacing: float) -> float:
        """Return the distance of the points, m; the spacing if it is left out."""
        return spacing if self.step is None else self.step

    def extents(self) -> Iterator[tuple[str, tuple[float, float]]]:
        """Yield axis and extent, m, of the axes that are given."""
        for axis, extent in (("x", self.x), ("y", self.y), ("z", self.z)):
            if extent is not None:
                yield axis, extent

    def counts(self, spacing: float) -> list[int]:
        """Return the number of points along each axis that is given, from its lower end on."""
        step = self.distance(spacing)
        return [1 + floor((high - low) / step + TOLERANCE) for _, (low, high) in self.extents()]
