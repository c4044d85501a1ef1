"""Checks of the space: tank and channel, what lies in them, and the lattice that they share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import degrees
from typing import Any

from debrisflow.case.bodies import BoxObstacle, MeshFill, MeshObstacle, PolygonObstacle
from debrisflow.case.built import LARGEST_MISFIT, MUST_STAND, as_built, enough
from debrisflow.case.fields import Interval
from debrisflow.case.polygons import fault_of
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.regions import (
    TOLERANCE,
    WALL_SHIFT,
    WEIR_SPACINGS,
    area_left,
    bed_end,
    boxes_among,
    covered,
    least_period,
    occupied,
    open_space,
    runout_rise,
    volume_left,
)
from debrisflow.case.rheology import RampedStrength, Rheology
from debrisflow.case.shapes import (
    Channel3D,
    ChannelShape,
    Geometry,
    Tank,
    Tank3D,
    is_three_dimensional,
    plain_of,
)
from debrisflow.case.tables import (
    AnyFill,
    AnyObstacle,
    AnyScheme,
    Bed,
    Block,
    Gravity,
    Inflow,
    Particles,
    Walls,
)
from debrisflow.case.terrain import Terrain

Fill = tuple[AnyFill, ...]
Obstacles = tuple[AnyObstacle, ...]

FEWEST_SPACINGS = 4
FEWEST_BED_SPACINGS = 3
# degrees, by form of the scheme: as far as was looked at, and of walls of particles as far as its
# cosine is above ``neighbors.wall_access.EDGE``, so that a floor is no edge
LARGEST_BEND = {"stable": 30.0, "study": 25.0}
BY_COLUMN = ("manning", "voellmy")  # laws of friction by the mean velocity of a column


def fills_of_dimension(geometry: Geometry, fill: Fill) -> Problems:
    """Check that fills have the dimension of the space."""
    if isinstance(geometry, Terrain):
        for k, part in enumerate(fill):
            message = "a terrain has no fills; use a [[release]], on the terrain or taken out of it"
            yield Problem(f"fill.{k}.type", message, part.type)
        return
    dimension = 3 if is_three_dimensional(geometry) else 2
    with_third = "channel3d" if isinstance(geometry, ChannelShape) else "tank3d"
    for k, part in enumerate(fill):
        if isinstance(part, MeshFill) and dimension == 2:
            message = f"only in three dimensions: geometry.type = '{with_third}'"
            yield Problem(f"fill.{k}.type", message, part.type)
        if isinstance(part, Block) and dimension == 3 and part.z is None:
            yield Problem(f"fill.{k}.z", "missing: extent along z, in three dimensions (m)")
        if isinstance(part, Block) and dimension == 2 and part.z is not None:
            message = (
                f"only in three dimensions; leave it out, or set geometry.type = '{with_third}'"
            )
            yield Problem(f"fill.{k}.z", message, part.z)
        if (
            not isinstance(part, Bed)
            and was_set(part, "velocity")
            and len(part.velocity) != dimension
        ):
            message = f"must be a list of {dimension} numbers, one for each dimension"
            yield Problem(f"fill.{k}.velocity", message, part.velocity)


def intervals_in_order(
    geometry: Geometry,
    particles: Particles,
    obstacle: Obstacles,
    fill: Fill,
    rheology: Rheology,
) -> Problems:
    """Check that intervals begin before they end."""
    intervals = _extents(fill, obstacle)
    if isinstance(rheology, RampedStrength):
        intervals["rheology.concentration_ramp"] = rheology.concentration_ramp
    for key, interval in intervals.items():
        if interval[0] >= interval[1]:
            yield Problem(key, "the first number must be less than the second", interval)
    if isinstance(geometry, ChannelShape):
        end = bed_end(geometry, particles)
        if geometry.bed_thickness > 0 and geometry.bed_start >= end:
            message = f"must be less than bed_end = {end:g} m"
            yield Problem("geometry.bed_start", message, geometry.bed_start)
        if end > geometry.length:
            message = f"must be at most the length {geometry.length:g} m"
            yield Problem("geometry.bed_end", message, end)


def _extents(fill: Fill, obstacle: Obstacles) -> dict[str, Interval]:
    """Return the extents of blocks and boxes by their keys."""
    bodies = [(f"fill.{k}", part) for k, part in enumerate(fill) if isinstance(part, Block)]
    boxes = [(f"obstacle.{k}", b) for k, b in enumerate(obstacle) if isinstance(b, BoxObstacle)]
    return {
        f"{key}.{axis}": extent
        for key, body in (*bodies, *boxes)
        for axis in "xyz"
        if (extent := getattr(body, axis)) is not None
    }


def lengths_kept(
    geometry: Geometry,
    particles: Particles,
    obstacle: Obstacles,
    fill: Fill,
    scheme: AnyScheme,
) -> Problems:
    """Check that what is built is as long as asked, within a tenth."""
    if isinstance(geometry, Terrain):
        return
    asked: dict[str, Any] = {"geometry": geometry, "particles": particles}
    asked |= {"obstacle": obstacle, "fill": fill}
    built = asked | as_built(asked | {"scheme": scheme})
    lengths = zip(_lengths(**asked), _lengths(**built), strict=True)
    for (key, value, length), (_, _, instead) in lengths:
        if length > 0 and abs(instead - length) > LARGEST_MISFIT * length * (1 + TOLERANCE):
            spacing = particles.spacing
            yield Problem(
                key,
                f"would be built as {instead:.6g} m instead of {length:.6g} m, more than a tenth "
                f"off; particles.spacing = {enough(length, spacing):.4g} would do",
                value,
            )


def _lengths(
    geometry: Geometry, particles: Particles, obstacle: Obstacles, fill: Fill
) -> Iterator[tuple[str, Any, float]]:
    """Yield key, value and length, m, of what has a length."""
    for name in MUST_STAND:
        length = getattr(geometry, name, None)
        if length is not None:
            yield f"geometry.{name}", length, length
    if isinstance(geometry, ChannelShape) and geometry.bed_thickness > 0:
        end = bed_end(geometry, particles)
        yield "geometry.bed_end", end, end - geometry.bed_start
    for key, extent in _extents(fill, obstacle).items():
        yield key, extent, extent[1] - extent[0]


def supply_resolved(particles: Particles, inflow: Inflow | None) -> Problems:
    """Check that a supply is a row deep; its discharge does not depend on the rounded depth."""
    spacing = particles.spacing
    if inflow and inflow.depth * (1 + LARGEST_MISFIT) < (1 - TOLERANCE) * spacing:
        message = f"not resolved: must be at least one spacing of {spacing:g} m"
        yield Problem("inflow.depth", message, inflow.depth)


def space_resolved(geometry: Geometry, particles: Particles) -> Problems:
    """Check that the spacing resolves tank, channel and bed."""
    if isinstance(geometry, Terrain):
        return
    spacing = particles.spacing
    across = ["height"]
    if isinstance(geometry, Tank3D):
        across.append("length")
    if isinstance(geometry, Channel3D):
        across.append("width")
    if not geometry.periodic:
        across.append("width" if isinstance(geometry, Tank3D) else "length")
    for name in across:
        length = getattr(geometry, name)
        if length < (FEWEST_SPACINGS - TOLERANCE) * spacing:
            message = f"not resolved: must be at least {FEWEST_SPACINGS} spacings of {spacing:g} m"
            yield Problem(f"geometry.{name}", message, length)
    if (
        isinstance(geometry, ChannelShape)
        and 0 < geometry.bed_thickness < (FEWEST_BED_SPACINGS - TOLERANCE) * spacing
    ):
        message = f"not resolved: must be at least {FEWEST_BED_SPACINGS} spacings of {spacing:g} m"
        yield Problem("geometry.bed_thickness", message, geometry.bed_thickness)


def periodic_space(geometry: Geometry, particles: Particles) -> Problems:
    """Check that a periodic space does not see itself and has no weir."""
    if not geometry.periodic:
        return
    name = "width" if isinstance(geometry, Tank3D) else "length"
    least = least_period(particles)
    if getattr(geometry, name) < least * (1 - TOLERANCE):
        message = (
            f"too short to be periodic: at least 3 (effective_radius + 1) spacings, {least:g} m"
        )
        yield Problem(f"geometry.{name}", message, getattr(geometry, name))
    if isinstance(geometry, ChannelShape) and geometry.weir_height > 0:
        yield Problem(
            "geometry.weir_height", "a periodic channel has no weir", geometry.weir_height
        )


def weir_in_channel(geometry: Geometry) -> Problems:
    """Check that the weir leaves the channel open above it."""
    if isinstance(geometry, ChannelShape) and geometry.weir_height >= geometry.height:
        message = f"must be less than the height of the channel, {geometry.height:g} m"
        yield Problem("geometry.weir_height", message, geometry.weir_height)


def runout_behind_bed(
    geometry: Geometry, gravity: Gravity, particles: Particles, scheme: AnyScheme
) -> Problems:
    """Check that a run-out bends up, behind the bed and below the top of the channel."""
    if not isinstance(geometry, ChannelShape):
        return
    start, slack = geometry.runout_start, TOLERANCE * particles.spacing
    if start is None:
        for name in ("runout_slope", "runout_width"):
            if hasattr(geometry, name) and was_set(geometry, name):
                message = "has no effect without geometry.runout_start"
                yield Problem(f"geometry.{name}", message, getattr(geometry, name))
        return
    if geometry.periodic or geometry.weir_height > 0:
        other = "geometry.periodic" if geometry.periodic else "geometry.weir_height"
        yield Problem(other, "leave it out where the channel has a run-out")
    bend, largest = degrees(gravity.fall) - geometry.runout_slope, LARGEST_BEND[scheme.form]
    if not TOLERANCE < bend <= largest + TOLERANCE:
        message = (
            f"the floor must bend up, by at most {largest:g} degrees, and not by {bend:g}: "
            f"give less than {degrees(gravity.fall):g} and at least "
            f"{degrees(gravity.fall) - largest:g}"
        )
        yield Problem("geometry.runout_slope", message, geometry.runout_slope)
    behind = bed_end(geometry, particles) if geometry.bed_thickness > 0 else 0.0
    apart = max(WEIR_SPACINGS, int(particles.effective_radius) + 1)
    behind, before = behind + apart * particles.spacing, geometry.length - apart * particles.spacing
    if not behind - slack <= start <= before + slack:
        message = (
            f"must leave {apart} spacings behind it, and in front of it to the bed or to x = 0: "
            f"at least {behind:g} and at most {before:g} m"
        )
        yield Problem("geometry.runout_start", message, start)
    rise = runout_rise(geometry, gravity)
    if rise >= geometry.height and plain_of(geometry) is None:
        message = f"must be greater than the rise of the run-out along the x axis, {rise:.3g} m"
        yield Problem("geometry.height", message, geometry.height)


def nothing_on_runout(
    geometry: Geometry, particles: Particles, obstacle: Obstacles, fill: Fill
) -> Problems:
    """Check that blocks, meshes and obstacles end before a run-out."""
    if not isinstance(geometry, ChannelShape) or geometry.runout_start is None:
        return
    slack = TOLERANCE * particles.spacing
    mesh_slack = slack + WALL_SHIFT * particles.spacing
    message = f"must end before the run-out, x = {geometry.runout_start:g} m"
    bodies: list[tuple[str, AnyFill | AnyObstacle]]
    bodies = [(f"fill.{k}", part) for k, part in enumerate(fill)]
    bodies += [(f"obstacle.{k}", body) for k, body in enumerate(obstacle)]
    for key, body in bodies:
        if isinstance(body, MeshFill | MeshObstacle | PolygonObstacle):
            end = occupied(body).upper[0]
            if end > geometry.runout_start + mesh_slack:
                yield Problem(key, f"{message}, and not at x = {end:.6g} m")
        elif not isinstance(body, Bed) and body.x[1] > geometry.runout_start + slack:
            yield Problem(f"{key}.x.1", message, body.x[1])


def plain_wider_than_channel(geometry: Geometry, particles: Particles) -> Problems:
    """Check that the plain is at least as wide as the channel that opens to it."""
    plain = plain_of(geometry)
    if not isinstance(geometry, Channel3D) or plain is None:
        return
    if plain.front > TOLERANCE * particles.spacing:
        message = f"must be at least the width of the channel, {geometry.width:g} m"
        yield Problem("geometry.runout_width", message, geometry.runout_width)


def fills_inside(geometry: Geometry, particles: Particles, fill: Fill) -> Problems:
    """Check that fills lie in the open space, and a bed in a recess."""
    if isinstance(geometry, Terrain):
        return
    spaces = open_space(geometry, particles)
    for k, part in enumerate(fill):
        area = covered(part, geometry, particles)
        if isinstance(part, Bed) and area is None:
            message = "needs a recess: a channel whose bed_thickness is greater than 0"
            yield Problem(f"fill.{k}.type", message, part.type)
        if isinstance(part, Bed) or area is None:
            continue
        slack = TOLERANCE + (WALL_SHIFT if isinstance(part, MeshFill) else 0.0)
        if not any(space.shrunk(-slack * particles.spacing).holds(area) for space in spaces):
            room = " or ".join(map(str, dict.fromkeys(spaces)))
            message = f"the {part.type} {area} is not inside the {geometry.type}, {room}"
            yield Problem(f"fill.{k}", message)


def fills_left(
    geometry: Geometry, particles: Particles, obstacle: Obstacles, fill: Fill
) -> Problems:
    """Check that obstacles and later fills leave something of every fill."""
    dimension = 3 if is_three_dimensional(geometry) else 2
    boxes = boxes_among(obstacle, dimension)
    polygons = [
        body
        for body in obstacle
        if dimension == 2 and isinstance(body, PolygonObstacle) and not fault_of(body)
    ]
    areas = [covered(part, geometry, particles) for part in fill]
    for k, (part, area) in enumerate(zip(fill, areas, strict=True)):
        if isinstance(part, MeshFill) or area is None or area.volume <= 0:
            continue
        later = [
            other
            for other, another in zip(areas[k + 1 :], fill[k + 1 :], strict=True)
            if other is not None and not isinstance(another, MeshFill)
        ]
        left = volume_left([area], [*boxes, *later])
        if polygons and left > 0.0:
            left = area_left(area, [*boxes, *later, *polygons])
        if left <= TOLERANCE * area.volume:
            message = "nothing is left of it: it lies in obstacles and fills after it in the file"
            yield Problem(f"fill.{k}", message)


def walls_that_drag(walls: Walls, geometry: Geometry) -> Problems:
    """Check that a moving wall exists, moves along itself and lets no fluid slip.

    In three dimensions no wall moves, which is checked with the scheme.
    """
    if is_three_dimensional(geometry):
        return
    present = _walls_present(geometry)
    for name, wall in walls:
        key, (along_x, along_y) = f"walls.{name}.velocity", wall.velocity
        if along_x == 0 and along_y == 0:
            continue
        if not present[name]:
            message = f"there is no {name} wall in this {geometry.type}"
        elif (
            name == "floor"
            and isinstance(geometry, ChannelShape)
            and geometry.runout_start is not None
        ):
            message = "a floor that bends to a run-out cannot move"
        elif wall.slip == "free-slip":
            message = "a free-slip wall drags no fluid along; set slip = 'no-slip'"
        elif along_y != 0 and name in ("floor", "ceiling"):
            message = "must be along the wall: the second number must be 0"
        elif along_x != 0 and name in ("left", "right"):
            message = "must be along the wall: the first number must be 0"
        else:
            continue
        yield Problem(key, message, wall.velocity)


def walls_with_friction(walls: Walls, geometry: Geometry) -> Problems:
    """Check that a law of friction stands alone, in three dimensions, and suits its wall."""
    for name, wall in walls:
        if wall.friction is None:
            continue
        key, law = f"walls.{name}.friction", wall.friction.law
        if not is_three_dimensional(geometry):
            message = "exists only in three dimensions; in two a wall has slip and roughness"
            yield Problem(f"{key}.law", message, law)
        elif law in BY_COLUMN and name not in ("floor", "bed"):
            message = "takes the mean of a column, and so is for a floor; use 'log' or 'coulomb'"
            yield Problem(f"{key}.law", message, law)
        for field in ("slip", "roughness"):
            if was_set(wall, field):
                message = f"is chosen by {key}; leave it out"
                yield Problem(f"walls.{name}.{field}", message, getattr(wall, field))


def walls_there(walls: Walls, geometry: Geometry) -> Problems:
    """Check that nothing is said of a wall that a geometry has not."""
    present = _walls_present(geometry)
    for name, wall in walls:
        for field in ("slip", "roughness", "friction"):
            if not present[name] and was_set(wall, field):
                message = f"there is no {name} wall in this {geometry.type}"
                yield Problem(f"walls.{name}.{field}", message, getattr(wall, field))


def _walls_present(geometry: Geometry) -> dict[str, bool]:
    """Tell which of the named walls a geometry has."""
    if isinstance(geometry, Terrain):
        return {name: name == "floor" for name in Walls.model_fields}
    closed = not geometry.periodic
    if isinstance(geometry, Tank3D):
        sides = {"left": True, "right": True, "front": closed, "back": closed}
        return {"floor": True, "bed": False, "ceiling": False} | sides
    tank = isinstance(geometry, Tank)
    return {
        "floor": True,
        "bed": isinstance(geometry, ChannelShape) and geometry.bed_thickness > 0,
        "left": closed,
        "right": closed
        and (tank or (isinstance(geometry, ChannelShape) and geometry.weir_height > 0)),
        "ceiling": isinstance(geometry, Tank) and geometry.ceiling,
        "front": isinstance(geometry, Channel3D),
        "back": isinstance(geometry, Channel3D),
    }


AS_ASKED: tuple[Callable[..., Problems], ...] = (
    intervals_in_order,
    lengths_kept,
    supply_resolved,
)
CHECKS: tuple[Callable[..., Problems], ...] = (
    fills_of_dimension,
    space_resolved,
    periodic_space,
    weir_in_channel,
    runout_behind_bed,
    nothing_on_runout,
    plain_wider_than_channel,
    fills_inside,
    fills_left,
    walls_that_drag,
    walls_with_friction,
    walls_there,
)
