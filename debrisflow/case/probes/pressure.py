"""The table of a probe of the pressure on a patch of a wall."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from debrisflow.case.fields import NONE, quantity
from debrisflow.case.probe import (
    SIZE,
    SIZE_SPACINGS,
    SLACK,
    TOLERANCE,
    Fault,
    Faults,
    Probe,
    Space,
)


class PressureProbe(Probe):
    """Mean pressure on a patch of a wall or an obstacle."""

    reads_reactions: ClassVar[bool] = True
    type: Literal["pressure"]
    wall: str = quantity(NONE, "name of the wall (floor, left, ...) or of the obstacle")
    x: float = quantity("m", "middle of the patch along x")
    y: float = quantity("m", "middle of the patch along y")
    z: float | None = quantity("m", "middle of the patch along z, in three dimensions", None)
    size: float | None = quantity("m", SIZE.format("over which the pressure acts"), None, gt=0)

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the place, which is to be within a spacing of the wall."""
        yield from space.coordinate_faults("z", self.z)
        yield from space.place_faults(x=self.x, y=self.y, z=self.z)
        yield from space.wall_faults(self.wall)
        if getattr(space.obstacles.get(self.wall), "motion", None) is not None:
            message = "it moves, and a patch does not; ask for the force on it: type = 'force'"
            yield Fault("wall", message, self.wall)
            return
        distance = space.distance_to(self.wall, (self.x, self.y, self.z or 0.0))
        if distance is not None and distance > space.spacing * (1 + SLACK):
            message = f"the place is {distance:.3g} m from that wall; at most a spacing"
            yield Fault("wall", message, self.wall)

    def complete(self, spacing: float) -> Self:
        """Return the probe with its size."""
        return self.model_copy(update={"size": self.side(spacing)})

    def warning(self, spacing: float) -> str:
        """Return that its patch is smaller than a spacing."""
        if self.side(spacing) >= (1.0 - TOLERANCE) * spacing:
            return ""
        return "patch smaller than a spacing; single particles press on it, less evenly than on two"

    def side(self, spacing: float) -> float:
        """Return the size, m; a multiple of the spacing if it is left out."""
        return SIZE_SPACINGS * spacing if self.size is None else self.size
