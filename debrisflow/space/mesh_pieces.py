"""The meshes of a case that are obstacles, cut into small triangles (NumPy and pyvista)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.regions import MESH_SLACK, surface_of
from debrisflow.case.triangles import Surface
from debrisflow.space.bodies import bodies_of
from debrisflow.space.domain import WALL_NAMES, image_shifts, wall_names
from debrisflow.space.ground import ground_of
from debrisflow.space.scene import faces_of

Floats = NDArray[np.float64]
WIDEST, WIDEST_ON_GROUND = 0.5, 1.0
"""Longest side of an element, in spacings; what lies nearer to a wide one sees its quarters, see
:func:`debrisflow.neighbors.elements.add_elements`."""
LEAST_AREA = 1e-4
"""Of an element that is lifted to a ground, in squares of a spacing; what is less was a side.  Of
one that was wholly below it, that in plan: along a curved ground a side leaves slivers."""


def pieces_of(
    case: ResolvedCase, pulled_back: float
) -> tuple[Floats, NDArray[np.int64], NDArray[np.bool_]]:
    """Return the meshes that are obstacles as small triangles.

    Parameters
    ----------
    case : ResolvedCase
    pulled_back : float
        Spacings by which the solid of the sums lies behind its surface.

    Returns
    -------
    pieces : (n, 3, 6) float64 array, m
        Three corners on the surface, and on the solid of the sums.
    number : (n,) int64 array
        Of the wall that they belong to.
    is_face : (n,) bool array
        False where they lie in a wall of the space, as the base of a body on a floor.
    """
    pieces, number = [np.zeros((0, 3, 6))], [np.zeros(0, dtype=np.int64)]
    is_face = [np.zeros(0, dtype=np.bool_)]
    for wall, obstacle in enumerate(case.obstacle, start=len(WALL_NAMES)):
        if isinstance(obstacle, MeshObstacle):
            surface = surface_of(obstacle)
        elif case.is_terrain and isinstance(obstacle, BoxObstacle):
            surface = surface_of_box(obstacle)
        else:
            continue
        own = _with_inner(_outward(surface), pulled_back, case)
        widest = WIDEST_ON_GROUND if case.is_terrain else WIDEST
        own = _cut(own, widest * case.particles.spacing)
        if case.is_terrain:
            own, faces = _on_ground(own, pulled_back, case)
            pieces.append(own)
            number.append(np.full(len(own), wall))
            is_face.append(faces)
            continue
        for shift in image_shifts(case):
            pieces.append(own + np.tile(shift, 2))
            number.append(np.full(len(own), wall))
            is_face.append(~_in_walls(own[:, :, :3], case))
    return np.concatenate(pieces), np.concatenate(number), np.concatenate(is_face)


def faces_in_open(case: ResolvedCase, name: str) -> Floats:
    """Return the triangles of an obstacle that fluid can meet, (n, 3, 3) array, m."""
    wall = wall_names(case).index(name)
    obstacle = case.obstacle[wall - len(WALL_NAMES)]
    if isinstance(obstacle, BoxObstacle) and not case.is_terrain:
        return surface_of_box(obstacle).corners
    pieces, number, is_face = pieces_of(case, 0.0)
    faces: Floats = pieces[(number == wall) & is_face][:, :, :3]
    return faces


def top_of_structures(case: ResolvedCase, x: float, y: float) -> float:
    """Return the highest level of the obstacles on a terrain at a place, m; -inf where none is."""
    pieces, _, is_face = pieces_of(case, 0.0)
    corners = pieces[is_face][:, :, :3]
    area = area_vectors(corners)
    looks_up = area[:, 2] > 1e-6 * np.linalg.norm(area, axis=1)
    a, b, c = np.moveaxis(corners[looks_up], 1, 0)
    plan = np.stack([b - a, c - a], axis=2)[:, :2]
    share = np.linalg.solve(plan, (np.array([x, y]) - a[:, :2])[:, :, None])[:, :, 0]
    over = np.all(share >= -1e-9, axis=1) & (share.sum(axis=1) <= 1.0 + 1e-9)
    level = a[:, 2] + share[:, 0] * (b - a)[:, 2] + share[:, 1] * (c - a)[:, 2]
    return float(level[over].max(initial=-np.inf))


def surface_of_box(box: BoxObstacle) -> Surface:
    """Return the surface of a box in three dimensions as triangles."""
    sides = faces_of(box)
    return Surface(np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]]))


def _on_ground(
    pieces: Floats, pulled_back: float, case: ResolvedCase
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the pieces of a body above the ground, and which of them a particle can meet.

    Points below the ground are lifted to it, so that the base follows the ground and buried parts
    of the sides vanish.  Thus no volume is counted twice, in the body and in the ground.
    """
    d0, ground = case.particles.spacing, ground_of(case).surface
    lifted, buried = pieces.copy(), np.ones(pieces.shape[:2], dtype=bool)
    for first, depth in ((0, 0.0), (3, pulled_back * d0)):
        level, along, aside = ground.level_and_slope(pieces[:, :, first], pieces[:, :, first + 1])
        level = level - depth * np.sqrt(1.0 + along**2 + aside**2)
        buried &= pieces[:, :, first + 2] <= level
        lifted[:, :, first + 2] = np.maximum(pieces[:, :, first + 2], level)
    area = area_vectors(lifted[:, :, :3])
    # where the ground rises along a side a lifted piece may turn over: it takes away in the sums
    # what another one has too much, and is no face
    is_turned = np.sum(area * area_vectors(pieces[:, :, :3]), axis=1) < 0.0
    is_buried = np.all(buried, axis=1)
    is_met = ~is_buried & ~is_turned
    size = np.where(is_buried, np.abs(area[:, 2]), np.linalg.norm(area, axis=1))
    kept = size > LEAST_AREA * d0**2
    return lifted[kept], is_met[kept]


