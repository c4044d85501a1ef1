"""Pairs of particles: who is near whom, separation and weight.

Inside kernels stand the paper's letters: ``d0`` particle spacing, ``r_e`` effective radius,
``w = r_e / r - 1`` weight, ``n`` and ``n0`` particle number density and its reference, ``lambda_``
Laplacian coefficient, ``Ds`` dimension, ``dx, dy, dz`` the components of ``r_ij = r_j - r_i``.
Every ``..._at`` function computes the row of one particle and writes nothing else.

Both schemes read pairs through :class:`Near`.  Loops over fluid neighbors have no branch, so that
they vectorize: a listed particle beyond the influence radius has the weight 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
BLOCK = 256
"""Particles of a task in parallel loops.

A fixed number: where a task began and ended, sums over particles and the ends of vectorized loops
would round differently, and the last digit would depend on the number of threads."""


class Near(NamedTuple):
    """Who is near whom, and the lattice by which sums are measured.

    Attributes
    ----------
    position : (n, 3) float64 array, m
        Of fluid and supply, and of the walls behind them where these have rows of their own.
    neighbors : (m, capacity) int32 array
        Neighbors of the first m particles; fluid and supply stand first in a row.
    fluid_count : (m,) int32 array
        Number of neighbors in a row that are fluid or supply.
    wall : (m or fewer, capacity) int32 array or None
        Neighbors among the walls, ``neighbors`` itself; None where walls are surfaces.
    wall_row : (m,) int32 array or None
        Row of ``wall`` that holds the neighbors of a particle.
    wall_start : (m,) int32 array or None
        Place of the first wall in that row.
    wall_count : (m,) int32 array or None
        Number of walls in that row.
    pressed_count : (m,) int32 array or None
        How many of these carry a pressure of their own; they stand first.
    wall_from : int
        What ``wall`` counts from: the number of the first wall particle.
    supply_from : int
        Fluid particles from this one on are supply, which moves at a given velocity.
    period : (2, 3) float64 array, m, 1/m, or None
        Period along each axis and its inverse, 0 where there is none; None where nothing repeats,
        for which kernels are compiled that are a twentieth faster.
    spacing, effective_radius : float, m
        d0 and r_e.
    dimension, number_density : float
        Ds and n0.
    laplacian_lambda : float, m2
        lambda.
    """

    position: Floats
    neighbors: Indices
    fluid_count: Indices
    wall: Indices | None
    wall_row: Indices | None
    wall_start: Indices | None
    wall_count: Indices | None
    pressed_count: Indices | None
    wall_from: int
    supply_from: int
    period: Floats | None
    spacing: float
    effective_radius: float
    dimension: float
    number_density: float
    laplacian_lambda: float


def repeats_of(period: Floats) -> Floats | None:
    """Return periods, (3,) array, m, with their inverses, or None, as :class:`Near` has them."""
    inverse = np.divide(1.0, period, out=np.zeros(3), where=period > 0.0)
    return np.stack([period, inverse]) if period.any() else None


@kernel
def to_nearest_image(dx, dy, dz, period):
    """Return the components of a distance through the nearest image, m."""
    if period is not None:
        dx -= period[0, 0] * np.rint(dx * period[1, 0])
        dy -= period[0, 1] * np.rint(dy * period[1, 1])
        dz -= period[0, 2] * np.rint(dz * period[1, 2])
    return dx, dy, dz


@kernel
def separation(i, j, position, other, period):
    """Return the components of ``r_j - r_i`` through the nearest image, m."""
    dx = other[j, 0] - position[i, 0]
    dy = other[j, 1] - position[i, 1]
    dz = other[j, 2] - position[i, 2]
    return to_nearest_image(dx, dy, dz, period)


@kernel
def inverse_distance(dx, dy, dz, near):
    """Return ``1 / r``; two particles at one place are taken 1e-6 d0 apart, in no direction."""
    r2 = dx * dx + dy * dy + dz * dz
    return 1.0 / np.sqrt(max(r2, 1e-12 * near.spacing * near.spacing))


@kernel
def fluid_pair(i, k, near):
    """Return the number j of fluid neighbor k of particle i, ``r_ij``, m, and ``1 / r``."""
    j = np.uint32(near.neighbors[i, k])
    dx, dy, dz = separation(i, j, near.position, near.position, near.period)
    return j, dx, dy, dz, inverse_distance(dx, dy, dz, near)


@kernel
def weight(inverse, near):
    """Return ``w = r_e / r - 1`` of equation (18), 0 beyond the influence radius.

    References
    ----------
    Koshizuka & Oka 1996, doi:10.13182/NSE96-A24205.
    """
    return max(near.effective_radius * inverse - 1.0, 0.0)


@kernel
def is_inside(weight):
    """Return 1 where a weight says that a pair is within the influence radius, else 0."""
    return 1.0 if weight > 0.0 else 0.0


@kernel
def higher_order_weight(inverse, near):
    """Return ``r_e / r^3``, 1/m2, of the sums of equations (5), (6), (9) and (17); 0 beyond r_e.

    References
    ----------
    Khayyer & Gotoh 2009, doi:10.1016/j.coastaleng.2008.10.004 (5); 2010,
    doi:10.1016/j.apor.2010.01.001 (6).
    """
    return near.effective_radius * is_inside(weight(inverse, near)) * inverse * inverse * inverse


@kernel
def gradient_factor(near):
    """Return ``Ds / n0``, the factor of the sums of equation (4) and equation (14)."""
    return near.dimension / near.number_density


@kernel
def laplacian_factor(near):
    """Return ``2 Ds / (lambda n0)``, 1/m2, the factor of the Laplacian of equation (15)."""
    return 2.0 * near.dimension / (near.laplacian_lambda * near.number_density)


@kernel
def coupling_weight(inverse, near):
    """Return ``(2 Ds/n0) w/r^2``, 1/m2, by which a viscosity couples two particles.

    The sum of ``w/r^2`` times the square of the distance is n, which the scheme keeps near n0.
    That of w alone, as in the usual ``(2 Ds/(lambda n0)) w``, is not that of the lattice once rows
    pass each other: in a film on a slope it was 2.2 % above it, and the stress with it.  Nearer
    than a tenth of a spacing it grows no further, or two particles at one place would outweigh, in
    the last digit, all others.
    """
    inverse = min(inverse, 10.0 / near.spacing)
    return 2.0 * gradient_factor(near) * weight(inverse, near) * inverse * inverse
