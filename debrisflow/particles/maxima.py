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
        nan where the flow has not arrived, see :meth:`reached`.
    first_depth : (n,) float64 array, m
        Depth of all fluid at the first sample, films of one row too; nan before.
    rested : (n,) bool array
        Where that fluid rested.
    """

    depth: Floats
    speed: Floats
    momentum_flux: Floats
    arrival_time: Floats
    first_depth: Floats
    rested: NDArray[np.bool_]

    def include(
        self,
        time: float,
        depth: Floats,
        speed: Floats,
        momentum_flux: Floats,
        whole_depth: Floats,
        rests: NDArray[np.bool_],
        spacing: float,
    ) -> None:
        """Take in the flow at a time.

        Parameters
        ----------
        time : float
            In s.
        depth, speed, momentum_flux : (n,) array, m, m/s, N/m
        whole_depth : (n,) array, m
            With films of one row.
        rests : (n,) bool array
            Where the fluid rests.
        spacing : float
            d0, m.
        """
        unknown = np.isnan(self.first_depth)
        self.first_depth[unknown], self.rested[unknown] = whole_depth[unknown], rests[unknown]
        np.maximum(self.depth, depth, out=self.depth)
        np.maximum(self.speed, speed, out=self.speed)
        np.maximum(self.momentum_flux, momentum_flux, out=self.momentum_flux)
        arrived = has_risen(depth, self.first_depth, spacing)
        self.arrival_time[arrived & np.isnan(self.arrival_time)] = time

    def reached(self, depth: Floats, spacing: float) -> NDArray[np.bool_]:
        """Return over which cells the flow has come, see :func:`is_reached`.

        All, before the first sample.
        """
        return is_reached(depth, self.first_depth, self.rested, spacing)


def has_risen(depth: Floats, first_depth: Floats, spacing: float) -> NDArray[np.bool_]:
    """Return where the flow is more than half a spacing deeper than at the start."""
    return depth > first_depth + LEAST_RISE * spacing


def is_reached(
    depth: Floats, first_depth: Floats, rested: NDArray[np.bool_], spacing: float
) -> NDArray[np.bool_]:
    """Return where no fluid rested at the start, or the flow is half a spacing deeper than it."""
    return ~rested | ~(first_depth > 0.0) | has_risen(depth, first_depth, spacing)


def no_maxima(cells: int) -> Maxima:
    """Return the maxima of a number of cells before the first sample."""
    zero, unknown = np.zeros((3, cells)), np.full((2, cells), np.nan)
    depth, speed, momentum_flux = (row.copy() for row in zero)
    arrival_time, first_depth = (row.copy() for row in unknown)
    rested = np.zeros(cells, dtype=np.bool_)
    return Maxima(depth, speed, momentum_flux, arrival_time, first_depth, rested)
