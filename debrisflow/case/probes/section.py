"""The table of a probe of what flows through a section."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import quantity
from debrisflow.case.probe import SLACK, Fault, Faults, Probe, Space


class SectionProbe(Probe):
    """What flows through the plane x = const."""

    type: Literal["section"]
    x: float = quantity("m", "place of the plane")

    def faults(self, space: Space) -> Faults:
        """Yield a fault if the plane is not in the space, a spacing from its ends."""
        if space.repeats_along_x:
            yield from space.place_faults(x=self.x)
            return
        lower, upper = space.extents["x"]
        first, last = lower + space.spacing, upper - space.spacing
        slack = SLACK * space.spacing
        if not first - slack <= self.x <= last + slack:
            message = f"must be a spacing from the ends, x = [{first:g}, {last:g}] m"
            yield Fault("x", message, self.x)
