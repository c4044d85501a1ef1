"""How an obstacle moves: a table of its own, which obstacles of all types may have."""

from __future__ import annotations

from itertools import pairwise
from math import dist, hypot

from debrisflow.case.fields import Components, Series, Table, Vector, quantity

DISPLACEMENTS = ("x", "y", "z", "angle")


class Motion(Table):
    """The motion of an obstacle: at a constant velocity from a time on, or by a table.

    Between the rows of a table it is a monotone cubic, so that the velocity has no jumps; after the
    last row the obstacle stands still.  An obstacle that moves out of the space is gone.
    """

    velocity: Components | None = quantity(
        "m/s", "constant velocity, as of a gate that is drawn; instead of a table", None
    )
    start: float = quantity("s", "time at which it begins to move with its velocity", 0.0, ge=0)
    time: Series | None = quantity("s", "times of the table, increasing", None)
    x: Series | None = quantity("m", "displacement along x at these times, the first one 0", None)
    y: Series | None = quantity("m", "displacement along y", None)
    z: Series | None = quantity("m", "displacement along z, in three dimensions", None)
    angle: Series | None = quantity(
        "degree", "angle by which it has turned from the x axis upward, as a flap", None
    )
    about: Vector | None = quantity(
        "m", "x and level (y, in three dimensions z) of the axis that it turns about", None
    )

    @property
    def greatest_speed(self) -> float:
        """The greatest speed without turning, m/s; of a table the mean between two rows."""
        if self.velocity is not None:
            return hypot(*self.velocity)
        columns = [column for name, column in self.table.items() if name != "angle"]
        places = list(zip(*columns, strict=True))
        rows = list(zip(self.time or (), places, strict=False))
        return max(
            (dist(a, b) / (end - start) for (start, a), (end, b) in pairwise(rows)), default=0.0
        )

    @property
    def table(self) -> dict[str, Series]:
        """The columns of the table that are given, by their names, without the times."""
        given = {name: getattr(self, name) for name in DISPLACEMENTS}
        return {name: column for name, column in given.items() if column is not None}
