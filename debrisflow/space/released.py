"""Where released matter stands: in columns on the ground of a terrain (NumPy only)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.coverage import depth_on
from debrisflow.case.released import depth_at
from debrisflow.case.releases import HydrographRelease
from debrisflow.case.structures import levels_of, plan_of
from debrisflow.errors import CaseError
from debrisflow.space.ground import MassRelease, ground_of, is_taken_out, smooth_surface

Floats = NDArray[np.float64]
LEAST_DISTANCE = 0.45
"""Spacings from the ground, along its normal, of the lowest particle of a column on a slope."""

LEAST_SEEN, PARTS = 0.7, 8
"""Share of the volume that the middles of columns must see, and parts of the side of a column by
which its mean depth is found otherwise."""

FREE = 0.4
"""Spacings from a structure within which no column stands; the others hold its volume."""


class Columns(NamedTuple):
    """Particles in upright columns on the ground, those of a column one after the other.

    Attributes
    ----------
    position : (n, 3) float64 array, m
    above : (n,) float64 array, m
        Height of the column over the center of each.
    """

    position: Floats
    above: Floats


def source_of(case: ResolvedCase) -> Floats:
    """Return the place of the first release, its middle or that of its line, (2,) array, m."""
    first = min(case.release, key=lambda release: release.start)
    if isinstance(first, HydrographRelease):
        return np.asarray(np.mean(first.line, axis=0) - case.terrain.box[:2])
    grid = ground_of(case).grid
    depth = depth_on(first, grid)
    cells = np.argwhere(depth > 0.0)
    middle: Floats = np.average(cells + 0.5, axis=0, weights=depth[depth > 0.0]) * grid.cell
    return middle


def released_depth(case: ResolvedCase) -> Floats:
    """Return the depth of all masses that are released, in the cells of the DEM, m."""
    ground = ground_of(case)
    depth = np.zeros(ground.given.shape)
    for release in case.release:
        if not isinstance(release, HydrographRelease):
            depth += depth_on(release, ground.grid)
    return depth


def columns_of(release: MassRelease, case: ResolvedCase) -> Columns:
    """Return the particles of a released mass, as many as its volume makes.

    Columns stand a spacing apart and are as high as the mass is deep, rounded so that all of them
    together hold its volume to a particle.

    Raises
    ------
    CaseError
        If no column of particles finds room in it.
    """
    d0, ground = case.particles.spacing, ground_of(case)
    depth = depth_on(release, ground.grid)
    volume = float(depth.sum()) * ground.grid.cell**2
    x, y = _middles_over(depth > 0.0, is_taken_out(release), case)
    if is_taken_out(release):
        high = _own_drop(release, x, y, case)
    else:
        high = _depth_of_columns(release, x, y, volume, case)
    inside = (x > 0.0) & (x < case.terrain.length) & (y > 0.0) & (y < case.terrain.width)
    high[~inside | _in_structures(x, y, case)] = 0.0
    if not high.any():
        raise CaseError(
            f"release.{case.release.index(release)}: no column of particles, {d0:g} m wide, stands "
            "in it: it is too narrow, or structures take its place; give smaller particles"
        )
    return stacked(x, y, high, round(volume / d0**3), case)


def _middles_over(
    cells: NDArray[np.bool_], with_margin: bool, case: ResolvedCase
) -> tuple[Floats, Floats]:
    """Return the middles of columns a spacing apart in the box around cells of the DEM, m.

    The margin is a cell of the smooth surface, over which a scar reaches beyond its cells.
    """
    d0, ground = case.particles.spacing, ground_of(case)
    around = ground.surface.width if with_margin else 0.0
    lines = []
    for index in np.nonzero(cells):
        start, end = index.min() * ground.grid.cell, (index.max() + 1) * ground.grid.cell
        first, last = np.floor((start - around) / d0), np.ceil((end + around) / d0)
        lines.append((np.arange(first, last) + 0.5) * d0)
    x, y = np.meshgrid(*lines, indexing="ij")
    return x.ravel(), y.ravel()


def _own_drop(release: MassRelease, x: Floats, y: Floats, case: ResolvedCase) -> Floats:
    """Return the depth of a scar between the smooth surfaces before and after, m.

    Where smoothed scars overlap, all of it belongs to the one that is deepest there.
    """
    ground = ground_of(case)
    masses = [part for part in case.release if not isinstance(part, HydrographRelease)]
    scars = [mass for mass in masses if is_taken_out(mass)]
    drops = [
        smooth_surface(depth_on(scar, ground.grid), ground.grid.cell, ground.surface.width)
        for scar in scars
    ]
    each = np.array([drop.level(x, y) for drop in drops])
    owned = np.argmax(each, axis=0) == scars.index(release)
    return np.where(owned, np.maximum(each.sum(axis=0), 0.0), 0.0)


def _depth_of_columns(
    release: MassRelease, x: Floats, y: Floats, volume: float, case: ResolvedCase
) -> Floats:
    """Return the depth of a mass on the ground in the middles of columns, m.

    Of a mass so narrow that the middles miss much of it, the mean depth of the columns.
    """
    d0, (west, south, *_) = case.particles.spacing, case.terrain.box
    high = depth_at(release, x + west, y + south)
    if high.sum() * d0**2 > LEAST_SEEN * volume:
        return high
    parts = ((np.arange(PARTS) + 0.5) / PARTS - 0.5) * d0
    shifts = [(a, b) for a in parts for b in parts]
    means = np.mean([depth_at(release, x + west + a, y + south + b) for a, b in shifts], axis=0)
    return np.asarray(means)


def _in_structures(x: Floats, y: Floats, case: ResolvedCase) -> NDArray[np.bool_]:
    """Return which places in plan lie in a structure above the ground, or at its face."""
    level, held = ground_of(case).surface.level(x, y), np.zeros(x.shape, dtype=bool)
    for body in case.obstacle:
        if isinstance(body, BoxObstacle | MeshObstacle):
            plan = plan_of(body).buffer(FREE * case.particles.spacing)
            held |= shapely.contains_xy(plan, x, y) & (level < levels_of(body)[1])
    return held


def stacked(x: Floats, y: Floats, high: Floats, count: int, case: ResolvedCase) -> Columns:
    """Return a number of particles in columns at places, (n,) arrays, m, as high as given, m.

    The heights are rounded so that the particles up to each column are right to half a particle.
    """
    d0 = case.particles.spacing
    until = np.floor(np.cumsum(high) * (count / high.sum()) + 0.5).astype(np.int64)
    number = np.diff(until, prepend=0)
    column = np.repeat(np.arange(x.size), number)
    row = np.arange(column.size) - np.repeat(until - number, number)
    level, along, across = ground_of(case).surface.level_and_slope(x, y)
    lowest = np.maximum(0.5, LEAST_DISTANCE * np.sqrt(1.0 + along**2 + across**2)) * d0
    position = np.empty((column.size, 3))
    position[:, 0], position[:, 1] = x[column], y[column]
    position[:, 2] = (level + lowest)[column] + row * d0
    return Columns(position, (number[column] - row - 0.5) * d0)
