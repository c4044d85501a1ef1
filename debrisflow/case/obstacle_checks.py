"""Checks of the obstacles and meshes in three dimensions."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

from debrisflow.case.bodies import BoxObstacle, MeshFill, MeshObstacle
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.regions import (
    TOLERANCE,
    WALL_SHIFT,
    lattice_points,
    occupied,
    open_space,
    shared_space,
)
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import AnyFill, AnyObstacle, Particles, Walls

Fill = tuple[AnyFill, ...]
Obstacles = tuple[AnyObstacle, ...]


def obstacles_of_dimension(geometry: Geometry, obstacle: Obstacles) -> Problems:
    """Check that obstacles stand in three dimensions."""
    if obstacle and not is_three_dimensional(geometry):
        message = f"there are none in a {geometry.type}; use geometry.type = '{geometry.type}3d'"
        yield Problem("obstacle", message)


def obstacles_named(obstacle: Obstacles) -> Problems:
    """Check that each obstacle has a name of its own, which no wall has."""
    known = dict.fromkeys(Walls.model_fields, "a wall")
    for k, body in enumerate(obstacle):
        if body.name in known:
            message = f"is the name of {known[body.name]}; choose another one"
            yield Problem(f"obstacle.{k}.name", message, body.name)
        known.setdefault(body.name, f"obstacle.{k}")


def obstacles_inside(geometry: Geometry, particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that obstacles lie inside the space and boxes are a spacing thick."""
    if not is_three_dimensional(geometry):
        return
    spaces = list(dict.fromkeys(open_space(geometry, particles)))
    for k, body in enumerate(obstacle):
        area = occupied(body)
        slack = TOLERANCE + (WALL_SHIFT if isinstance(body, MeshObstacle) else 0.0)
        if not any(space.shrunk(-slack * particles.spacing).holds(area) for space in spaces):
            room = " or ".join(map(str, spaces))
            message = f"the {body.type} {area} is not inside the {geometry.type}, {room}"
            yield Problem(f"obstacle.{k}", message)
        if not isinstance(body, BoxObstacle):
            continue
        for axis, extent in (("x", body.x), ("y", body.y), ("z", body.z)):
            if 0 < extent[1] - extent[0] < (1 - TOLERANCE) * particles.spacing:
                message = f"not resolved: must be at least one spacing of {particles.spacing:g} m"
                yield Problem(f"obstacle.{k}.{axis}", message, extent)


def obstacles_apart(geometry: Geometry, particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that no two obstacles overlap; out of a fill they are cut."""
    if not is_three_dimensional(geometry):
        return
    solids = [(f"obstacle.{k}", body, occupied(body)) for k, body in enumerate(obstacle)]
    for (name, body, area), (key, other, another) in combinations(solids, 2):
        shared = shared_space((body, other), area.overlap(another), particles)
        if shared:
            yield Problem(key, f"overlaps {name}, '{body.name}', in {shared}")


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
    obstacles_inside,
    obstacles_apart,
    meshes_resolved,
)
