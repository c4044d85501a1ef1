"""Maps over the members of a study: probability of exceedance and of arrival, quantiles.

All count members: of N members of which k exceed a threshold in a cell, the probability is k / N.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid
from debrisflow.errors import OutputError
from debrisflow.study.maps.grid import layer_on, terrain_on
from debrisflow.study.names import ARRIVAL

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BLOCK = 256_000_000  # bytes of the values of all members that are in memory at a time
ROUNDING = 1e-9  # of a number of members


def shares_over(
    folders: Sequence[Path], grid: MapGrid, layer: str, thresholds: Sequence[float]
) -> Floats:
    """Return the shares of the members whose layer is greater than thresholds.

    Parameters
    ----------
    folders : sequence of Path
        Of finished members.
    grid : MapGrid
    layer : str
        Where a member has none of it, it counts as 0, see
        :func:`debrisflow.study.maps.grid.layer_on`.
    thresholds : sequence of float
        In the unit of the layer.  Depths up to ``output.layer_depth`` are not told from 0.

    Returns
    -------
    (thresholds, rows, columns) float64 array
        The northernmost row first; 0 off the terrain too.

    Raises
    ------
    OutputError
        If there is no member, or one lacks the layer.
    """
    counts = np.zeros((len(thresholds), *grid.shape), dtype=np.int64)
    for values in layers_on(folders, grid, layer):
        for count, threshold in zip(counts, thresholds, strict=True):
            count += values > threshold
    return counts / len(folders)


def shares_arrived(folders: Sequence[Path], grid: MapGrid, times: Sequence[float]) -> Floats:
    """Return the shares of the members whose flow has arrived at times, s, or before.

    (times, rows, columns); see :func:`shares_over`.
    """
    counts = np.zeros((len(times), *grid.shape), dtype=np.int64)
    for values in layers_on(folders, grid, ARRIVAL):
        for count, time in zip(counts, times, strict=True):
            count += values <= time
    return counts / len(folders)


def quantiles(
    folders: Sequence[Path],
    grid: MapGrid,
    layer: str,
    shares: Sequence[float],
    block: int = BLOCK,
) -> Floats:
    """Return the least values that shares of the members do not exceed, (shares, rows, columns).

    Of N members in increasing order it is that at place ``ceil(share N)``: always the value of a
    member, never one between two.  A member without the layer in a cell counts as 0.  Of the
    arrival it is the time at which that share has arrived, inf where fewer ever do.

    The values of all members are needed at once; they are read only for cells that a member
    reaches, and for some of these after the others.

    Parameters
    ----------
    folders, grid, layer
        As of :func:`shares_over`.
    shares : sequence of float
        Over 0, at most 1.
    block : int
        Bytes of values that are in memory at a time.
    """
    none = np.inf if layer == ARRIVAL else 0.0
    reached = np.zeros(grid.shape, dtype=bool)
    for values in layers_on(folders, grid, layer):
        reached |= values != none
    found = np.full((len(shares), reached.size), none)
    cells = np.flatnonzero(reached)
    size = max(block // (8 * len(folders)), 1)
    places = [rank(share, len(folders)) - 1 for share in shares]
    for start in range(0, cells.size, size):
        some = cells[start : start + size]
        stack = np.empty((len(folders), some.size))
        for row, values in zip(stack, layers_on(folders, grid, layer), strict=True):
            row[:] = values.ravel()[some]
        stack.sort(axis=0)
        found[:, some] = stack[places]
    return found.reshape(len(shares), *grid.shape)


def rank(share: float, count: int) -> int:
    """Return the place, from 1 on, of the least of some values that a share does not exceed.

    Examples
    --------
    >>> rank(0.5, 4), rank(0.51, 4), rank(0.07, 100), rank(0.01, 8)
    (2, 3, 7, 1)
    """
    return min(max(int(np.ceil(share * count - ROUNDING)), 1), count)


def layers_on(folders: Sequence[Path], grid: MapGrid, layer: str) -> Iterator[Floats]:
    """Yield a layer of each member, see :func:`debrisflow.study.maps.grid.layer_on`.

    Raises
    ------
    OutputError
        If there is no member, or one lacks the layer.
    """
    expect_members(folders)
    for folder in folders:
        yield layer_on(folder, grid, layer)


def expect_members(folders: Sequence[Path]) -> None:
    """Refuse to make maps of no members.

    Raises
    ------
    OutputError
    """
    if not folders:
        raise OutputError(
            "there is no finished member, so no map can be made; members.csv says how each ended"
        )


def known_on(folders: Sequence[Path], grid: MapGrid) -> Flags:
    """Return the cells in which the terrain of any member has data, (rows, columns)."""
    known = np.zeros(grid.shape, dtype=bool)
    for folder in folders:
        known |= np.isfinite(terrain_on(folder, grid).values)
        if known.all():
            break
    return known
