"""Bodies given by their shape: obstacles, which may move, and what a closed mesh encloses."""

from __future__ import annotations

from typing import Annotated, Any, Literal

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
