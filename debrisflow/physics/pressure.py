"""The pressure Poisson equation of the semi-implicit scheme and the correction by its gradient."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.boundary import face_count
from debrisflow.neighbors.pairs import (
    BLOCK,
    fluid_pair,
    gradient_factor,
    higher_order_weight,
    weight,
)
from debrisflow.neighbors.wall_access import (
    own_velocity,
    pressed_count,
    pressed_pair,
    wall_source_at,
)
from debrisflow.physics.free_surface import density_error, is_given, is_on_free_surface, missing
from debrisflow.physics.operators import (
    fluid_gradient_at,
    gradient_at,
    least_neighbor_value_at,
    number_density_at,
)
from debrisflow.physics.wall_push import wall_push_at

DISORDER = 6.0
"""Factor of the disorder term with the sum gradient, see :func:`source_at`."""


class Interface(NamedTuple):
    """Which of the coefficients of :func:`interface_coefficient` act.

    ``Interface(0, 0, 3)`` is the symmetric one, consistent with the flux through the face;
    ``Interface(4, -1, 0)`` is the study's equation (9) in two dimensions.
    """

    own: float
    other: float
    mean: float


class Source(NamedTuple):
    """How the pressure equation sees time, density errors and disorder.

    Attributes
    ----------
    dt : float, s
    density_rate : float, 1/s
        1 / tau: rate at which a density error decays.
    disorder : float
        Factor of the disorder term, 6 for the sum gradient and 0 for others.
    consistency : float
        Factor of the divergence: 1, or the ratio between Laplacian and divergence, by which a step
        projects all of it.
    fall : (3,) float64 array, m/s
        What gravity adds to the velocity in a step.
    """

    dt: float
    density_rate: float
    disorder: float
    consistency: float
    fall: NDArray[np.float64]


def higher_order_factor(dimension: int) -> float:
    """Return the factor of the higher-order Laplacian: 3 in equation (6), 2 in equation (17).

    References
    ----------
    Khayyer & Gotoh 2010, doi:10.1016/j.apor.2010.01.001; 2012.

    Examples
    --------
    >>> higher_order_factor(2), higher_order_factor(3)
    (3.0, 2.0)
    """
    return 5.0 - dimension


def symmetric_interface(dimension: int) -> Interface:
    """Return the coefficient that is consistent with the flux through the face of a pair."""
    return Interface(own=0.0, other=0.0, mean=higher_order_factor(dimension))


def study_interface(dimension: int) -> Interface:
    """Return the coefficient of equation (9): 4 / rho_i - 1 / rho_j, in three dimensions 3.

    It carries the gradient of 1 / rho with the wrong sign; kept as the study's form.
    """
    return Interface(own=1.0 + higher_order_factor(dimension), other=-1.0, mean=0.0)


@kernel
def interface_coefficient(rho_i, rho_j, interface):
    """Return ``own / rho_i + other / rho_j + mean 2 / (rho_i + rho_j)``, m3/kg, of equation (9)."""
    return interface.own / rho_i + interface.other / rho_j + 2.0 * interface.mean / (rho_i + rho_j)


@kernel
def source_sums_at(i, velocity, fall, near, solid):
    """Return what the pressure equation needs of all neighbors of particle i.

    n; the length of ``sum of w r_ij / r``; the divergence ``sum of (r_e / r^3) r_ij . u_ij`` of
    equation (5), 1/s; and ``a . b``, 1/m2, with ``a = sum of r_ij w / r^2`` and ``b = sum of
    r_e r_ij / r^3``, which tells the disorder of the particles.

    References
    ----------
    Khayyer & Gotoh 2009, doi:10.1016/j.coastaleng.2008.10.004.
    """
    u, v, w = own_velocity(i, velocity, near, solid)
    n, divergence = 0.0, 0.0
    x, y, z, ax, ay, az, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        weighed, q = weight(inverse, near), higher_order_weight(inverse, near)
        along, f = weighed * inverse, weighed * inverse * inverse
        du, dv, dw = velocity[j, 0] - u, velocity[j, 1] - v, velocity[j, 2] - w
        n += weighed
        divergence += q * (dx * du + dy * dv + dz * dw)
        x, y, z = x + along * dx, y + along * dy, z + along * dz
        ax, ay, az = ax + f * dx, ay + f * dy, az + f * dz
        bx, by, bz = bx + q * dx, by + q * dy, bz + q * dz
    walls = wall_source_at(i, u, v, w, fall, near, solid)
    n, divergence = n + walls[0], divergence + walls[4]
    x, y, z = x + walls[1], y + walls[2], z + walls[3]
    ax, ay, az = ax + walls[5], ay + walls[6], az + walls[7]
    bx, by, bz = bx + walls[8], by + walls[9], bz + walls[10]
    return n, np.sqrt(x * x + y * y + z * z), divergence, ax * bx + ay * by + az * bz


@kernel
def coefficients_at(i, density, near, solid, interface, system):
    """Write the coefficients of row i; return how many, their sum, and whether fluid is among them.

    The Laplacian of variable density, equation (8), as ``sum of A_ij (p_j - p_i)``:

        A_ij = (r_e / r^3) (own / rho_i + other / rho_j + mean 2 / (rho_i + rho_j))

    Pairs beyond the influence radius have no entry: the solver reads each one many times.
    """
    rho, diagonal, entries, wet = density[i], 0.0, 0, i < near.supply_from
    for k in range(near.fluid_count[i]):
        j, _, _, _, inverse = fluid_pair(i, k, near)
        if near.effective_radius * inverse > 1.0:
            q = higher_order_weight(inverse, near)
            a = q * interface_coefficient(rho, density[j], interface)
            system.columns[i, entries], system.value[i, entries] = j, a
            diagonal += a
            entries += 1
            wet = wet or j < near.supply_from
    for k in range(pressed_count(i, near, solid)):
        j, inverse = pressed_pair(i, k, near, solid)
        if near.effective_radius * inverse > 1.0:
            q = higher_order_weight(inverse, near)
            a = q * interface_coefficient(rho, density[j], interface)
            system.columns[i, entries], system.value[i, entries] = j, a
            diagonal += a
            entries += 1
    return entries, diagonal, wet


@kernel
def source_at(i, velocity, density, near, solid, surface, source, system, n, on_free_surface, air):
    """Write the right side of row i, n_i, and what its disorder adds to the diagonal.

    The pressure equation of a fluid of variable density, equation (7),
    ``div (grad p / rho) = div u* / dt``, discrete:

        (1/n0) sum of A_ij (p_j - p_i)  -  (6 / (n0 rho_i)) a_i . b_i p_i
            = (1/(n0 dt)) [ sum of (r_e / r^3) r_ij . u*_ij - (n - n0) / tau ]

    with ``A_ij = (r_e / r^3) (own / rho_i + other / rho_j + mean 2 / (rho_i + rho_j))``, written
    here times -n0.  Denser than n0 drives the pressure up.  Dummy walls have no row, which makes
    the wall a Neumann boundary; p = 0 on the free surface and on walls that touch no fluid.

    The density error is asked to decay in the time tau, whatever the step: a share of it in every
    step would throw the fluid whenever a step is shorter than the others.

    The second term on the left is ours.  Where the particles are not on a lattice the sum gradient
    pushes by ``2 p_i a_i``, ``a_i = (Ds/n0) sum of r_ij w / r^2``, and spreads them: the divergence
    of that push is about ``-4 p_i a_i . b_i / n0``, ``b_i = sum of r_e r_ij / r^3``, on average
    over the fluid.  An equation that does not know of it overshoots by the disorder squared times
    the square of the rows of particles between surface and floor; from about 100 rows on the
    pressure alternates between steps and a dam break gains energy.  6 is 4 times the ratio 3/2
    between the Laplacian and the divergence.

    On the lattice the Laplacian (HL) of r^2 is 7.4265 (2D, r_e = 3.1 d0), 8.5048 (2D, 2.1), 6.910
    (3D, 2.4) or 6.439 (3D, 2.1) instead of 2 Ds, and the divergence (HS) of r 2.4755, 2.8349, 3.455
    or 3.219 instead of Ds: only their ratio counts.  It is 2/3 of the exact one in two dimensions
    and 1 in three, so that in two dimensions a step projects 2/3 of the divergence, unless
    ``consistency`` makes up for it.

    References
    ----------
    Khayyer & Gotoh 2009, doi:10.1016/j.coastaleng.2008.10.004 (source); 2010,
    doi:10.1016/j.apor.2010.01.001 (Laplacian).
    """
    n0 = near.number_density
    n[i], asymmetry, divergence, disorder = source_sums_at(i, velocity, source.fall, near, solid)
    ratio, asymmetry = n[i] / n0, asymmetry / n0
    on_free_surface[i] = is_on_free_surface(ratio, asymmetry, surface)
    error = n0 * density_error(ratio, asymmetry, surface)
    system.right[i] = (source.density_rate * error - source.consistency * divergence) / source.dt
    air[i] = missing(ratio, asymmetry, surface)
    system.diagonal[i] = air[i] / density[i]
    if i < near.supply_from and n[i] > surface.upper * n0:
        # near the surface the sums lack neighbors and do not tell disorder
        spread = gradient_factor(near) * disorder
        system.diagonal[i] += source.disorder * max(spread, 0.0) / density[i]


@kernel
def left_side_at(i, density, near, solid, surface, interface, system, on_free_surface):
    """Write the left side of row i after :func:`source_at`; p = 0 where it is given."""
    entries, diagonal, wet = coefficients_at(i, density, near, solid, interface, system)
    if is_given(on_free_surface[i], surface) or not wet or diagonal <= 0.0:
        system.entries[i], system.diagonal[i], system.right[i] = 0, 1.0, 0.0
    else:
        system.entries[i] = entries
        system.diagonal[i] += diagonal


@kernel
def _assemble(
    first,
    last,
    velocity,
    density,
    near,
    solid,
    surface,
    interface,
    source,
    system,
    n,
    on_surface,
    air,
):
    # in two loops, which together take two thirds of the time of one: fewer sums at a time
    for i in range(first, last):
        source_at(i, velocity, density, near, solid, surface, source, system, n, on_surface, air)
    for i in range(first, last):
        left_side_at(i, density, near, solid, surface, interface, system, on_surface)


@kernel
def _find_free_surface(first, last, near, solid, surface, n, on_free_surface):
    for i in range(first, last):
        n0 = near.number_density
        n[i], asymmetry = number_density_at(i, near, solid)
        on_free_surface[i] = is_on_free_surface(n[i] / n0, asymmetry / n0, surface)


@loop
def find_free_surface(near, solid, surface, n, on_free_surface):
    """Write number density and free surface of every unknown, as :func:`assemble` does."""
    for block in prange((n.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n.size)
        _find_free_surface(first, last, near, solid, surface, n, on_free_surface)


@loop
def assemble(
    velocity, density, near, solid, surface, interface, source, system, n, on_free_surface, air
):
    """Write the pressure equation, number density and free surface of every unknown.

    Parameters
    ----------
    velocity, density : (moving particles, 3), (n,) float64 array, m/s, kg/m3
    near : Near
    solid : Solid or Boundary
    surface : FreeSurface or VirtualAir
    interface : Interface
    source : Source
    system : System
    n, on_free_surface, air : (m,) float64, bool, float64 array, -, -, 1/m2
        Written, as the system is; the last one is :func:`debrisflow.physics.free_surface.missing`.
    """
    rows = system.entries.size
    for block in prange((rows + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, rows)
        _assemble(
            first,
            last,
            velocity,
            density,
            near,
            solid,
            surface,
            interface,
            source,
            system,
            n,
            on_free_surface,
            air,
        )


@kernel
def _correct(first, last, dt, pressure, density, with_walls, near, solid, velocity):
    for i in range(first, last):
        x, y, z = gradient_at(i, pressure, with_walls, near, solid)
        velocity[i, 0] -= dt * x / density[i]
        velocity[i, 1] -= dt * y / density[i]
        velocity[i, 2] -= dt * z / density[i]


@loop
def correct(dt, pressure, density, with_walls, near, solid, velocity):
    """Subtract ``dt grad p / rho`` from the velocity of the first ``velocity.shape[0]`` particles.

    With the pressure and ``with_walls`` it is the conservative sum form, in which dummy walls take
    the pressure of the particle that looks at them.  With ``p - p_min`` and without walls it is
    the study's equation (4), ``(p_i + p_j) - (p_min_i + p_min_j)``, which is not consistent: on a
    lattice the sum of a linear field is zero.

    References
    ----------
    Khayyer & Gotoh 2008, doi:10.1142/S0578563408001788.
    """
    n = velocity.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _correct(first, last, dt, pressure, density, with_walls, near, solid, velocity)


@kernel
def _correct_before_surfaces(first, last, dt, pressure, density, g, near, solid, velocity, push):
    for i in range(first, last):
        x, y, z = fluid_gradient_at(i, pressure, near)
        push[i, 0], push[i, 1], push[i, 2] = 0.0, 0.0, 0.0
        per = 1.0 / density[i]
        if face_count(i, solid) > 0:
            a, b, c = velocity[i, 0] / dt, velocity[i, 1] / dt, velocity[i, 2] / dt
            u, v, w = wall_push_at(i, pressure, density[i], g, a, b, c, 1.0 / dt, near, solid)
            push[i, 0], push[i, 1], push[i, 2] = per * u, per * v, per * w
        velocity[i, 0] += dt * (push[i, 0] - per * x)
        velocity[i, 1] += dt * (push[i, 1] - per * y)
        velocity[i, 2] += dt * (push[i, 2] - per * z)


@loop
def correct_before_surfaces(dt, pressure, density, gravity, near, solid, velocity, push):
    """Subtract ``dt grad p / rho`` from the velocity of the fluid particles before surfaces.

    The conservative sum form over the fluid, and what the walls push the particles by,
    :func:`debrisflow.physics.wall_push.wall_push_at`, which is written too, (n, 3) float64 array,
    m/s2.
    """
    n = velocity.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _correct_before_surfaces(
            first, last, dt, pressure, density, gravity, near, solid, velocity, push
        )


@kernel
def _least_pressure(first, last, pressure, near, solid, least):
    for i in range(first, last):
        least[i] = least_neighbor_value_at(i, pressure, near, solid)


@loop
def least_pressure(pressure, near, solid, least):
    """Write the least pressure among each unknown and its neighbors, (m,) float64 array, Pa."""
    n = least.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _least_pressure(first, last, pressure, near, solid, least)
