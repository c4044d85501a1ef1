"""The pressure of the fluid on a wall, from the particles next to it (NumPy and SciPy only).

The surface of a wall consists of the faces between its cells and open ones, each as large as the
side of a cell.  A staircase of such faces has the vector area of the smooth surface that it
represents, and therefore the same force.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from debrisflow.case import ResolvedCase, shapes, tables
from debrisflow.case.bodies import BoxObstacle
from debrisflow.case.shapes import plain_of
from debrisflow.neighbors.patches import Band, Patch, Patches, patches_of
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import State
from debrisflow.space.bodies import are_among
from debrisflow.space.domain import domain, wall_names
from debrisflow.space.floor import floor_level, height_over_floor, is_over_floor
from debrisflow.space.gravity import gravity_vector

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]
OF_STEP = "of the step before; at a start that at rest, or none in two dimensions"
REACH = 1.5  # spacings from the surface within which particles press on it
FULL_FROM = 0.75  # spacings; a single particle nearer than this presses fully
LATTICE_TOLERANCE = 1.0e-3  # spacings


class Faces(NamedTuple):
    """Faces of the surface of a wall, each of the area d0^(D - 1).

    Attributes
    ----------
    position : (n, 3) float64 array, m
        Middles of the faces.
    normal : (n, 3) float64 array
        Unit normals out of the wall.
    """

    position: Floats
    normal: Floats


def wall_faces(case: ResolvedCase, walls: Particles, name: str) -> Faces:
    """Return the faces of a wall or obstacle that the fluid can touch.

    A wall cell has a face toward every open cell beside it; a cell at an edge has two or three.
    Where the wall does not follow the lattice (a run-out), each particle of its first layer
    represents one face.

    Parameters
    ----------
    case : ResolvedCase
    walls : Particles
        Particles by which all walls are drawn, whatever else is among them.
    name : str
        One of :func:`debrisflow.space.domain.wall_names`.
    """
    d0, axes, drawn = case.particles.spacing, case.dimension, np.flatnonzero(walls.wall >= 0)
    cell, follows = _cells(walls.position[drawn], d0, axes)
    own = walls.wall[drawn] == wall_names(case).index(name)
    own &= walls.kind[drawn] == Kind.WALL
    period = np.rint(domain(case).period / d0).astype(np.int64)
    lattice = cell[own & follows]
    box = next((b for b in case.obstacle if isinstance(b, BoxObstacle) and b.name == name), None)
    position, normal = [], []
    for axis in range(axes):
        for side in (-1, 1):
            step = np.zeros(3)
            step[axis] = side
            beside = lattice + step.astype(np.int64)
            shown = ~are_among(_wrapped(beside, period), cell[follows])
            shown &= _in_space(case, (beside + 0.5) * d0)
            place = (lattice[shown] + 0.5 * (1.0 + step)) * d0
            if box is not None:  # which need not end on the lattice
                place[:, axis] = getattr(box, "xyz"[axis])[int(side > 0)]
            position.append(place)
            normal.append(np.tile(step, (int(np.count_nonzero(shown)), 1)))
    rows = drawn[own & ~follows]
    outward, depth = walls.wall_normal[rows], walls.wall_depth[rows, None]
    surface = walls.position[rows] + depth * outward
    inside = _in_space(case, surface + 0.5 * d0 * outward)
    faces = Faces(
        np.concatenate([*position, surface[inside]]), np.concatenate([*normal, outward[inside]])
    )
    faces.position[:, axes:] = 0.0
    return faces


def face_pressure(
    faces: Faces, case: ResolvedCase, position: Floats, pressure: Floats, density: Floats
) -> Floats:
    """Return the pressure of the fluid on the faces of a wall, Pa.

    At a face s, from the particles i in front of it and nearer than R = 1.5 d0,

        p_s = sum_i w_i max(p_i + rho_i g . (x_s - x_i), 0) / max(sum_i w_i, w_0)

    with w = (1 - r / R)^2 and w_0 = w(0.75 d0).  The explicit scheme extrapolates in the same way
    to its wall particles.  The pressure of still water is exact on a lattice and for random
    displacements of up to 0.3 d0 (with w_0 = w(d0 / 2), the first row, it would be 1 to 8 % too low
    there).  Because of the lower bound on the sum of weights, the pressure of a particle that
    approaches a dry wall grows gradually, and does not act on faces far beside it.

    Parameters
    ----------
    faces : Faces
    case : ResolvedCase
    position : (n, 3) float64 array, m
        Of the fluid particles only.
    pressure, density : (n,) float64 array, Pa, kg/m3

    Returns
    -------
    (m,) float64 array, Pa
        0 where no fluid is near.
    """
    reach = REACH * case.particles.spacing
    period = domain(case).period
    near = _near(faces.position, position, reach, period)
    if near.size == 0:
        return np.zeros(len(faces.position))
    pairs = _tree(faces.position, period).sparse_distance_matrix(
        _tree(position[near], period), reach, output_type="ndarray"
    )
    face, row = pairs["i"], near[pairs["j"]]
    outward = position[row] - faces.position[face]
    repeat = np.where(period > 0.0, period, np.inf)
    outward -= np.where(period > 0.0, period, 0.0) * np.rint(outward / repeat)
    is_before = np.einsum("ij,ij->i", outward, faces.normal[face]) > 0.0
    weight = is_before * (1.0 - pairs["v"] / reach) ** 2
    extrapolated = pressure[row] - density[row] * (outward @ gravity_vector(case))
    total = np.bincount(face, weight, len(faces.position))
    pressed = np.bincount(face, weight * np.maximum(extrapolated, 0.0), len(faces.position))
    return np.asarray(pressed / np.maximum(total, (1.0 - FULL_FROM / REACH) ** 2))


def pressure_on(faces: Faces, case: ResolvedCase, state: State) -> Floats:
    """Return the pressure on the faces of a wall in a state, (n,) array, Pa."""
    p, rows = state.particles, state.particles.fluid
    pressure = p.pressure[rows]
    if isinstance(case.scheme, tables.ExplicitScheme):
        # there walls return the pressure of colliding grains too; that of grains in contact is a
        # part of the whole
        pressure = pressure + p.collision_pressure[rows]
    return face_pressure(faces, case, p.position[rows], pressure, p.density[rows])


def force(faces: Faces, pressure: Floats, area: float, about: Floats) -> tuple[Floats, Floats]:
    """Return force and moment of the fluid on a wall, in two dimensions per meter of width.

    ``F = -sum p n A`` and ``M = -sum (x - a) x p n A``, of the pressure alone.

    Parameters
    ----------
    faces : Faces
    pressure : (n,) float64 array, Pa
        On the faces.
    area : float, m2 or m
        Of one face.
    about : (3,) float64 array, m
        The point a.

    Examples
    --------
    A face of 1 m2 at x = 2 m that looks against x, under 3 Pa, and its moment about y = -1 m:

    >>> one = Faces(np.array([[2.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]]))
    >>> force(one, np.array([3.0]), 1.0, np.array([0.0, -1.0, 0.0]))
    (array([3., 0., 0.]), array([ 0.,  0., -3.]))
    """
    pushes = -pressure[:, None] * area * faces.normal
    return pushes.sum(axis=0), np.cross(faces.position - about, pushes).sum(axis=0)


def patches_in(case: ResolvedCase, patches: Sequence[Patch | Band]) -> Patches:
    """Return patches in one record, in the space of a case."""
    return patches_of(patches, case.particles.spacing, case.dimension, domain(case).period)


def nearest_on(faces: Faces, place: Floats, case: ResolvedCase) -> tuple[Floats, Floats, float]:
    """Return a place moved onto the plane of the nearest face, its normal, and how far it is, m."""
    offset = faces.position - place
    across = np.abs(offset) - 0.5 * case.particles.spacing * np.sqrt(1.0 - faces.normal**2)
    nearest = int(np.argmin(np.linalg.norm(np.maximum(across, 0.0), axis=1)))
    distance = float(np.linalg.norm(np.maximum(across[nearest], 0.0)))
    normal = faces.normal[nearest]
    return place + (offset[nearest] @ normal) * normal, normal, distance


def _cells(position: Floats, d0: float, axes: int) -> tuple[Cells, NDArray[np.bool_]]:
    """Return the cells of wall particles, and which of them stand in the middle of theirs."""
    scaled = position[:, :axes] / d0
    cell = np.zeros(position.shape, dtype=np.int64)
    cell[:, :axes] = np.floor(scaled)
    follows = np.all(np.abs(scaled - cell[:, :axes] - 0.5) < LATTICE_TOLERANCE, axis=1)
    return cell, follows


def _wrapped(cell: Cells, period: Cells) -> Cells:
    return np.where(period > 0, np.mod(cell, np.maximum(period, 1)), cell)


def _in_space(case: ResolvedCase, position: Floats) -> NDArray[np.bool_]:
    """Return which points lie over the floor of the space and below the rim of its walls."""
    shape, up = case.geometry, case.dimension - 1
    x, y, level = position[:, 0], position[:, 1], position[:, up]
    inside = is_over_floor(case, x, y)
    if isinstance(shape, shapes.ChannelShape) and shape.runout_start is not None:
        inside &= height_over_floor(case, x, level, x) > 0.0
    if plain_of(shape) is not None:
        level = level - np.maximum(floor_level(case, x), 0.0)
    return np.asarray(inside & (level < shape.height))


def _near(surface: Floats, position: Floats, reach: float, period: Floats) -> Cells:
    """Return the particles in the box around a surface, which keeps the search small."""
    if len(surface) == 0:
        return np.zeros(0, dtype=np.int64)
    lower = np.where(period > 0.0, -np.inf, surface.min(axis=0) - reach)
    upper = np.where(period > 0.0, np.inf, surface.max(axis=0) + reach)
    return np.flatnonzero(np.all((position > lower) & (position < upper), axis=1))


def _tree(position: Floats, period: Floats) -> cKDTree:
    """Return a search tree; it requires coordinates from 0 to below the period."""
    wrapped = np.where(
        period > 0.0, np.mod(position, np.where(period > 0.0, period, 1.0)), position
    )
    return cKDTree(np.where((period > 0.0) & (wrapped >= period), 0.0, wrapped), boxsize=period)
