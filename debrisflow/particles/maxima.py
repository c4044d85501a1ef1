"""The greatest depth, speed and momentum flux of a run in each cell, and when the flow arrived."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LEAST_RISE = 0.5  # spacings


@dataclass
class Maxima:
    """What the flow has reached so far in each cell of :func:`debrisflow.space.plan_grid.plan`.

    Attributes
    ----------
    depth : (n,) float64 array, m
    speed : (n,) float64 array, m/s
    momentum_flux : (n,) float64 array, N/m
    arrival_time : (n,) float64 array, s
        nan where the flow has not arrived.
    first_depth : (n,) float64 array, m
        Depth at the first sample; nan before.
    """

    depth: Floats
    speed: Floats
    momentum_flux: Floats
    arrival_time: Floats
    first_depth: Floats

    def include(
        self, time: float, depth: Floats, speed: Floats, momentum_flux: Floats, spacing: float
    ) -> None:
        """Take in the flow at a time.

        Parameters
        ----------
        time : float
            In s.
        depth, speed, momentum_flux : (n,) array, m, m/s, N/m
        spacing : float
            d0, m; a flow has arrived where it is d0 / 2 deeper than at the first sample.
        """
        unknown = np.isnan(self.first_depth)
        self.first_depth[unknown] = depth[unknown]
        np.maximum(self.depth, depth, out=self.depth)
        np.maximum(self.speed, speed, out=self.speed)
        np.maximum(self.momentum_flux, momentum_flux, out=self.momentum_flux)
        risen = depth > self.first_depth + LEAST_RISE * spacing
        self.arrival_time[risen & np.isnan(self.arrival_time)] = time


def no_maxima(cells: int) -> Maxima:
    """Return the maxima of a number of cells before the first sample."""
    zero, unknown = np.zeros((3, cells)), np.full((2, cells), np.nan)
    return Maxima(*(row.copy() for row in (*zero, *unknown)))
