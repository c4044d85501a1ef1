"""Effective pressure between the grains of a bed: the static balance of their buoyant weight.

    sum of a_ij [ (p_j - p_i) - b_ij . r_ij ] = 0,   a_ij = (d0 / r)^3,
    b_ij = (C_i + C_j)/2 (rho_s - rho_l) g

Every linear pressure solves it exactly on any arrangement of particles; neither the time step nor
the velocity enters, so the result carries no noise of the flow, and water above the bed adds
nothing.  C is that at the level of the particle; p = 0 where it is less than the least.  It takes
the pores as drained: no excess pore pressure, no dilatancy.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, fluid_pair, is_inside, weight


@kernel
def balance_weight(inverse, near):
    """Return ``a = (d0 / r)^3``, the weight of a pair in the balance; 0 beyond r_e."""
    return is_inside(weight(inverse, near)) * (near.spacing * inverse) ** 3


@kernel
def covered_depth_at(i, gravity, near):
    """Return what a free-surface particle has to carry of the rows above its center, m.

    Half of its own row, and what its row lies nearer than d0 to the row below: where the pressure
    of the fluid lets the uppermost row sink, that much of the weight would be missing in every row
    below.

    Along gravity, since the normal of a row as uneven as that of a bed is known to some ten degrees
    only, and loads along it come out a third of a row too small.  On an even surface at an angle
    theta this is ``1.5 d0 (1 - cos theta)`` too much, 0.05 d0 at 15 degrees.
    """
    d0 = near.spacing
    g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
    nearest = d0
    if g > 0.0:
        for k in range(near.fluid_count[i]):
            j, dx, dy, dz, inverse = fluid_pair(i, k, near)
            below = (gravity[0] * dx + gravity[1] * dy + gravity[2] * dz) / g
            if j < near.supply_from and below * inverse > 0.7:
                nearest = min(nearest, below)
    return 1.5 * d0 - nearest


@kernel
def _carried_depths(first, last, gravity, chosen, near, depth):
    for i in range(first, last):
        depth[i] = covered_depth_at(i, gravity, near) if chosen[i] else 0.0


@loop
def carried_depths(gravity, chosen, near, depth):
    """Write :func:`covered_depth_at` of the chosen particles, m, and 0 of all others."""
    for block in prange((depth.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, depth.size)
        _carried_depths(first, last, gravity, chosen, near, depth)


@kernel
def _couple_grains(first, last, near, c, gravity, couplings, right):
    for i in range(first, last):
        diagonal, pushed = 0.0, 0.0
        for k in range(near.fluid_count[i]):
            j, dx, dy, dz, inverse = fluid_pair(i, k, near)
            couplings.value[i, k] = np.float32(balance_weight(inverse, near))
            diagonal += couplings.value[i, k]
            fall = gravity[0] * dx + gravity[1] * dy + gravity[2] * dz
            pushed -= couplings.value[i, k] * 0.5 * (c[i] + c[j]) * fall
        couplings.diagonal[i] = max(diagonal, 1e-6)
        right[i, 0] = pushed


@loop
def couple_grains(near, c, submerged_gravity, couplings, right):
    """Write the static balance, and its right side, (n, 1) float64 array.

    Walls are left out: a linear pressure satisfies the balance of a row without them as well.
    On the free surface of a bed p is given: the weight of half a row and of what that row has sunk.

    Parameters
    ----------
    near : Near
    c : (n,) float64 array
        Concentration at the level of the particle.
    submerged_gravity : (3,) float64 array, N/m3
        ``(rho_s - rho_l) g``.
    couplings : Couplings
    right : (n, 1) float64 array, Pa
    """
    n = couplings.diagonal.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _couple_grains(first, last, near, c, submerged_gravity, couplings, right)
