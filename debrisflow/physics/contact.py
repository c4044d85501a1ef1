"""Contact: particles that come too close to each other or to a wall collide."""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.wall_access import contact

CONTACT_REACH = 1.5  # spacings within which a wall particle can be touched


@kernel
def collide_at(i, fluid_count, velocity, density, walls, distance, restitution, stencil):
    """Return the velocity of particle i after its collisions.

    Two particles nearer than ``distance`` that approach each other exchange the impulse of a
    collision with the given restitution, evaluated from the same velocities for both, so that
    momentum is conserved; inflow particles have infinite mass.  A wall acts as the plane of its
    surface: a particle nearer to it than ``distance - d0/2`` bounces along the normal with the
    same restitution and slides freely.  Without collisions a dam break blows up.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    u0, v0, w0 = u, v, w
    d0 = stencil.spacing
    near_wall = False
    for k in range(stencil.neighbor_count[i]):
        inverse = stencil.inverse[i, k]
        if inverse * CONTACT_REACH * d0 < 1.0:
            continue
        j = stencil.neighbors[i, k]
        near_wall = near_wall or j >= stencil.wall_from
        if inverse * distance <= 1.0 or j >= stencil.wall_from:
            continue
        dx, dy, dz = stencil.dx[i, k], stencil.dy[i, k], stencil.dz[i, k]
        approach = (
            (u0 - velocity[j, 0]) * dx + (v0 - velocity[j, 1]) * dy + (w0 - velocity[j, 2]) * dz
        )
        if approach > 0.0:
            share = density[j] / (density[i] + density[j]) if j < fluid_count else 1.0
            impulse = (1.0 + restitution) * share * approach * inverse * inverse
            u -= impulse * dx
            v -= impulse * dy
            w -= impulse * dz
    if not near_wall:
        return u, v, w
    for k in range(stencil.neighbor_count[i]):
        height, nx, ny, nz = contact(i, k, walls, stencil)
        if height >= distance - 0.5 * d0:
            continue
        j = stencil.neighbors[i, k]
        approach = (velocity[j, 0] - u) * nx + (velocity[j, 1] - v) * ny + (velocity[j, 2] - w) * nz
        if approach > 0.0:
            u += (1.0 + restitution) * approach * nx
            v += (1.0 + restitution) * approach * ny
            w += (1.0 + restitution) * approach * nz
    return u, v, w


@loop
def collide(fluid_count, velocity, density, walls, distance, restitution, stencil, collided):
    """Write the velocities of the fluid particles after their collisions."""
    for i in prange(fluid_count):
        collided[i, 0], collided[i, 1], collided[i, 2] = collide_at(
            i, fluid_count, velocity, density, walls, distance, restitution, stencil
        )
