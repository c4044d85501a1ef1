"""The ground of a terrain: a smooth surface over the cells of a DEM, and its zones (NumPy, SciPy).

The level is a quadratic B-spline through means of the DEM over square cells, of which the slope is
continuous; see :mod:`debrisflow.neighbors.height_field`.  Releases that are taken out of the
terrain lower it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.coverage import depth_on, holds_middles
from debrisflow.case.rasters import MapGrid
from debrisflow.case.releases import HydrographRelease, PolygonRelease, RasterRelease, Zone
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.space.domain import FLOOR, first_zone

Floats = NDArray[np.float64]
MassRelease = PolygonRelease | RasterRelease


class Surface(NamedTuple):
    """A smooth surface over the plan; its first cell begins at the origin.

    Attributes
    ----------
    width : float, m
        Of a cell of the spline.
    coefficients : (n, m) float64 array, m
        One a cell, along x and y.
    """

    width: float
    coefficients: Floats

    def level(self, x: Floats, y: Floats) -> Floats:
        """Return the level at places, m."""
        return self.level_and_slope(x, y)[0]

    def level_and_slope(self, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
        """Return level, m, and slope along x and y at places, arrays of one shape."""
        z, along, across = self._derivatives(x, y, ((0, 0), (1, 0), (0, 1)))
        return z, along, across

    def mean_curvature(self, x: Floats, y: Floats) -> Floats:
        """Return the mean curvature at places, 1/m, positive in a valley."""
        orders = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        zx, zy, zxx, zxy, zyy = self._derivatives(x, y, orders)
        bent = (1.0 + zy**2) * zxx - 2.0 * zx * zy * zxy + (1.0 + zx**2) * zyy
        return np.asarray(0.5 * bent / (1.0 + zx**2 + zy**2) ** 1.5)

    def _derivatives(
        self, x: Floats, y: Floats, orders: Sequence[tuple[int, int]]
    ) -> tuple[Floats, ...]:
        """Return derivatives of the level at places, each so often along x and along y."""
        i, p = _cell_and_bases(x, self.width)
        j, q = _cell_and_bases(y, self.width)
        found = np.zeros((len(orders), *np.broadcast(x, y).shape))
        for k, m in np.ndindex(3, 3):
            rows = _mirrored(i + k - 1, self.coefficients.shape[0])
            columns = _mirrored(j + m - 1, self.coefficients.shape[1])
            c = self.coefficients[rows, columns]
            for sums, (a, b) in zip(found, orders, strict=True):
                sums += c * p[a][k] * q[b][m]
        return tuple(
            sums / self.width ** (a + b) for sums, (a, b) in zip(found, orders, strict=True)
        )


class Ground(NamedTuple):
    """The ground of a case.

    Attributes
    ----------
    grid : MapGrid
        The cells of the DEM, cropped.
    given : (columns, rows) float64 array, m
        Levels of the DEM over the origin; nan without data.
    surface, whole : Surface
        What flow runs over, and the surface of the DEM: the same where nothing is taken out.
    number : (columns, rows) int64 array
        Of the wall that the ground is in each cell: the floor, or a zone.
    """

    grid: MapGrid
    given: Floats
    surface: Surface
    whole: Surface
    number: NDArray[np.int64]

    def cells(self, x: Floats, y: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return column and row of the cells that hold places, those at the border beyond it."""
        cell, found = self.grid.cell, []
        for place, count in ((x, self.grid.columns), (y, self.grid.rows)):
            found.append(np.clip(np.floor(place / cell).astype(np.int64), 0, count - 1))
        return found[0], found[1]

    def has_data(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """Return which places lie over cells of the DEM with a level."""
        return np.asarray(np.isfinite(self.given[self.cells(x, y)]))


def smooth_surface(levels: Floats, cell: float, width: float) -> Surface:
    """Return the spline through means of levels, (n, m) array, m, of square cells, m.

    Parameters
    ----------
    levels : (n, m) float64 array, m
        nan where there is none: there the nearest stands for it.
    cell : float, m
        Of the levels.
    width : float, m
        Of a cell of the spline, a multiple of it.

    Examples
    --------
    >>> surface = smooth_surface(np.add.outer(np.arange(0.5, 40.0), np.zeros(6)), 1.0, 2.0)
    >>> level, along, across = surface.level_and_slope(np.array([19.0]), np.array([3.0]))
    >>> print(level.round(6), along.round(3), across.round(3) + 0.0)
    [19.] [1.] [0.]
    """
    from scipy.ndimage import distance_transform_edt, spline_filter

    if np.isnan(levels).any():
        _, nearest = distance_transform_edt(np.isnan(levels), return_indices=True)
        levels = levels[tuple(nearest)]
    times = round(width / cell)
    missing = [(0, -count % times) for count in levels.shape]
    padded = np.pad(levels, missing, mode="edge")
    shape = [part for count in padded.shape for part in (count // times, times)]
    means = padded.reshape(shape).mean(axis=(1, 3))
    coefficients = spline_filter(means, order=2, mode="mirror")
    return Surface(width, np.ascontiguousarray(coefficients))


def _cell_and_bases(
    place: Floats, width: float
) -> tuple[NDArray[np.int64], tuple[tuple[Floats, ...], ...]]:
    """Return the cells of places along an axis, and the splines around them with derivatives."""
    at = np.asarray(place) / width - 0.5
    cell = np.floor(at + 0.5).astype(np.int64)
    t = at - cell
    basis = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    one = np.ones_like(t)
    return cell, (basis, (t - 0.5, -2.0 * t, t + 0.5), (one, -2.0 * one, one))


def _mirrored(k: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    k = np.abs(k)
    k = np.minimum(k, 2 * (count - 1) - k)
    return np.clip(k, 0, count - 1)


def is_taken_out(release: MassRelease) -> bool:
    """Return whether a mass is taken out of the terrain, not put on it."""
    return release.place == "in-terrain"


def ground_of(case: ResolvedCase) -> Ground:
    """Return the ground of a case on a terrain."""
    masses = (part for part in case.release if not isinstance(part, HydrographRelease))
    scars = tuple(mass for mass in masses if is_taken_out(mass))
    named = [case.terrain.dem, *(getattr(scar, "file", None) for scar in scars)]
    named += [file for zone in case.zone for file in (zone.file, zone.raster)]
    states = [Path(file).stat() for file in named if file is not None]
    stamps = tuple((state.st_mtime_ns, state.st_size) for state in states)
    return _ground(case.terrain, scars, case.zone, first_zone(case), stamps)


@lru_cache(maxsize=4)
def _ground(
    shape: ResolvedTerrain,
    scars: tuple[MassRelease, ...],
    zones: tuple[Zone, ...],
    first: int,
    stamps: tuple[tuple[int, int], ...],
) -> Ground:
    """Return the ground of a terrain, as its files are at stamps of their times and sizes.

    Zones are numbered from the first on.
    """
    raster = shape.levels
    grid = raster.grid
    given = raster.plan - shape.origin[2]
    left = given - sum((depth_on(scar, grid) for scar in scars), np.zeros_like(given))
    number = np.full(given.shape, FLOOR)
    for k, zone in enumerate(zones, first):
        number[holds_middles(zone, grid)] = k
    whole = smooth_surface(given, grid.cell, shape.cell)
    surface = smooth_surface(left, grid.cell, shape.cell) if scars else whole
    return Ground(grid, given, surface, whole, number)
