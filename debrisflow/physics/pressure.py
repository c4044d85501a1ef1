"""The pressure Poisson equation of the semi-implicit scheme and the correction by its gradient."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.physics.operators import gradient_at, least_neighbor_value_at

Floats = NDArray[np.float64]


class FreeSurface(NamedTuple):
    """When a particle is on the free surface: n < lower n0, or n < upper n0 and asymmetric.

    The study takes n < 0.97 n0 alone, which flickers inside the fluid; asking for the asymmetry
    ``|sum of w r_ij / r| > asymmetry n0`` as well keeps the pressure of the interior, and the
    first clause keeps an isolated particle from being an unknown of its own.
    """

    lower: float
    upper: float
    asymmetry: float


class Interface(NamedTuple):
    """Coefficient of the pressure equation: own / rho_i + other / rho_j + mean * 2/(rho_i + rho_j).

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
    """

    dt: float
    density_rate: float
    disorder: float


@kernel
def pressure_row_at(i, fluid_count, velocity, density, stencil, surface, interface, source, system):
    """Write row i of the pressure equation and return n_i and whether i is on the free surface.

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
    or 3.219 instead of Ds: only their ratio counts, 2/3 of the exact one in two dimensions and 1 in
    three, so that in two dimensions a step projects 2/3 of the divergence.

    References
    ----------
    Khayyer & Gotoh 2009, doi:10.1016/j.coastaleng.2008.10.004 (source); 2010,
    doi:10.1016/j.apor.2010.01.001 (Laplacian).
    """
    r_e, n0 = stencil.effective_radius, stencil.number_density
    n, divergence, diagonal = 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    ax, ay, az = 0.0, 0.0, 0.0
    bx, by, bz = 0.0, 0.0, 0.0
    u, v, w_ = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    wet = i < fluid_count
    mine = interface.own / density[i]
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        dx, dy, dz = stencil.dx[i, k], stencil.dy[i, k], stencil.dz[i, k]
        inverse = stencil.inverse[i, k]
        w = r_e * inverse - 1.0
        n += w
        x += w * dx * inverse
        y += w * dy * inverse
        z += w * dz * inverse
        f = w * inverse * inverse
        ax += f * dx
        ay += f * dy
        az += f * dz
        q = r_e * inverse * inverse * inverse
        bx += q * dx
        by += q * dy
        bz += q * dz
        divergence += q * (
            dx * (velocity[j, 0] - u) + dy * (velocity[j, 1] - v) + dz * (velocity[j, 2] - w_)
        )
    for k in range(stencil.unknown_count[i]):
        j = stencil.neighbors[i, k]
        wet = wet or j < fluid_count
        a = r_e * stencil.inverse[i, k] ** 3
        a *= mine + interface.other / density[j] + interface.mean * 2.0 / (density[i] + density[j])
        diagonal += a
        system.value[i, k] = a
    asymmetric = np.sqrt(x * x + y * y + z * z) > surface.asymmetry * n0
    on_surface = n < surface.lower * n0 or (n < surface.upper * n0 and asymmetric)
    if on_surface or not wet or diagonal <= 0.0:
        system.entries[i] = 0
        system.diagonal[i] = 1.0
        system.right[i] = 0.0
    else:
        if i < fluid_count and n > surface.upper * n0:
            # near the surface the sums lack neighbors and do not tell disorder
            spread = stencil.dimension / n0 * (ax * bx + ay * by + az * bz)
            diagonal += source.disorder * max(spread, 0.0) / density[i]
        system.entries[i] = stencil.unknown_count[i]
        system.diagonal[i] = diagonal
        system.right[i] = (source.density_rate * (n - n0) - divergence) / source.dt
    return n, on_surface


@loop
def assemble(
    fluid_count, velocity, density, stencil, surface, interface, source, system, n, on_surface
):
    """Write the pressure equation, number density and free surface of every unknown.

    The system must take its columns from the stencil's neighbors.
    """
    for i in prange(system.entries.size):
        n[i], on_surface[i] = pressure_row_at(
            i, fluid_count, velocity, density, stencil, surface, interface, source, system
        )


@loop
def correct(dt, pressure, density, with_walls, stencil, velocity):
    """Subtract ``dt grad p / rho`` from the velocity of the first ``velocity.shape[0]`` particles.

    With the pressure and ``with_walls`` it is the conservative sum form, in which dummy walls take
    the pressure of the particle that looks at them.  With ``p - p_min`` and without walls it is
    the study's equation (4), ``(p_i + p_j) - (p_min_i + p_min_j)``, which is not consistent: on a
    lattice the sum of a linear field is zero.

    References
    ----------
    Khayyer & Gotoh 2008, doi:10.1142/S0578563408001788.
    """
    for i in prange(velocity.shape[0]):
        x, y, z = gradient_at(i, pressure, with_walls, stencil)
        velocity[i, 0] -= dt * x / density[i]
        velocity[i, 1] -= dt * y / density[i]
        velocity[i, 2] -= dt * z / density[i]


@loop
def least_pressure(pressure, stencil, least):
    """Write the least pressure among each unknown and its neighbors, (m,) float64 array, Pa."""
    for i in prange(least.size):
        least[i] = least_neighbor_value_at(i, pressure, stencil)
