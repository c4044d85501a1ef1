"""Friction of rough walls by the law of the wall."""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK
from debrisflow.neighbors.wall_access import contact, velocity_of, wall_pair
from debrisflow.physics.turbulence import wall_friction


@kernel
def slowed_at(i, dt, velocity, near, solid):
    """Return the velocity of particle i slowed by the rough walls that it touches.

    In the layer next to a wall the stress ``rho f |u| u`` of the law of the wall, spread over one
    spacing, acts on the part of the velocity along the wall; implicit, so that it never reverses.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    nearest, touched = near.spacing, -1
    nx, ny, nz = 0.0, 0.0, 0.0
    for k in range(near.wall_count[i]):
        j, dx, dy, dz, _ = wall_pair(i, k, near, solid)
        if solid.contact_height[j] == -np.inf or solid.roughness[j] == 0.0:
            continue
        height, ax, ay, az = contact(dx, dy, dz, j, solid, near)
        if height < nearest:
            nearest, touched = height, j
            nx, ny, nz = ax, ay, az
    if touched >= 0:
        wall_u, wall_v, wall_w = velocity_of(touched, solid.velocity)
        du, dv, dw = u - wall_u, v - wall_v, w - wall_w
        normal = du * nx + dv * ny + dw * nz
        du, dv, dw = du - normal * nx, dv - normal * ny, dw - normal * nz
        speed = np.sqrt(du * du + dv * dv + dw * dw)
        f = wall_friction(max(nearest, 0.5 * near.spacing), solid.roughness[touched])
        kept = 1.0 / (1.0 + dt * f * speed / near.spacing)
        u -= (1.0 - kept) * du
        v -= (1.0 - kept) * dv
        w -= (1.0 - kept) * dw
    return u, v, w


@kernel
def _slow(first, last, dt, velocity, near, solid, slowed):
    for i in range(first, last):
        slowed[i, 0], slowed[i, 1], slowed[i, 2] = slowed_at(i, dt, velocity, near, solid)


@loop
def slow_along_walls(dt, velocity, near, solid, slowed):
    """Write the velocities of the fluid particles after the friction of rough walls, m/s."""
    n = slowed.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _slow(first, last, dt, velocity, near, solid, slowed)
