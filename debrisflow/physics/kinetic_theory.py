"""Kinetic theory of colliding grains: closed forms of equations (10), (11) and (19)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel

Floats = NDArray[np.float64]


class Grains(NamedTuple):
    """What the grain stress needs to know of the sediment.

    Attributes
    ----------
    density : float, kg/m3
        rho_s.
    diameter : float, m
        d_m.
    restitution : float
        e.
    packing_limit : float
        C*.
    largest_concentration : float
        Concentration at which C is clipped, below C*.
    """

    density: float
    diameter: float
    restitution: float
    packing_limit: float
    largest_concentration: float


@allocating_kernel
def radial_distribution(c, packing_limit):
    """Return ``g0 = 1 / (1 - (C / C*)^(1/3))`` of equation (11).

    Ding & Gidaspow (doi:10.1002/aic.690360404) have a factor 3/5 in front, which the study leaves
    out.

    Examples
    --------
    >>> round(radial_distribution(0.5, 0.55), 1)
    32.0
    """
    return 1.0 / (1.0 - (c / packing_limit) ** (1.0 / 3.0))


@kernel
def granular_pressure(c, temperature, grains):
    """Return ``2 rho_s C^2 g0 (1 + e) T``, the isotropic part of equation (10), Pa.

    The kinetic part ``C rho_s T`` is left out, as in the study.
    """
    g0 = radial_distribution(c, grains.packing_limit)
    return 2.0 * grains.density * c * c * g0 * (1.0 + grains.restitution) * temperature


@kernel
def granular_viscosity(c, temperature, grains):
    """Return ``0.8 C^2 d_m rho_s g0 (1 + e) sqrt(T / pi)``, Pa s.

    Half of the factor of S in equation (10) and, in three dimensions, in equation (19), whose bulk
    viscosity acts on ``div v``, which the study takes to be 0: only its own form has it.
    """
    g0 = radial_distribution(c, grains.packing_limit)
    return (
        0.8
        * c
        * c
        * grains.diameter
        * grains.density
        * g0
        * (1.0 + grains.restitution)
        * np.sqrt(temperature / np.pi)
    )


def bulk_viscosity(c: Floats, temperature: Floats, grains: Grains) -> Floats:
    """Return ``4 C^2 d_m rho_s g0 (1 + e) sqrt(T) / (3 sqrt(pi))`` of equation (19), Pa s.

    Parameters
    ----------
    c, temperature : (n,) float64 array, -, m2/s2
    grains : Grains
    """
    clipped = np.minimum(c, grains.largest_concentration)
    g0 = 1.0 / (1.0 - np.cbrt(clipped / grains.packing_limit))
    dense = clipped**2 * grains.diameter * grains.density * g0 * (1.0 + grains.restitution)
    found: Floats = 4.0 / 3.0 * dense * np.sqrt(temperature / np.pi)
    return found


@kernel
def algebraic_temperature(shear_rate, grains):
    """Return ``d_m^2 shear_rate^2 / (15 (1 - e))``: production equals dissipation, m2/s2.

    Independent of the resolution.  In plane shear the stress then has the ratio
    ``tau / p = 0.4 sqrt(15 (1 - e) / pi)``.
    """
    return (grains.diameter * shear_rate) ** 2 / (15.0 * (1.0 - grains.restitution))
