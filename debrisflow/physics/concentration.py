"""Local concentration of sediment: around a particle, and at its level."""

from __future__ import annotations

from numba import prange

from debrisflow._jit import kernel, loop
from debrisflow.neighbors.pairs import BLOCK, fluid_pair, weight

SELF_WEIGHT = 2.0  # of a particle in its own mean


@kernel
def concentrations_at(i, fraction, level, down, near):
    """Return the share of sediment around particle i and that at its level.

        C = (2 f_i + sum of w f_j) / (2 + sum of w)

    and the same of ``level`` with the weights ``w sin^2``, of the angle between the way to the
    neighbor and ``down``, the unit vector of gravity, which may be zero.  Supply counts, walls and
    air do not.

    C at the level of a particle decides where grains touch and what they weigh.  C itself, a mean
    over the whole influence radius, goes over from a bed to the water on it within three rows, and
    at a free surface knows of one side only: a row of water on a bed has more than half of the
    bed's concentration, would have its strength and stick to it.  At its own level the change
    takes one row to either side of the surface, under deep water, a film or none.

    Parameters
    ----------
    i : int
    fraction, level : (n,) float64 array
        At first the volume of sediment in the particles; the means of the first pass in a second,
        which smooths them.
    down : (3,) float64 array
    near : Near
    """
    total, share = SELF_WEIGHT, SELF_WEIGHT * fraction[i]
    level_total, level_share = SELF_WEIGHT, SELF_WEIGHT * level[i]
    for k in range(near.fluid_count[i]):
        j, dx, dy, dz, inverse = fluid_pair(i, k, near)
        w = weight(inverse, near)
        below = inverse * (down[0] * dx + down[1] * dy + down[2] * dz)
        aside = w * (1.0 - below * below)
        total, share = total + w, share + w * fraction[j]
        level_total, level_share = level_total + aside, level_share + aside * level[j]
    return share / total, level_share / level_total


@kernel
def _concentrations(first, last, fraction, level, down, near, around, at_level):
    for i in range(first, last):
        around[i], at_level[i] = concentrations_at(i, fraction, level, down, near)


@loop
def concentrations(fraction, level, down, near, around, at_level):
    """Write :func:`concentrations_at` of every particle, (n,) float64 arrays."""
    for block in prange((around.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, around.size)
        _concentrations(first, last, fraction, level, down, near, around, at_level)
