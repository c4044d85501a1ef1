"""Mean, least and greatest over the steps between two rows of a table, in the sum of a probe.

The running sum of n quantities has 4 n + 2 numbers: their integrals over time since t = 0, these at
the last row, the least and the greatest values since then, its time, and the number of steps since
then in which the quantities had values.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.state import State

Floats = NDArray[np.float64]
LEAST, GREATEST = EXTREMES = ("_least", "_greatest")  # endings of the names of columns


class RowStatistics(NamedTuple):
    """What quantities were over the steps since the row before.

    Attributes
    ----------
    mean, least, greatest : (n,) float64 array
        Least and greatest are nan where the quantities had values in no step.
    """

    mean: Floats
    least: Floats
    greatest: Floats


def sum_shape(quantities: int) -> tuple[int]:
    """Return the shape of the running sum of a number of quantities."""
    return (4 * quantities + 2,)


def integrals(kept: Floats) -> Floats:
    """Return the integrals since t = 0, (n,) array, a view of the running sum."""
    return kept[: kept.size // 4]


def add_step(kept: Floats, state: State, values: Floats, seen: bool = True) -> None:
    """Add the last step, in which the quantities had some values; before t = 0 nothing.

    Parameters
    ----------
    kept : (4 n + 2,) float64 array
        The running sum, changed in place.
    state : State
    values : (n,) float64 array
    seen : bool
        Whether these are values; if not, they count in the integrals only.
    """
    if state.time <= 0.0:
        return
    total, _, least, greatest = _parts(kept)
    total += state.dt * values
    if seen:
        is_first = kept[-1] == 0.0
        least[:] = values if is_first else np.minimum(least, values)
        greatest[:] = values if is_first else np.maximum(greatest, values)
        kept[-1] += 1.0


def since_row(kept: Floats, state: State, values: Floats, seen: bool = True) -> RowStatistics:
    """Return the statistics since the row before and begin a new row; in the first row the values.

    The parameters are those of :func:`add_step`.
    """
    total, before, least, greatest = _parts(kept)
    now = max(state.time, 0.0)
    elapsed, none = now - kept[-2], np.full(total.size, np.nan)
    if elapsed > 0.0:
        known = kept[-1] > 0.0
        found = RowStatistics(
            (total - before) / elapsed,
            least.copy() if known else none,
            greatest.copy() if known else none,
        )
    else:
        found = RowStatistics(values.copy(), *(values.copy() if seen else none for _ in EXTREMES))
    before[:], kept[-2], kept[-1] = total, now, 0.0
    return found


def _parts(kept: Floats) -> Floats:
    """Return integrals, these at the last row, least and greatest, (4, n) array, a view."""
    return kept[:-2].reshape(4, -1)
