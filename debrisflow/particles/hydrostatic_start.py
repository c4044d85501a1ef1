"""The start of a weakly compressible fluid: compressed under its own weight, and jittered."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.regions import TOLERANCE
from debrisflow.particles.matter import reference_density
from debrisflow.particles.record import Particles
from debrisflow.space.bodies import in_walls

LARGEST_GAP = 1.5  # spacings between two particles of one column


def compress(particles: Particles, case: ResolvedCase) -> None:
    """Compress columns of fluid that stand on a wall as their weight does; move the particles too.

    At a height z in a column h high, of matter of density rho_m,

        s = g / (rho0 c^2) times the integral of rho_m from z to h,
        z' = the integral of 1 / (1 + s) from 0 to z

    where z' is the height to which it sinks.  With rho_m = rho0 that is s = g (h - z) / c^2 and
    z' = (c^2 / g) ln[(1 + g h / c^2) / (1 + s)].  A column that stands on nothing falls, and is
    left as it is.  Without this start the fluid drops by its compression and swings.

    Parameters
    ----------
    particles : Particles
        On the lattice; changed in place.
    case : ResolvedCase
    """
    fluid, d0, up = particles.fluid, case.particles.spacing, case.dimension - 1
    gradient = max(-case.gravity.components[1], 0.0) / case.explicit_scheme.sound_speed**2
    if gradient == 0.0 or particles.fluid_count == 0:
        return
    cell = np.floor(particles.position / d0).astype(np.int64)
    across = np.delete(cell, up, axis=1)
    order = np.lexsort((particles.position[fluid, up], *across[fluid].T))
    height = particles.position[order, up]
    starts = np.any(np.diff(across[order], axis=0) != 0, axis=1)
    starts |= np.diff(height) > LARGEST_GAP * d0
    first = np.concatenate([[0], np.flatnonzero(starts) + 1])
    column = np.repeat(np.arange(first.size), np.diff(first, append=order.size))
    last = np.append(first[1:], order.size) - 1
    beneath = (cell[order[first]] + 0.5) * d0
    beneath[:, up] -= d0
    # a box off the lattice may end half a spacing below the cells that are cut out for it
    stands = in_walls(case, beneath, slack=TOLERANCE * d0)
    load = gradient * d0 * particles.density[order] / reference_density(case)
    above = np.cumsum(load)
    compression = above[last][column] - above + 0.5 * load
    lower = d0 / load * np.log((1.0 + compression + 0.5 * load) / (1.0 + compression))
    whole = np.cumsum(
        d0 / load * np.log((1.0 + compression + 0.5 * load) / (1.0 + compression - 0.5 * load))
    )
    beneath_first = np.append(0.0, whole)[first]
    settled = np.append(0.0, whole[:-1]) - beneath_first[column] + lower
    moved = stands[column]
    rows = order[moved]
    particles.position[rows, up] = (height[first] - 0.5 * d0)[column][moved] + settled[moved]
    particles.compression[rows] = compression[moved]


def jitter(particles: Particles, case: ResolvedCase) -> None:
    """Move the fluid particles a little at random, so that no symmetry of the lattice survives.

    Parameters
    ----------
    particles : Particles
        Changed in place.
    case : ResolvedCase
    """
    reach = case.explicit_scheme.jitter * case.particles.spacing
    rng = np.random.default_rng(case.particles.seed)
    step = rng.uniform(-reach, reach, (particles.fluid_count, 3))
    particles.position[particles.fluid, : case.dimension] += step[:, : case.dimension]
