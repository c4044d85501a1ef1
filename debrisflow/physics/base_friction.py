"""Friction of a flow along the walls that are surfaces, one form for all laws.

The stress tau on a wall slows the particles nearer to it than a spacing, along the wall, as a
volume force.  Sliding friction, ``tau = tan(delta) R``, is a share of what presses particle i to
the wall, its own reaction R less what the water in its pores bears; the reactions of a column add
up to its weight, whatever the order of its rows.  A drag, ``tau = rho c |u| u``, is that of the
particle's own velocity and height in the law of the wall, and that of the mean velocity and the
depth of its column in the laws of Manning and Voellmy, shared among the particles of the column
that are next to the wall.

    a_i = -[tan(delta) R_i / rho + b |u_i|^2] u_i / |u_i|

Implicit: first what slides, by return mapping, so that what friction can hold stands still, then
the drag, exactly; within the exchange of momentum as a viscosity at the velocity that is expected,
by which what friction can hold creeps by less than :data:`SLOWEST`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.boundary import (
    LEAST_HEIGHT,
    face_at,
    face_count,
    velocity_beside,
    velocity_of_face,
)
from debrisflow.neighbors.pairs import BLOCK
from debrisflow.physics.turbulence import wall_friction

Floats = NDArray[np.float64]
SLOWEST = 1e-6
"""Speed, m/s, below which sliding friction is a viscosity in the exchange of momentum: ten
centimeters a day."""
THINNEST = 0.25  # spacings, and particles on a square of one; no column is taken thinner
STEEPEST = 0.5  # upward part of the normal below which a wall is no floor of a column


class BaseFriction(NamedTuple):
    """The friction of each wall, by its number, (walls,) float64 arrays.

    Attributes
    ----------
    sliding : tangent of the angle of friction, less what the pores bear
    roughness : equivalent sand roughness of the law of the wall, m; 0 where it does not act
    manning : g n^2, of Manning's law, m^(1/3)
    turbulent : g / xi, of Voellmy's law
    """

    sliding: Floats
    roughness: Floats
    manning: Floats
    turbulent: Floats


class Columns(NamedTuple):
    """Means over the columns that the particles stand in, (n,) float64 arrays.

    Attributes
    ----------
    depth : m, along the vertical of the space
    speed : m/s
    beside : how many particles of a column next to a wall stand on a square of a spacing
    """

    depth: Floats
    speed: Floats
    beside: Floats


@kernel
def drag_at(i, height, nz, number, friction, columns, spacing, speed):
    """Return b, 1/m, by which a drag slows particle i: ``du/dt = -b |u| u``.

    ``[kappa / ln(1 + 30 y / k_s)]^2 / d0`` by the law of the wall; by the mean velocity of the
    column ``g n^2 / h^(1/3)`` of Manning's law and ``g / xi`` of Voellmy's, over d0 and the number
    of particles that share it.

    References
    ----------
    Voellmy 1955, Schweizerische Bauzeitung 73.
    """
    b = 0.0
    if friction.roughness[number] > 0.0:
        height = max(height, LEAST_HEIGHT * spacing)
        b += wall_friction(height, friction.roughness[number]) / spacing
    c = friction.turbulent[number]
    if abs(nz) >= STEEPEST and (c > 0.0 or friction.manning[number] > 0.0):
        depth = max(columns.depth[i] * abs(nz), THINNEST * spacing)
        c += friction.manning[number] * depth ** (-1.0 / 3.0)
        mean = columns.speed[i] / max(speed, SLOWEST)
        b += c * mean * mean / (max(columns.beside[i] * abs(nz), THINNEST) * spacing)
    return b


@kernel
def friction_at(i, f, u, v, w, pressed, friction, columns, spacing, solid):
    """Return speed along face f, m/s, its sliding friction, m/s2, and drag b, 1/m, of particle i.

    Sliding friction is that of what the wall pushes, ``pressed``, m/s2; a drag slows what is nearer
    than a spacing.
    """
    height, nx, ny, nz, number = face_at(i, f, solid)
    u, v, w = velocity_beside(u, v, w, i, f, solid)
    across = u * nx + v * ny + w * nz
    speed = np.sqrt(max(u * u + v * v + w * w - across * across, 0.0))
    b = 0.0
    if height < spacing:
        b = drag_at(i, height, nz, number, friction, columns, spacing, speed)
    return speed, friction.sliding[number] * pressed, b


@kernel
def pressed_by(i, f, x, y, z, solid):
    """Return what face f pushes of what is left of a reaction, m/s2, and what the others have."""
    _, nx, ny, nz, _ = face_at(i, f, solid)
    pressed = max(x * nx + y * ny + z * nz, 0.0)
    return pressed, x - pressed * nx, y - pressed * ny, z - pressed * nz


@kernel
def slowed_speed(speed, sliding, b, dt):
    """Return a speed after a step of sliding friction, m/s2, and a drag, 1/m.

    Examples
    --------
    >>> slowed_speed(0.01, 2.0, 0.0, 0.01), slowed_speed(1.0, 2.0, 0.0, 0.01)
    (0.0, 0.98)
    >>> round(slowed_speed(1.0, 0.0, 3.0, 0.01), 5)
    0.97168
    """
    slid = max(speed - dt * sliding, 0.0)
    return 2.0 * slid / (1.0 + np.sqrt(1.0 + 4.0 * b * dt * slid))


@kernel
def along(u, v, w, nx, ny, nz, share):
    """Return a velocity of which the part along a wall is taken by a share."""
    across = u * nx + v * ny + w * nz
    return (
        share * u + (1.0 - share) * across * nx,
        share * v + (1.0 - share) * across * ny,
        share * w + (1.0 - share) * across * nz,
    )


@kernel
def _slow_along_walls(first, last, dt, reaction, friction, columns, spacing, solid, velocity):
    for i in range(first, last):
        x, y, z = reaction[i, 0], reaction[i, 1], reaction[i, 2]
        for f in range(face_count(i, solid)):
            u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
            pressed, x, y, z = pressed_by(i, f, x, y, z, solid)
            speed, sliding, b = friction_at(
                i, f, u, v, w, pressed, friction, columns, spacing, solid
            )
            _, nx, ny, nz, _ = face_at(i, f, solid)
            kept = slowed_speed(speed, sliding, b, dt) / max(speed, 1e-300)
            du, dv, dw = velocity_beside(u, v, w, i, f, solid)
            kept_u, kept_v, kept_w = along(du, dv, dw, nx, ny, nz, kept)
            velocity[i, 0] = u - (du - kept_u)
            velocity[i, 1] = v - (dv - kept_v)
            velocity[i, 2] = w - (dw - kept_w)


@loop
def slow_along_walls(dt, reaction, friction, columns, spacing, solid, velocity):
    """Slow all fluid particles by the friction of the walls, in place."""
    n = velocity.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _slow_along_walls(first, last, dt, reaction, friction, columns, spacing, solid, velocity)


@kernel
def _hold_along_walls(
    first, last, dt, velocity, reaction, friction, columns, spacing, solid, hold, carried
):
    for i in range(first, last):
        u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        x, y, z = reaction[i, 0], reaction[i, 1], reaction[i, 2]
        xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        gu, gv, gw = 0.0, 0.0, 0.0
        for f in range(face_count(i, solid)):
            pressed, x, y, z = pressed_by(i, f, x, y, z, solid)
            speed, sliding, b = friction_at(
                i, f, u, v, w, pressed, friction, columns, spacing, solid
            )
            _, nx, ny, nz, _ = face_at(i, f, solid)
            held = dt * (sliding / max(speed, SLOWEST) + b * speed)
            wall_u, wall_v, wall_w = velocity_of_face(i, f, solid)
            across = wall_u * nx + wall_v * ny + wall_w * nz
            gu += held * (wall_u - across * nx)
            gv += held * (wall_v - across * ny)
            gw += held * (wall_w - across * nz)
            xx, xy, yy = (
                xx + held * (1.0 - nx * nx),
                xy - held * nx * ny,
                yy + held * (1.0 - ny * ny),
            )
            xz, yz, zz = xz - held * nx * nz, yz - held * ny * nz, zz + held * (1.0 - nz * nz)
        hold[i, 0], hold[i, 1], hold[i, 2] = xx, xy, yy
        hold[i, 3], hold[i, 4], hold[i, 5] = xz, yz, zz
        carried[i, 0], carried[i, 1], carried[i, 2] = gu, gv, gw


@loop
def hold_along_walls(dt, velocity, reaction, friction, columns, spacing, solid, hold, carried):
    """Write by what the implicit exchange of momentum holds all fluid particles along walls.

    ``hold``, (n, 6) float64 array, is dt times the rates, 1, at which friction slows them at a
    velocity, (n, 3) array, m/s: the sum over the faces of a rate times ``1 - nn``, as xx, xy, yy,
    xz, yz, zz.  ``carried``, (n, 3) array, m/s, is what this gives of the velocity of moving walls.
    """
    n = hold.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _hold_along_walls(
            first, last, dt, velocity, reaction, friction, columns, spacing, solid, hold, carried
        )


class Grid(NamedTuple):
    """Upright columns over the plan of the space.

    Attributes
    ----------
    lower, width : (2,) float64 array, m
        Corner of the space, and width of a column along x and y.
    shape : (2,) int64 array
    repeats : (2,) bool array
        Whether the space repeats.
    """

    lower: Floats
    width: Floats
    shape: NDArray[np.int64]
    repeats: NDArray[np.bool_]


@kernel
def _columns_around(place, axis, grid):
    """Return the two columns around a place along an axis, and the share of the second.

    At the end of the space the last column stands for the one beyond.
    """
    at = (place - grid.lower[axis]) / grid.width[axis] - 0.5
    below = np.floor(at)
    first, most = int(below), grid.shape[axis] - 1
    if grid.repeats[axis]:
        return first % (most + 1), (first + 1) % (most + 1), at - below
    return min(max(first, 0), most), min(max(first + 1, 0), most), at - below


@allocating_kernel
def survey_columns(position, velocity, next_to_wall, grid, spacing, sums, columns):
    """Write depth, speed and particles beside the wall of the column around each particle.

    A particle counts for the four columns around it by its distance to their middles, and reads
    their means in the same way.  One after the other, so that the sums do not depend on threads.

    Parameters
    ----------
    position, velocity : (n, 3) float64 array, m, m/s
    next_to_wall : (n,) bool array
    grid : Grid
    spacing : float, m
    sums : (columns along x, along y, 5) float64 array
        Zeros; holds number, momentum along x, y, z, and number beside the wall.
    columns : Columns
        Written.
    """
    n, spread = columns.depth.size, np.empty(5)
    area = grid.width[0] * grid.width[1]
    for is_read in (False, True):
        for i in range(n):
            spread[:] = 0.0
            a, b, x = _columns_around(position[i, 0], 0, grid)
            c, d, y = _columns_around(position[i, 1], 1, grid)
            for corner in range(4):
                column = sums[b if corner % 2 else a, d if corner > 1 else c]
                share = (x if corner % 2 else 1.0 - x) * (y if corner > 1 else 1.0 - y)
                if is_read:
                    for k in range(5):
                        spread[k] += share * column[k]
                else:
                    column[0] += share
                    for k in range(3):
                        column[1 + k] += share * velocity[i, k]
                    column[4] += share if next_to_wall[i] else 0.0
            if is_read:
                momentum = np.sqrt(spread[1] ** 2 + spread[2] ** 2 + spread[3] ** 2)
                columns.depth[i] = spread[0] * spacing * spacing * spacing / area
                columns.speed[i] = momentum / spread[0]
                columns.beside[i] = spread[4] * spacing * spacing / area
