"""The half spaces of three dimensions and the half planes of two, by one name.

Lengths are in spacings; see :mod:`debrisflow.neighbors.half_space` and
:mod:`debrisflow.neighbors.half_plane`.
"""

from __future__ import annotations

from typing import NamedTuple

from debrisflow._jit import kernel
from debrisflow.neighbors import half_plane, half_space


class Beyond(NamedTuple):
    """What kind of solid lies beyond a face, whose sums the functions here return.

    Attributes
    ----------
    radius : float
        R, in spacings.
    dimension : float
        Ds.
    """

    radius: float
    dimension: float


@kernel
def stretched(q, beyond):
    """Return a distance as the sums see it; in two dimensions it is the true one."""
    return q if beyond.dimension < 3.0 else half_space.STRETCH * q


@kernel
def seen_distance(q, beyond):
    """Return the distance at which the sums see a face that is at a distance q."""
    if beyond.dimension < 3.0:
        return q
    return half_space.STRETCH * (q + half_space.PULLED_BACK)


@kernel
def push_beyond(q, beyond):
    """Return the sum of ``w r_n / r^2`` over the solid."""
    if beyond.dimension < 3.0:
        return half_plane.push_beyond(q, beyond.radius)
    return half_space.push_beyond(q, beyond.radius)


@kernel
def across_beyond(q, beyond):
    """Return the sum of ``w r_n^2 / r^2`` over the solid."""
    if beyond.dimension < 3.0:
        return half_plane.across_beyond(q, beyond.radius)
    return half_space.across_beyond(q, beyond.radius)


@kernel
def along_beyond(q, beyond):
    """Return the sum of ``w r_t^2 / r^2`` along a tangent over the solid."""
    if beyond.dimension < 3.0:
        return half_plane.along_beyond(q, beyond.radius)
    return half_space.along_beyond(q, beyond.radius)


@kernel
def flux_beyond(q, beyond):
    """Return the sum of ``R r_n / r^3`` over the solid."""
    if beyond.dimension < 3.0:
        return half_plane.flux_beyond(q, beyond.radius)
    return half_space.flux_beyond(q, beyond.radius)


@kernel
def lever_beyond(q, beyond):
    """Return the sum of ``w r_n`` over the solid."""
    if beyond.dimension < 3.0:
        return half_plane.lever_beyond(q, beyond.radius)
    return half_space.lever_beyond(q, beyond.radius)
