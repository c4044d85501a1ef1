"""Means over the steps between two rows of a table, kept in the running sum of a probe.

The running sum of n quantities has 2 n + 1 numbers: their integrals over time since t = 0, these at
the last row, and its time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.state import State

Floats = NDArray[np.float64]


def sum_shape(quantities: int) -> tuple[int]:
    """Return the shape of the running sum of a number of quantities."""
    return (2 * quantities + 1,)


def integrals(kept: Floats) -> Floats:
    """Return the integrals since t = 0, (n,) array, a view of the running sum."""
    return kept[: kept.size // 2]


def add_step(kept: Floats, state: State, values: Floats) -> None:
    """Add the last step, in which the quantities had some values; before t = 0 nothing."""
    if state.time > 0.0:
        integrals(kept)[:] += state.dt * values


def mean_since_row(kept: Floats, state: State, values: Floats) -> Floats:
    """Return the means since the row before and begin a new row; in the first row the values."""
    total, now = integrals(kept), max(state.time, 0.0)
    elapsed, before = now - kept[-1], kept[total.size : -1]
    mean = (total - before) / elapsed if elapsed > 0.0 else values.copy()
    before[:], kept[-1] = total, now
    return mean
