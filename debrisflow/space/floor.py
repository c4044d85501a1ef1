"""The fixed floor of tanks and channels: level, bend, roughness (NumPy only).

In two dimensions y is up, in three z.
"""

from __future__ import annotations

from math import radians, tan

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, shapes
from debrisflow.case.friction import LogFriction
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import is_three_dimensional, plain_of, runout_of
from debrisflow.case.tables import Wall
from debrisflow.space.ground import ground_of

Floats = NDArray[np.float64]


def floor_level(case: ResolvedCase, x: Floats, across: Floats | None = None) -> Floats:
    """Return the level of the fixed floor at x, the bottom of the recess under a bed, m.

    That of a terrain also depends on the place ``across``, its y.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> channel = shapes.Channel(
    ...     type="channel", length=4.0, height=1.0, bed_start=1.0, bed_end=3.0, bed_thickness=0.2
    ... )
    >>> floor_level(Case(geometry=channel), np.array([0.5, 2.0, 3.5]))
    array([ 0. , -0.2,  0. ])
    """
    shape = case.geometry
    if isinstance(shape, ResolvedTerrain):
        return ground_of(case).surface.level(x, _given(across))
    level = np.zeros_like(np.asarray(x, dtype=float))
    if isinstance(shape, shapes.ChannelShape):
        if shape.periodic:
            x = np.mod(x, shape.length)
        level[(x >= shape.bed_start) & (x < shape.bed_end)] = -shape.bed_thickness
        if not shape.periodic:
            level[x >= shape.bed_end] = shape.weir_height
        runout = runout_of(shape)
        if runout is not None:
            level += np.maximum(x - runout.start, 0.0) * tan(runout_bend(case))
    return level


def runout_bend(case: ResolvedCase) -> float:
    """Return the angle by which the floor of a channel bends up to its run-out, rad; 0 without."""
    runout = runout_of(case.geometry)
    return case.gravity.fall - radians(runout.slope) if runout else 0.0


def floor_bend(case: ResolvedCase, x: Floats) -> Floats:
    """Return the angle by which the floor at x rises above the x axis, rad."""
    runout, x = runout_of(case.geometry), np.asarray(x, dtype=float)
    if runout is None:
        return np.zeros_like(x)
    return np.where(x > runout.start, runout_bend(case), 0.0)


def height_over_floor(
    case: ResolvedCase, x: Floats, y: Floats, at: Floats, across: Floats | None = None
) -> Floats:
    """Return the heights of points over the floor that is under ``at``, along its normal, m.

    Those over a terrain are along the normal of the ground right below them, at x and ``across``.
    """
    if isinstance(case.geometry, ResolvedTerrain):
        level, along, aside = ground_of(case).surface.level_and_slope(x, _given(across))
        return (y - level) / np.sqrt(1.0 + along**2 + aside**2)
    bend = floor_bend(case, at)
    return (y - floor_level(case, at) - np.tan(bend) * (x - at)) * np.cos(bend)


def _given(across: Floats | None) -> Floats:
    if across is None:
        raise TypeError("the level of a terrain depends on y too")
    return across


def is_over_floor(case: ResolvedCase, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which places have the floor of the space under them; in two dimensions y is not used.

    Examples
    --------
    A channel 0.5 m wide that opens at x = 2 m to a plain three times as wide:

    >>> from types import SimpleNamespace as Case
    >>> flume = shapes.Channel3D(
    ...     type="channel3d", length=4.0, width=0.5, height=1.0, runout_start=2.0, runout_width=1.5
    ... )
    >>> is_over_floor(Case(geometry=flume), np.array([1.0, 1.0, 3.0]), np.array([0.2, 0.8, 0.8]))
    array([ True, False,  True])
    """
    shape = case.geometry
    repeats_along_x = shape.periodic and not isinstance(shape, shapes.Tank3D)
    over = np.full(np.shape(x), fill_value=True)
    if not repeats_along_x:
        over &= (x > 0.0) & (x < shape.length)
    if not is_three_dimensional(shape):
        return over
    plain = plain_of(shape)
    between = (y > 0.0) & (y < shape.width)
    if plain is not None:
        between |= (x > plain.start) & (y > plain.front) & (y < plain.back)
    elif isinstance(shape, shapes.Tank3D) and shape.periodic:
        return over
    return np.asarray(over & between)


def roughness_of(wall: Wall) -> float:
    """Return the equivalent sand roughness of a wall, m; 0 where it has no law of the wall."""
    return wall.friction.roughness if isinstance(wall.friction, LogFriction) else wall.roughness


def floor_roughness(case: ResolvedCase, x: Floats) -> Floats:
    """Return the roughness of the fixed floor at x, under a bed that of its recess, m.

    Infinite where the floor has none, so that no law of the wall acts.
    """
    shape, x = case.geometry, np.asarray(x, dtype=float)
    roughness = np.full_like(x, roughness_of(case.walls.floor))
    if isinstance(shape, shapes.ChannelShape):
        if shape.periodic:
            x = np.mod(x, shape.length)
        elif shape.weir_height > 0.0:
            roughness[x >= shape.bed_end] = roughness_of(case.walls.right)
        if shape.bed_thickness > 0.0:
            in_bed = (x >= shape.bed_start) & (x < shape.bed_end)
            roughness[in_bed] = roughness_of(case.walls.bed)
    return np.where(roughness > 0.0, roughness, np.inf)
