"""How fast a case may flow: what decides the speed of sound and foretells the time step."""

from __future__ import annotations

from itertools import product
from math import hypot, sqrt

from debrisflow.case.regions import Geometry, Region, covered
from debrisflow.case.tables import AnyFill, Bed, Gravity, Inflow, Particles, Tank3D, Walls


def given_speed(fill: tuple[AnyFill, ...], inflow: Inflow | None, walls: Walls) -> float:
    """Return the largest speed in the case file: of a fill, a wall or the supply, m/s."""
    speeds = [hypot(*part.velocity) for part in fill if not isinstance(part, Bed)]
    speeds += [hypot(*wall.velocity) for _, wall in walls]
    if inflow is not None:
        graph = inflow.hydrograph
        if graph is None:
            speeds.append(inflow.velocity or (inflow.discharge or 0.0) / inflow.depth)
        elif not isinstance(graph, str):
            speeds.append(max(graph.discharge) / inflow.depth)
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

    With ``to_floor``, in a tank of three dimensions, down to the lowest end of its floor.
    """
    areas = [covered(part, geometry, particles) for part in fill]
    if to_floor and areas and isinstance(geometry, Tank3D):
        areas.append(Region((0.0, 0.0, 0.0), (geometry.length, geometry.width, 0.0)))
    if inflow is not None:
        areas.append(Region((0.0, 0.0), (0.0, inflow.depth)))
    along, upward = gravity.components
    levels = [
        -(along * x + upward * y)
        for area in areas
        if area is not None
        for x, y in product((area.lower[0], area.upper[0]), (area.lower[-1], area.upper[-1]))
    ]
    return sqrt(2.0 * (max(levels) - min(levels))) if levels else 0.0
