"""Sums over a wall that fills a half space, in closed form, in three dimensions.

What lattice particles of a wall would add to a sum over neighbors becomes an integral over the
wall, one particle per cube of a spacing.  Lengths are in spacings, q is the distance of the
particle to the plane, R the influence radius, ``w = R / r - 1``, n the direction into the wall.  A
particle behind the plane, q < 0, sees the rest of the sphere.

The same sums over a lattice of wall particles differ from these by what
:data:`debrisflow.neighbors.boundary.STRETCH` makes up for.
"""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel


@kernel
def number_density_beyond(q, r):
    """Return the integral of w, ``pi/3 (R - q)^3``.

    Examples
    --------
    >>> round(number_density_beyond(0.5, 2.4), 3), number_density_beyond(2.4, 2.4)
    (7.183, 0.0)
    """
    rest = max(r - abs(q), 0.0)
    beyond = np.pi / 3.0 * rest * rest * rest
    return beyond if q >= 0.0 else 2.0 * np.pi / 3.0 * r * r * r - beyond


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
    beyond = np.pi * r * r * r / 30.0 * rest * rest * (2.0 + 3.0 * part)
    return beyond if q >= 0.0 else 2.0 * np.pi * r * r * r / 15.0 - beyond


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
    """Return the integral of ``w r_n^2 / r^2``; along each tangent it is half of what is left of N.

    ``pi/9 [R^3 - 9 R q^2 + 8 q^3 + 6 q^3 ln(R/q)]``

    Examples
    --------
    >>> round(across_beyond(0.5, 2.4), 3)
    3.7
    """
    p = min(abs(q), r)
    logarithm = 6.0 * np.log(r / max(p, 1e-9 * r))
    beyond = np.pi / 9.0 * (r * r * r - 9.0 * r * p * p + p * p * p * (8.0 + logarithm))
    return beyond if q >= 0.0 else 2.0 * np.pi / 9.0 * r * r * r - beyond


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
