"""The pressure of walls that are surfaces on the particles before them.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel
from debrisflow.neighbors.boundary import (
    face_at,
    face_count,
    velocity_of_face,
    wall_sums_at,
)
from debrisflow.neighbors.pairs import fluid_pair, gradient_factor, weight
from debrisflow.physics.operators import cofactors

LEAST_MOMENT = 0.04
"""Share of the moments of a whole neighborhood that is added to them, so that a lone particle has
no gradient of the pressure along a wall."""
STIFF_ACROSS = 1.3
"""The same, by which the gradient across a face is held to what stops the fluid there."""


@kernel
def gradient_in_walls_at(i, pressure, rho, gravity, ax, ay, az, rate, near, solid):
    """Return the pressure gradient in the wall that particle i stands in front of, Pa/m.

    Across each face it is what holds up the fluid there: ``rho g . n`` of fluid at rest, or, where
    it approaches faster, ``rho (a - u_wall rate) . n``: a, m/s2, stops it within a time of which
    ``rate`` is the inverse, before walls that do not move.  Along the faces it is that of the fluid
    before them, by least squares over its neighbors.  With the whole of gravity in the wall thin
    fronts are held back; with nothing along it a still tank runs at 0.2 m/s, since a fourth of what
    surrounds a particle at a vertical wall is missing.
    """
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, own = 0.0, 0.0, 0.0, pressure[i]
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        f = weight(inverse, near) * inverse * inverse
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        f *= pressure[j] - own
        x, y, z = x + f * dx, y + f * dy, z + f * dz
    third = near.number_density / near.dimension
    xx, yy, zz = xx + LEAST_MOMENT * third, yy + LEAST_MOMENT * third, zz + LEAST_MOMENT * third
    for k in range(face_count(i, solid)):
        _, nx, ny, nz, _ = face_at(i, k, solid)
        wall_u, wall_v, wall_w = velocity_of_face(i, k, solid)
        across = STIFF_ACROSS * third
        xx, xy, yy = xx + across * nx * nx, xy + across * nx * ny, yy + across * ny * ny
        xz, yz, zz = xz + across * nx * nz, yz + across * ny * nz, zz + across * nz * nz
        still = gravity[0] * nx + gravity[1] * ny + gravity[2] * nz
        moves = rate * (wall_u * nx + wall_v * ny + wall_w * nz)
        falls = across * rho * min(still, ax * nx + ay * ny + az * nz - moves)
        x, y, z = x + falls * nx, y + falls * ny, z + falls * nz
    a, b, c, d, e, f, determinant = cofactors(xx, xy, yy, xz, yz, zz)
    q = 1.0 / determinant
    return q * (a * x + b * y + d * z), q * (b * x + c * y + e * z), q * (d * x + e * y + f * z)


@kernel
def wall_push_at(i, pressure, rho, gravity, ax, ay, az, rate, near, solid):
    """Return the force of the walls on particle i by their pressure, N/m3.

        -(Ds/n0) [2 p_i G + T . (grad p)_wall]

    the sum form with the pressure ``p_i + (grad p)_wall . r`` at a place r in the wall.  A wall
    does not pull: it pushes no less than with p_i alone, which is not negative.
    """
    _, _, gx, gy, gz, xx, yy, zz, xy, xz, yz = wall_sums_at(i, solid)
    size = np.sqrt(gx * gx + gy * gy + gz * gz)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    p = pressure[i]
    bx, by, bz = gradient_in_walls_at(i, pressure, rho, gravity, ax, ay, az, rate, near, solid)
    x = 2.0 * p * gx + xx * bx + xy * by + xz * bz
    y = 2.0 * p * gy + xy * bx + yy * by + yz * bz
    z = 2.0 * p * gz + xz * bx + yz * by + zz * bz
    missing = max(p * size - (x * gx + y * gy + z * gz) / size, 0.0) / size
    push = -gradient_factor(near)
    return push * (x + missing * gx), push * (y + missing * gy), push * (z + missing * gz)
