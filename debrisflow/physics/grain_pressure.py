"""Effective pressure between the grains of a bed: the static balance of their buoyant weight."""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop


@kernel
def covered_depth_at(i, fluid_count, gravity, stencil):
    """Return what a free-surface particle has to carry of the rows above its center, m.

    Half of its own row, and what its row lies nearer than d0 to the row below: the pressure of the
    fluid lets the uppermost row sink by about a quarter of a spacing, and that much of the weight
    would be missing in every row below.

    Along gravity, since the normal of a row as uneven as that of a bed is known to some ten degrees
    only, and loads along it come out a third of a row too small.  On an even surface at an angle
    theta this is ``1.5 d0 (1 - cos theta)`` too much, 0.05 d0 at 15 degrees.
    """
    d0 = stencil.spacing
    g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
    nearest = d0
    for k in range(stencil.neighbor_count[i]):
        if stencil.neighbors[i, k] >= fluid_count or g == 0.0:
            continue
        below = (
            gravity[0] * stencil.dx[i, k]
            + gravity[1] * stencil.dy[i, k]
            + gravity[2] * stencil.dz[i, k]
        ) / g
        if below * stencil.inverse[i, k] > 0.7:
            nearest = min(nearest, below)
    return 1.5 * d0 - nearest


@kernel
def grain_pressure_row_at(
    i,
    fluid_count,
    c,
    least_concentration,
    on_free_surface,
    submerged_density,
    gravity,
    stencil,
    system,
):
    """Write row i of the static balance of the buoyant grains.

        sum of a_ij [ (p_j - p_i) - b_ij . r_ij ] = 0,   a_ij = r_e d0^2 / r^3,
        b_ij = (C_i + C_j)/2 (rho_s - rho_l) g

    Every linear pressure solves it exactly on any arrangement of particles; neither the time step
    nor the velocity enters, so the result carries no noise of the flow, and water above the bed
    adds nothing.  C is that at the level of the particle; p = 0 where it is less than the least; on
    the free surface of a bed p is the weight of half a row and of what that row has sunk.  Walls
    are natural boundaries: pairs of two wall particles and dummies are left out.
    It takes the pores as drained: no excess pore pressure, no dilatancy.
    """
    is_fluid = i < fluid_count
    system.entries[i] = 0
    system.diagonal[i] = 1.0
    system.right[i] = 0.0
    if is_fluid and c[i] < least_concentration:
        return
    if is_fluid and on_free_surface[i]:
        g = np.sqrt(gravity[0] ** 2 + gravity[1] ** 2 + gravity[2] ** 2)
        depth = covered_depth_at(i, fluid_count, gravity, stencil)
        system.right[i] = c[i] * submerged_density * g * depth
        return
    diagonal, right = 0.0, 0.0
    for k in range(stencil.unknown_count[i]):
        j = stencil.neighbors[i, k]
        system.value[i, k] = 0.0
        if not is_fluid and j >= fluid_count:
            continue
        a = stencil.effective_radius * stencil.spacing**2 * stencil.inverse[i, k] ** 3
        share = c[i] if j >= fluid_count else (c[j] if not is_fluid else 0.5 * (c[i] + c[j]))
        right -= (
            a
            * share
            * submerged_density
            * (
                gravity[0] * stencil.dx[i, k]
                + gravity[1] * stencil.dy[i, k]
                + gravity[2] * stencil.dz[i, k]
            )
        )
        diagonal += a
        system.value[i, k] = a
    if diagonal > 0.0:
        system.entries[i] = stencil.unknown_count[i]
        system.diagonal[i] = diagonal
        system.right[i] = right


@loop
def assemble_grain_pressure(
    fluid_count,
    c,
    least_concentration,
    on_free_surface,
    submerged_density,
    gravity,
    stencil,
    system,
):
    """Write the balance of the buoyant grains for every fluid, inflow and wall particle.

    The system must take its columns from the stencil's neighbors.
    """
    for i in prange(system.entries.size):
        grain_pressure_row_at(
            i,
            fluid_count,
            c,
            least_concentration,
            on_free_surface,
            submerged_density,
            gravity,
            stencil,
            system,
        )
