"""Gravity in the axes of a case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase

Floats = NDArray[np.float64]


def gravity_vector(case: ResolvedCase) -> Floats:
    """Return the acceleration of gravity in the axes of the case, (3,) float64 array, m/s2.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> from debrisflow.case.tables import Gravity
    >>> gravity = Gravity(acceleration=10.0, slope=30.0)
    >>> gravity_vector(Case(gravity=gravity, dimension=2)).round(3)
    array([ 5.  , -8.66,  0.  ])
    """
    along, upward = case.gravity.components
    return np.array([along, 0.0, upward] if case.dimension == 3 else [along, upward, 0.0])
