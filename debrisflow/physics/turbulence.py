"""Turbulence: mixing length over a floor, and the law of the wall."""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel

KARMAN = 0.41


@kernel
def mixing_length(limit, height, roughness):
    """Return ``min(l, kappa (y + k_s / 30))``, m, the mixing length at a height y over a floor.

    ``limit`` is the l of the case.  Near a rough floor, where the stress is that on the floor, the
    length makes the profile of :func:`wall_friction`, so that the stress on the floor and that
    within the flow do not depend on the height of the lowest row.  An infinite roughness leaves l
    as it is.

    References
    ----------
    Escudier 1966, The distribution of mixing-length in turbulent flows near walls, Imperial
    College, London (the greatest length).

    Examples
    --------
    >>> mixing_length(0.01, 1.0, 0.03), round(mixing_length(0.01, 0.001, 0.03), 5)
    (0.01, 0.00082)
    """
    return min(limit, KARMAN * (height + roughness / 30.0))


@kernel
def turbulent_viscosity(density, length, shear_rate):
    """Return Prandtl's ``rho l^2 shear_rate``, Pa s."""
    return density * length**2 * shear_rate


@kernel
def wall_friction(height, roughness):
    """Return ``[kappa / ln(1 + 30 y / k_s)]^2``, wall stress over ``rho u^2`` at a height y.

    The law of the wall over a floor of equivalent sand roughness k_s at y > 0, with its origin at
    the height k_s / 30 where the usual form, ``kappa / ln(30 y / k_s)``, has no speed left.  Below
    y = k_s it is an extension that is smooth, not one that is measured.

    Examples
    --------
    >>> round(wall_friction(0.01, 0.001), 5)
    0.00516
    """
    return (KARMAN / np.log(1.0 + 30.0 * height / roughness)) ** 2
