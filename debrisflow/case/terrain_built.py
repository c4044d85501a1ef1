"""A terrain as it is built: on whole cells of its DEM, with an origin from which a run measures."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor
from typing import Any, TypeVar

import numpy as np

from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.fields import Point, Table
from debrisflow.case.materials import Mixture
from debrisflow.case.motion import Motion
from debrisflow.case.probe import DIGITS
from debrisflow.case.released import direction_down, greatest_depth
from debrisflow.case.releases import AnyRelease, HydrographRelease
from debrisflow.case.resolved import (
    MappedTerrain,
    ResolvedHydrographRelease,
    ResolvedRelease,
    ResolvedTerrain,
    resolved,
)
from debrisflow.case.tables import AnyObstacle, Particles
from debrisflow.case.terrain import Terrain

CELL_SPACINGS = 3.0  # of the smooth surface, at least: the rows of wall under it see no bumps
TOP_SPACINGS, LEAST_TOP = 50.0, 20.0  # m; over the highest ground, for spray and run-up
BELOW_SPACINGS, LEAST_BELOW = 10.0, 1.0  # m; under the lowest ground, for the smooth surface
ROUND = 10.0  # m, to which origin and top are rounded
_Part = TypeVar("_Part", bound=Table)


def built_terrain(
    terrain: Terrain, particles: Particles, release: tuple[AnyRelease, ...] = ()
) -> ResolvedTerrain:
    """Return a terrain with its borders on cells of the DEM, its surface, top and origin.

    Without an origin its lengths are those of the map.  A terrain already built is unchanged.
    """
    if isinstance(terrain, ResolvedTerrain):
        return terrain
    levels, spacing = terrain.levels, particles.spacing
    west, south, _, _ = box = terrain.box
    below = max(BELOW_SPACINGS * spacing, LEAST_BELOW) + deepest_scar(release)
    base = ROUND * floor((float(np.nanmin(levels.values)) - below) / ROUND)
    above = max(TOP_SPACINGS * spacing, LEAST_TOP)
    return resolved(
        MappedTerrain if terrain.origin is None else ResolvedTerrain,
        terrain.model_copy(update={"crop": None}),
        crop=box,
        cell=cell_of_surface(levels.grid.cell, spacing),
        upper_level=ROUND * ceil((float(np.nanmax(levels.values)) + above) / ROUND),
        origin=(west, south, base),
    )


def cell_of_surface(cell: float, spacing: float) -> float:
    """Return the cell of the smooth surface through a DEM of a given cell, m.

    Examples
    --------
    >>> cell_of_surface(10.0, 1.0), cell_of_surface(1.0, 0.5), cell_of_surface(0.5, 0.5)
    (10.0, 2.0, 1.5)
    """
    return max(ceil(CELL_SPACINGS * spacing / cell - 1e-9), 1) * cell


def deepest_scar(release: tuple[AnyRelease, ...]) -> float:
    """Return the greatest depth that releases take out of the terrain, m."""
    taken = [
        greatest_depth(part)
        for part in release
        if not isinstance(part, HydrographRelease) and part.place == "in-terrain"
    ]
    return max(taken, default=0.0)


def built_releases(
    release: tuple[AnyRelease, ...], terrain: ResolvedTerrain, mixture: Mixture
) -> tuple[ResolvedRelease, ...]:
    """Return releases with the direction of those over a line, and what masses are made of."""
    found: list[ResolvedRelease] = []
    for part in release:
        if isinstance(part, HydrographRelease):
            if isinstance(part.line, str) or isinstance(part.hydrograph, str):
                raise TypeError("lines and hydrographs in files are read by load_case")
            down = direction_down(part.line, terrain.levels) if part.direction is None else None
            found.append(resolved(ResolvedHydrographRelease, part, direction=down or 0.0))
        elif part.material == "mixture" and part.concentration is None:
            found.append(part.model_copy(update={"concentration": mixture.concentration}))
        else:
            found.append(part)
    return tuple(found)


def over_origin(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return terrain, obstacles and probes of a case on the map, measured from the origin.

    Parameters
    ----------
    case : mapping of str to table
        By name; nothing is returned where its lengths are over the origin already.
    """
    terrain = case["geometry"]
    if not isinstance(terrain, MappedTerrain):
        return {}
    back = tuple(-at for at in terrain.origin)
    x, y, z = back
    return {
        "geometry": resolved(ResolvedTerrain, terrain),
        "obstacle": tuple(_moved(body, (x, y, z)) for body in case["obstacle"]),
        "probe": tuple(probe.moved((x, y, z)) for probe in case["probe"]),
    }


def _moved(body: AnyObstacle, by: Point) -> AnyObstacle:
    """Return an obstacle at another place."""
    found: dict[str, Any] = {}
    if isinstance(body, MeshObstacle):
        found["offset"] = tuple(
            round(at + step, DIGITS) for at, step in zip(body.offset, by, strict=True)
        )
    elif isinstance(body, BoxObstacle) and body.z is not None:
        for axis, extent, step in zip("xyz", (body.x, body.y, body.z), by, strict=True):
            found[axis] = (round(extent[0] + step, DIGITS), round(extent[1] + step, DIGITS))
    if isinstance(body.motion, Motion) and body.motion.about is not None:
        x, level = body.motion.about
        about = (round(x + by[0], DIGITS), round(level + by[2], DIGITS))
        found["motion"] = body.motion.model_copy(update={"about": about})
    return body.model_copy(update=found)
