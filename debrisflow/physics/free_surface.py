"""Where the free surface is, and how the pressure equation closes there.

Two rules, each a record: p = 0 at the particles of the surface, as in the study, here; or virtual
air, see :mod:`debrisflow.physics.virtual_air`.
"""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import kernel
from debrisflow.dispatch import by_record


class FreeSurface(NamedTuple):
    """When a particle is on the free surface, see :func:`is_on_free_surface`; there p = 0.

    The study takes n < 0.97 n0 alone, which flickers inside the fluid; asking for the asymmetry
    ``|sum of w r_ij / r| > asymmetry n0`` as well keeps the pressure of the interior, and the
    first clause keeps an isolated particle from being an unknown of its own.
    """

    lower: float
    upper: float
    asymmetry: float


@kernel
def is_on_free_surface(ratio, asymmetry, surface):
    """Return whether n/n0 and the asymmetry over n0 are those of the free surface.

    n < lower n0, or n < upper n0 and asymmetric.
    """
    return ratio < surface.lower or (ratio < surface.upper and asymmetry > surface.asymmetry)


@by_record
def is_given(on_free_surface, surface):
    """Return whether the pressure of a particle is 0, since it is on the free surface."""
    return on_free_surface


@by_record
def density_error(ratio, asymmetry, surface):
    """Return ``n/n0 - 1`` as the pressure equation sees it."""
    return ratio - 1.0


@by_record
def missing(ratio, asymmetry, surface):
    """Return what air adds to the diagonal of the pressure equation, times rho, 1/m2: nothing."""
    return 0.0
