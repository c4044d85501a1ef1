"""Tables of the spaces that are computed, in two and in three dimensions."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeGuard

from debrisflow.case.fields import NONE, Table, quantity
from debrisflow.case.terrain import Terrain


class Tank(Table):
    """A rectangular tank; its inner corner is the origin, y is up."""

    type: Literal["tank"]
    length: float = quantity("m", "inner length along x", gt=0)
    height: float = quantity("m", "height of the side walls above the floor", gt=0)
    ceiling: bool = quantity(NONE, "close the tank by a wall at its height", False)
    periodic: bool = quantity(NONE, "repeat the tank along x instead of side walls", False)


class Tank3D(Table):
    """A rectangular tank in three dimensions; its inner corner is the origin, z is up."""

    type: Literal["tank3d"]
    length: float = quantity("m", "inner length along x", gt=0)
    width: float = quantity("m", "inner width along y", gt=0)
    height: float = quantity("m", "height of the side walls above the floor", gt=0)
    periodic: bool = quantity(
        NONE, "repeat the tank along y instead of front and back walls", False
    )


class ChannelShape(Table):
    """A channel along x with a fixed floor at level 0, a recessed movable bed and an end weir.

    The end at x = length is open: what passes it leaves the computation.  The floor may bend up to
    a milder slope, the run-out, where a flow deposits.
    """

    type: str
    length: float = quantity("m", "length along the floor, from x = 0", gt=0)
    height: float = quantity("m", "height of the computed space above the fixed floor", gt=0)
    bed_start: float = quantity("m", "x at which the recess for the bed begins", 0.0, ge=0)
    bed_end: float | None = quantity(
        "m", "x at which the recess ends; the length less the weir if left out", None
    )
    bed_thickness: float = quantity("m", "depth of the recess below the fixed floor", 0.0, ge=0)
    weir_height: float = quantity(
        "m", "crest of the end weir above the fixed floor; 0 is level with the bed", 0.0, ge=0
    )
    runout_start: float | None = quantity(
        "m", "x at which the floor bends up to the slope of the run-out; no bend if left out", None
    )
    runout_slope: float = quantity(
        "degree", "angle by which the floor of the run-out falls below the horizontal", 0.0
    )
    periodic: bool = quantity(NONE, "repeat the channel along x: no weir, no open end", False)


class Channel(ChannelShape):
    """A channel in two dimensions; y is up."""

    type: Literal["channel"]


class Channel3D(ChannelShape):
    """A channel in three dimensions between walls at y = 0 and y = width; z is up.

    A run-out may be a plain wider than the channel.  Its outer edges are open as the end at
    x = length is; beside the mouth a head wall as high as the channel, of the walls front and
    back, closes it in the plane x = runout_start.
    """

    type: Literal["channel3d"]
    width: float = quantity("m", "inner width along y, from y = 0", gt=0)
    runout_width: float | None = quantity(
        "m",
        "width of a plain with open edges beyond runout_start, in the middle of which the channel "
        "ends; the run-out stays between the walls of the channel if left out",
        None,
        gt=0,
    )


Geometry = Tank | Channel | Tank3D | Channel3D | Terrain
THREE_DIMENSIONAL = ("tank3d", "channel3d", "terrain")


def is_three_dimensional(geometry: object) -> TypeGuard[Tank3D | Channel3D | Terrain]:
    """Return whether a geometry has three dimensions."""
    return isinstance(geometry, Tank3D | Channel3D | Terrain)


class Plain(NamedTuple):
    """A plain to which a channel opens.

    Attributes
    ----------
    start : float, m
        The x of the mouth.
    mouth : float, m
        Width of the channel, from y = 0.
    front, back : float, m
        The y of the outer edges.
    """

    start: float
    mouth: float
    front: float
    back: float


def plain_of(geometry: object) -> Plain | None:
    """Return the plain to which a channel opens, None without one.

    Examples
    --------
    >>> flume = Channel3D(
    ...     type="channel3d", length=4.0, width=0.5, height=1.0, runout_start=2.0, runout_width=1.5
    ... )
    >>> plain_of(flume)
    Plain(start=2.0, mouth=0.5, front=-0.5, back=1.0)
    """
    if not isinstance(geometry, Channel3D):
        return None
    if geometry.runout_start is None or geometry.runout_width is None:
        return None
    middle, half = 0.5 * geometry.width, 0.5 * geometry.runout_width
    return Plain(
        start=geometry.runout_start,
        mouth=geometry.width,
        front=middle - half,
        back=middle + half,
    )


class Runout(NamedTuple):
    """The part of a channel whose floor bends up to a milder slope.

    Attributes
    ----------
    start : float, m
        The x of the bend.
    slope : float, degree
        By which the floor falls below the horizontal.
    """

    start: float
    slope: float


def runout_of(geometry: object) -> Runout | None:
    """Return the run-out of a channel, whether between its walls or a plain; None without one."""
    if not isinstance(geometry, ChannelShape) or geometry.runout_start is None:
        return None
    return Runout(start=geometry.runout_start, slope=geometry.runout_slope)
