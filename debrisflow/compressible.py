"""The weakly compressible fluid: density, equation of state and forces of each particle.

Letters as in :mod:`debrisflow.operators`; ``s = rho / rho0 - 1`` is the compression, ``c`` the
speed of sound, ``e = r_ij / r``.  Fluid and walls stand in two lists; walls do not move.  The loops
over fluid neighbors are free of branches, so that they vectorize: a listed particle beyond the
influence radius has the weight 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.granular import algebraic_temperature, granular_pressure, granular_viscosity
from debrisflow.operators import face_towards, mirrored, strain_rate

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
INTERIOR = 0.94  # n/n0 above which the density follows the particle number density
SURFACE = 0.85  # n/n0 below which a particle is at a free surface and carries no pressure
LEAST_COMPRESSION, GREATEST_COMPRESSION = -0.02, 0.5
CAP = 0.1  # of the study's granular temperature, see :func:`capped_temperature`


class Fluid(NamedTuple):
    """What is known of the fluid particles.

    Attributes
    ----------
    position, velocity : (n, 3) float64 array, m, m/s
    compression : (n,) float64 array
        s.
    pressure : (n,) float64 array, Pa
        Of the mixture; 0 at a free surface.
    grain_pressure, viscosity : (n,) float64 array, Pa, m2/s
        Of colliding grains; kinematic, Newtonian and of colliding grains.
    """

    position: Floats
    velocity: Floats
    compression: Floats
    pressure: Floats
    grain_pressure: Floats
    viscosity: Floats


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
    """

    position: Floats
    normal: Floats
    depth: Floats
    slip: Floats


class Near(NamedTuple):
    """Who is near whom: neighbors of every fluid particle in the fluid and in the walls.

    Attributes
    ----------
    fluid, wall : (n, capacity) int32 array
    fluid_count, wall_count : (n,) int32 array
    period, frequency : (3,) float64 array, m, 1/m
        Period along each axis and its inverse; 0 where there is none.
    """

    fluid: Indices
    fluid_count: Indices
    wall: Indices
    wall_count: Indices
    period: Floats
    frequency: Floats


class Numbers(NamedTuple):
    """Constants of the scheme.

    Attributes
    ----------
    spacing, effective_radius : float, m
        d0 and r_e.
    dimension, number_density : float
        Ds and n0.
    gradient, laplacian : float, -, 1/m2
        ``Ds / n0`` and ``2 Ds / (lambda n0)``.
    smooth_density, smooth_steepness : float
        m0 and its growth with the density, see :class:`debrisflow.lattice.Reference`.
    density, sound_speed : float, kg/m3, m/s
        rho0 and c.
    gravity : (3,) float64 array, m/s2
    diffusion, relaxation : float, -, s
        delta, and the time in which s follows n.
    artificial_viscosity : float
        alpha.
    collision_distance, restitution : float, m, -
    """

    spacing: float
    effective_radius: float
    dimension: float
    number_density: float
    gradient: float
    laplacian: float
    smooth_density: float
    smooth_steepness: float
    density: float
    sound_speed: float
    gravity: Floats
    diffusion: float
    relaxation: float
    artificial_viscosity: float
    collision_distance: float
    restitution: float


@kernel
def separation(i, j, position, other, near):
    """Return the components of ``r_j - r_i`` through the nearest image, m."""
    dx = other[j, 0] - position[i, 0]
    dy = other[j, 1] - position[i, 1]
    dz = other[j, 2] - position[i, 2]
    dx -= near.period[0] * np.rint(dx * near.frequency[0])
    dy -= near.period[1] * np.rint(dy * near.frequency[1])
    dz -= near.period[2] * np.rint(dz * near.frequency[2])
    return dx, dy, dz


@kernel
def inverse_distance(dx, dy, dz, numbers):
    """Return ``1 / r``; two particles at one place are taken 1e-6 d0 apart, in no direction."""
    r2 = dx * dx + dy * dy + dz * dz
    return 1.0 / np.sqrt(max(r2, 1e-12 * numbers.spacing * numbers.spacing))


