"""How fast a case may flow: what decides the speed of sound and foretells the time step."""

from __future__ import annotations

from itertools import product
from math import hypot, sqrt

from debrisflow.case.regions import Region, covered, recess, runout_rise, section_of_supply
from debrisflow.case.released import greatest_depth
from debrisflow.case.releases import AnyRelease, HydrographRelease
from debrisflow.case.shapes import Channel3D, Geometry, Tank3D
from debrisflow.case.tables import AnyFill, Bed, Gravity, Inflow, Particles, Walls


def given_speed(
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    geometry: Geometry,
    walls: Walls,
    release: tuple[AnyRelease, ...] = (),
) -> float:
    """Return the largest speed in the case file, m/s: of fill, release, wall or supply."""
    speeds = [hypot(*part.velocity) for part in fill if not isinstance(part, Bed)]
    speeds += [hypot(*wall.velocity) for _, wall in walls]
    speeds += [
        part.velocity if isinstance(part, HydrographRelease) else hypot(*part.velocity)
        for part in release
    ]
    if inflow is not None:
        graph, area = inflow.hydrograph, section_of_supply(inflow, geometry)
        if graph is None:
            speeds.append(inflow.velocity or (inflow.discharge or 0.0) / area)
        elif not isinstance(graph, str):
            speeds.append(max(graph.discharge) / area)
    return max(speeds)


def fall_speed(
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    geometry: Geometry,
    particles: Particles,
    gravity: Gravity,
    to_floor: bool = False,
) -> float:
    """Return the speed of a free fall through the height of fills and supply, m/s.

    With ``to_floor``, in three dimensions, down to the lowest end of the floor: of a sloping
    channel that to which the whole flow may run.
    """
    areas = [covered(part, geometry, particles) for part in fill]
    if inflow is not None:
        areas.append(Region((0.0, 0.0), (0.0, inflow.depth)))
    if to_floor and areas and isinstance(geometry, Tank3D | Channel3D):
        areas += _floors(geometry, particles, gravity)
    along, upward = gravity.components
    levels = [
        -(along * x + upward * y)
        for area in areas
        if area is not None
        for x, y in product((area.lower[0], area.upper[0]), (area.lower[-1], area.upper[-1]))
    ]
    return sqrt(2.0 * (max(levels) - min(levels))) if levels else 0.0


def collapse_speed(release: tuple[AnyRelease, ...], gravity: Gravity) -> float:
    """Return the speed of a free fall through the depth of the deepest release, m/s."""
    depths = [greatest_depth(part) for part in release if not isinstance(part, HydrographRelease)]
    return sqrt(2.0 * hypot(*gravity.components) * max(depths, default=0.0))


def _floors(
    geometry: Tank3D | Channel3D, particles: Particles, gravity: Gravity
) -> list[Region | None]:
    """Return the floor, the recess below it and the far end of a run-out."""
    end, width = geometry.length, geometry.width
    if isinstance(geometry, Tank3D) or geometry.runout_start is None:
        return [Region((0.0, 0.0, 0.0), (end, width, 0.0)), recess(geometry, particles)]
    start, rise = geometry.runout_start, runout_rise(geometry, gravity)
    return [
        Region((0.0, 0.0, 0.0), (start, width, 0.0)),
        Region((end, 0.0, rise), (end, width, rise)),
        recess(geometry, particles),
    ]
