"""What an obstacle that moves runs into: walls of the space and other obstacles."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import MeshObstacle, PolygonObstacle
from debrisflow.case.built import walls_along
from debrisflow.space.domain import domain

Floats = NDArray[np.float64]
LOOKS = 200  # at the obstacles during a run
INTO_WALL = 0.5
"""Spacings into a wall that are let pass: the foot of a flap is as deep as half its thickness."""
INTO_BODY = 1e-3  # spacings
SHARED = "what both share counts twice"


class Outline(NamedTuple):
    """A body at a time.

    Attributes
    ----------
    side : shapely.Polygon, m
        As seen along y, in three dimensions, over x and up; of a mesh its hull.
    lower, upper : (3,) float64 array, m
    """

    side: shapely.Polygon
    lower: Floats
    upper: Floats


def encounters(case: ResolvedCase) -> list[str]:
    """Return what obstacles that move run into, a line for each pair with the time.

    Meshes are followed against the walls only, since their hulls may share what they do not.
    """
    moving = {k for k, body in enumerate(case.obstacle) if body.motion is not None}
    if not moving:
        return []
    found: dict[tuple[str, str], float] = {}
    for time in np.linspace(0.0, case.time.end, LOOKS + 1):
        for pair in _at(case, float(time), moving):
            found.setdefault(pair, float(time))
    return [
        f"obstacle.{one}: runs into {other} at t = {time:.3g} s; {SHARED}"
        for (one, other), time in found.items()
    ]


def _at(case: ResolvedCase, time: float, moving: set[int]) -> Iterator[tuple[str, str]]:
    """Yield the name of a moving obstacle and what it is in at a time, s."""
    # here, so that the check of a case in which nothing moves needs no SciPy
    from debrisflow.space.scene import obstacle_faces

    bodies = [
        _outline(faces, case, isinstance(part, PolygonObstacle))
        for part, faces in zip(case.obstacle, obstacle_faces(case, time), strict=True)
    ]
    for k in sorted(moving):
        for axis, end in _walls_entered(bodies[k], case):
            yield case.obstacle[k].name, f"the wall at {axis} = {end:g} m"
    slack = INTO_BODY * case.particles.spacing
    for j, k in combinations(range(len(bodies)), 2):
        pair = case.obstacle[j], case.obstacle[k]
        if not moving & {j, k} or any(isinstance(part, MeshObstacle) for part in pair):
            continue
        if _share(bodies[j], bodies[k], slack):
            one, other = pair if j in moving else pair[::-1]
            yield one.name, f"obstacle.{other.name}"


def _outline(faces: Floats, case: ResolvedCase, is_polygon: bool) -> Outline:
    corners = faces.reshape(-1, 3)
    side = corners[:, [0, case.dimension - 1]]
    shape = shapely.Polygon(side) if is_polygon else shapely.MultiPoint(side).convex_hull
    return Outline(shape, corners.min(axis=0), corners.max(axis=0))


def _share(one: Outline, other: Outline, slack: float) -> bool:
    """Return whether two bodies share more than a surface."""
    lower, upper = np.maximum(one.lower, other.lower), np.minimum(one.upper, other.upper)
    thick = upper - lower > 2.0 * slack
    thick[1] |= one.upper[2] == one.lower[2]  # in two dimensions the outlines alone tell
    if not (thick[0] and thick[1]):
        return False
    return bool(shapely.intersects(one.side.buffer(-slack), other.side.buffer(-slack)))


def _walls_entered(body: Outline, case: ResolvedCase) -> Iterator[tuple[str, float]]:
    """Yield axis and place, m, of the outer walls of the space that a body is in."""
    closed, slack = domain(case).closed, INTO_WALL * case.particles.spacing
    for axis, (name, walls) in enumerate(walls_along(case.geometry, case.particles).items()):
        if closed[axis, 0] and body.lower[axis] < min(walls) - slack:
            yield name, min(walls)
        if closed[axis, 1] and body.upper[axis] > max(walls) + slack:
            yield name, max(walls)
