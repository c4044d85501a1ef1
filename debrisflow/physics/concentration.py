"""Local concentration of sediment, around a particle and at its level."""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop


@kernel
def concentration_at(i, fluid_count, fraction, stencil):
    """Return the weighted share of sediment in reach, the particle itself counted twice."""
    share, total = 2.0 * fraction[i], 2.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count:
            w = stencil.effective_radius * stencil.inverse[i, k] - 1.0
            share += w * fraction[j]
            total += w
    return share / total


@loop
def concentration(fluid_count, fraction, stencil, c):
    """Write the weighted share of ``fraction`` around the first ``fluid_count`` particles.

    Applied to its own result it smooths the concentration.
    """
    for i in prange(fluid_count):
        c[i] = concentration_at(i, fluid_count, fraction, stencil)


@kernel
def level_concentration_at(i, fluid_count, fraction, down, stencil):
    """Return the share of sediment around particle i at its level, i itself counted twice.

    Weights are ``w`` times the square of the sine between the way to the neighbor and ``down``, the
    unit vector of gravity, which may be zero.
    """
    share, total = 2.0 * fraction[i], 2.0
    for k in range(stencil.neighbor_count[i]):
        j = stencil.neighbors[i, k]
        if j < fluid_count:
            inverse = stencil.inverse[i, k]
            below = inverse * (
                down[0] * stencil.dx[i, k] + down[1] * stencil.dy[i, k] + down[2] * stencil.dz[i, k]
            )
            w = (stencil.effective_radius * inverse - 1.0) * (1.0 - below * below)
            share += w * fraction[j]
            total += w
    return share / total


@loop
def level_concentration(fluid_count, fraction, down, stencil, c):
    """Write the share of sediment at the level of every fluid particle.

    It decides where grains touch and what they weigh.  The concentration C, a mean over the whole
    influence radius, goes over from a bed to the water on it within three rows, and at a free
    surface knows of one side only: a row of water on a bed has more than half of the bed's
    concentration, would have its strength and stick to it.  At its own level the change takes one
    row to either side of the surface, under deep water, a film or none.
    """
    for i in prange(fluid_count):
        c[i] = level_concentration_at(i, fluid_count, fraction, down, stencil)
