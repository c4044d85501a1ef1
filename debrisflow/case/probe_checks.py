"""Cross-checks of the probes: their names, and what each of them checks in the space of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from debrisflow.case.probe import Probe, Space
from debrisflow.case.problems import Problem
from debrisflow.case.regions import open_space, runout_rise
from debrisflow.case.releases import Zone
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
from debrisflow.case.terrain import Terrain

Problems = Iterator[Problem]


def names_of_probes(probe: tuple[Probe, ...]) -> Problems:
    """Check that no two probes write into one file."""
    seen: dict[str, int] = {}
    for k, one in enumerate(probe):
        first = seen.setdefault(one.name, k)
        if first != k:
            yield Problem(f"probe.{k}.name", f"the name of probe.{first}; give another", one.name)


def places_of_probes(
    probe: tuple[Probe, ...],
    geometry: Geometry,
    gravity: Gravity,
    obstacle: tuple[AnyObstacle, ...],
    particles: Particles,
    zone: tuple[Zone, ...],
) -> Problems:
    """Check what each probe asks for: a place in the space, a box with a volume, a known wall."""
    space = Space(
        shape=geometry.type,
        dimension=3 if is_three_dimensional(geometry) else 2,
        spacing=particles.spacing,
        extents=_extents(geometry, gravity, particles),
        repeats_along_x=geometry.periodic and not isinstance(geometry, Tank3D),
        planes=_walls(geometry) | dict.fromkeys(part.name for part in zone),
        obstacles={part.name: part for part in obstacle},
    )
    for k, one in enumerate(probe):
        for field, message, value in one.faults(space):
            yield Problem(f"probe.{k}.{field}", message, value)


def _extents(
    geometry: Geometry, gravity: Gravity, particles: Particles
) -> dict[str, tuple[float, float]]:
    if isinstance(geometry, Terrain):
        return {
            axis: (lower, upper)
            for space in open_space(geometry, particles)
            for axis, lower, upper in zip("xyz", space.lower, space.upper, strict=True)
        }
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
    return {"x": (0.0, geometry.length), "y": (0.0, geometry.height)}


def _walls(geometry: Geometry) -> dict[str, tuple[int, float] | None]:
    """Return axis and level of the walls that a geometry has; None for one of several levels."""
    found: dict[str, tuple[int, float] | None]
    if isinstance(geometry, Terrain):
        return {"floor": None}
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
        found |= {"left": (0, 0.0), "right": (0, geometry.length)}
    if geometry.ceiling:
        found["ceiling"] = (1, geometry.height)
    return found


CHECKS: tuple[Callable[..., Problems], ...] = (names_of_probes, places_of_probes)
