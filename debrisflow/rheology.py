"""Apparent viscosity: Newtonian fluid, turbulence, friction of packed grains, drag, rough walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel

KARMAN = 0.41


class Strength(NamedTuple):
    """Coulomb friction of packed grains and turbulence of the flow.

    Attributes
    ----------
    friction : float
        Tangent of the friction angle; 0 switches the friction off.
    mixing_length : float, m
        The greatest, see :func:`mixing_length`.
    ramp_start, ramp_end : float
        Concentrations between which the friction grows from nothing to full.
    smallest_shear_rate : float, 1/s
    largest_viscosity : float, Pa s
    """

    friction: float
    mixing_length: float
    ramp_start: float
    ramp_end: float
    smallest_shear_rate: float
    largest_viscosity: float


class DragLaw(NamedTuple):
    """Drag between water and grains: Wen & Yu, and Ergun in dense mixtures.

    Attributes
    ----------
    ergun_from : float
        Concentration from which Ergun's law holds: 0.2 in Gidaspow's drag, infinite in Wen & Yu's.
    diameter : float, m
        Grain diameter d_m.
    density, viscosity : float, kg/m3, Pa s
        Of water.
    packing_limit : float
        Concentrations are taken no greater.
    """

    ergun_from: float
    diameter: float
    density: float
    viscosity: float
    packing_limit: float


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
def harmonic_mean(a, b):
    """Return ``2 a b / (a + b)``, the viscosity of a plane between two layers.

    Examples
    --------
    >>> harmonic_mean(1.0, 3.0), harmonic_mean(0.0, 0.0)
    (1.5, 0.0)
    """
    total = a + b
    return 2.0 * a * b / total if total > 0.0 else 0.0


@kernel
def frictional_viscosity(pressure, concentration, shear_rate, strength):
    """Return the viscosity of grains that yield at ``p tan(phi)``, Pa s.

    ``R min(tan(phi) p / max(shear_rate, smallest), largest)`` with R the ramp of the
    concentration: sharp yield, very viscous below it.  Pass the pair's mean pressure, which makes
    the strength of the plane between two rows exact.
    """
    ramp = (concentration - strength.ramp_start) / (strength.ramp_end - strength.ramp_start)
    ramp = min(max(ramp, 0.0), 1.0)
    yielding = strength.friction * pressure / max(shear_rate, strength.smallest_shear_rate)
    return ramp * min(yielding, strength.largest_viscosity)


@kernel
def drag_coefficient(c, speed, drag):
    """Return ``K = beta / (C (1 - C))``, kg/(m3 s).

    beta is the force on either phase per unit volume of mixture and slip velocity; divided by the
    shares of both phases it is the coefficient between a volume of sediment and one of water.
    Wen & Yu with the drag coefficient of Schiller & Naumann; Ergun from ``drag.ergun_from`` on.

    Grains of 3 mm settle in water by Wen & Yu at 0.99, 0.94 and 0.88 of the speed of Richardson &
    Zaki at C = 0.1, 0.2 and 0.3.  By Gidaspow, whose change of law suits fine grains, the drag
    jumps by 3.2 at C = 0.2, and the settling speed falls from 0.21 to 0.11 m/s.

    References
    ----------
    Gidaspow 1994, Multiphase Flow and Fluidization, Academic Press; Wen & Yu 1966, Chemical
    Engineering Progress Symposium Series 62; Richardson & Zaki 1954, Transactions of the
    Institution of Chemical Engineers 32.
    """
    c = min(c, drag.packing_limit)
    d, rho, mu = drag.diameter, drag.density, drag.viscosity
    if c > drag.ergun_from:
        return 150.0 * c * mu / ((1.0 - c) ** 2 * d * d) + 1.75 * rho * speed / ((1.0 - c) * d)
    reynolds = (1.0 - c) * rho * speed * d / mu
    if reynolds < 1000.0:
        inertia = 24.0 * mu / ((1.0 - c) * d) * (1.0 + 0.15 * reynolds**0.687)
    else:
        inertia = 0.44 * rho * speed
    return 0.75 * inertia * (1.0 - c) ** -2.65 / d


@kernel
def freedom(value, limit):
    """Return 1, falling linearly from 0.9 of the limit on to 1e-4 at the limit.

    Of the concentration and the packing limit: what the contacts of the grains leave of their slip.

    Examples
    --------
    >>> [round(freedom(c, 0.5), 4) for c in (0.3, 0.45, 0.475, 0.5)]
    [1.0, 1.0, 0.5, 0.0001]
    """
    return min(max(10.0 * (1.0 - value / limit), 1e-4), 1.0)


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
