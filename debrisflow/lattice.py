"""Reference values of the regular lattice: what number density and Laplacian are measured by.

The weight of the method is ``w(r) = r_e / r - 1`` for ``r < r_e``, else 0.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np


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
    """

    dimension: int
    spacing: float
    effective_radius: float
    neighbors: int
    number_density: float
    laplacian_lambda: float


def reference(dimension: int, effective_radius: float, spacing: float) -> Reference:
    """Return the lattice constants of an influence radius given in spacings.

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
    return Reference(
        dimension,
        spacing,
        effective_radius * spacing,
        r.size,
        n0,
        float((w * r**2).sum() / n0) * spacing**2,
    )
