"""Checks of the structures on a terrain: that they stand in the ground, beside what is released."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import shapely

from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.released import area, depth_at
from debrisflow.case.releases import AnyRelease, HydrographRelease
from debrisflow.case.resolved import MappedTerrain, ResolvedTerrain
from debrisflow.case.shapes import Geometry
from debrisflow.case.structures import Structure, ground_under, levels_of, plan_of
from debrisflow.case.tables import AnyObstacle, Particles
from debrisflow.case.terrain import Terrain

Obstacles = tuple[AnyObstacle, ...]
OVERLAP = 0.1
"""Of the area of a release, that may lie over a structure: cells of a raster do not end at it."""
PLACES = 200  # along each side of a structure, at which releases over it are looked for


def turned_on_terrain(geometry: Geometry, obstacle: Obstacles) -> Problems:
    """Check that boxes are turned on a terrain only."""
    if isinstance(geometry, Terrain):
        return
    for k, body in enumerate(obstacle):
        if isinstance(body, BoxObstacle) and body.turn != 0.0:
            message = (
                "boxes are turned on a terrain only; elsewhere a turned box is a mesh in three "
                "dimensions, a polygon in two"
            )
            yield Problem(f"obstacle.{k}.turn", message, body.turn)


def structures_stand(geometry: Geometry, particles: Particles, obstacle: Obstacles) -> Problems:
    """Check that structures reach into the ground and rise above it."""
    for k, body in _structures(geometry, obstacle):
        assert isinstance(geometry, ResolvedTerrain)
        lowest, highest = ground_under(body, geometry)
        bottom, top = levels_of(body)
        key = f"obstacle.{k}.z" if isinstance(body, BoxObstacle) else f"obstacle.{k}"
        value = body.z if isinstance(body, BoxObstacle) else None
        message = ""
        if top <= lowest:
            message = f"lies below the ground, which is {lowest:.6g} to {highest:.6g} m there"
        elif bottom > highest + particles.spacing:
            message = (
                f"hovers over the ground, which is {lowest:.6g} to {highest:.6g} m there; let it "
                f"reach below {lowest:.6g} m, what is in the ground does not count"
            )
        if message and value is None:
            yield Problem(key, f"its levels are {bottom:.6g} to {top:.6g} m: it {message}")
        elif message:
            yield Problem(key, message, value)


def releases_beside_structures(
    geometry: Geometry, obstacle: Obstacles, release: tuple[AnyRelease, ...]
) -> Problems:
    """Check that nothing is released in a structure."""
    for k, body in _structures(geometry, obstacle):
        assert isinstance(geometry, ResolvedTerrain)
        plan = plan_of(body)
        if not isinstance(geometry, MappedTerrain):
            plan = shapely.transform(plan, lambda places: places + np.array(geometry.origin[:2]))
        for m, part in enumerate(release):
            if isinstance(part, HydrographRelease):
                if shapely.LineString(part.line).intersects(plan):
                    message = f"crosses obstacle.{k}, '{body.name}'; move one of them"
                    yield Problem(f"release.{m}.line", message, part.line)
                continue
            west, south, east, north = plan.bounds
            lines = (np.linspace(*ends, PLACES) for ends in ((west, east), (south, north)))
            x, y = (line.ravel() for line in np.meshgrid(*lines))
            held = shapely.contains_xy(plan, x, y) & (depth_at(part, x, y) > 0.0)
            shared = float(held.mean()) * (east - west) * (north - south)
            if shared > OVERLAP * area(part):
                message = (
                    f"lies over obstacle.{k}, '{body.name}', with {shared:.3g} m2 of its "
                    f"{area(part):.3g}; cut it out there"
                )
                yield Problem(f"release.{m}", message)


def _structures(geometry: Geometry, obstacle: Obstacles) -> Iterator[tuple[int, Structure]]:
    """Yield the structures that can stand on a terrain, by their places in the case."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    for k, body in enumerate(obstacle):
        if isinstance(body, MeshObstacle) or (isinstance(body, BoxObstacle) and body.z is not None):
            yield k, body


CHECKS: tuple[Callable[..., Problems], ...] = (
    turned_on_terrain,
    structures_stand,
    releases_beside_structures,
)
