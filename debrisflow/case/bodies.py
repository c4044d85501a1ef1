"""Bodies given by their shape: obstacles, which may move, and what a closed mesh encloses."""

from __future__ import annotations

from math import cos, radians, sin
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from debrisflow.case.fields import (
    NAME_PATTERN,
    NONE,
    Components,
    Interval,
    Point,
    Table,
    Vector,
    quantity,
)
from debrisflow.case.materials import pore_pressure_decay, pore_pressure_share
from debrisflow.case.motion import Motion

Number = TypeVar("Number", float, NDArray[np.float64])
MESH_FILE = "closed surface of triangles: an STL, OBJ or PLY file, looked for beside the case"


class MeshFill(Table):
    """What a closed surface of triangles encloses, filled with particles on a lattice."""

    type: Literal["mesh"]
    file: str = quantity(NONE, MESH_FILE)
    scale: float = quantity(NONE, "factor from the lengths of the file to meters", 1.0, gt=0)
    offset: Point = quantity("m", "displacement of the scaled mesh", (0.0, 0.0, 0.0))
    material: Literal["water", "mixture"] = quantity(
        NONE, "water; mixture (one kind of particle for sediment and water)"
    )
    velocity: Components = quantity("m/s", "initial velocity", (0.0, 0.0))
    pore_pressure: float = pore_pressure_share()
    pore_pressure_time: float | None = pore_pressure_decay()


def _obstacle_name() -> Any:
    return quantity(NONE, "name of the obstacle, by which probes refer to it", pattern=NAME_PATTERN)


def _slip() -> Any:
    return quantity(NONE, "condition along the wall", "no-slip")


def _motion() -> Any:
    return quantity(
        NONE,
        "how it moves; a table, or a CSV file beside the case with the columns time and any of "
        "x, y, z; it stands still if left out",
        None,
    )


class BoxObstacle(Table):
    """A box of wall in the way of the flow, in two dimensions a rectangle."""

    type: Literal["box"]
    name: str = _obstacle_name()
    x: Interval = quantity("m", "extent along x")
    y: Interval = quantity("m", "extent along y")
    z: Interval | None = quantity("m", "extent along z, in three dimensions", None)
    turn: float = quantity(
        "degree",
        "by which it is turned about the vertical through its middle, to the left as seen from "
        "above; on a terrain only",
        0.0,
        ge=-360,
        le=360,
    )
    slip: Literal["no-slip", "free-slip"] = _slip()
    motion: Motion | str | None = _motion()

    @property
    def extents(self) -> tuple[Interval, ...]:
        """Its extents along the axes of the space; the last one is upward."""
        return (self.x, self.y) if self.z is None else (self.x, self.y, self.z)

    def turned(self, x: Number, y: Number, by: float) -> tuple[Number, Number]:
        """Return places in plan, m, turned about its middle to the left by an angle, degrees.

        Examples
        --------
        >>> box = BoxObstacle(type="box", name="a", x=(0.0, 4.0), y=(0.0, 2.0), z=(0.0, 1.0))
        >>> x, y = box.turned(4.0, 1.0, 90.0)
        >>> round(x, 9), round(y, 9)
        (2.0, 3.0)
        """
        if by == 0.0:
            return x, y
        a, b = 0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1])
        along, aside = cos(radians(by)), sin(radians(by))
        return a + along * (x - a) - aside * (y - b), b + aside * (x - a) + along * (y - b)

    def unturned(self, place: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return a place, m, turned back about its middle, by as much as the box is turned."""
        return *self.turned(place[0], place[1], -self.turn), place[2]

    @property
    def corners_in_plan(self) -> tuple[Vector, ...]:
        """Its four corners as seen from above, one after the other around it, m."""
        (x0, x1), (y0, y1) = self.x, self.y
        plain = (x0, y0), (x1, y0), (x1, y1), (x0, y1)
        return tuple(self.turned(x, y, self.turn) for x, y in plain)


class PolygonObstacle(Table):
    """A polygon of wall in the way of the flow, in two dimensions: a wedge, a step, a weir."""

    type: Literal["polygon"]
    name: str = _obstacle_name()
    corners: Annotated[tuple[Vector, ...], Strict(False), Field(min_length=3)] = quantity(
        "m", "its corners (x, y), one after the other around it"
    )
    slip: Literal["no-slip", "free-slip"] = _slip()
    motion: Motion | str | None = _motion()

    @property
    def extents(self) -> tuple[Interval, ...]:
        """Those of the box around it."""
        x, y = zip(*self.corners, strict=True)
        return (min(x), max(x)), (min(y), max(y))


class MeshObstacle(Table):
    """What a closed surface of triangles encloses, as wall in the way of the flow."""

    type: Literal["mesh"]
    name: str = _obstacle_name()
    file: str = quantity(NONE, MESH_FILE)
    scale: float = quantity(NONE, "factor from the lengths of the file to meters", 1.0, gt=0)
    offset: Point = quantity("m", "displacement of the scaled mesh", (0.0, 0.0, 0.0))
    slip: Literal["no-slip", "free-slip"] = _slip()
    motion: Motion | str | None = _motion()
