"""What a particle sees of a wall particle: height, contact, mirrored velocity.

Letters as in :mod:`debrisflow.neighbors.pairs`.  The functions by record are those that kernels of
both dimensions call: here stand their formulas for walls of particles, in
:mod:`debrisflow.neighbors.boundary` those for surfaces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel
from debrisflow.dispatch import by_record
from debrisflow.neighbors.pairs import (
    coupling_weight,
    higher_order_weight,
    inverse_distance,
    separation,
    weight,
)

Floats = NDArray[np.float64]
EDGE = 0.9  # greatest component of a unit normal at an edge of two axis-parallel faces


class Solid(NamedTuple):
    """What is known of the wall particles.

    Attributes
    ----------
    position, normal : (m, 3) float64 array, m
        The normal points out of the wall.
    depth : (m,) float64 array, m
        Distance to the wall's surface.
    slip : (m,) float64 array
        1 where the wall is free-slip, 0 where it is no-slip.
    roughness : (m,) float64 array, m
        Equivalent sand roughness; 0 where the law of the wall does not act.
    velocity : (m, 3) float64 array, m/s, or None
        None where no wall moves.
    contact_height : (m,) float64 array, m
        Height over the surface below which contacts are looked for; -inf under the first layer.
    """

    position: Floats
    normal: Floats
    depth: Floats
    slip: Floats
    roughness: Floats
    velocity: Floats | None
    contact_height: Floats


@kernel
def first_of(i, start):
    """Return ``start[i]``, 0 if there is no array of starts."""
    return 0 if start is None else start[i]


@kernel
def wall_pair(i, k, near, solid):
    """Return the number j of wall neighbor k of particle i, ``r_ij``, m, and ``1 / r``."""
    place = first_of(i, near.wall_start) + k
    j = np.uint32(near.wall[near.wall_row[i], place] - near.wall_from)
    dx, dy, dz = separation(i, j, near.position, solid.position, near.period)
    return j, dx, dy, dz, inverse_distance(dx, dy, dz, near)


@kernel
def height_over(dx, dy, dz, j, solid):
    """Return the height over the surface at wall particle j, m, from the separation to it."""
    normal = solid.normal
    return -(dx * normal[j, 0] + dy * normal[j, 1] + dz * normal[j, 2]) - solid.depth[j]


@kernel
def across_wall(dx, dy, dz, j, solid):
    """Return a separation from wall particle j; from one that is free-slip the part across it."""
    normal, slip = solid.normal, solid.slip[j]
    across = slip * (dx * normal[j, 0] + dy * normal[j, 1] + dz * normal[j, 2])
    along = 1.0 - slip
    return (
        along * dx + across * normal[j, 0],
        along * dy + across * normal[j, 1],
        along * dz + across * normal[j, 2],
    )


@kernel
def wall_factor(height, j, solid, near):
    """Return ``1 + s / h``, by how much a velocity difference to wall particle j is mirrored.

    s is its depth under the surface, h the height over it, not taken below d0/2, its value in the
    first row of the lattice.
    """
    return 1.0 + solid.depth[j] / max(height, 0.5 * near.spacing)


@kernel
def velocity_of(j, velocity):
    """Return the velocity of wall particle j, m/s; 0 if there is no array of velocities."""
    if velocity is None:
        return 0.0, 0.0, 0.0
    else:
        return velocity[j, 0], velocity[j, 1], velocity[j, 2]


@kernel
def wall_velocity_difference(u, v, w, height, j, solid, near):
    """Return ``u_j - u_i``, m/s, where a wall particle keeps its surface at the wall's velocity.

    A wall particle at depth ``s`` under its surface takes the velocity on the line through
    ``u_i`` at the height ``h`` of particle i and the wall's velocity at the surface, so that

        u_j - u_i = -(1 + s / h) (u_i - u_wall)

    which makes a linear profile exact; along a free-slip wall the tangential part is 0.

    References
    ----------
    Morris, Fox & Zhu 1997, doi:10.1006/jcph.1997.5776.
    """
    wall_u, wall_v, wall_w = velocity_of(j, solid.velocity)
    nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
    factor = wall_factor(height, j, solid, near)
    return mirrored(wall_u - u, wall_v - v, wall_w - w, nx, ny, nz, factor, solid.slip[j])


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
def contact(dx, dy, dz, j, solid, near):
    """Return height over and normal of the surface that first-layer wall particle j stands for.

    Infinite if the surface is not below.
    """
    nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
    return face_towards(dx, dy, dz, nx, ny, nz, near.spacing)


@by_record
def wall_density_at(i, near, solid):
    """Return what the walls of particle i add to n, and to the sum of ``w r_ij / r``."""
    n, x, y, z = 0.0, 0.0, 0.0, 0.0
    for k in range(near.wall_count[i]):
        _, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        w = weight(inverse, near)
        n += w
        x, y, z = x + w * inverse * dx, y + w * inverse * dy, z + w * inverse * dz
    return n, x, y, z


@by_record
def wall_source_at(i, u, v, w, fall, near, solid):
    """Return what the walls of particle i add to the sums of the pressure equation.

    To n; to the sum of ``w r_ij / r``; to the divergence, 1/s, of a velocity u, v, w of particle
    i; and to the vectors a and b, see :func:`debrisflow.physics.pressure.source_sums_at`.
    ``fall``, m/s, is what gravity adds to the velocity in a step.
    """
    n, divergence = 0.0, 0.0
    x, y, z, ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        weighed, q = weight(inverse, near), higher_order_weight(inverse, near)
        along, f = weighed * inverse, weighed * inverse * inverse
        wall_u, wall_v, wall_w = velocity_of(j, solid.velocity)
        n += weighed
        divergence += q * (dx * (wall_u - u) + dy * (wall_v - v) + dz * (wall_w - w))
        x, y, z = x + along * dx, y + along * dy, z + along * dz
        ax, ay, az = ax + f * dx, ay + f * dy, az + f * dz
        bx, by, bz = bx + q * dx, by + q * dy, bz + q * dz
    return n, x, y, z, divergence, ax, ay, az, bx, by, bz


@by_record
def own_velocity(i, velocity, near, solid):
    """Return the velocity of particle i, m/s; of a wall that has a row, that of the wall."""
    if i < near.wall_from:
        return velocity[i, 0], velocity[i, 1], velocity[i, 2]
    else:
        return velocity_of(i - near.wall_from, solid.velocity)


@by_record
def pressed_count(i, near, solid):
    """Return how many neighbors of particle i are walls that carry a pressure."""
    return near.pressed_count[i]


@by_record
def pressed_pair(i, k, near, solid):
    """Return the row of the k-th of these and ``1 / r``, 1/m."""
    j, _, _, _, inverse = wall_pair(i, k, near, solid)
    return near.wall_from + j, inverse


@kernel
def _pull_at(i, velocity, released, near, solid):
    """Return the sum of ``(u_j - u_i) w`` over walls; free-slip ones are left out by a share."""
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        height = height_over(dx, dy, dz, j, solid)
        du, dv, dw = wall_velocity_difference(u, v, w, height, j, solid, near)
        f = weight(inverse, near) * (1.0 - released * solid.slip[j])
        x, y, z = x + f * du, y + f * dv, z + f * dw
    return x, y, z


@by_record
def viscous_pull_at(i, velocity, near, solid):
    """Return the sum of ``(u_j - u_i) w`` over the walls of particle i, m/s."""
    return _pull_at(i, velocity, 0.0, near, solid)


@by_record
def grain_pull_at(i, velocity, near, solid):
    """Return the sum of ``(u_j - u_i) w`` over the no-slip walls of particle i, m/s."""
    return _pull_at(i, velocity, 1.0, near, solid)


@by_record
def stick_count(i, near, solid):
    """Return at how many places walls may hold particle i by viscosity."""
    return near.wall_count[i]


@by_record
def stick_at(i, k, near, solid):
    """Return how a wall holds particle i by viscosity at one of its places.

    That is the sum of ``(2 Ds/n0) (w/r^2) (1 + s/h)``, 1/m2, 0 where it is free-slip; height over
    and normal of the surface, m; the separation, m, half of which leads to where the strength is
    asked for; the roughness, m; and the velocity of the wall, m/s.
    """
    j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
    height = height_over(dx, dy, dz, j, solid)
    pull = coupling_weight(inverse, near) * wall_factor(height, j, solid, near)
    u, v, w = velocity_of(j, solid.velocity)
    return (
        pull * (1.0 - solid.slip[j]),
        max(height, 0.5 * near.spacing),
        solid.normal[j, 0],
        solid.normal[j, 1],
        solid.normal[j, 2],
        dx,
        dy,
        dz,
        solid.roughness[j],
        u,
        v,
        w,
    )


@by_record
def wall_moments_at(i, velocity, near, solid):
    """Return the moments of the velocity gradient over the walls of particle i.

    ``M`` as (xx, xy, yy, xz, yz, zz) and ``B`` by rows, see
    :func:`debrisflow.physics.operators.fluid_moments_at`.
    """
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
        f = weight(inverse, near) * inverse * inverse
        height = height_over(dx, dy, dz, j, solid)
        du, dv, dw = wall_velocity_difference(u, v, w, height, j, solid, near)
        dx, dy, dz = across_wall(dx, dy, dz, j, solid)
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    return xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz


@by_record
def free_slip_face_at(i, near, solid):
    """Return normal and height, m, of the nearest free-slip surface, r_e where there is none.

    Only a surface that the particle stands over counts, none beyond its end.
    """
    nx, ny, nz, nearest = 0.0, 0.0, 0.0, near.effective_radius
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, _ = wall_pair(i, k, near, solid)
        if solid.slip[j] == 0.0:
            continue
        height, ax, ay, az = contact(dx, dy, dz, j, solid, near)
        if height < nearest:
            nx, ny, nz, nearest = ax, ay, az, max(height, 0.0)
    return nx, ny, nz, nearest
