"""The outlines of dams and other obstacles on the map."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.space.scene import obstacle_faces

Floats = NDArray[np.float64]


def structures(case: ResolvedCase) -> dict[str, list[Floats]]:
    """Return the outlines of the obstacles of a case in plan by their names.

    Returns
    -------
    dict of str to list of (n, 2) float64 array, m
        Places on the map, the last that of the first; at the start, if an obstacle moves.
    """
    origin = getattr(case.geometry, "origin", None) or (0.0, 0.0, 0.0)
    found = {}
    for part, faces in zip(case.obstacle, obstacle_faces(case), strict=True):
        rings = outlines(faces)
        found[part.name] = [ring + np.array(origin[:2]) for ring in rings]
    return found


def outlines(faces: Floats) -> list[Floats]:
    """Return the outlines of faces as seen from above.

    Parameters
    ----------
    faces : (n, 3 or 4, 3) float64 array, m

    Examples
    --------
    >>> faces = np.array([[[0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]]], dtype=float)
    >>> [ring.shape for ring in outlines(faces)]
    [(5, 2)]
    """
    flat = shapely.polygons(faces[..., :2])
    whole = shapely.union_all(flat[shapely.area(flat) > 0.0])  # without those that are upright
    return [np.asarray(part.exterior.coords) for part in shapely.get_parts(whole) if part.area]
