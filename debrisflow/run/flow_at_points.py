"""The flow at given points, from the particles around them (NumPy and SciPy only)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.run.probe import Column
from debrisflow.space.domain import domain

Floats = NDArray[np.float64]
REACH = 2.0  # spacings
WET = 1.0  # spacings; with no particle nearer than this a point is dry
POINTS_AT_ONCE = 20_000  # which bounds the memory
WORST_CONDITION = 1000.0  # of the moments, above which a slope is not told


class Space(NamedTuple):
    """What of a case a flow at points depends on.

    Attributes
    ----------
    dimension : int
    spacing : float, m
    period : (3,) float64 array, m
        0 along axes that do not repeat.
    """

    dimension: int
    spacing: float
    period: Floats


def space_of(case: ResolvedCase) -> Space:
    """Return what of a case a flow at points depends on."""
    return Space(case.dimension, case.particles.spacing, domain(case).period)


def flow_at(points: Floats, state: State, space: Space) -> tuple[NDArray[np.bool_], Floats]:
    """Return which points are wet, and the flow at them.

    The value at a point of the straight line nearest to the particles within two spacings, by
    least squares with the weight ``(1 - r / R)^2``: exact for fields that vary linearly, beside a
    wall and under a surface too.  Where the particles stand in a line or are too few it is their
    weighted mean.

    Parameters
    ----------
    points : (n, 3) float64 array, m
    state : State
    space : Space

    Returns
    -------
    wet : (n,) bool array
        Whether a particle is nearer than a spacing.
    flow : (n, 5) float64 array
        Velocity, m/s, pressure, Pa, and concentration; 0 at dry points.
    """
    p, axes = state.particles, slice(space.dimension)
    row, place = _images(p.position[p.fluid], points, space)
    tree, reach = cKDTree(place[:, axes]), REACH * space.spacing
    wet, flow = np.zeros(len(points), dtype=bool), np.zeros((len(points), 5))
    for first in range(0, len(points), POINTS_AT_ONCE):
        part = slice(first, first + POINTS_AT_ONCE)
        # sorted, so that the order of the sums does not depend on the tree
        near = tree.query_ball_point(points[part, axes], reach, return_sorted=True)
        count = [len(found) for found in near]
        image = np.array([number for found in near for number in found], dtype=np.int64)
        point = np.repeat(np.arange(len(count)), count)
        offset = (place[image, axes] - points[part][point, axes]) / space.spacing
        distance = np.linalg.norm(offset, axis=1)
        nearest = np.full(len(count), np.inf)
        np.minimum.at(nearest, point, distance)
        wet[part] = reached = nearest <= WET
        if not reached.any():
            continue
        kept, number = reached[point], np.cumsum(reached) - 1
        rows = row[image[kept]]
        fields = np.column_stack([p.velocity[rows], p.pressure[rows], p.concentration[rows]])
        weight = np.maximum(1.0 - distance[kept] / REACH, 0.0) ** 2
        flow[part][reached] = _values_at_points(number[point[kept]], offset[kept], weight, fields)
    return wet, flow


def flow_columns(dimension: int) -> tuple[Column, ...]:
    """Return the columns of :func:`flow_rows`."""
    dry = "at this time; nan where it is dry"
    return (
        *(Column(f"velocity_{axis}", "m/s", dry) for axis in "xyz"[:dimension]),
        Column("pressure", "Pa", dry),
        Column("concentration", "", f"volumetric, of sediment, {dry}"),
        Column("wet", "", "1 where a particle is nearer than a spacing, else 0"),
    )


def flow_rows(points: Floats, state: State, space: Space) -> Floats:
    """Return the flow at points, a row each, with the columns of :func:`flow_columns`."""
    wet, flow = flow_at(points, state, space)
    flow[~wet] = np.nan
    return np.column_stack([flow[:, : space.dimension], flow[:, 3:], wet])


def _images(position: Floats, points: Floats, space: Space) -> tuple[NDArray[np.int64], Floats]:
    """Return rows and places of the particles in the box around points, by all their images."""
    reach = REACH * space.spacing
    lower, upper = points.min(axis=0) - reach, points.max(axis=0) + reach
    row, place = np.arange(len(position)), position
    for axis in np.flatnonzero(space.period > 0.0):
        period = space.period[axis]
        first = np.floor((lower[axis] - place[:, axis]) / period) + 1.0  # image above the lower end
        images = 1 + int((upper[axis] - lower[axis]) / period)
        row, place = np.tile(row, images), np.tile(place, (images, 1))
        place[:, axis] += period * (np.tile(first, images) + np.repeat(range(images), first.size))
    for k in range(space.dimension):  # along x first: most are far away
        inside = (place[:, k] >= lower[k]) & (place[:, k] <= upper[k])
        row, place = row[inside], place[inside]
    return row, place


def _values_at_points(
    point: NDArray[np.int64], offset: Floats, weight: Floats, fields: Floats
) -> Floats:
    """Return at each point the value of the nearest linear function of each field.

    Parameters
    ----------
    point : (pairs,) int array
        Number of the point of each pair of a point and a particle; each point has pairs.
    offset : (pairs, D) array
        From the point to the particle, in spacings.
    weight : (pairs,) array
    fields : (pairs, m) array

    Examples
    --------
    >>> offset = np.array([[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [1.5, 0.0]])
    >>> fields = 3.0 + offset @ [[2.0], [1.0]]
    >>> _values_at_points(np.zeros(4, dtype=int), offset, np.ones(4), fields).round(9)
    array([[3.]])
    """
    count = int(point.max(initial=-1)) + 1
    basis = np.column_stack([np.ones(len(offset)), offset])
    moments = _sums(point, weight[:, None, None] * basis[:, :, None] * basis[:, None, :], count)
    products = _sums(point, weight[:, None, None] * basis[:, :, None] * fields[:, None, :], count)
    total = np.maximum(moments[:, 0, 0], np.finfo(float).tiny)
    found = products[:, 0] / total[:, None]
    enough = np.bincount(point, minlength=count) > basis.shape[1] - 1
    with np.errstate(invalid="ignore", divide="ignore"):
        enough &= np.linalg.cond(moments) < WORST_CONDITION
    found[enough] = np.linalg.solve(moments[enough], products[enough])[:, 0]
    return np.asarray(found)


def _sums(point: NDArray[np.int64], values: Floats, count: int) -> Floats:
    """Return the sums of values over the pairs of each point."""
    flat = values.reshape(len(point), -1)
    sums: Floats = np.column_stack([np.bincount(point, column, count) for column in flat.T])
    return np.reshape(sums, (count, *values.shape[1:]))
