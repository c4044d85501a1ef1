"""Drag between water and grains."""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import kernel


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
    grain_density : float, kg/m3
    packing_limit : float
        Concentrations are taken no greater.
    """

    ergun_from: float
    diameter: float
    density: float
    viscosity: float
    grain_density: float
    packing_limit: float


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
