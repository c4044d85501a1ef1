"""Tables of the bodies of three dimensions: boxes, and what a closed mesh encloses."""

from __future__ import annotations

from typing import Any, Literal

from debrisflow.case.fields import NONE, Components, Interval, Point, Table, quantity

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


def _obstacle_name() -> Any:
    return quantity(
        NONE, "name of the obstacle, by which probes refer to it", pattern=r"^[a-z][a-z0-9_]*$"
    )


class BoxObstacle(Table):
    """A box of wall in the way of the flow."""

    type: Literal["box"]
    name: str = _obstacle_name()
    x: Interval = quantity("m", "extent along x")
    y: Interval = quantity("m", "extent along y")
    z: Interval = quantity("m", "extent along z")
    slip: Literal["no-slip", "free-slip"] = quantity(NONE, "condition along the wall", "no-slip")


class MeshObstacle(Table):
    """What a closed surface of triangles encloses, as wall in the way of the flow."""

    type: Literal["mesh"]
    name: str = _obstacle_name()
    file: str = quantity(NONE, MESH_FILE)
    scale: float = quantity(NONE, "factor from the lengths of the file to meters", 1.0, gt=0)
    offset: Point = quantity("m", "displacement of the scaled mesh", (0.0, 0.0, 0.0))
    slip: Literal["no-slip", "free-slip"] = quantity(NONE, "condition along the wall", "no-slip")
