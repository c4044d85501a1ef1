"""The terrain under a map: its hillshade and its contours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.colors import LightSource
from numpy.typing import NDArray

from debrisflow.case.rasters import Raster

Floats = NDArray[np.float64]
LIGHT_FROM, LIGHT_ABOVE = 315.0, 45.0  # degrees from north, clockwise, and over the horizon
DARKEST = 0.35  # gray of a slope in the shade, so that lines and labels stay legible on it
INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
MOST_CONTOURS = 40
EACH_LABELLED = 5


class Contours(NamedTuple):
    """Elevations at which contours are drawn, m.

    Attributes
    ----------
    interval : float
    thin, labelled : (n,) array
    """

    interval: float
    thin: Floats
    labelled: Floats


def hillshade(terrain: Raster) -> Floats:
    """Return the brightness of a terrain lit from the north-west, (rows, columns), 0 to 1.

    Examples
    --------
    A slope that faces the light is brighter than one that turns away from it.

    >>> from debrisflow.case.rasters import MapGrid
    >>> east = np.tile(np.arange(4.0), (4, 1))
    >>> grid = MapGrid(0.0, 0.0, 1.0, 4, 4)
    >>> bool(hillshade(Raster(grid, east)).mean() > hillshade(Raster(grid, -east)).mean())
    True
    """
    known = np.isfinite(terrain.values)
    mean = float(np.nanmean(terrain.values)) if known.any() else 0.0
    level = np.where(known, terrain.values, mean)
    up, east = np.gradient(level, -terrain.grid.cell, terrain.grid.cell)
    normal = np.stack([-east, -up, np.ones_like(level)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    # not stretched to the full range, as by LightSource.hillshade: a plain stays even
    lit = np.maximum(normal @ LightSource(LIGHT_FROM, LIGHT_ABOVE).direction, 0.0)
    return np.where(known, DARKEST + (1.0 - DARKEST) * lit, np.nan)


def contours(terrain: Raster) -> Contours:
    """Return the elevations of contours, each fifth of them labelled.

    Examples
    --------
    >>> from debrisflow.case.rasters import MapGrid
    >>> slope = Raster(MapGrid(0.0, 0.0, 1.0, 2, 2), np.array([[100.0, 100.0], [103.0, 303.0]]))
    >>> found = contours(slope)
    >>> found.interval, found.labelled.tolist()
    (10.0, [150.0, 200.0, 250.0, 300.0])
    """
    low, high = float(np.nanmin(terrain.values)), float(np.nanmax(terrain.values))
    interval = next((i for i in INTERVALS if (high - low) / i <= MOST_CONTOURS), INTERVALS[-1])
    first, last = int(np.floor(low / interval)) + 1, int(np.ceil(high / interval)) - 1
    numbers = np.arange(first, last + 1)
    fifth = numbers % EACH_LABELLED == 0
    return Contours(interval, numbers[~fifth] * interval, numbers[fifth] * interval)
