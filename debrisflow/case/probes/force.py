"""The table of a probe of the force on a wall."""

from __future__ import annotations

from typing import ClassVar, Literal

from debrisflow.case.fields import NONE, Components, quantity
from debrisflow.case.probe import Fault, Faults, Probe, Space


class ForceProbe(Probe):
    """Force and moment on a whole wall or obstacle; in the form study those of the pressure."""

    reads_reactions: ClassVar[bool] = True
    type: Literal["force"]
    wall: str = quantity(NONE, "name of the wall (floor, left, ...) or of the obstacle")
    about: Components = quantity("m", "point about which the moment is taken", (0.0, 0.0))

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the point and the wall."""
        if space.dimension == 2 and len(self.about) == 3:
            yield Fault("about", "a point in two dimensions has 2 numbers", self.about)
        yield from space.wall_faults(self.wall)
