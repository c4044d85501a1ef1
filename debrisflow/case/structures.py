"""Structures on a terrain as seen from above, and the ground under them."""

from __future__ import annotations

import numpy as np
import shapely

from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.regions import surface_of
from debrisflow.case.released import cells_at
from debrisflow.case.resolved import MappedTerrain, ResolvedTerrain

Structure = BoxObstacle | MeshObstacle
PLACES = 40  # along each side of a structure, at which the ground under it is asked


def plan_of(body: Structure) -> shapely.Geometry:
    """Return what a structure covers as seen from above.

    Examples
    --------
    >>> dam = BoxObstacle(type="box", name="dam", x=(0.0, 4.0), y=(0.0, 2.0), turn=90.0)
    >>> shapely.bounds(plan_of(dam)).round(6) + 0.0
    array([ 1., -1.,  3.,  3.])
    """
    if isinstance(body, MeshObstacle):
        triangles = shapely.polygons(surface_of(body).corners[:, :, :2])
        return shapely.union_all(triangles[shapely.area(triangles) > 0.0])
    return shapely.Polygon(body.corners_in_plan)


def levels_of(body: Structure) -> tuple[float, float]:
    """Return the lowest and the highest level of a structure, m."""
    if isinstance(body, MeshObstacle):
        surface = surface_of(body)
        return float(surface.lower[2]), float(surface.upper[2])
    return body.extents[-1]


def ground_under(body: Structure, terrain: ResolvedTerrain) -> tuple[float, float]:
    """Return the lowest and the highest level of the DEM under a structure, m, in its own frame."""
    plan, levels = plan_of(body), terrain.levels
    origin = (0.0, 0.0, 0.0) if isinstance(terrain, MappedTerrain) else terrain.origin
    west, south, east, north = plan.bounds
    x, y = np.meshgrid(np.linspace(west, east, PLACES), np.linspace(south, north, PLACES))
    inside = shapely.intersects_xy(plan, x, y)
    found = cells_at(levels, x[inside] + origin[0], y[inside] + origin[1], np.nan) - origin[2]
    if not np.isfinite(found).any():
        return np.nan, np.nan
    return float(np.nanmin(found)), float(np.nanmax(found))
