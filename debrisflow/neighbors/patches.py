"""Patches of walls: squares whose share in the forces on walls each step finds.

A particle presses on the square of wall, d0 wide, around its foot, and so does a face of a wall as
its cells draw it; a patch takes the share of each square that it covers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
ALIKE = 0.7
"""Least cosine between the normals of a patch and of what belongs to it: on the slopes of a floor
that bends, but not on the next side of a box."""


class Patch(NamedTuple):
    """A square patch on a wall.

    Attributes
    ----------
    wall : int
        Number of the wall or obstacle.
    center, normal : (3,) float64 array, m, -
        Middle, and unit normal out of the wall.
    size : float, m
        Side of the square; in two dimensions the width of the strip.
    """

    wall: int
    center: Floats
    normal: Floats
    size: float


class Band(NamedTuple):
    """What of a wall lies between two levels, whichever way it looks.

    Attributes
    ----------
    wall : int
        Number of the wall or obstacle.
    lower, upper : float, m
    """

    wall: int
    lower: float
    upper: float


class Patches(NamedTuple):
    """Patches as kernels read them.

    Attributes
    ----------
    wall : (n,) int64 array
    center : (n, 3) float64 array, m
    frame : (n, 3, 3) float64 array
        Normal and two tangents.
    half : (n, 3) float64 array, m
        Half of the extent along each of these; infinite along an axis that the space lacks.
    period : (2, 3) float64 array, m, 1/m
        Period along each axis and its inverse, 0 where there is none.
    cell : float, m
        Side of the square of a particle.
    alike : (n,) float64 array
        Least cosine between the normals of a patch and of what belongs to it.
    """

    wall: NDArray[np.int64]
    center: Floats
    frame: Floats
    half: Floats
    period: Floats
    cell: float
    alike: Floats


def patches_of(
    patches: Sequence[Patch | Band], spacing: float, dimension: int, period: Floats
) -> Patches:
    """Return patches in one record; the spacing d0 and the period in m."""
    bands = np.array([isinstance(patch, Band) for patch in patches], dtype=bool)
    squares = [patch if isinstance(patch, Patch) else _square_of(patch) for patch in patches]
    normal = np.array([patch.normal for patch in squares]).reshape(-1, 3)
    half = np.array([0.5 * patch.size for patch in squares])[:, None].repeat(3, axis=1)
    half[:, 0] = 0.5 * spacing * (1.0 + 1e-6)  # rounding
    half[:, dimension:] = np.inf
    frame = _frames(normal, dimension)
    frame[bands] = np.eye(3)
    half[bands, :2] = np.inf
    return Patches(
        np.array([patch.wall for patch in squares], dtype=np.int64),
        np.array([patch.center for patch in squares]).reshape(-1, 3),
        frame,
        half,
        np.stack([period, np.divide(1.0, period, out=np.zeros(3), where=period > 0.0)]),
        spacing,
        np.where(bands, -2.0, ALIKE),
    )


def _square_of(band: Band) -> Patch:
    """Return a patch as high as a band, in the middle of it."""
    center = np.array([0.0, 0.0, 0.5 * (band.lower + band.upper)])
    return Patch(band.wall, center, np.array([1.0, 0.0, 0.0]), band.upper - band.lower)


def no_patches() -> Patches:
    """Return a record without patches."""
    return patches_of([], 1.0, 3, np.zeros(3))


def shares(k: int, patches: Patches, position: Floats, normal: Floats) -> Floats:
    """Return the share of the squares of wall around places that patch k covers, 0 to 1.

    As :func:`debrisflow.physics.wall_forces.share_in_patch`, for many places.

    Parameters
    ----------
    k : int
    patches : Patches
    position, normal : (m, 3) float64 array, m, -
        Of places on the same wall.

    Returns
    -------
    (m,) float64 array
    """
    offset = position - patches.center[k]
    offset -= patches.period[0] * np.rint(offset * patches.period[1])
    along, half, side = np.abs(offset @ patches.frame[k].T), patches.half[k], 0.5 * patches.cell
    covered = np.minimum(along + side, half) - np.maximum(along - side, -half)
    share = np.clip(covered[:, 1:] / (2.0 * side), 0.0, 1.0).prod(axis=1)
    is_on = (along[:, 0] < half[0]) & (normal @ patches.frame[k, 0] >= patches.alike[k])
    return np.where(is_on, share, 0.0)


def _frames(normal: Floats, dimension: int) -> Floats:
    """Return normals, each with two tangents; the second is the axis that the space lacks."""
    least = np.abs(normal).argmin(axis=1) if dimension == 3 else np.full(len(normal), 2)
    across = np.eye(3)[least] - normal * np.take_along_axis(normal, least[:, None], axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([normal, np.cross(across, normal), across], axis=1)
