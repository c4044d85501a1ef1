"""The table of a probe of the volume in a box."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import Interval, quantity
from debrisflow.case.probe import Faults, Probe, Space


class VolumeProbe(Probe):
    """Volume of the fluid, and of the sediment in it, inside a box: what a dam has trapped."""

    type: Literal["volume"]
    x: Interval = quantity("m", "extent along x")
    y: Interval = quantity("m", "extent along y")
    z: Interval | None = quantity("m", "extent along z, in three dimensions", None)

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the box, a part of which is to be in the space."""
        yield from space.coordinate_faults("z", self.z)
        yield from space.extent_faults(x=self.x, y=self.y, z=self.z)
