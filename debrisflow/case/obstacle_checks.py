"""Checks of the obstacles, and of the meshes among fills."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from math import inf

from debrisflow.case.bodies import BoxObstacle, MeshFill, MeshObstacle, PolygonObstacle
from debrisflow.case.polygons import fault_of, thickness
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.regions import (
    TOLERANCE,
    WALL_SHIFT,
    Region,
    lattice_points,
    occupied,
    open_space,
    shared_space,
)
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import AnyFill, AnyObstacle, AnyScheme, Particles, Walls
from debrisflow.case.terrain import Terrain

Fill = tuple[AnyFill, ...]
Obstacles = tuple[AnyObstacle, ...]


def obstacles_of_dimension(geometry: Geometry, obstacle: Obstacles) -> Problems:
    """Check that obstacles have the dimension of the space."""
    has_three = is_three_dimensional(geometry)
    for k, body in enumerate(obstacle):
        if isinstance(body, BoxObstacle) and has_three and body.z is None:
            yield Problem(f"obstacle.{k}.z", "missing: extent along z, in three dimensions (m)")
        elif isinstance(body, BoxObstacle) and not has_three and body.z is not None:
            message = "only in three dimensions; in two y is up: leave z out"
            yield Problem(f"obstacle.{k}.z", message, body.z)
        elif isinstance(body, MeshObstacle) and not has_three:
            message = (
                f"only in three dimensions: geometry.type = '{geometry.type}3d'; in two 'polygon'"
            )
            yield Problem(f"obstacle.{k}.type", message, body.type)
        elif isinstance(body, PolygonObstacle) and has_three:
            message = "only in two dimensions; in three there are meshes"
            yield Problem(f"obstacle.{k}.type", message, body.type)


def _of_dimension(geometry: Geometry, obstacle: Obstacles) -> dict[int, AnyObstacle]:
    """Return the obstacles that have the dimension of the space, by their places in the case."""
    axes = 3 if is_three_dimensional(geometry) else 2
    return {
        k: body
        for k, body in enumerate(obstacle)
        if (3 if isinstance(body, MeshObstacle) else len(body.extents)) == axes
    }


def obstacles_named(obstacle: Obstacles) -> Problems:
    """Check that each obstacle has a name of its own, which no wall has."""
    known = dict.fromkeys(Walls.model_fields, "a wall")
    for k, body in enumerate(obstacle):
        if body.name in known:
            message = f"is the name of {known[body.name]}; choose another one"
            yield Problem(f"obstacle.{k}.name", message, body.name)
        known.setdefault(body.name, f"obstacle.{k}")


def polygons_closed(obstacle: Obstacles) -> Problems:
    """Check that the sides of a polygon do not cross and enclose something."""
    for k, body in enumerate(obstacle):
        if isinstance(body, PolygonObstacle) and (fault := fault_of(body)):
            yield Problem(f"obstacle.{k}.corners", fault)


def polygons_thick(particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that polygons have room for a row of wall, whose sums hold the fluid off."""
    for k, body in enumerate(obstacle):
        if isinstance(body, PolygonObstacle) and not fault_of(body):
            widest = thickness(body)
            if widest <= particles.spacing:
                message = (
                    f"too thin: {widest:.3g} m where it is thickest, which must be more than a "
                    f"spacing, {particles.spacing:g} m; a box may be thinner"
                )
                yield Problem(f"obstacle.{k}.corners", message)


def polygons_of_surfaces(scheme: AnyScheme, obstacle: Obstacles) -> Problems:
    """Check that polygons are no walls of particles."""
    if scheme.form != "study":
        return
    for k, body in enumerate(obstacle):
        if isinstance(body, PolygonObstacle):
            message = "walls of particles follow the lattice; set scheme.form = 'stable'"
            yield Problem(f"obstacle.{k}.type", message, body.type)


def obstacles_inside(geometry: Geometry, particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that obstacles lie inside the space; on a terrain they may reach below it."""
    spaces = list(dict.fromkeys(open_space(geometry, particles)))
    for k, body in _of_dimension(geometry, obstacle).items():
        area = occupied(body)
        slack = TOLERANCE + (WALL_SHIFT if isinstance(body, MeshObstacle) else 0.0)
        rooms = [space.shrunk(-slack * particles.spacing) for space in spaces]
        if isinstance(geometry, Terrain):  # what lies in the ground is left out
            rooms = [Region((*room.lower[:2], -inf), room.upper) for room in rooms]
        if not any(room.holds(area) for room in rooms):
            room = " or ".join(map(str, spaces))
            message = f"the {body.type} {area} is not inside the {geometry.type}, {room}"
            yield Problem(f"obstacle.{k}", message)


def obstacles_apart(geometry: Geometry, particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that no two obstacles overlap; out of a fill they are cut."""
    standing = _of_dimension(geometry, obstacle)
    if any(isinstance(body, PolygonObstacle) and fault_of(body) for body in obstacle):
        return
    solids = [(f"obstacle.{k}", body, occupied(body)) for k, body in standing.items()]
    for (name, body, area), (key, other, another) in combinations(solids, 2):
        shared = shared_space((body, other), area.overlap(another), particles)
        if shared:
            yield Problem(key, f"overlaps {name} in {shared}")


def meshes_resolved(
    geometry: Geometry, particles: Particles, obstacle: Obstacles, fill: Fill
) -> Problems:
    """Check that every mesh encloses a point of the lattice."""
    if not is_three_dimensional(geometry):
        return
    for name, bodies in (("obstacle", obstacle), ("fill", fill)):
        for k, body in enumerate(bodies):
            if not isinstance(body, MeshFill | MeshObstacle):
                continue
            cells = lattice_points(body, particles)
            if cells is not None and not len(cells):
                message = (
                    f"encloses no point of the lattice, whose spacing is {particles.spacing:g} m: "
                    f"its extents are {occupied(body)}; look at its scale"
                )
                yield Problem(f"{name}.{k}", message)


CHECKS: tuple[Callable[..., Problems], ...] = (
    obstacles_of_dimension,
    obstacles_named,
    polygons_closed,
    polygons_thick,
    polygons_of_surfaces,
    obstacles_inside,
    obstacles_apart,
    meshes_resolved,
)
