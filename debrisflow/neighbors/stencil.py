"""Pair geometry of one step: who is within the influence radius of whom, and where.

Inside kernels stand the paper's letters: ``d0`` particle spacing, ``r_e`` effective radius,
``w = r_e / r - 1`` weight, ``n`` and ``n0`` particle number density and its reference, ``lambda_``
Laplacian coefficient, ``dx, dy, dz`` the components of ``r_ij = r_j - r_i``.  Every ``..._at``
function computes the row of one particle and writes nothing else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.lattice import Reference
from debrisflow.neighbors.lists import nearest_image

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]


class Stencil(NamedTuple):
    """Who is within the influence radius of whom at this step, and the lattice constants.

    Pair geometry is computed once a step and read by every term.

    Attributes
    ----------
    neighbors : (m, capacity) int32 array
        Neighbors of the first m particles; those that carry a pressure stand first.
    neighbor_count : (m,) int32 array
        Number of neighbors in each row.
    unknown_count : (m,) int32 array
        Number of neighbors in each row that carry a pressure.
    dx, dy, dz : (m, capacity) float64 array, m
        Components of ``r_j - r_i``, through the nearest image where the domain repeats.
    inverse : (m, capacity) float64 array, 1/m
        ``1 / r``.
    wall_from : int
        Particles from this one on are walls.
    dimension : float
        Ds.
    spacing, effective_radius : float, m
        d0 and r_e.
    number_density : float
        n0.
    laplacian_lambda : float, m^2
        lambda.
    """

    neighbors: Indices
    neighbor_count: Indices
    unknown_count: Indices
    dx: Floats
    dy: Floats
    dz: Floats
    inverse: Floats
    wall_from: int
    dimension: float
    spacing: float
    effective_radius: float
    number_density: float
    laplacian_lambda: float


def empty_stencil(rows: int, capacity: int, lattice: Reference) -> Stencil:
    """Return a stencil with room for ``capacity`` neighbors of ``rows`` particles."""
    return Stencil(
        np.zeros((rows, capacity), dtype=np.int32),
        np.zeros(rows, dtype=np.int32),
        np.zeros(rows, dtype=np.int32),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        np.zeros((rows, capacity)),
        rows,
        float(lattice.dimension),
        lattice.spacing,
        lattice.effective_radius,
        lattice.number_density,
        lattice.laplacian_lambda,
    )


@kernel
def survey_at(i, position, period, listed, listed_count, stencil):
    """Write row i of the stencil from the particles listed near i.

    Two particles at one place have no direction: they are kept apart by 1e-6 d0 along x, whose
    sign follows their order, so that the pair stays opposite.
    """
    rows = stencil.neighbor_count.size
    reach2 = stencil.effective_radius**2
    x, y, z = position[i, 0], position[i, 1], position[i, 2]
    found, last = 0, stencil.neighbors.shape[1]
    for k in range(listed_count[i]):
        j = listed[i, k]
        dx = nearest_image(position[j, 0] - x, period[0])
        dy = nearest_image(position[j, 1] - y, period[1])
        dz = nearest_image(position[j, 2] - z, period[2])
        r2 = dx * dx + dy * dy + dz * dz
        if r2 >= reach2:
            continue
        if r2 == 0.0:
            dx = 1e-6 * stencil.spacing if j > i else -1e-6 * stencil.spacing
            r2 = dx * dx
        if j < rows:
            place = found
            found += 1
        else:
            last -= 1
            place = last
        stencil.neighbors[i, place] = j
        stencil.dx[i, place] = dx
        stencil.dy[i, place] = dy
        stencil.dz[i, place] = dz
        stencil.inverse[i, place] = 1.0 / np.sqrt(r2)
    stencil.unknown_count[i] = found
    for place in range(last, stencil.neighbors.shape[1]):
        stencil.neighbors[i, found] = stencil.neighbors[i, place]
        stencil.dx[i, found] = stencil.dx[i, place]
        stencil.dy[i, found] = stencil.dy[i, place]
        stencil.dz[i, found] = stencil.dz[i, place]
        stencil.inverse[i, found] = stencil.inverse[i, place]
        found += 1
    stencil.neighbor_count[i] = found


@loop
def survey(position, period, listed, listed_count, stencil):
    """Write the stencil of the step from the neighbor list."""
    for i in prange(listed_count.size):
        survey_at(i, position, period, listed, listed_count, stencil)
