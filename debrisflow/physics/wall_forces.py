"""Forces of the fluid on walls that are surfaces, from what these push its particles by."""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.boundary import Boundary, face_at, face_count, wall_sums_at
from debrisflow.neighbors.pairs import BLOCK, to_nearest_image
from debrisflow.neighbors.patches import Patches

Floats = NDArray[np.float64]
MOST = 2.0  # own share of a face in what all walls push by
COMPONENTS = 6  # force along x, y, z and its moment about the origin of the space


@kernel
def share_in_patch(a, b, c, nx, ny, nz, k, patches):
    """Return the share of the square of wall around a foot that patch k covers, 0 to 1.

    Squares of particles on a lattice fill a wall, so that patches side by side share out the force
    on it.
    """
    frame, half, side = patches.frame, patches.half, 0.5 * patches.cell
    dx, dy, dz = a - patches.center[k, 0], b - patches.center[k, 1], c - patches.center[k, 2]
    dx, dy, dz = to_nearest_image(dx, dy, dz, patches.period)
    ux, uy, uz = frame[k, 0, 0], frame[k, 0, 1], frame[k, 0, 2]
    off = abs(dx * ux + dy * uy + dz * uz)
    if off >= half[k, 0] or nx * ux + ny * uy + nz * uz < patches.alike[k]:
        return 0.0
    share = 1.0
    for axis in range(1, 3):
        along = abs(dx * frame[k, axis, 0] + dy * frame[k, axis, 1] + dz * frame[k, axis, 2])
        reach = half[k, axis]
        covered = (min(along + side, reach) - max(along - side, -reach)) / (2.0 * side)
        share *= min(max(covered, 0.0), 1.0)
    return share


@kernel
def _add_force(i, f, x, y, z, position, solid, patches, total):
    """Add a force on a face of particle i, N, at the foot of the particle on it."""
    distance, nx, ny, nz, number = face_at(i, f, solid)
    a = position[i, 0] - distance * nx
    b = position[i, 1] - distance * ny
    c = position[i, 2] - distance * nz
    sums = total[number]
    sums[0] += x
    sums[1] += y
    sums[2] += z
    sums[3] += b * z - c * y
    sums[4] += c * x - a * z
    sums[5] += a * y - b * x
    for k in range(patches.wall.size):
        if patches.wall[k] == number:
            share = share_in_patch(a, b, c, nx, ny, nz, k, patches)
            sums = total[solid.slip.size + k]
            sums[0] += share * x
            sums[1] += share * y
            sums[2] += share * z


@kernel
def own_share(i, f, nx, ny, nz, solid):
    """Return what face f pushes particle i by, over what all walls push across that face.

    In a corner the floor ends under the particle, and what is left of it pushes toward the other
    wall: a fifth of what that wall pushes the first row by, which is missing in the sum of both.
    So much of the thrust of the fluid goes through the floor, from one end of it to the other.
    """
    _, _, gx, gy, gz, _, _, _, _, _, _ = wall_sums_at(i, solid)
    across = -(gx * nx + gy * ny + gz * nz)
    own = solid.push[solid.row[i], f]
    return min(max(own / across, 1.0), MOST) if across > 0.0 else 1.0


@kernel
def add_forces_at(i, mass, push, reaction, position, solid, patches, total):
    """Add to the forces on the walls what particle i does to its faces.

    A face takes what is along its normal, the nearest face first, of the pressure its own share;
    what it pushes by more than all walls together the others take, along themselves.  The nearest
    face takes the rest, along it.  So the forces of all walls add up to the reaction on all
    particles.
    """
    faces = face_count(i, solid)
    if faces == 0:
        return
    x, y, z = -mass * reaction[i, 0], -mass * reaction[i, 1], -mass * reaction[i, 2]
    u, v, w = -mass * push[i, 0], -mass * push[i, 1], -mass * push[i, 2]
    if faces > 1:
        for f in range(faces):
            _, nx, ny, nz, _ = face_at(i, f, solid)
            pressed = min(x * nx + y * ny + z * nz, 0.0)
            x, y, z = x - pressed * nx, y - pressed * ny, z - pressed * nz
            _add_force(
                i, f, pressed * nx, pressed * ny, pressed * nz, position, solid, patches, total
            )
            still = min(u * nx + v * ny + w * nz, 0.0)
            u, v, w = u - still * nx, v - still * ny, w - still * nz
            more = (own_share(i, f, nx, ny, nz, solid) - 1.0) * still
            _add_force(i, f, more * nx, more * ny, more * nz, position, solid, patches, total)
            more /= 1.0 - faces
            for g in range(faces):
                if g != f:
                    _add_force(
                        i, g, more * nx, more * ny, more * nz, position, solid, patches, total
                    )
    _add_force(i, 0, x, y, z, position, solid, patches, total)


@kernel
def _add_forces(first, last, volume, density, push, reaction, position, solid, patches, total):
    for i in range(first, last):
        add_forces_at(i, volume * density[i], push, reaction, position, solid, patches, total)


@loop
def wall_forces(volume, density, push, reaction, position, solid, patches, partial):
    """Write force and moment on each wall, and the force on each patch, by blocks of particles.

    Parameters
    ----------
    volume : float, m3
        Of a particle.
    density : (n,) float64 array, kg/m3
    push, reaction : (n, 3) float64 array, m/s2
        What the walls push the fluid particles by with their pressure, and all that they do.
    position : (n, 3) float64 array, m
    solid : Boundary
    patches : Patches
        As :class:`debrisflow.neighbors.patches.Patches`.
    partial : (blocks, walls + patches, 6) float64 array, N, N m
        Zeros; the force on a wall, and its moment about the origin, are the sums over the blocks;
        behind the walls come the patches, without moments.
    """
    n = density.size
    for block in prange(partial.shape[0]):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        total = partial[block]
        _add_forces(first, last, volume, density, push, reaction, position, solid, patches, total)


def room_for_forces(count: int, solid: Boundary, patches: Patches) -> Floats:
    """Return zeros, (blocks, walls + patches, 6) array, for the forces of a number of particles."""
    rows = solid.slip.size + patches.wall.size
    return np.zeros(((count + BLOCK - 1) // BLOCK, rows, COMPONENTS))
