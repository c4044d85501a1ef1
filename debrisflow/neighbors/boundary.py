"""Walls as surfaces: what a particle feels of the solid behind them.

A particle near a wall has the sums over the solid that a lattice of wall particles would give it,
as integrals, and up to three faces of walls that it stands in front of.  Letters as in
:mod:`debrisflow.neighbors.pairs`; G points into the wall.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.beyond import (
    Beyond,
    across_beyond,
    along_beyond,
    flux_beyond,
    lever_beyond,
    push_beyond,
    seen_distance,
)
from debrisflow.neighbors.pairs import BLOCK

Floats = NDArray[np.float64]
FACES = 3  # of walls that one particle can stand in front of
LEAST_HEIGHT = 0.25
"""Spacings below which a height does not divide: nearer, contact holds the particle."""


class WallMotion(NamedTuple):
    """How the walls move, by their number; the numbers are of the present time.

    Attributes
    ----------
    velocity : (walls, 3) float64 array, m/s
        Along itself of a wall of the space, of all of an obstacle that is displaced.
    spin : (walls, 3) float64 array, rad/s
        Angular velocity of an obstacle that turns.
    axis : (walls, 3) float64 array, m
        A point of the axis that it turns about.
    """

    velocity: Floats
    spin: Floats
    axis: Floats


class Walls(NamedTuple):
    """What the walls are like, by their number.

    Attributes
    ----------
    slip : (walls,) float64 array
        1 where a wall is free-slip, 0 where it is no-slip.
    roughness : (walls,) float64 array, m
        Equivalent sand roughness; 0 where the law of the wall does not act.
    motion : WallMotion or None
        None where no wall moves, for which kernels are compiled that are faster.
    """

    slip: Floats
    roughness: Floats
    motion: WallMotion | None


class Boundary(NamedTuple):
    """What the particles feel of the walls.

    Attributes
    ----------
    row : (n,) int32 array
        Row of a particle in the arrays of those near a wall, -1 far from all.
    sums : (rows, 11 or 17) float64 array
        n and m of the solid, G, 1/m, and T as xx, yy, zz, xy, xz, yz; in two dimensions the
        vectors V and H, 1/m, of :mod:`debrisflow.neighbors.quadrant`.
    faces : (rows,) int32 array
        Number of faces, the nearest first.
    distance : (rows, 3) float64 array, m
        To the faces; negative inside.
    normal : (rows, 3, 3) float64 array
        Unit normals out of the walls, a row for each face.
    number : (rows, 3) int32 array
        The wall that a face belongs to.
    push : (rows, 3) float64 array, 1/m
        The part of G that the body behind a face has across it.
    share : (rows, 3) float64 array
        Factor of the drag of a face, see :mod:`debrisflow.neighbors.wall_shares`.
    is_edge : (rows, 3) bool array
        Whether the particle stands off an edge of the body, not over a face of it.
    velocity : (rows, 3, 3) float64 array, m/s, or None
        Of the walls at the faces, a row for each; None where no wall moves.
    slip, roughness
        See :class:`Walls`.
    radius : float
        R, in spacings.
    dimension : float
        Ds.
    """

    row: NDArray[np.int32]
    sums: Floats
    faces: NDArray[np.int32]
    distance: Floats
    normal: Floats
    number: NDArray[np.int32]
    push: Floats
    share: Floats
    is_edge: NDArray[np.bool_]
    slip: Floats
    roughness: Floats
    velocity: Floats | None
    radius: float
    dimension: float


def boundary_of(row: NDArray[np.int32], walls: Walls, beyond: Beyond, sums: int) -> Boundary:
    """Return room for what the particles with a row feel, of a number of sums."""
    rows = int(row.max(initial=-1)) + 1
    return Boundary(
        row=row,
        sums=np.zeros((rows, sums)),
        faces=np.zeros(rows, dtype=np.int32),
        distance=np.zeros((rows, FACES)),
        normal=np.zeros((rows, FACES, 3)),
        number=np.zeros((rows, FACES), dtype=np.int32),
        push=np.zeros((rows, FACES)),
        share=np.ones((rows, FACES)),
        is_edge=np.zeros((rows, FACES), dtype=np.bool_),
        slip=walls.slip,
        roughness=walls.roughness,
        velocity=None if walls.motion is None else np.zeros((rows, FACES, 3)),
        radius=beyond.radius,
        dimension=beyond.dimension,
    )


@kernel
def beyond_of(solid):
    """Return what lies beyond the faces of walls."""
    return Beyond(solid.radius, solid.dimension)


@kernel
def insert_face(row, distance, normal, number, push, is_edge, boundary):
    """Put a face among those of a row, the nearest first; the farthest of four is dropped.

    What pushes off the solid is no push of a wall, and counts as 0.
    """
    place = boundary.faces[row]
    while place > 0 and boundary.distance[row, place - 1] > distance:
        place -= 1
    if place == FACES:
        return
    count = min(boundary.faces[row] + 1, FACES)
    for k in range(count - 1, place, -1):
        boundary.distance[row, k] = boundary.distance[row, k - 1]
        boundary.number[row, k] = boundary.number[row, k - 1]
        boundary.push[row, k] = boundary.push[row, k - 1]
        boundary.is_edge[row, k] = boundary.is_edge[row, k - 1]
        for axis in range(3):
            boundary.normal[row, k, axis] = boundary.normal[row, k - 1, axis]
    boundary.distance[row, place] = distance
    boundary.number[row, place] = number
    boundary.push[row, place] = max(push, 0.0)
    boundary.is_edge[row, place] = is_edge
    for axis in range(3):
        boundary.normal[row, place, axis] = normal[axis]
    boundary.faces[row] = count


@kernel
def wall_sums_at(i, solid):
    """Return n, m, the vector G, 1/m, and T as xx, yy, zz, xy, xz, yz, of particle i."""
    row = solid.row[i]
    if row < 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s = solid.sums[row]
    return s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10]


@kernel
def face_count(i, solid):
    """Return the number of faces that particle i stands in front of."""
    return solid.faces[solid.row[i]] if solid.row[i] >= 0 else 0


@kernel
def face_at(i, f, solid):
    """Return distance, m, normal, and wall number of face f of particle i."""
    row = solid.row[i]
    normal = solid.normal
    return (
        solid.distance[row, f],
        normal[row, f, 0],
        normal[row, f, 1],
        normal[row, f, 2],
        solid.number[row, f],
    )


@kernel
def wall_density_at(i, near, solid):
    """Return n and the vector V of the solid before particle i; in two dimensions."""
    row = solid.row[i]
    if row < 0:
        return 0.0, 0.0, 0.0, 0.0
    s = solid.sums[row]
    return s[0], s[11], s[12], s[13]


@kernel
def wall_source_at(i, u, v, w, fall, near, solid):
    """Return what the walls of particle i add to the sums of the pressure equation, in 2D.

    See :func:`debrisflow.neighbors.wall_access.wall_source_at`.  In the wall the pressure is

        p_i + rho [g + sum over the faces of ((u* - u_wall) / dt - g) . n n] . r

    so that after the step nothing moves into a face, and still water is exact beside edges too.
    That is a divergence of ``-2 H . (u* - u_wall)``, as of a fluid that moves behind the wall
    against it as it does before it.  Supply moves at a given velocity, whatever the wall does.
    """
    row = solid.row[i]
    if row < 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s = solid.sums[row]
    hx, hy, hz = s[14], s[15], s[16]
    flux = hx * fall[0] + hy * fall[1] + hz * fall[2]
    for f in range(face_count(i, solid)):
        height, nx, ny, nz, _ = face_at(i, f, solid)
        q = seen_distance(height / near.spacing, beyond_of(solid))
        part = part_of_face(i, f, q, near, solid) * flux_beyond(q, beyond_of(solid)) / near.spacing
        du, dv, dw = velocity_beside(u - fall[0], v - fall[1], w - fall[2], i, f, solid)
        flux -= part * (du * nx + dv * ny + dw * nz)
    if i >= near.supply_from:
        flux = 0.0
    return s[0], s[11], s[12], s[13], -2.0 * flux, s[2], s[3], s[4], hx, hy, hz


@kernel
def own_velocity(i, velocity, near, solid):
    """Return the velocity of particle i, m/s."""
    return velocity[i, 0], velocity[i, 1], velocity[i, 2]


@kernel
def pressed_count(i, near, solid):
    """Return that no neighbor is a wall with a pressure of its own."""
    return 0


@kernel
def pressed_pair(i, k, near, solid):
    """Return no row of a wall."""
    return 0, 0.0


@kernel
def viscous_pull_at(i, velocity, near, solid):
    """Return the sum of ``(u_j - u_i) w`` over the walls of particle i, m/s.

    ``-(u_t / h) integral of w r_n`` over the faces of no-slip walls, u_t along the wall and
    relative to it: the profile of the velocity goes on straight through the surface.
    """
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    x, y, z = 0.0, 0.0, 0.0
    for f in range(face_count(i, solid)):
        height, nx, ny, nz, number = face_at(i, f, solid)
        if solid.slip[number] > 0.0:
            continue
        height = max(height, LEAST_HEIGHT * near.spacing)
        drag = lever_of_face(i, f, height, near, solid) / height
        du, dv, dw = velocity_beside(u, v, w, i, f, solid)
        across = du * nx + dv * ny + dw * nz
        x -= drag * (du - across * nx)
        y -= drag * (dv - across * ny)
        z -= drag * (dw - across * nz)
    return x, y, z


@kernel
def grain_pull_at(i, velocity, near, solid):
    """Return the same, which holds grains by their collisions with a no-slip wall."""
    return viscous_pull_at(i, velocity, near, solid)


@kernel
def _velocity_in(row, f, velocity):
    # an argument, since Numba drops a branch for None by the types of arguments only
    if velocity is None:
        return 0.0, 0.0, 0.0
    else:
        return velocity[row, f, 0], velocity[row, f, 1], velocity[row, f, 2]


@kernel
def velocity_of_face(i, f, solid):
    """Return the velocity of the wall at face f of particle i, m/s; 0 where no wall moves."""
    return _velocity_in(solid.row[i], f, solid.velocity)


@kernel
def velocity_beside(u, v, w, i, f, solid):
    """Return a velocity relative to that of the wall at face f of particle i, m/s."""
    wall_u, wall_v, wall_w = velocity_of_face(i, f, solid)
    return u - wall_u, v - wall_v, w - wall_w


@kernel
def flow_of_walls_at(i, solid):
    """Return the sum of ``u_wall . G`` over the faces of particle i, 1/s."""
    flow = 0.0
    for f in range(face_count(i, solid)):
        _, nx, ny, nz, _ = face_at(i, f, solid)
        u, v, w = velocity_of_face(i, f, solid)
        flow -= solid.push[solid.row[i], f] * (u * nx + v * ny + w * nz)
    return flow


@kernel
def _write_velocities(first, last, position, motion, solid):
    velocity, spin, axis = motion.velocity, motion.spin, motion.axis
    for i in range(first, last):
        for f in range(face_count(i, solid)):
            distance, nx, ny, nz, b = face_at(i, f, solid)
            x = position[i, 0] - distance * nx - axis[b, 0]
            y = position[i, 1] - distance * ny - axis[b, 1]
            z = position[i, 2] - distance * nz - axis[b, 2]
            own = solid.velocity[solid.row[i], f]
            own[0] = velocity[b, 0] + spin[b, 1] * z - spin[b, 2] * y
            own[1] = velocity[b, 1] + spin[b, 2] * x - spin[b, 0] * z
            own[2] = velocity[b, 2] + spin[b, 0] * y - spin[b, 1] * x


@loop
def write_velocities(position, motion, solid):
    """Write the velocities of the walls at the faces of all particles.

    ``u = velocity + spin x (r - axis)`` at the foot r of a particle on a face.

    Parameters
    ----------
    position : (n, 3) float64 array, m
    motion : WallMotion
    solid : Boundary
        Changed.
    """
    n = solid.row.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _write_velocities(first, last, position, motion, solid)


@kernel
def stick_count(i, near, solid):
    """Return how many places of no-slip or free-slip wall hold particle i by viscosity."""
    return face_count(i, solid)


@kernel
def stick_at(i, f, near, solid):
    """Return how a face holds a particle by viscosity.

    See :func:`debrisflow.neighbors.wall_access.stick_at`: the mirrored velocity of a half space
    makes the sum of ``(2 Ds/n0) (w/r^2) (r_n / h)``, which is ``(2 Ds/n0) G / h``.
    """
    height, nx, ny, nz, number = face_at(i, f, solid)
    height = max(height, LEAST_HEIGHT * near.spacing)
    push = solid.share[solid.row[i], f] * solid.push[solid.row[i], f]
    pull = 2.0 * near.dimension / near.number_density * push / height
    pull *= 1.0 - solid.slip[number]
    down = 2.0 * height
    wall_u, wall_v, wall_w = velocity_of_face(i, f, solid)
    return (
        pull,
        height,
        nx,
        ny,
        nz,
        -down * nx,
        -down * ny,
        -down * nz,
        solid.roughness[number],
        wall_u,
        wall_v,
        wall_w,
    )


@kernel
def part_of_face(i, f, q, near, solid):
    """Return what a face pushes particle i by, over what the half space behind it would.

    q is the distance at which the sums see it.
    """
    full = push_beyond(q, beyond_of(solid)) / near.spacing
    return solid.push[solid.row[i], f] / full if full > 0.0 else 0.0


@kernel
def lever_of_face(i, f, height, near, solid):
    """Return the part of the integral of ``w r_n`` that a face has, m.

    That of the half space behind it, times the share of its push that is there.
    """
    q = seen_distance(height / near.spacing, beyond_of(solid))
    return part_of_face(i, f, q, near, solid) * lever_beyond(q, beyond_of(solid)) * near.spacing


@kernel
def wall_moments_at(i, velocity, near, solid):
    """Return the moments of the velocity gradient over the walls of particle i.

    See :func:`debrisflow.neighbors.wall_access.wall_moments_at`.  Of a half space, with T_n across
    and T_t along it: ``M = T_t (1 - nn) + T_n nn`` and ``B = ((u_i - u_wall) / h) (x) T_n n``; of a
    free-slip one only what is across.
    """
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    for f in range(face_count(i, solid)):
        height, nx, ny, nz, number = face_at(i, f, solid)
        height = max(height, LEAST_HEIGHT * near.spacing)
        q = seen_distance(height / near.spacing, beyond_of(solid))
        share = part_of_face(i, f, q, near, solid)
        across = share * across_beyond(q, beyond_of(solid))
        stick = 1.0 - solid.slip[number]
        along = stick * share * along_beyond(q, beyond_of(solid))
        rest = across - along
        xx, xy, yy = xx + along + rest * nx * nx, xy + rest * nx * ny, yy + along + rest * ny * ny
        xz, yz, zz = xz + rest * nx * nz, yz + rest * ny * nz, zz + along + rest * nz * nz
        du, dv, dw = velocity_beside(u, v, w, i, f, solid)
        normal = du * nx + dv * ny + dw * nz
        gu = normal * nx + stick * (du - normal * nx)
        gv = normal * ny + stick * (dv - normal * ny)
        gw = normal * nz + stick * (dw - normal * nz)
        b = across / height
        ux, uy, uz = ux + b * gu * nx, uy + b * gu * ny, uz + b * gu * nz
        vx, vy, vz = vx + b * gv * nx, vy + b * gv * ny, vz + b * gv * nz
        wx, wy, wz = wx + b * gw * nx, wy + b * gw * ny, wz + b * gw * nz
    return xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz


@kernel
def free_slip_face_at(i, near, solid):
    """Return normal and height, m, of the nearest free-slip face, r_e where there is none.

    Only a face that the particle stands over counts, none beyond its end.
    """
    for f in range(face_count(i, solid)):
        height, nx, ny, nz, number = face_at(i, f, solid)
        if solid.slip[number] > 0.0 and not solid.is_edge[solid.row[i], f]:
            return nx, ny, nz, max(height, 0.0)
    return 0.0, 0.0, 0.0, near.effective_radius


@kernel
def rebounded(i, u, v, w, reach, restitution, solid):
    """Return a velocity after the bounce off the faces nearer than ``reach``, m, that it meets.

    Along the normal, with a restitution; what is along the face stays.
    """
    for f in range(face_count(i, solid)):
        distance, nx, ny, nz, _ = face_at(i, f, solid)
        du, dv, dw = velocity_beside(u, v, w, i, f, solid)
        approach = -(du * nx + dv * ny + dw * nz)
        if distance < reach and approach > 0.0:
            u += (1.0 + restitution) * approach * nx
            v += (1.0 + restitution) * approach * ny
            w += (1.0 + restitution) * approach * nz
    return u, v, w


@kernel
def _find_inside(first, last, spacing, solid, inside):
    for i in range(first, last):
        inside[i] = face_count(i, solid) > 0 and face_at(i, 0, solid)[0] < -0.5 * spacing


@loop
def find_inside(spacing, solid, inside):
    """Write which particles are half a spacing deep in a wall or deeper, (n,) bool array."""
    for block in prange((inside.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, inside.size)
        _find_inside(first, last, spacing, solid, inside)
