"""Patches of walls, whose share in the forces on walls each step finds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Patches(NamedTuple):
    """Rectangles on walls along the axes.

    Attributes
    ----------
    wall : (n,) int64 array
        Number of the wall or obstacle.
    center, normal : (n, 3) float64 array, m, -
        Middle, and unit normal out of the wall.
    half : (n, 3) float64 array, m
        Half of the extent along each axis; infinite along an axis that the space lacks; along the
        normal how far off the plane of the patch a place may be.
    cell : (n, 3) float64 array, m
        Extent along each axis of the square of wall that a particle presses on; 0 along the normal.
    """

    wall: NDArray[np.int64]
    center: Floats
    normal: Floats
    half: Floats
    cell: Floats


def join(patches: Sequence[Patches]) -> Patches:
    """Return all patches in one record."""
    if not patches:
        return Patches(np.zeros(0, dtype=np.int64), *np.zeros((4, 0, 3)))
    return Patches(*(np.concatenate(parts) for parts in zip(*patches, strict=True)))
