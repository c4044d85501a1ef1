"""By how much a particle before a wall bears more or less of the drag than on the lattice.

The drag of a wall on the rows of a lattice before it, each by its part of G, adds up to the stress
on the wall.  Rows that have sunk, or that the flow has drawn apart, bear more or less than that:
0.86 to 1.06 of it in deposits of a slurry.  So the parts are measured over the column of fluid
around a particle, and made to add up.

Letters as in :mod:`debrisflow.neighbors.pairs`.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.beyond import push_beyond, seen_distance
from debrisflow.neighbors.boundary import beyond_of, face_at, face_count
from debrisflow.neighbors.pairs import BLOCK, fluid_pair

ALIKE = 0.9  # cosine between the normals of faces that are taken for one plane
BESIDE = 0.5  # cosine between the normals of faces below which one stands beside the other
RIM = 0.2909
"""How far from the middle of a column, over its radius, the center of half of it lies, each place
weighed by ``(1 - t^2)^2``: 16/35 / (pi/2)."""
SCATTER = 0.15
"""Share of that by which the center is off its place in a layer without order."""
LEAST_SHARE, GREATEST_SHARE = 0.5, 2.0


@kernel
def push_beside(j, nx, ny, nz, number, solid):
    """Return the part of G that particle j has across a plane of a wall, 1/m."""
    for f in range(face_count(j, solid)):
        _, ax, ay, az, other = face_at(j, f, solid)
        if other == number and ax * nx + ay * ny + az * nz > ALIKE:
            return solid.push[solid.row[j], f]
    return 0.0


@kernel
def place_along(dx, dy, dz, nx, ny, nz, square):
    """Return where a place stands along a wall from the middle of a column, m, and its weight."""
    across = dx * nx + dy * ny + dz * nz
    x, y, z = dx - across * nx, dy - across * ny, dz - across * nz
    rest = max(1.0 - (x * x + y * y + z * z) / square, 0.0)
    return x, y, z, rest * rest


@kernel
def squares_covered(square):
    """Return the sum of ``(1 - t^2/square)^2`` over a square lattice, lengths in spacings.

    A particle has itself in the middle of its column and no other within a spacing, so that this,
    not the integral, is what a column holds on each row.

    Examples
    --------
    >>> round(squares_covered(2.4**2 - 1.0), 3)
    4.943
    """
    total, most = 0.0, int(np.sqrt(square))
    for a in range(-most, most + 1):
        for b in range(-most, most + 1):
            rest = max(1.0 - (a * a + b * b) / square, 0.0)
            total += rest * rest
    return total


@kernel
def add_column(i, f, push, dx, dy, dz, square, solid, column):
    """Add a push, 1/m, at a place relative to particle i to its column before face f.

    And its images in walls beside it, before which the fluid does not end as at a rim.
    """
    _, nx, ny, nz, _ = face_at(i, f, solid)
    for g in range(-1, face_count(i, solid)):
        ax, ay, az = dx, dy, dz
        if g >= 0:
            height, mx, my, mz, _ = face_at(i, g, solid)
            if abs(mx * nx + my * ny + mz * nz) > BESIDE or solid.is_edge[solid.row[i], g]:
                continue
            behind = 2.0 * (height + dx * mx + dy * my + dz * mz)
            ax, ay, az = dx - behind * mx, dy - behind * my, dz - behind * mz
        x, y, z, w = place_along(ax, ay, az, nx, ny, nz, square)
        column[0] += w * push
        column[1] += w
        column[2] += w * x
        column[3] += w * y
        column[4] += w * z


@kernel
def share_at(i, f, near, solid, whole, column):
    """Return the factor of the drag of face f on particle i.

        (n0 / 2 Ds) A / [d0 sum of G_j K_j],  K = (1 - t^2/A_r^2)^2

    t being the distance from i along the wall, A_r the radius of the column, in which also the
    second row is all within the influence radius, and A the sum of K over the squares of a lattice,
    ``whole``, of which at the rim of the fluid only a part is covered.  On the lattice the sum of G
    over the rows of a column is ``n0 / (2 Ds)``, a sixth of that of the moments of all neighbors.
    ``column`` is room for five sums.
    """
    height, nx, ny, nz, number = face_at(i, f, solid)
    own, d0 = solid.push[solid.row[i], f], near.spacing
    full = push_beyond(seen_distance(height / d0, beyond_of(solid)), beyond_of(solid))
    if own <= 0.0 or full <= 0.0:
        return 1.0
    square = near.effective_radius * near.effective_radius - d0 * d0
    column[:] = 0.0
    add_column(i, f, own, 0.0, 0.0, 0.0, square, solid, column)
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, _ = fluid_pair(i, k, near)
        if solid.row[j] >= 0:
            push = push_beside(j, nx, ny, nz, number, solid)
            if push > 0.0:
                add_column(i, f, push, dx, dy, dz, square, solid, column)
    off = np.sqrt((column[2] ** 2 + column[3] ** 2 + column[4] ** 2) / square) / (RIM * column[1])
    covered = 1.0 - 0.5 * min(max(off - SCATTER, 0.0) / (1.0 - SCATTER), 1.0)
    there = own * d0 / full  # of the plane, near the ends of a body
    wanted = near.number_density / (2.0 * near.dimension) * whole * covered * there
    return min(max(wanted / (d0 * column[0]), LEAST_SHARE), GREATEST_SHARE)


@allocating_kernel
def _share_drag(first, last, near, solid):
    column, reach = np.empty(5), near.effective_radius / near.spacing
    whole = squares_covered(reach * reach - 1.0)
    for i in range(first, last):
        for f in range(face_count(i, solid)):
            no_slip = solid.slip[face_at(i, f, solid)[4]] == 0.0
            share = share_at(i, f, near, solid, whole, column) if no_slip else 1.0
            solid.share[solid.row[i], f] = share


@loop
def share_drag(near, solid):
    """Write the factors of the drag of all faces into the record of the walls."""
    n = solid.row.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        _share_drag(block * BLOCK, min(block * BLOCK + BLOCK, n), near, solid)
