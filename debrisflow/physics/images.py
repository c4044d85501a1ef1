"""Images of a fluid behind free-slip walls, by which what moves along one shears as inside.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, coupling_weight
from debrisflow.neighbors.wall_access import free_slip_face_at

Floats = NDArray[np.float64]
ALIKE = 0.9  # cosine between the normals of surfaces that are taken for one plane


class Mirrors(NamedTuple):
    """The free-slip wall that each particle is nearest to.

    Attributes
    ----------
    normal : (n, 3) float64 array
        Out of the wall; 0 where none is in reach.
    height : (n,) float64 array, m
        Over its surface; the influence radius where none is in reach.
    """

    normal: Floats
    height: Floats


def no_mirrors(count: int) -> Mirrors:
    """Return room for the mirrors of particles."""
    return Mirrors(np.zeros((count, 3)), np.zeros(count))


@kernel
def _find_mirrors(first, last, near, solid, mirrors):
    for i in range(first, last):
        nx, ny, nz, height = free_slip_face_at(i, near, solid)
        mirrors.normal[i, 0] = nx
        mirrors.normal[i, 1] = ny
        mirrors.normal[i, 2] = nz
        mirrors.height[i] = height


@loop
def find_mirrors(near, solid, mirrors):
    """Write the mirrors of all particles."""
    n = mirrors.height.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _find_mirrors(first, last, near, solid, mirrors)


@kernel
def image_weight(i, j, dx, dy, dz, mirrors, near):
    """Return the coupling weight of the image of one of two particles with the other, 1/m2.

    For two that are nearest to the same plane, h over it: the image is ``sqrt(r^2 + 4 h_i h_j)``
    away and moves along the wall as the particle does.  That it moves across it the other way is
    left out, and so are images in a second wall.  Without images a layer along a wall would resist
    a quarter less than it should.
    """
    normal, height = mirrors.normal, mirrors.height
    alike = normal[i, 0] * normal[j, 0] + normal[i, 1] * normal[j, 1] + normal[i, 2] * normal[j, 2]
    if alike < ALIKE:
        return 0.0
    r2 = dx * dx + dy * dy + dz * dz + 4.0 * height[i] * height[j]
    return coupling_weight(1.0 / np.sqrt(max(r2, 1e-12 * near.spacing**2)), near)
