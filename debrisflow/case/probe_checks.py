"""Cross-checks of the probes: their names, their places and the walls that they name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import hypot

from debrisflow.case.bodies import BoxObstacle
from debrisflow.case.probes import (
    AnyProbe,
    ForceProbe,
    HeightProbe,
    PressureProbe,
    SectionProbe,
    VolumeProbe,
)
from debrisflow.case.problems import Problem, did_you_mean, either
from debrisflow.case.regions import runout_rise
from debrisflow.case.shapes import (
    Channel,
    Channel3D,
    ChannelShape,
    Geometry,
    Tank3D,
    is_three_dimensional,
    plain_of,
)
from debrisflow.case.tables import AnyObstacle, Gravity, Particles

Problems = Iterator[Problem]
Probes = tuple[AnyProbe, ...]
Obstacles = tuple[AnyObstacle, ...]
TOLERANCE = 1e-6  # spacings


def names_of_probes(probe: Probes) -> Problems:
    """Check that no two probes write into one file."""
    seen: dict[str, int] = {}
    for k, one in enumerate(probe):
        first = seen.setdefault(one.name, k)
        if first != k:
            yield Problem(f"probe.{k}.name", f"the name of probe.{first}; give another", one.name)


def coordinates_of_probes(probe: Probes, geometry: Geometry) -> Problems:
    """Check that places have as many coordinates as the case has dimensions."""
    is_three = is_three_dimensional(geometry)
    for k, one in enumerate(probe):
        last = {HeightProbe: "y", PressureProbe: "z", VolumeProbe: "z"}.get(type(one))
        value = getattr(one, last) if last else None
        if last and is_three and value is None:
            yield Problem(f"probe.{k}.{last}", "missing: the place needs it in three dimensions")
        elif last and not is_three and value is not None:
            message = f"the place has no {last} in two dimensions; leave it out"
            yield Problem(f"probe.{k}.{last}", message, value)
        if isinstance(one, ForceProbe) and not is_three and len(one.about) == 3:
            message = "a point in two dimensions has 2 numbers"
            yield Problem(f"probe.{k}.about", message, one.about)


def places_of_probes(
    probe: Probes, geometry: Geometry, gravity: Gravity, particles: Particles
) -> Problems:
    """Check that probes stand in the space, and sections a spacing from its ends."""
    slack = TOLERANCE * particles.spacing
    space = _extents(geometry, gravity)
    for k, one in enumerate(probe):
        for axis, (lower, upper) in space.items():
            place = getattr(one, axis, None)
            if place is None or isinstance(one, VolumeProbe):
                continue
            message = f"outside the {geometry.type}, {axis} = [{lower:g}, {upper:g}] m"
            if isinstance(one, SectionProbe) and not _repeats_along_x(geometry):
                lower, upper = lower + particles.spacing, upper - particles.spacing
                message = f"must be a spacing from the ends, {axis} = [{lower:g}, {upper:g}] m"
            if not lower - slack <= place <= upper + slack:
                yield Problem(f"probe.{k}.{axis}", message, place)


def boxes_of_probes(probe: Probes, geometry: Geometry, gravity: Gravity) -> Problems:
    """Check that the box of a probe has a volume, part of it in the space."""
    for k, one in enumerate(probe):
        if not isinstance(one, VolumeProbe):
            continue
        for axis, (lower, upper) in _extents(geometry, gravity).items():
            extent = getattr(one, axis)
            if extent is None:
                continue
            if extent[0] >= extent[1]:
                message = "the first number must be less than the second"
                yield Problem(f"probe.{k}.{axis}", message, extent)
            elif extent[1] <= lower or extent[0] >= upper:
                message = f"outside the {geometry.type}, {axis} = [{lower:g}, {upper:g}] m"
                yield Problem(f"probe.{k}.{axis}", message, extent)


def walls_of_probes(
    probe: Probes, geometry: Geometry, obstacle: Obstacles, particles: Particles
) -> Problems:
    """Check that the wall of a probe is there, and its place within a spacing of it."""
    flat, boxes = _walls(geometry), {part.name: part for part in obstacle}
    known = (*flat, *boxes)
    for k, one in enumerate(probe):
        if not isinstance(one, PressureProbe | ForceProbe):
            continue
        if one.wall not in known:
            message = f"there is no such wall, but {either(known)}" + did_you_mean(one.wall, known)
            yield Problem(f"probe.{k}.wall", message, one.wall)
            continue
        if not isinstance(one, PressureProbe):
            continue
        place = (one.x, one.y, one.z or 0.0)
        plane, body = flat.get(one.wall), boxes.get(one.wall)
        if plane is not None:
            distance = abs(place[plane[0]] - plane[1])
        elif isinstance(body, BoxObstacle):
            distance = _distance_to_box(place, body)
        else:
            continue  # the run finds the surface of a bed or a mesh
        if distance > particles.spacing * (1 + TOLERANCE):
            message = f"the place is {distance:.3g} m from that wall; at most a spacing"
            yield Problem(f"probe.{k}.wall", message, one.wall)


def _extents(geometry: Geometry, gravity: Gravity) -> dict[str, tuple[float, float]]:
    if isinstance(geometry, Tank3D):
        ends = (geometry.length, geometry.width, geometry.height)
        return {axis: (0.0, end) for axis, end in zip("xyz", ends, strict=True)}
    if isinstance(geometry, Channel3D):
        plain = plain_of(geometry)
        rise = runout_rise(geometry, gravity) if plain else 0.0
        return {
            "x": (0.0, geometry.length),
            "y": (plain.front, plain.back) if plain else (0.0, geometry.width),
            "z": (-geometry.bed_thickness, geometry.height + rise),
        }
    if isinstance(geometry, Channel):
        return {"x": (0.0, geometry.length), "y": (-geometry.bed_thickness, geometry.height)}
    return {"x": (0.0, geometry.width), "y": (0.0, geometry.height)}


def _repeats_along_x(geometry: Geometry) -> bool:
    return geometry.periodic and not isinstance(geometry, Tank3D)


def _walls(geometry: Geometry) -> dict[str, tuple[int, float] | None]:
    """Return axis and level of the walls that a geometry has; None for one of several levels."""
    found: dict[str, tuple[int, float] | None]
    if isinstance(geometry, Tank3D):
        found = {"floor": (2, 0.0), "left": (0, 0.0), "right": (0, geometry.length)}
        if not geometry.periodic:
            found |= {"front": (1, 0.0), "back": (1, geometry.width)}
        return found
    sides = not geometry.periodic
    if isinstance(geometry, ChannelShape):
        found = {"floor": None}
        if geometry.bed_thickness > 0:
            found["bed"] = None
        if sides:
            found["left"] = (0, 0.0)
        if sides and geometry.weir_height > 0:
            found["right"] = None
        if isinstance(geometry, Channel3D):
            opens = plain_of(geometry) is not None  # then the head wall belongs to them
            found["front"] = None if opens else (1, 0.0)
            found["back"] = None if opens else (1, geometry.width)
        return found
    found = {"floor": (1, 0.0)}
    if sides:
        found |= {"left": (0, 0.0), "right": (0, geometry.width)}
    if geometry.ceiling:
        found["ceiling"] = (1, geometry.height)
    return found


def _distance_to_box(place: tuple[float, float, float], box: BoxObstacle) -> float:
    """Return the distance of a point, outside or inside, to the surface of a box, m."""
    gaps = [
        max(low - at, at - high)
        for at, (low, high) in zip(place, (box.x, box.y, box.z), strict=True)
    ]
    return hypot(*(max(gap, 0.0) for gap in gaps)) if max(gaps) > 0 else -max(gaps)


CHECKS: tuple[Callable[..., Problems], ...] = (
    names_of_probes,
    coordinates_of_probes,
    places_of_probes,
    boxes_of_probes,
    walls_of_probes,
)
