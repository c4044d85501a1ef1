"""Sums over a wall that fills a half space, in closed form, in three dimensions.

What lattice particles of a wall would add to a sum over neighbors becomes an integral over the
wall, one particle per cube of a spacing.  Lengths are in spacings, q is the distance of the
particle to the plane, R the influence radius, ``w = R / r - 1``, n the direction into the wall.  A
particle behind the plane, q < 0, sees the rest of the sphere.

The same sums over a lattice of wall particles differ from these by what :data:`STRETCH` makes up
for.
"""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel

PULLED_BACK = 0.0155
"""Spacings by which the solid of the sums lies behind its surface."""
STRETCH = 1.067
"""By how much the sums see the solid farther away than it is.

The integral over a solid is 7 to 10 % more than the sum over the lattice of wall particles for the
first row of fluid before it, and 50 to 60 % more for the second, which sees one row of them where
the integral sees nine tenths of a spacing of solid.  Stretched and pulled back, so that a distance
q counts as 1.067 q + 0.017, N, G and T_n are within 3 % in both rows."""


@kernel
def number_density_beyond(q, r):
    """Return the integral of w, ``pi/3 (R - q)^3``.

    Examples
    --------
    >>> round(number_density_beyond(0.5, 2.4), 3), number_density_beyond(2.4, 2.4)
    (7.183, 0.0)
    """
    rest = max(r - abs(q), 0.0)
    total = np.pi / 3.0 * rest * rest * rest
    return total if q >= 0.0 else 2.0 * np.pi / 3.0 * r * r * r - total


@kernel
def smooth_density_beyond(q, r):
    """Return the integral of ``(1 - r/R)^2``, ``pi R^3/30 (1 - q/R)^4 (2 + 3 q/R)``.

    Examples
    --------
    >>> round(smooth_density_beyond(0.5, 2.4), 3)
    1.493
    """
    part = min(abs(q) / r, 1.0)
    rest = (1.0 - part) * (1.0 - part)
    total = np.pi * r * r * r / 30.0 * rest * rest * (2.0 + 3.0 * part)
    return total if q >= 0.0 else 2.0 * np.pi * r * r * r / 15.0 - total


@kernel
def push_beyond(q, r):
    """Return the integral of ``w r_n / r^2``, ``pi [(R - q)(R - 3q)/2 + q^2 ln(R/q)]``.

    Examples
    --------
    >>> round(push_beyond(0.5, 2.4), 3), round(push_beyond(0.0, 2.0), 3)
    (3.918, 6.283)
    """
    q = abs(q)
    if q >= r:
        return 0.0
    logarithm = q * q * np.log(r / max(q, 1e-9 * r))
    return np.pi * (0.5 * (r - q) * (r - 3.0 * q) + logarithm)


@kernel
def across_beyond(q, r):
    """Return the integral of ``w r_n^2 / r^2``.

    ``pi/9 [R^3 - 9 R q^2 + 8 q^3 + 6 q^3 ln(R/q)]``

    Examples
    --------
    >>> round(across_beyond(0.5, 2.4), 3)
    3.7
    """
    p = min(abs(q), r)
    logarithm = 6.0 * np.log(r / max(p, 1e-9 * r))
    total = np.pi / 9.0 * (r * r * r - 9.0 * r * p * p + p * p * p * (8.0 + logarithm))
    return total if q >= 0.0 else 2.0 * np.pi / 9.0 * r * r * r - total


@kernel
def along_beyond(q, r):
    """Return the integral of ``w r_t^2 / r^2`` along a tangent, half of what is left of N."""
    return 0.5 * (number_density_beyond(q, r) - across_beyond(q, r))


@kernel
def flux_beyond(q, r):
    """Return the integral of ``R r_n / r^3``, ``pi (R - q)^2``.

    Examples
    --------
    >>> round(flux_beyond(0.4, 2.4), 3)
    12.566
    """
    rest = max(r - abs(q), 0.0)
    return np.pi * rest * rest


@kernel
def lever_beyond(q, r):
    """Return the integral of ``w r_n``, ``pi/12 (R - q)^3 (R + 3q)``; q >= 0.

    Examples
    --------
    >>> round(lever_beyond(0.5, 2.4), 3)
    7.003
    """
    rest = max(r - q, 0.0)
    return np.pi / 12.0 * rest * rest * rest * (r + 3.0 * q)


@kernel
def smooth_lever_beyond(q, r):
    """Return the integral of ``(1 - r/R)^2 r_n``, ``pi/60 (R - q)^4 (R^2 + 4 R q + 5 q^2) / R^2``.

    Examples
    --------
    >>> round(smooth_lever_beyond(0.5, 2.4), 3)
    1.399
    """
    rest = max(r - q, 0.0)
    return np.pi / 60.0 * rest**4 * (r * r + 4.0 * r * q + 5.0 * q * q) / (r * r)
