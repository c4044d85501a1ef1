"""The table of a probe of the flow along a line."""

from __future__ import annotations

from math import ceil, dist
from typing import Literal, Self

from debrisflow.case.fields import NONE, Components, quantity
from debrisflow.case.probe import TOLERANCE, Fault, Faults, Probe, Space
from debrisflow.case.words import ABSENT

MOST_POINTS = 100_000
WORDS = {2: "two", 3: "three"}


class LineProbe(Probe):
    """Velocity, pressure and concentration of the fluid at points along a straight line."""

    type: Literal["line"]
    start: Components = quantity("m", "first point of the line")
    end: Components = quantity("m", "last point of the line")
    points: int | None = quantity(
        NONE, "number of points, both ends among them; one a spacing if left out", None, ge=2
    )

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the ends."""
        for field, place in (("start", self.start), ("end", self.end)):
            if len(place) != space.dimension:
                message = (
                    f"a point in {WORDS[space.dimension]} dimensions has {space.dimension} numbers"
                )
                yield Fault(field, message, place)
                return
            for fault in space.place_faults(**dict(zip("xyz", place, strict=False))):
                yield Fault(field, fault.message, place)
        if dist(self.start, self.end) <= TOLERANCE * space.spacing:
            yield Fault("end", "the line has no length", self.end)
        elif self.count(space.spacing) > MOST_POINTS:
            message = f"the line has {self.count(space.spacing)} points; at most {MOST_POINTS}"
            yield Fault("points", message, ABSENT if self.points is None else self.points)

    def complete(self, spacing: float) -> Self:
        """Return the probe with its number of points."""
        return self.model_copy(update={"points": self.count(spacing)})

    def count(self, spacing: float) -> int:
        """Return the number of points; at most a spacing apart if it is left out."""
        between = ceil(dist(self.start, self.end) / spacing - TOLERANCE)
        return 1 + max(1, between) if self.points is None else self.points
