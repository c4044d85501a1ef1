"""What surveys of all runs have: fronts, budgets and the curves of probes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from debrisflow.results.budgets import budget_table
from debrisflow.results.probe_curves import ProbeCurve, ProbeFigures, probe_curves, probe_figures
from debrisflow.results.reader import Run
from debrisflow.run.tables import Table

Floats = NDArray[np.float64]
WINDOW_SHARE = 0.2
REST_SHARE = 0.01


def last_part(times: Floats) -> tuple[float, float]:
    """Return the last fifth of some times, in order, s."""
    end = float(times[-1])
    return end - WINDOW_SHARE * (end - float(times[0])), end


@dataclass(frozen=True)
class Measured:
    """What was measured of a run.

    Attributes
    ----------
    run : Run
    window : (float, float), s
        Over which samples of probes, and profiles, are averaged.
    fronts : Table
        As ``front.csv``, with the share of the volume that moves.
    has_grains : bool
        Whether there is sediment in any of the fluid.
    smoothing : float, s, or None
        Span of the running means of probes; ten intervals of each if None.
    """

    run: Run
    window: tuple[float, float]
    fronts: Table
    has_grains: bool
    smoothing: float | None

    @cached_property
    def probe_curves(self) -> list[ProbeCurve]:
        """Return the curves of the probes, but those of sections."""
        return probe_curves(self.run, self.smoothing)

    @property
    def probe_figures(self) -> list[ProbeFigures]:
        """Return the figures of these curves."""
        return probe_figures(self.probe_curves, self.window)

    @property
    def rest_time(self) -> float:
        """Return the time from which on less than 1 % of the volume moves, s; nan if none."""
        moving = np.flatnonzero(self.fronts["moving_share"] >= REST_SHARE)
        later = moving[-1] + 1 if moving.size else 0
        time = self.fronts["time"]
        return float(time[later]) if later < time.size else np.nan

    @cached_property
    def budget(self) -> Table:
        """Return mass by matter and energies in time."""
        return budget_table(self.run.case, self.run.history)
