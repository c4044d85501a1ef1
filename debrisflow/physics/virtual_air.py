"""Virtual air: what particles at a free surface miss counts as neighbors of no pressure.

So every wet particle is an unknown of the pressure equation, also one of a jet or film as thin as
a particle.  With p = 0 at the particles of the surface, half a spacing inside the fluid, nothing
but collisions would carry these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel
from debrisflow.neighbors.lattice import Reference

FROM, WIDTH = 0.05, 0.05
"""Asymmetry over n0 from which air counts, and over which it comes to count fully."""
SPARSE = 0.85
"""n/n0 below which it counts whatever the asymmetry, fully within the same width."""


class VirtualAir(NamedTuple):
    """The missing neighbors of a particle at the surface, as particles of air with p = 0.

    Attributes
    ----------
    lower, upper, asymmetry : float
        As of :class:`FreeSurface`, by which the surface is shown.
    linear, square : float
        Factors of ``L = max(1 - n/n0, 0)`` and of its square in what the air adds to the diagonal
        of the pressure equation, see :func:`missing`.
    """

    lower: float
    upper: float
    asymmetry: float
    linear: float
    square: float


def virtual_air(lattice: Reference, factor: float) -> VirtualAir:
    """Return the air that is exact under a flat surface.

    There a row at the depth d_k lacks the rows at the heights d_j over the surface, whose pressure
    would be ``-p_k d_j / d_k``, so that air adds ``sum of (1 + d_j / d_k) A_j`` to its diagonal.
    a L + b L^2 is that in the first two rows, or a L in the first one where b would be negative.

    Parameters
    ----------
    lattice : Reference
    factor : float
        Of ``r_e / r^3`` in the coefficients A of the pressure equation.
    """
    radius = lattice.effective_radius / lattice.spacing
    deficits, wanted = np.zeros(2), np.zeros(2)
    along = np.arange(-int(radius), int(radius) + 1)
    for k in range(2):
        for beyond in range(int(radius) + 1):
            r = np.hypot(along, k + 1.0 + beyond)
            r = r[r < radius]
            deficits[k] += np.sum(radius / r - 1.0) / lattice.number_density
            share = 1.0 + (beyond + 0.5) / (k + 0.5)
            wanted[k] += factor * share * np.sum(radius / r**3) / lattice.spacing**2
    linear, square = wanted[0] / deficits[0], 0.0
    if deficits[1] > 0.0:
        rows = deficits[:, None]
        both = np.linalg.solve(np.hstack([rows, rows**2]), wanted)
        linear, square = both if both[1] > 0.0 else (linear, 0.0)
    return VirtualAir(0.8, 0.97, 0.1, float(linear), float(square))


@kernel
def gate(ratio, asymmetry):
    """Return how far air counts, 0 to 1.

    Examples
    --------
    >>> gate(0.96, 0.01), gate(0.96, 0.2), gate(0.5, 0.0)
    (0.0, 1.0, 1.0)
    """
    there = max((asymmetry - FROM) / WIDTH, (SPARSE - ratio) / WIDTH)
    return min(max(there, 0.0), 1.0)


@kernel
def is_given(on_free_surface, surface):
    """Return that no pressure is given."""
    return False


@kernel
def density_error(ratio, asymmetry, surface):
    """Return ``n/n0 - 1``; what air makes it too small does not count."""
    error = ratio - 1.0
    return error if error > 0.0 else (1.0 - gate(ratio, asymmetry)) * error


@kernel
def missing(ratio, asymmetry, surface):
    """Return what virtual air adds to the diagonal of the pressure equation, times rho, 1/m2.

    From n, since the sum of ``r_e / r^3`` that is missing would flicker.
    """
    lacking = max(1.0 - ratio, 0.0)
    return gate(ratio, asymmetry) * lacking * (surface.linear + surface.square * lacking)
