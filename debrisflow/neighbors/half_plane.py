"""Sums over a wall that fills a half plane, in closed form, in two dimensions.

The wall is rows of particles at the depths 1/2, 3/2, ... under its surface, each spread along its
row: the mean over the lattice at all places along the wall, which a particle that slides over it
does not feel.  An integral over the wall, as in :mod:`debrisflow.neighbors.half_space`, would have
sums without bound at the surface.  Lengths are in spacings, q is the distance of the particle to
the surface, R the influence radius, ``w = R / r - 1``, n the direction into the wall.
"""

from __future__ import annotations

import numpy as np

from debrisflow._jit import kernel

FIRST_ROW = 0.5
"""Depth of the first row of a wall under its surface, in spacings."""
NEAREST = 0.1
"""Height over a row, in spacings, below which its sums do not grow."""


@kernel
def _half_length(h, r):
    return np.sqrt(max(r * r - h * h, 0.0))


@kernel
def _first_height(q):
    """Return the height over the first row, held where the particle is in the wall."""
    return max(q + FIRST_ROW, NEAREST)


@kernel
def number_density_beyond(q, r):
    """Return the sum of w, ``2 (R asinh(L/h) - L)`` over rows at h, ``L^2 = R^2 - h^2``.

    Examples
    --------
    >>> round(number_density_beyond(0.5, 3.1), 3)
    6.809
    """
    h, total = _first_height(q), 0.0
    while h < r:
        half = _half_length(h, r)
        total += 2.0 * (r * np.arcsinh(half / h) - half)
        h += 1.0
    return total


@kernel
def lean_beyond(q, r):
    """Return the sum of ``w r_n / r``, ``2 R atan(L/h) - 2 h asinh(L/h)`` over rows at h.

    Examples
    --------
    >>> round(lean_beyond(0.5, 3.1), 2)
    5.51
    """
    h, total = _first_height(q), 0.0
    while h < r:
        half = _half_length(h, r) / h
        total += 2.0 * (r * np.arctan(half) - h * np.arcsinh(half))
        h += 1.0
    return total


@kernel
def push_beyond(q, r):
    """Return the sum of ``w r_n / r^2``, ``2 L/h - 2 atan(L/h)`` over rows at h.

    Examples
    --------
    >>> round(push_beyond(0.5, 3.1), 3)
    4.025
    """
    h, total = _first_height(q), 0.0
    while h < r:
        half = _half_length(h, r) / h
        total += 2.0 * (half - np.arctan(half))
        h += 1.0
    return total


@kernel
def flux_beyond(q, r):
    """Return the sum of ``R r_n / r^3``, ``2 L/h`` over rows at h.

    Examples
    --------
    >>> round(flux_beyond(0.5, 3.1), 2)
    8.76
    """
    h, total = _first_height(q), 0.0
    while h < r:
        total += 2.0 * _half_length(h, r) / h
        h += 1.0
    return total


@kernel
def across_beyond(q, r):
    """Return the sum of ``w r_n^2 / r^2``, h times that of :func:`push_beyond` for each row.

    Along the wall it is what is left of the number density.

    Examples
    --------
    >>> round(across_beyond(0.5, 3.1), 3)
    4.677
    """
    h, total = _first_height(q), 0.0
    while h < r:
        half = _half_length(h, r) / h
        total += 2.0 * h * (half - np.arctan(half))
        h += 1.0
    return total


@kernel
def along_beyond(q, r):
    """Return the sum of ``w r_t^2 / r^2`` along the wall.

    Examples
    --------
    >>> round(along_beyond(0.5, 3.1), 2)
    2.13
    """
    return number_density_beyond(q, r) - across_beyond(q, r)


@kernel
def lever_beyond(q, r):
    """Return the sum of ``w r_n``, h times the number density of each row.

    Examples
    --------
    >>> round(lever_beyond(0.5, 3.1), 3)
    8.377
    """
    h, total = _first_height(q), 0.0
    while h < r:
        half = _half_length(h, r)
        total += 2.0 * h * (r * np.arcsinh(half / h) - half)
        h += 1.0
    return total
