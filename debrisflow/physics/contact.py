"""Contact: particles that come too close to each other or to a wall collide."""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.boundary import face_at, face_count, rebounded, velocity_beside
from debrisflow.neighbors.pairs import BLOCK, fluid_pair
from debrisflow.neighbors.wall_access import contact, height_over, velocity_of, wall_pair


@kernel
def impulse_share(rho_i, rho_j, j, near):
    """Return ``rho_j / (rho_i + rho_j)``, the share of the other mass; 1 beside waiting supply.

    Supply moves at a given velocity whatever it meets, and so has infinite mass.
    """
    return rho_j / (rho_i + rho_j) if j < near.supply_from else 1.0


@kernel
def impulse(along, inverse, share, distance):
    """Return the factor of ``r_ij`` in the change of velocity by a collision without rebound, 1/s.

    ``along = u_ij . r_ij``; 0 where the two are farther apart than the distance or part.  Both
    sides of a pair take it from the same velocities, so that momentum is conserved.
    """
    hit = min(along, 0.0) * inverse * inverse * share
    return hit if inverse * distance > 1.0 else 0.0


@kernel
def hit_between(along, inverse, rho_i, rho_j, j, distance, near):
    """Return :func:`impulse` of a pair, 0 where particles do not collide: the distance is None."""
    if distance is None:
        return 0.0
    return impulse(along, inverse, impulse_share(rho_i, rho_j, j, near), distance)


@kernel
def collisions_at(i, velocity, density, distance, near):
    """Return the change of velocity of particle i by its collisions without rebound, m/s."""
    u, v, w, rho = velocity[i, 0], velocity[i, 1], velocity[i, 2], density[i]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        along = (velocity[j, 0] - u) * dx + (velocity[j, 1] - v) * dy + (velocity[j, 2] - w) * dz
        f = impulse(along, inverse, impulse_share(rho, density[j], j, near), distance)
        x, y, z = x + f * dx, y + f * dy, z + f * dz
    return x, y, z


@kernel
def touches_wall_at(i, near, solid):
    """Return how many first-layer wall particles particle i may touch."""
    touched = 0.0
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, _ = wall_pair(i, k, near, solid)
        touched += 1.0 if height_over(dx, dy, dz, j, solid) < solid.contact_height[j] else 0.0
    return touched


@kernel
def bounce_at(i, u, v, w, distance, restitution, near, solid):
    """Return a velocity of particle i after it bounced off the walls that it touches.

    A wall acts as the plane of its surface: a particle nearer to it than ``distance - d0/2`` that
    approaches bounces along the normal and slides freely.
    """
    reach = distance - 0.5 * near.spacing
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, _ = wall_pair(i, k, near, solid)
        if solid.contact_height[j] == -np.inf:
            continue
        height, nx, ny, nz = contact(dx, dy, dz, j, solid, near)
        if height >= reach:
            continue
        wall_u, wall_v, wall_w = velocity_of(j, solid.velocity)
        approach = (wall_u - u) * nx + (wall_v - v) * ny + (wall_w - w) * nz
        if approach > 0.0:
            u += (1.0 + restitution) * approach * nx
            v += (1.0 + restitution) * approach * ny
            w += (1.0 + restitution) * approach * nz
    return u, v, w


@kernel
def _collide(first, last, velocity, density, distance, restitution, near, solid, collided):
    for i in range(first, last):
        x, y, z = collisions_at(i, velocity, density, distance, near)
        u = velocity[i, 0] + (1.0 + restitution) * x
        v = velocity[i, 1] + (1.0 + restitution) * y
        w = velocity[i, 2] + (1.0 + restitution) * z
        if touches_wall_at(i, near, solid) > 0.0:
            u, v, w = bounce_at(i, u, v, w, distance, restitution, near, solid)
        collided[i, 0], collided[i, 1], collided[i, 2] = u, v, w


@loop
def collide(velocity, density, distance, restitution, near, solid, collided):
    """Write the velocities of the fluid particles after their collisions, (n, 3) array, m/s.

    Two particles nearer than ``distance``, m, that approach exchange the impulse of a collision
    with the given restitution.  Without collisions a dam break blows up.
    """
    n = collided.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _collide(first, last, velocity, density, distance, restitution, near, solid, collided)


@kernel
def _bounce_off_walls(first, last, reach, restitution, solid, velocity):
    for i in range(first, last):
        if face_count(i, solid) > 0:
            u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
            u, v, w = rebounded(i, u, v, w, reach, restitution, solid)
            velocity[i, 0], velocity[i, 1], velocity[i, 2] = u, v, w


@loop
def bounce_off_walls(reach, restitution, solid, velocity):
    """Let all fluid particles bounce off the surfaces that they are nearer to than ``reach``, m."""
    n = velocity.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _bounce_off_walls(first, last, reach, restitution, solid, velocity)


@kernel
def held_off_at(i, u, v, w, reach, sliding, effective, solid):
    """Return a velocity of particle i, m/s, without what leads into faces nearer than ``reach``, m.

    What a face takes presses on it, and slows the particle along it by the coefficient of friction
    of its wall, ``sliding``, (walls,) array, times the share that grains bear, ``effective``, (n,)
    array or None for all of it.
    """
    share = 1.0 if effective is None else effective[i]
    for f in range(face_count(i, solid)):
        distance, nx, ny, nz, number = face_at(i, f, solid)
        du, dv, dw = velocity_beside(u, v, w, i, f, solid)
        approach = -(du * nx + dv * ny + dw * nz)
        if distance >= reach or approach <= 0.0:
            continue
        u, v, w = u + approach * nx, v + approach * ny, w + approach * nz
        du, dv, dw = velocity_beside(u, v, w, i, f, solid)
        speed = np.sqrt(du * du + dv * dv + dw * dw)
        lost = min(share * sliding[number] * approach / max(speed, 1e-300), 1.0)
        u, v, w = u - lost * du, v - lost * dv, w - lost * dw
    return u, v, w


@kernel
def _hold_off_walls(first, last, reach, sliding, effective, solid, velocity):
    for i in range(first, last):
        u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        u, v, w = held_off_at(i, u, v, w, reach, sliding, effective, solid)
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = u, v, w


@loop
def hold_off_walls(reach, sliding, effective, solid, velocity):
    """Take from the velocity of all fluid particles what leads into walls that they touch.

    After the exchange of momentum, whose other forces know no contact: without it deposits sink
    into the floor, from 0.30 to 0.08 d0 in 60 s.
    """
    n = velocity.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _hold_off_walls(first, last, reach, sliding, effective, solid, velocity)
