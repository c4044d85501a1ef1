"""The table of a probe of the flow at a point."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import quantity
from debrisflow.case.probe import Faults, Probe, Space


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
