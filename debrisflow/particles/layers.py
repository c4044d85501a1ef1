"""Greatest values, arrival and duration of the flow in the cells of a map, while a case runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Layers:
    """What the flow has done so far in each cell of a map.

    The arrays are (columns, rows), along x from the west and along y from the south; they have no
    cells in a case without terrain.  How they are found: :mod:`debrisflow.physics.map_cells`.

    Attributes
    ----------
    peak_depth : float64 array, m
        Volume over the area of the cell, along the vertical.
    peak_speed : float64 array, m/s
    peak_momentum_flux : float64 array, m3/s2
    peak_pressure : float64 array, kPa
    arrival : float64 array, s
        nan where the flow has not arrived.
    duration : float64 array, s
    """

    peak_depth: Floats
    peak_speed: Floats
    peak_momentum_flux: Floats
    peak_pressure: Floats
    arrival: Floats
    duration: Floats


def no_layers(columns: int = 0, rows: int = 0) -> Layers:
    """Return the layers of a number of cells before the first step.

    Examples
    --------
    >>> no_layers().peak_depth.size, no_layers(4, 3).arrival.shape
    (0, (4, 3))
    """
    depth, speed, momentum_flux, pressure, duration = (np.zeros((columns, rows)) for _ in range(5))
    arrival = np.full((columns, rows), np.nan)
    return Layers(depth, speed, momentum_flux, pressure, arrival, duration)
