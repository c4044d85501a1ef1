"""The table of a probe of the pressure on a structure by height."""

from __future__ import annotations

from math import hypot
from typing import ClassVar, Literal

from debrisflow.case.fields import NONE, Vector, quantity
from debrisflow.case.probe import Fault, Faults, Probe, Space
from debrisflow.case.words import either


class BandsProbe(Probe):
    """Force and pressure on an obstacle in bands of equal height, in three dimensions."""

    reads_reactions: ClassVar[bool] = True
    type: Literal["bands"]
    wall: str = quantity(NONE, "name of the obstacle")
    bands: int = quantity(
        NONE, "number of bands between the lowest ground at the obstacle and its top", ge=1, le=200
    )
    direction: Vector = quantity(
        NONE, "direction in plan in which the flow pushes, of any length", (1.0, 0.0)
    )

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the obstacle and the direction."""
        if space.dimension == 2:
            message = "only in three dimensions; in two use 'pressure' or 'force'"
            yield Fault("type", message, self.type)
        elif self.wall not in space.obstacles:
            known = f": {either(list(space.obstacles))}" if space.obstacles else ""
            yield Fault("wall", f"must be an obstacle{known}", self.wall)
        elif getattr(space.obstacles[self.wall], "motion", None) is not None:
            message = "the obstacle moves, which bands cannot follow; use type = 'force'"
            yield Fault("wall", message, self.wall)
        if hypot(*self.direction) == 0.0:
            yield Fault("direction", "has no length", self.direction)
