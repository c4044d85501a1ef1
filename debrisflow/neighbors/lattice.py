"""Reference values of the regular lattice: what number density and Laplacian are measured by.

The weight of the method is ``w(r) = r_e / r - 1`` for ``r < r_e``, else 0.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Reference(NamedTuple):
    """Lattice constants of one influence radius.

    Attributes
    ----------
    dimension : int
        Space dimension Ds, 2 or 3.
    spacing : float
        Particle spacing d0, m.
    effective_radius : float
        Influence radius r_e, m.
    neighbors : int
        Number of lattice points inside the influence radius.
    number_density : float
        n0 = sum of w over the lattice, dimensionless.
    laplacian_lambda : float
        lambda = sum of w r^2 over sum of w, m^2.
    smooth_density : float
        m0 = 1 + sum of W over the lattice, W of :func:`smooth_weight`.
    smooth_steepness : float
        ``d(m / m0) / d(rho / rho0) = sum of -r W' over Ds m0``.
    """

    dimension: int
    spacing: float
    effective_radius: float
    neighbors: int
    number_density: float
    laplacian_lambda: float
    smooth_density: float
    smooth_steepness: float


def smooth_weight(q: Floats) -> Floats:
    """Return ``W = (1 - q)^2``, q = r / r_e below 1, which tells the density with little noise.

    Of particles in disorder ``1 + sum of W`` is 1.7 % less, 0.5 % more, 0.2 % less than on a
    lattice of the same density at r_e = 2.1, 2.4, 3.1 d0, the sum of w 1.7 % less, 1.7 % more,
    0.2 % more.  A fluid whose density follows the sum comes to rest too dense or too loose by that.
    """
    return (1.0 - q) ** 2


def reference(dimension: int, effective_radius: float, spacing: float) -> Reference:
    """Return the lattice constants of an influence radius given in spacings.

    ``n0 = sum of w`` and ``lambda = sum of w r^2 / sum of w``, equation (16).

    Parameters
    ----------
    dimension : int
        Space dimension, 2 or 3.
    effective_radius : float
        Influence radius as a multiple of the spacing.
    spacing : float
        Particle spacing, m.

    Examples
    --------
    >>> r = reference(2, 3.1, 1.0)
    >>> r.neighbors, round(r.number_density, 4), round(r.laplacian_lambda, 4)
    (28, 18.9764, 2.4485)
    """
    reach = range(-int(effective_radius), int(effective_radius) + 1)
    squared = np.array(sorted(sum(k * k for k in p) for p in product(reach, repeat=dimension)))
    r = np.sqrt(squared[(squared > 0) & (squared < effective_radius**2)].astype(float))
    w = effective_radius / r - 1.0
    n0 = float(w.sum())
    q = r / effective_radius
    m0 = 1.0 + float(smooth_weight(q).sum())
    return Reference(
        dimension,
        spacing,
        effective_radius * spacing,
        r.size,
        n0,
        float((w * r**2).sum() / n0) * spacing**2,
        m0,
        float((2.0 * q * (1.0 - q)).sum() / m0) / dimension,
    )
