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
from debrisflow.neighbors.wall_access import wall_pair


@kernel
def balance_weight(inverse, near):
    """Return ``a = (d0 / r)^3``, the weight of a pair in the balance; 0 beyond r_e."""
    return is_inside(weight(inverse, near)) * (near.spacing * inverse) ** 3


@kernel
def covered_depth_at(i, gravity, near):
    """Return what a free-surface particle has to carry of the rows above its center, m.

    Half of its own row, and what its row lies nearer than d0 to the row below: the pressure of the
    fluid lets the uppermost row sink by about a quarter of a spacing, and that much of the weight
    would be missing in every row below.

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
def grain_pressure_row_at(
    i, c, least_concentration, on_free_surface, submerged_density, gravity, near, solid, system
):
    """Write row i of the static balance, with the walls as unknowns of their own.

    On the free surface of a bed p is the weight of half a row and of what that row has sunk.  Walls
    are natural boundaries: pairs of two wall particles, and walls without a row, are left out.
    """
    system.entries[i], system.diagonal[i], system.right[i] = 0, 1.0, 0.0
    if i < near.supply_from:
        if c[i] < least_concentration:
            return
        if on_free_surface[i]:
            g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
            depth = covered_depth_at(i, gravity, near)
            system.right[i] = c[i] * submerged_density * g * depth
            return
    diagonal, right, entries = 0.0, 0.0, 0
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        if i >= near.supply_from and j >= near.supply_from:
            continue
        a = balance_weight(inverse, near)
        share = (
            c[i]
            if j >= near.supply_from
            else (c[j] if i >= near.supply_from else 0.5 * (c[i] + c[j]))
        )
        fall = gravity[0] * dx + gravity[1] * dy + gravity[2] * dz
        right -= a * share * submerged_density * fall
        diagonal += a
        system.columns[i, entries], system.value[i, entries] = j, a
        entries += a > 0.0
    if i < near.supply_from:
        for k in range(near.pressed_count[i]):
            j, dx, dy, dz, inverse = wall_pair(i, k, near, solid)
            a = balance_weight(inverse, near)
            fall = gravity[0] * dx + gravity[1] * dy + gravity[2] * dz
            right -= a * c[i] * submerged_density * fall
            diagonal += a
            system.columns[i, entries], system.value[i, entries] = near.wall_from + j, a
            entries += a > 0.0
    if diagonal > 0.0:
        system.entries[i] = entries
        system.diagonal[i] = diagonal
        system.right[i] = right


@kernel
def _assemble(
    first, last, c, least, on_free_surface, submerged_density, gravity, near, solid, system
):
    for i in range(first, last):
        grain_pressure_row_at(
            i, c, least, on_free_surface, submerged_density, gravity, near, solid, system
        )


@loop
def assemble_grain_pressure(
    c, least_concentration, on_free_surface, submerged_density, gravity, near, solid, system
):
    """Write the balance of the buoyant grains for every fluid, inflow and wall particle."""
    n = system.entries.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _assemble(
            first,
            last,
            c,
            least_concentration,
            on_free_surface,
            submerged_density,
            gravity,
            near,
            solid,
            system,
        )


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
    """Write the static balance over the fluid alone, and its right side, (n, 1) float64 array.

    Walls are left out: the pressure of what the wall would hold is that which the balance asks for.
    """
    n = couplings.diagonal.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _couple_grains(first, last, near, c, submerged_gravity, couplings, right)
