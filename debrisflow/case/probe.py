"""Tables of the probes: what is measured at a place, on a wall or across the flow."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import NONE, Components, Interval, Table, quantity

SIZE = "side of the square, in two dimensions width of the strip, {}; 2 spacings if left out"


class _Probe(Table):
    """What all probes have."""

    name: str = quantity(
        NONE,
        "name of the probe, and of its file probes/NAME.csv; small letters, digits and _",
        pattern=r"^[a-z][a-z0-9_]*$",
    )
    interval: float = quantity(
        "s", "sampling interval; a sample is taken at the end of the step in which it is due", gt=0
    )


class HeightProbe(_Probe):
    """Height of the fluid above what it stands on: the floor, or the top of an obstacle."""

    type: Literal["height"]
    x: float = quantity("m", "place along x")
    y: float | None = quantity("m", "place along y, in three dimensions", None)
    size: float | None = quantity("m", SIZE.format("over which the height is taken"), None, gt=0)


class PressureProbe(_Probe):
    """Mean pressure on a patch of a wall or an obstacle."""

    type: Literal["pressure"]
    wall: str = quantity(NONE, "name of the wall (floor, left, ...) or of the obstacle")
    x: float = quantity("m", "middle of the patch along x")
    y: float = quantity("m", "middle of the patch along y")
    z: float | None = quantity("m", "middle of the patch along z, in three dimensions", None)
    size: float | None = quantity("m", SIZE.format("over which the pressure acts"), None, gt=0)


class ForceProbe(_Probe):
    """Force and moment of the pressure on a whole wall or obstacle."""

    type: Literal["force"]
    wall: str = quantity(NONE, "name of the wall (floor, left, ...) or of the obstacle")
    about: Components = quantity("m", "point about which the moment is taken", (0.0, 0.0))


class SectionProbe(_Probe):
    """What flows through the plane x = const."""

    type: Literal["section"]
    x: float = quantity("m", "place of the plane")


class VolumeProbe(_Probe):
    """Volume of the fluid, and of the sediment in it, inside a box: what a dam has trapped."""

    type: Literal["volume"]
    x: Interval = quantity("m", "extent along x")
    y: Interval = quantity("m", "extent along y")
    z: Interval | None = quantity("m", "extent along z, in three dimensions", None)


AnyProbe = HeightProbe | PressureProbe | ForceProbe | SectionProbe | VolumeProbe
