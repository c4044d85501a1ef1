"""A sparse linear system in rows of neighbors, and the products that solvers need of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import loop

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]


class System(NamedTuple):
    """Rows of a sparse linear system.

    Attributes
    ----------
    columns : (m, capacity) int32 array
        Columns of the entries of each row.
    value : (m, capacity) float64 array
        Entries off the diagonal, with their sign turned.
    entries : (m,) int32 array
        Entries of each row; 0 where the solution is given.
    diagonal, right : (m,) float64 array
    """

    columns: Indices
    value: Floats
    entries: Indices
    diagonal: Floats
    right: Floats


def empty_system(rows: int, capacity: int) -> System:
    """Return a system of given zeros with room for ``capacity`` entries in each row."""
    return System(
        columns=np.zeros((rows, capacity), dtype=np.int32),
        value=np.zeros((rows, capacity)),
        entries=np.zeros(rows, dtype=np.int32),
        diagonal=np.ones(rows),
        right=np.zeros(rows),
    )


class SystemRoom:
    """Memory for one system after another, kept as long as its shape stays."""

    def __init__(self) -> None:
        self._system = empty_system(0, 0)

    def fit(self, shape: tuple[int, ...]) -> System:
        """Return a system of rows and capacity; it holds what the last one held."""
        if self._system.value.shape != shape:
            self._system = empty_system(*shape)
        return self._system


@loop
def multiply(system, x, y):
    """Write ``y = A x``."""
    for i in prange(x.size):
        total = system.diagonal[i] * x[i]
        for k in range(system.entries[i]):
            total -= system.value[i, k] * x[system.columns[i, k]]
        y[i] = total


@loop
def residual(system, right, x, rest):
    """Write ``rest = right - A x``, 0 where the solution is given."""
    for i in prange(x.size):
        total = right[i] - system.diagonal[i] * x[i]
        for k in range(system.entries[i]):
            total += system.value[i, k] * x[system.columns[i, k]]
        rest[i] = total if system.entries[i] > 0 else 0.0
