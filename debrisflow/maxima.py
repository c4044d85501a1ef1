"""The greatest depth, speed and momentum flux of a run in each cell, and when the flow arrived."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.grid import FLOOR_WORDS, PLACE, PLACE_WORDS, floor_level, plan
from debrisflow.series import write_table

Floats = NDArray[np.float64]
LEAST_RISE = 0.5  # spacings
COLUMNS = ("floor_level", "maximal_depth", "maximal_speed", "maximal_momentum_flux", "arrival_time")
HEAD = (
    "greatest values from t = 0 until now, time = {time!r} s, in samples every {interval:g} s",
    "  (output.history_interval)",
    "{place}",
    "floor_level: m, of {floor}",
    "maximal_depth: m, greatest flow_height as deposit.csv defines it",
    "maximal_speed: m/s, greatest mean of the speeds of the particles up to that height",
    "maximal_momentum_flux: N/m, greatest integral of density times speed squared over the depth",
    "arrival_time: s, first sample at which the depth is more than half a spacing greater than at",
    "  t = 0; nan where it never is",
)


@dataclass
class Maxima:
    """What the flow has reached so far in each cell of :func:`debrisflow.grid.plan`.

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


def write_maxima(path: Path, case: tables.Case, time: float, maxima: Maxima) -> None:
    """Write ``maxima.csv`` at a time, s; what was there is replaced."""
    grid, dimension = plan(case), case.dimension
    words = {"place": PLACE_WORDS[dimension], "floor": FLOOR_WORDS[dimension]}
    head = [line.format(time=time, interval=case.output.history_interval, **words) for line in HEAD]
    place = PLACE[dimension]
    values = (maxima.depth, maxima.speed, maxima.momentum_flux, maxima.arrival_time)
    columns = [getattr(grid, axis) for axis in place] + [floor_level(case, grid), *values]
    rows = ([float(v) for v in row] for row in zip(*columns, strict=True))
    write_table(path, (*place, *COLUMNS), head, rows)