@kernel
def weight(inverse, numbers):
    """Return ``w = r_e / r - 1``, 0 beyond the influence radius."""
    return max(numbers.effective_radius * inverse - 1.0, 0.0)


@kernel
def smooth_weight(inverse, numbers):
    """Return ``(1 - q)^2`` with q = r / r_e, 0 beyond it; see :func:`lattice.smooth_weight`."""
    rest = 1.0 - min(1.0 / (inverse * numbers.effective_radius), 1.0)
    return rest * rest


@kernel
def density_rate_at(i, fluid, solid, near, numbers):
    """Return n / n0, the compression that the summed density tells, and ds/dt, 1/s.

        ds/dt = -(1 + s) (Ds/n0) sum of u_ij . r_ij w / r^2
                + delta c d0 (2 Ds/(lambda n0)) sum of [s_j - s_i - g . r_ij / c^2] w

    The first sum, continuity, is over fluid and walls; the second, over fluid, evens out noise
    but not the hydrostatic part, which would make the fluid sink.

    References
    ----------
    Antuono, Colagrossi, Marrone & Molteni 2010, doi:10.1016/j.cpc.2009.11.002 (diffusion of
    density in SPH).
    """
    position, velocity, s = fluid.position, fluid.velocity, fluid.compression
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    c2 = numbers.sound_speed * numbers.sound_speed
    gx, gy, gz = numbers.gravity[0] / c2, numbers.gravity[1] / c2, numbers.gravity[2] / c2
    s_i = s[i]
    n, m, flow, difference = 0.0, 1.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        weighed = weight(inverse, numbers)
        n += weighed
        m += smooth_weight(inverse, numbers)
        along = (velocity[j, 0] - u) * dx + (velocity[j, 1] - v) * dy + (velocity[j, 2] - w) * dz
        flow += along * weighed * inverse * inverse
        difference += (s[j] - s_i - gx * dx - gy * dy - gz * dz) * weighed
    for k in range(near.wall_count[i]):
        j = np.uint32(near.wall[i, k])
        dx, dy, dz = separation(i, j, position, solid.position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        weighed = weight(inverse, numbers)
        n += weighed
        m += smooth_weight(inverse, numbers)
        flow -= (u * dx + v * dy + w * dz) * weighed * inverse * inverse
    spread = numbers.diffusion * numbers.sound_speed * numbers.spacing * numbers.laplacian
    rate = -(1.0 + s_i) * numbers.gradient * flow + spread * difference
    summed = (m / numbers.smooth_density - 1.0) / numbers.smooth_steepness
    return n / numbers.number_density, summed, rate


@kernel
def new_compression(s, rate, n, summed, relaxation, dt):
    """Return the compression after a time step.

    In the interior, n > 0.94 n0, it follows the summed density within the relaxation time, so that
    what continuity loses does not add up; at a free surface, n < 0.85 n0, it is 0.

    Examples
    --------
    >>> [new_compression(0.0, 1.0, n, 0.02, 0.1, 0.01) for n in (1.0, 0.8)]
    [0.012, 0.0]
    """
    if n < SURFACE:
        return 0.0
    if n > INTERIOR:
        rate += (summed - s) / relaxation
    return min(max(s + dt * rate, LEAST_COMPRESSION), GREATEST_COMPRESSION)


@kernel
def state_pressure(s, numbers):
    """Return ``p = rho0 c^2 max(s, 0)``, the integral of equation (12), Pa."""
    return numbers.density * numbers.sound_speed * numbers.sound_speed * max(s, 0.0)


@loop
def advance_density(dt, fluid, solid, near, numbers, n, compression, pressure):
    """Write n, the compression after a time step and its pressure, of every fluid particle."""
    for i in prange(n.size):
        ratio, summed, rate = density_rate_at(i, fluid, solid, near, numbers)
        s = new_compression(fluid.compression[i], rate, ratio, summed, numbers.relaxation, dt)
        n[i] = ratio * numbers.number_density
        compression[i] = s
        pressure[i] = state_pressure(s, numbers)


@kernel
def shear_rate_at(i, fluid, solid, near, numbers):
    """Return ``sqrt(2 D : D)``, 1/s, exact for a linear profile on any arrangement.

    The same moments as in :func:`debrisflow.operators.shear_rate_at`.
    """
    position, velocity = fluid.position, fluid.velocity
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        f = weight(inverse, numbers) * inverse * inverse
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    for k in range(near.wall_count[i]):
        j = np.uint32(near.wall[i, k])
        dx, dy, dz = separation(i, j, position, solid.position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        f = weight(inverse, numbers) * inverse * inverse
        du, dv, dw = wall_velocity_difference(u, v, w, dx, dy, dz, j, solid, numbers)
        xx, xy, yy = xx + f * dx * dx, xy + f * dx * dy, yy + f * dy * dy
        xz, yz, zz = xz + f * dx * dz, yz + f * dy * dz, zz + f * dz * dz
        ux, uy, uz = ux + f * du * dx, uy + f * du * dy, uz + f * du * dz
        vx, vy, vz = vx + f * dv * dx, vy + f * dv * dy, vz + f * dv * dz
        wx, wy, wz = wx + f * dw * dx, wy + f * dw * dy, wz + f * dw * dz
    return strain_rate(xx, xy, yy, xz, yz, zz, ux, uy, uz, vx, vy, vz, wx, wy, wz)


@kernel
def wall_velocity_difference(u, v, w, dx, dy, dz, j, solid, numbers):
    """Return ``u_j - u_i`` for wall particle j, as :func:`operators.velocity_difference`."""
    nx, ny, nz = solid.normal[j, 0], solid.normal[j, 1], solid.normal[j, 2]
    height = -(dx * nx + dy * ny + dz * nz) - solid.depth[j]
    factor = 1.0 + solid.depth[j] / max(height, 0.5 * numbers.spacing)
    return mirrored(-u, -v, -w, nx, ny, nz, factor, solid.slip[j])


@kernel
def agitation_at(i, fluid, near, numbers):
    """Return the variance of the velocity in reach, over Ds: T of equations (20), (21), m2/s2."""
    position, velocity = fluid.position, fluid.velocity
    count, su, sv, sw, square = 1.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        inside = 1.0 if weight(inverse, numbers) > 0.0 else 0.0
        du = velocity[j, 0] - velocity[i, 0]
        dv = velocity[j, 1] - velocity[i, 1]
        dw = velocity[j, 2] - velocity[i, 2]
        count += inside
        su, sv, sw = su + inside * du, sv + inside * dv, sw + inside * dw
        square += inside * (du * du + dv * dv + dw * dw)
    mean = (su * su + sv * sv + sw * sw) / count
    return max(square - mean, 0.0) / count / numbers.dimension


@kernel
def capped_temperature(temperature, c, grains, numbers):
    """Return the granular temperature, m2/s2, not above ``(z c rho0 / K)^2 / 3``, z = 0.1.

    ``K = 2 rho_s C^2 g0 (1 + e)``, the granular pressure of T = 1.  The variance of the velocity is
    mostly scatter of the particles; above the limit the pressure made of it makes more of it than
    the artificial viscosity takes away, and at C = 0.5 the fluid blows up.
    """
    pushed = granular_pressure(c, 1.0, grains)
    limit = CAP * numbers.sound_speed * numbers.density / pushed
    return min(temperature, limit * limit / 3.0)


@loop
def stir(is_algebraic, fluid, solid, near, c, grains, numbers, temperature):
    """Write the granular temperature of every fluid particle, (n,) float64 array, m2/s2."""
    for i in prange(temperature.size):
        if is_algebraic:
            rate = shear_rate_at(i, fluid, solid, near, numbers)
            temperature[i] = algebraic_temperature(rate, grains)
        else:
            agitation = agitation_at(i, fluid, near, numbers)
            temperature[i] = capped_temperature(agitation, c, grains, numbers)


@loop
def collide_grains(c, viscosity, grains, numbers, n, temperature, grain_pressure, total_viscosity):
    """Write pressure, Pa, and kinematic viscosity, m2/s, of the fluid with its colliding grains.

    The pressure fades from n = n0 to 0.8 n0: at a free surface it would throw out the particles,
    which then hang as sheets.  ``viscosity`` is the Newtonian part.
    """
    for i in prange(n.size):
        inside = min(max(5.0 * (n[i] / numbers.number_density - 0.8), 0.0), 1.0)
        grain_pressure[i] = inside * granular_pressure(c, temperature[i], grains)
        collisions = granular_viscosity(c, temperature[i], grains)
        total_viscosity[i] = viscosity + collisions / numbers.density


@kernel
def acceleration_at(i, fluid, solid, near, numbers):
    """Return the acceleration of particle i, m/s2, and the change of its velocity by collisions.

        -(1/rho0) (Ds/n0) sum of (P_i + P_j) r_ij w / r^2
        + (2 Ds/(lambda n0)) sum of [alpha c d0 (u_ij . e) e + nu_ij u_ij] w + g

    with P the pressure of fluid and grains and nu_ij the mean viscosity of the pair.  The sum form
    of the pressure conserves momentum, and is never attractive since P >= 0; the study's form (14)
    is not needed then.  A wall neighbor has the pressure ``max(p_i + rho0 g . r_ij, 0)`` and
    exchanges momentum by viscosity where it is no-slip; the artificial viscosity does not act on
    walls, where it would be a drag that depends on the spacing.  Particles nearer than the
    collision distance that approach exchange the impulse of a collision, from the same velocities
    for both.
    """
    position, velocity = fluid.position, fluid.velocity
    u, v, w = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    rho, push, pull = numbers.density, numbers.gradient, numbers.laplacian
    damping = pull * numbers.artificial_viscosity * numbers.sound_speed * numbers.spacing
    near_by = 1.0 / numbers.collision_distance if numbers.collision_distance > 0.0 else np.inf
    p_i, nu_i = fluid.pressure[i] + fluid.grain_pressure[i], fluid.viscosity[i]
    ax, ay, az, cx, cy, cz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j = np.uint32(near.fluid[i, k])
        dx, dy, dz = separation(i, j, position, position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        weighed = weight(inverse, numbers)
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        along = du * dx + dv * dy + dw * dz
        p = p_i + fluid.pressure[j] + fluid.grain_pressure[j]
        line = (damping * along - push * p / rho) * weighed * inverse * inverse
        drag = pull * 0.5 * (nu_i + fluid.viscosity[j]) * weighed
        ax += line * dx + drag * du
        ay += line * dy + drag * dv
        az += line * dz + drag * dw
        hit = min(along, 0.0) * inverse * inverse if inverse > near_by else 0.0
        cx += hit * dx
        cy += hit * dy
        cz += hit * dz
    gx, gy, gz = numbers.gravity[0], numbers.gravity[1], numbers.gravity[2]
    for k in range(near.wall_count[i]):
        j = np.uint32(near.wall[i, k])
        dx, dy, dz = separation(i, j, position, solid.position, near)
        inverse = inverse_distance(dx, dy, dz, numbers)
        weighed = weight(inverse, numbers)
        p_wall = max(fluid.pressure[i] + rho * (gx * dx + gy * dy + gz * dz), 0.0)
        p = p_i + p_wall + fluid.grain_pressure[i]
        line = -push * p / rho * weighed * inverse * inverse
        du, dv, dw = wall_velocity_difference(u, v, w, dx, dy, dz, j, solid, numbers)
        drag = pull * nu_i * weighed * (1.0 - solid.slip[j])
        ax += line * dx + drag * du
        ay += line * dy + drag * dv
        az += line * dz + drag * dw
    share = 0.5 * (1.0 + numbers.restitution)
    return ax + gx, ay + gy, az + gz, share * cx, share * cy, share * cz


@kernel
def bounce_at(i, u, v, w, fluid, solid, near, numbers):
    """Return a velocity of particle i after it bounced off the walls that it touches.

    A wall acts as the plane of its surface: a particle nearer to it than ``collision_distance -
    d0/2`` that approaches bounces along the normal and slides freely.
    """
    reach = numbers.collision_distance - 0.5 * numbers.spacing
    for k in range(near.wall_count[i]):
        j = near.wall[i, k]
        if solid.depth[j] > 0.75 * numbers.spacing:
            continue
        dx, dy, dz = separation(i, j, fluid.position, solid.position, near)
        height, nx, ny, nz = face_towards(
            dx,
            dy,
            dz,
            solid.normal[j, 0],
            solid.normal[j, 1],
            solid.normal[j, 2],
            numbers.spacing,
        )
        if height >= reach:
            continue
        approach = -(u * nx + v * ny + w * nz)
        if approach > 0.0:
            u += (1.0 + numbers.restitution) * approach * nx
            v += (1.0 + numbers.restitution) * approach * ny
            w += (1.0 + numbers.restitution) * approach * nz
    return u, v, w


@kernel
def is_inside_wall_at(i, position, solid, near, numbers):
    """Return whether particle i is where a wall particle of the second layer or deeper stands."""
    for k in range(near.wall_count[i]):
        j = near.wall[i, k]
        if solid.depth[j] > numbers.spacing:
            dx, dy, dz = separation(i, j, position, solid.position, near)
            if max(abs(dx), abs(dy), abs(dz)) < 0.5 * numbers.spacing:
                return True
    return False


@loop
def find_inside_walls(position, solid, near, numbers, inside):
    """Write which fluid particles went into a wall, (n,) bool array."""
    for i in prange(inside.size):
        inside[i] = is_inside_wall_at(i, position, solid, near, numbers)


@loop
def advance_velocity(dt, fluid, solid, near, numbers, velocity):
    """Write the velocity of every fluid particle after a time step, (n, 3) float64 array, m/s."""
    for i in prange(velocity.shape[0]):
        ax, ay, az, cx, cy, cz = acceleration_at(i, fluid, solid, near, numbers)
        u = fluid.velocity[i, 0] + dt * ax + cx
        v = fluid.velocity[i, 1] + dt * ay + cy
        w = fluid.velocity[i, 2] + dt * az + cz
        u, v, w = bounce_at(i, u, v, w, fluid, solid, near, numbers)
        velocity[i, 0] = u
        velocity[i, 1] = v
        velocity[i, 2] = w


@loop
def move(dt, velocity, position):
    """Move every particle by its velocity."""
    for i in prange(velocity.shape[0]):
        for k in range(3):
            position[i, k] += dt * velocity[i, k]


@loop
def survey_motion(position, velocity, lower, upper, fastest, outside):
    """Write, of each block of particles, the greatest squared speed and how many are outside.

    Outside the box from ``lower`` to ``upper``; a velocity that is not finite is infinitely fast.
    """
    n = velocity.shape[0]
    for block in prange(fastest.size):
        most, left = 0.0, 0
        for i in range(block * n // fastest.size, (block + 1) * n // fastest.size):
            square = velocity[i, 0] ** 2 + velocity[i, 1] ** 2 + velocity[i, 2] ** 2
            most = max(most, square if square < np.inf else np.inf)
            for k in range(3):
                left += position[i, k] < lower[k] or position[i, k] > upper[k]
        fastest[block] = most
        outside[block] = left
