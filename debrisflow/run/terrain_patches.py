"""Patches of walls on a terrain: on the ground, or on a face of a structure (NumPy, pyvista)."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.errors import CaseError
from debrisflow.neighbors.patches import Patch, patches_of
from debrisflow.run.wall_pressure import Faces
from debrisflow.space.domain import FLOOR, wall_names
from debrisflow.space.ground import ground_of
from debrisflow.space.mesh_pieces import area_vectors, faces_in_open

Floats = NDArray[np.float64]
OFF = 0.1  # spacings from a face of a structure, beyond which a part of a patch is not on it


def patch_on_terrain(
    case: ResolvedCase, wall: str, place: Floats, size: float
) -> tuple[Patch, Faces, float, float]:
    """Return the patch nearest to a place, its parts, their area, m2, and how far it was, m.

    Parameters
    ----------
    case : ResolvedCase
    wall : str
        The floor, a zone or an obstacle.
    place : (3,) float64 array, m
    size : float, m
        Side of the patch.
    """
    number = wall_names(case).index(wall)
    is_ground = wall not in {body.name for body in case.obstacle}
    if is_ground:
        center, normal = _on_ground(case, number, wall, place)
        nearest = np.zeros((0, 3))
    else:
        corners = faces_in_open(case, wall)
        [center], [face] = _nearest(corners, place[None])
        normal = area_vectors(corners[face][None])[0]
        normal /= np.linalg.norm(normal)
        nearest = corners
    distance = float(np.linalg.norm(place - center))
    patch = Patch(number, center, normal, size)
    count = max(1, ceil(size / case.particles.spacing - 1e-9))
    middles = ((np.arange(count) + 0.5) / count - 0.5) * size
    along, aside = patches_of([patch], 1.0, 3, np.zeros(3)).frame[0, 1:]
    a, b = (line.ravel()[:, None] for line in np.meshgrid(middles, middles))
    parts = center + a * along + b * aside
    if is_ground:
        parts[:, 2] = ground_of(case).surface.level(parts[:, 0], parts[:, 1])
    else:
        off = np.linalg.norm(_nearest(nearest, parts)[0] - parts, axis=1)
        parts = parts[off < OFF * case.particles.spacing]
    area = len(parts) * (size / count) ** 2
    return patch, Faces(parts, np.tile(normal, (len(parts), 1))), area, distance


def _on_ground(case: ResolvedCase, number: int, wall: str, place: Floats) -> tuple[Floats, Floats]:
    """Return the place of the ground at a place in plan, and the normal there."""
    ground = ground_of(case)
    level, along, aside = ground.surface.level_and_slope(place[:1], place[1:2])
    found = int(ground.number[ground.cells(place[:1], place[1:2])][0])
    if found != number:
        names = wall_names(case)
        other = "no zone" if found == FLOOR else f"the zone '{names[found]}'"
        raise CaseError(
            f"the ground at the place of a probe on {wall} is in {other}; set its wall to "
            f"'{names[found]}'"
        )
    normal = np.array([-along[0], -aside[0], 1.0])
    return np.array([place[0], place[1], level[0]]), normal / np.linalg.norm(normal)


def _nearest(corners: Floats, places: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the points of triangles nearest to places, (n, 3) array, m, and their triangles."""
    import pyvista

    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    mesh = pyvista.PolyData.from_regular_faces(corners.reshape(-1, 3), faces)
    cells, points = mesh.find_closest_cell(places, return_closest_point=True)
    return np.atleast_2d(points), np.atleast_1d(cells)
