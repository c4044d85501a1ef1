"""The table of a probe of the height of the fluid."""

from __future__ import annotations

from typing import Literal, Self

from debrisflow.case.fields import quantity
from debrisflow.case.probe import SIZE, SIZE_SPACINGS, Faults, Probe, Space


class HeightProbe(Probe):
    """Height of the fluid above what it stands on: the floor, or the top of an obstacle."""

    type: Literal["height"]
    x: float = quantity("m", "place along x")
    y: float | None = quantity("m", "place along y, in three dimensions", None)
    size: float | None = quantity("m", SIZE.format("over which the height is taken"), None, gt=0)

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the place."""
        yield from space.coordinate_faults("y", self.y)
        yield from space.place_faults(x=self.x, y=self.y)

    def complete(self, spacing: float) -> Self:
        """Return the probe with its size."""
        return self.model_copy(update={"size": self.side(spacing)})

    def side(self, spacing: float) -> float:
        """Return the size, m; a multiple of the spacing if it is left out."""
        return SIZE_SPACINGS * spacing if self.size is None else self.size