def area_vectors(corners: Floats) -> Floats:
    """Return the vector area of triangles, (n, 3, 3) array, m; outward if they turn to the left."""
    a, b, c = np.moveaxis(corners, 1, 0)
    vectors: Floats = 0.5 * np.cross(b - a, c - a)
    return vectors


def _outward(surface: Surface) -> Floats:
    """Return the corners of the triangles, which turn to the left as seen from outside."""
    import pyvista

    faces = np.arange(3 * len(surface.corners)).reshape(-1, 3)
    mesh = pyvista.PolyData.from_regular_faces(surface.corners.reshape(-1, 3), faces)
    turned = mesh.clean().compute_normals(
        point_normals=False, cell_normals=True, auto_orient_normals=True
    )
    corners: Floats = np.asarray(turned.points, dtype=float)[turned.regular_faces]
    against = np.sum(area_vectors(corners) * turned.cell_data["Normals"], axis=1) < 0.0
    corners[against] = corners[against][:, ::-1]
    return corners


def _with_inner(corners: Floats, pulled_back: float, case: ResolvedCase) -> Floats:
    """Return triangles with those of the solid of the sums, (n, 3, 6): all faces pulled back.

    A vertex moves so that each face around it moves by the same along its normal; the base of a
    body that stands on a wall follows the solid of that wall.
    """
    area = area_vectors(corners)
    normal = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-300)
    back = pulled_back * case.particles.spacing
    moved = np.where(_in_walls(corners, case), back, -back)
    _, vertex = np.unique(
        np.rint(corners.reshape(-1, 3) / (1e-6 * case.particles.spacing)),
        axis=0,
        return_inverse=True,
    )
    vertex = vertex.reshape(-1)
    matrix, right = (
        np.zeros((vertex.max(initial=-1) + 1, 3, 3)),
        np.zeros((vertex.max(initial=-1) + 1, 3)),
    )
    own = np.repeat(normal, 3, axis=0)
    np.add.at(matrix, vertex, own[:, :, None] * own[:, None, :])
    np.add.at(right, vertex, own * np.repeat(moved, 3)[:, None])
    shift = np.einsum("vij,vj->vi", np.linalg.pinv(matrix, rcond=1e-3), right)
    return np.concatenate([corners, corners + shift[vertex].reshape(corners.shape)], axis=2)


def _cut(pieces: Floats, widest: float) -> Floats:
    """Return triangles, (n, 3, 6), halved along their longest sides until none is wider, m."""
    done = []
    while len(pieces):
        corners = pieces[:, :, :3]
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        longest = np.argmax(sides, axis=1)
        small = sides.max(axis=1) <= widest
        done.append(pieces[small])
        rows, first = np.flatnonzero(~small), longest[~small]
        a, b, c = (pieces[rows, (first + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        pieces = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(done)


def _in_walls(corners: Floats, case: ResolvedCase) -> NDArray[np.bool_]:
    """Return which triangles lie in another wall or on its surface."""
    slack, inside = MESH_SLACK * case.particles.spacing, np.zeros(len(corners), dtype=bool)
    for body in bodies_of(case):
        held = body.holds(corners.reshape(-1, 3), slack)
        inside |= np.all(held.reshape(-1, 3), axis=1)
    return inside
