"""The table of a probe of the flow at a point."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import quantity
from debrisflow.case.probe import Fault, Faults, Probe, Space


class PointProbe(Probe):
    """Velocity, pressure and concentration of the fluid at a point."""

    type: Literal["point"]
    x: float = quantity("m", "place along x")
    y: float = quantity("m", "place along y")
    z: float | None = quantity("m", "place along z, in three dimensions", None)

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the place."""
        yield from space.coordinate_faults("z", self.z)
        yield from space.place_faults(x=self.x, y=self.y, z=self.z)
        within = space.obstacle_around((self.x, self.y, self.z or 0.0))
        if within:
            message = f"the place lies in obstacle.{within}, where there is no fluid"
            yield Fault("x", message, self.x)
