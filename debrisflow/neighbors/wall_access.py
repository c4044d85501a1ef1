"""What a fluid particle sees of a wall particle: height, contact, mirrored velocity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel

Floats = NDArray[np.float64]

EDGE = 0.9  # greatest component of a unit normal at an edge of two axis-parallel faces


class WallSurface(NamedTuple):
    """What viscous terms need to know of walls; rows of other particles hold zeros.

    Attributes
    ----------
    normal : (n, 3) float64 array
        Unit normal out of the wall.
    depth : (n,) float64 array, m
        Distance of the wall particle to the surface.
    slip : (n,) float64 array
        1 where the wall is free-slip, 0 where it is no-slip.
    roughness : (n,) float64 array, m
        Equivalent sand roughness; 0 where the law of the wall does not act.
    """

    normal: Floats
    depth: Floats
    slip: Floats
    roughness: Floats


@kernel
def velocity_difference(i, k, velocity, walls, stencil):
    """Return ``u_j - u_i``, where a wall particle has the velocity that keeps its surface still.

    A wall particle at depth ``s`` under its surface takes the velocity on the line through
    ``u_i`` at the height ``h`` of particle i and the wall's velocity at the surface, so that

        u_j - u_i = -(1 + s / h) (u_i - u_wall)

    which makes a linear profile exact; along a free-slip wall the tangential part is 0.  ``h`` is
    not taken below d0/2, its value on the lattice.

    References
    ----------
    Morris, Fox & Zhu 1997, doi:10.1006/jcph.1997.5776.
    """
    j = stencil.neighbors[i, k]
    du = velocity[j, 0] - velocity[i, 0]
    dv = velocity[j, 1] - velocity[i, 1]
    dw = velocity[j, 2] - velocity[i, 2]
    if j < stencil.wall_from:
        # returned from here, the loop over fluid neighbors is ten times faster
        return du, dv, dw
    nx, ny, nz = walls.normal[j, 0], walls.normal[j, 1], walls.normal[j, 2]
    factor = 1.0 + walls.depth[j] / wall_distance(i, k, walls, stencil)
    return mirrored(du, dv, dw, nx, ny, nz, factor, walls.slip[j])


@kernel
def mirrored(du, dv, dw, nx, ny, nz, factor, slip):
    """Return a velocity difference times a factor; of the part along a free-slip wall nothing.

    Examples
    --------
    >>> mirrored(1.0, 2.0, 0.0, 0.0, 1.0, 0.0, 1.5, 1.0)
    (0.0, 3.0, 0.0)
    """
    normal = du * nx + dv * ny + dw * nz
    stick = 1.0 - slip
    return (
        factor * (normal * nx + stick * (du - normal * nx)),
        factor * (normal * ny + stick * (dv - normal * ny)),
        factor * (normal * nz + stick * (dw - normal * nz)),
    )


@kernel
def height_over(i, k, walls, stencil):
    """Return the height of particle i over the surface of the wall of neighbor k, m."""
    j = stencil.neighbors[i, k]
    below = (
        stencil.dx[i, k] * walls.normal[j, 0]
        + stencil.dy[i, k] * walls.normal[j, 1]
        + stencil.dz[i, k] * walls.normal[j, 2]
    )
    return -below - walls.depth[j]


@kernel
def contact(i, k, walls, stencil):
    """Return height over and normal of the wall face that neighbor k shows to particle i.

    Infinite if the neighbor is no wall or lies deeper than the first layer, and where
    :func:`face_towards` is.
    """
    j = stencil.neighbors[i, k]
    d0 = stencil.spacing
    if j < stencil.wall_from or walls.depth[j] > 0.75 * d0:
        return np.inf, 0.0, 0.0, 0.0
    return face_towards(
        stencil.dx[i, k],
        stencil.dy[i, k],
        stencil.dz[i, k],
        walls.normal[j, 0],
        walls.normal[j, 1],
        walls.normal[j, 2],
        d0,
    )


@kernel
def face_towards(dx, dy, dz, nx, ny, nz, d0):
    """Return height over and normal of the face of a first-layer wall particle at a separation.

    Infinite if the wall particle is not under the particle that looks at it: it answers for the d0
    of surface in front of it, in three dimensions for its square, so that no corner between four
    wall particles is open.  At an edge of two axis-parallel faces its normal (nx, ny, nz) halves
    their angle, and the face that looks at the particle counts.

    Examples
    --------
    >>> face_towards(0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    (0.5, 0.0, 1.0, 0.0)
    """
    if max(abs(nx), abs(ny), abs(nz)) < EDGE:
        ax, ay, az = abs(dx), abs(dy), abs(dz)
        nx = -np.sign(dx) if ax >= ay and ax >= az else 0.0
        ny = -np.sign(dy) if ay > ax and ay >= az else 0.0
        nz = -np.sign(dz) if az > ax and az > ay else 0.0
    above = -(dx * nx + dy * ny + dz * nz)
    aside = max(abs(dx + above * nx), abs(dy + above * ny), abs(dz + above * nz))
    if above <= 0.0 or aside > 0.5001 * d0:
        return np.inf, 0.0, 0.0, 0.0
    return above - 0.5 * d0, nx, ny, nz


@kernel
def wall_distance(i, k, walls, stencil):
    """Return the height over the wall, not below d0/2, the height of the first row, m."""
    return max(height_over(i, k, walls, stencil), 0.5 * stencil.spacing)
