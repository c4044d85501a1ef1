"""Polygons that are obstacles in two dimensions: what is wrong with them, and their measures."""

from __future__ import annotations

import numpy as np
import shapely

from debrisflow.case.bodies import PolygonObstacle

FIRST_ROW = 0.5  # spacings, see neighbors.half_plane
FLAT = 1e-6  # of the box around a polygon, which encloses nothing below that


def fault_of(polygon: PolygonObstacle) -> str:
    """Return what is wrong with a polygon; empty if nothing is."""
    x, y = np.array(polygon.corners).T
    if abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) <= FLAT * np.ptp(x) * np.ptp(y):
        return "encloses nothing: its corners lie on a line, or its sides cross"
    shape = shapely.Polygon(polygon.corners)
    if not shapely.is_valid(shape):
        _, _, place = shapely.is_valid_reason(shape).partition("[")
        return f"its sides cross or touch at ({place.rstrip(']').replace(' ', ', ')}) m"
    return ""


def thickness(polygon: PolygonObstacle) -> float:
    """Return the diameter of the largest circle in a polygon, m.

    Examples
    --------
    >>> corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0))
    >>> round(thickness(PolygonObstacle(type="polygon", name="wedge", corners=corners)), 3)
    2.0
    """
    shape = shapely.Polygon(polygon.corners)
    tolerance = 1e-3 * shape.area / shape.length
    return float(2.0 * shapely.maximum_inscribed_circle(shape, tolerance).length)


def share_without_rows(polygon: PolygonObstacle, spacing: float) -> float:
    """Return the share of the sides of a polygon that have no row of wall under them.

    The first row lies half a spacing, m, under the sides, and does not reach into parts that are
    thinner than two such depths.

    Examples
    --------
    >>> square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    >>> thin = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.05), (0.0, 0.05))
    >>> [
    ...     round(share_without_rows(PolygonObstacle(type="polygon", name="a", corners=c), 0.1), 2)
    ...     for c in (square, thin)
    ... ]
    [0.0, 1.0]
    """
    shape = shapely.Polygon(polygon.corners)
    inner = shape.buffer(-FIRST_ROW * spacing, join_style="mitre")
    seen = inner.buffer(2.0 * FIRST_ROW * spacing)
    return float(shape.exterior.difference(seen).length / shape.exterior.length)


def is_in_polygon(x: float, y: float, polygon: PolygonObstacle) -> bool:
    """Return whether a place lies in a polygon."""
    return bool(shapely.Polygon(polygon.corners).contains(shapely.Point(x, y)))


def distance_to_polygon(x: float, y: float, polygon: PolygonObstacle) -> float:
    """Return the distance of a place, outside or inside, to the sides of a polygon, m."""
    sides = shapely.Polygon(polygon.corners).exterior
    return float(shapely.distance(sides, shapely.Point(x, y)))
