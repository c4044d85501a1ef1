"""The table of a probe of what a dam holds back, and what flows over it."""

from __future__ import annotations

from math import hypot
from typing import Literal, Self

from debrisflow.case.fields import NONE, Vector, quantity
from debrisflow.case.probe import DIGITS, Fault, Faults, Probe, Space
from debrisflow.case.words import either


class DamProbe(Probe):
    """Volume that an obstacle holds back, when it is overtopped, and what has flowed over it."""

    type: Literal["dam"]
    wall: str = quantity(NONE, "name of the obstacle")
    direction: Vector = quantity(
        NONE, "direction in plan in which the flow comes, of any length", (1.0, 0.0)
    )
    crest: float | None = quantity(
        "m",
        "level of the crest, or of the sill of a notch; the top of the obstacle if left out",
        None,
    )

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the obstacle and the direction."""
        if space.dimension == 2:
            yield Fault("type", "only in three dimensions; in two use 'volume'", self.type)
        elif self.wall not in space.obstacles:
            known = f": {either(list(space.obstacles))}" if space.obstacles else ""
            yield Fault("wall", f"must be an obstacle{known}", self.wall)
        elif getattr(space.obstacles[self.wall], "motion", None) is not None:
            yield Fault("wall", "it moves; a dam stands still", self.wall)
        if hypot(*self.direction) == 0.0:
            yield Fault("direction", "has no length", self.direction)
        for fault in space.place_faults(z=self.crest):
            yield Fault("crest", fault.message, self.crest)

    def moved(self, by: tuple[float, float, float]) -> Self:
        """Return the probe with its crest measured from another level."""
        if self.crest is None:
            return self
        return self.model_copy(update={"crest": round(self.crest + by[2], DIGITS)})
