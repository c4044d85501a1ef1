"""Multigrid preconditioner: hierarchy from pyamg, cycles of our own that run on several threads.

Gauss-Seidel sweeps run within blocks of a fixed number of rows, so that the result has the same
bits on any number of threads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop
from debrisflow.schemes.system import Floats, Indices, System, residual

BLOCK = 512


class Hierarchy(NamedTuple):
    """Coarse levels of a multigrid preconditioner, one behind the other in flat arrays.

    Level 0 is the system itself.  Level l has ``size[l]`` unknowns, the first of them at
    ``first[l]`` of the level vectors; ``matrix``, ``restrict`` and ``prolong`` are compressed rows
    of all levels, whose row pointers for level l begin at ``first[l] + l``.

    Attributes
    ----------
    size, first : (levels,) int64 array
    matrix_start, restrict_start, prolong_start : int64 arrays
        Row pointers.  ``prolong`` of level l has a row for each unknown of level l - 1.
    matrix_index, restrict_index, prolong_index : int32 arrays
    matrix_value, restrict_value, prolong_value : float64 arrays
    diagonal : float64 array
    prolong_first : (levels,) int64 array
        Where the row pointers of ``prolong`` begin.
    inverse : (k, k) float64 array
        Inverse of the matrix of the last level.
    """

    size: NDArray[np.int64]
    first: NDArray[np.int64]
    matrix_start: NDArray[np.int64]
    matrix_index: Indices
    matrix_value: Floats
    diagonal: Floats
    restrict_start: NDArray[np.int64]
    restrict_index: Indices
    restrict_value: Floats
    prolong_first: NDArray[np.int64]
    prolong_start: NDArray[np.int64]
    prolong_index: Indices
    prolong_value: Floats
    inverse: Floats


_NO_ROWS = np.zeros(0, np.int64)
_NO_COLUMNS = np.zeros(0, np.int32)
_NO_VALUES = np.zeros(0)
NO_HIERARCHY = Hierarchy(
    size=np.zeros(1, np.int64),
    first=np.zeros(1, np.int64),
    matrix_start=_NO_ROWS,
    matrix_index=_NO_COLUMNS,
    matrix_value=_NO_VALUES,
    diagonal=_NO_VALUES,
    restrict_start=_NO_ROWS,
    restrict_index=_NO_COLUMNS,
    restrict_value=_NO_VALUES,
    prolong_first=np.zeros(1, np.int64),
    prolong_start=_NO_ROWS,
    prolong_index=_NO_COLUMNS,
    prolong_value=_NO_VALUES,
    inverse=np.zeros((1, 1)),
)


def hierarchy(system: System) -> Hierarchy:
    """Return the Ruge-Stueben hierarchy of a system.

    It stays useful while the particles move by a fraction of the influence radius, so it is built
    once in a number of steps.  Set-up and cycle grow about linearly with the unknowns.
    """
    from pyamg import ruge_stuben_solver

    # 0.1 counts the first two rings of neighbors as strong: half the coarse unknowns of the usual
    # 0.25 at the same number of iterations
    strength = ("classical", {"theta": 0.1})
    levels = ruge_stuben_solver(_as_csr(system), strength=strength, max_coarse=100).levels
    matrices = [level.A.tocsr() for level in levels[1:]]
    prolongs = [level.P.tocsr() for level in levels[:-1]]
    restricts = [p.T.tocsr() for p in prolongs]
    size = np.array([level.A.shape[0] for level in levels])
    first = (
        np.concatenate([[0, 0], np.cumsum(size[1:])[:-1]]) if size.size > 1 else np.zeros(1, int)
    )
    prolong_first = np.concatenate([[0, 0], np.cumsum(size[:-1] + 1)[:-1]])[: size.size]
    inverse = np.linalg.pinv(levels[-1].A.toarray())
    diagonal = [m.diagonal() for m in matrices]
    return Hierarchy(
        size.astype(np.int64),
        first.astype(np.int64),
        *_flat(matrices),
        np.concatenate(diagonal) if diagonal else np.zeros(0),
        *_flat(restricts),
        prolong_first.astype(np.int64),
        *_flat(prolongs),
        np.ascontiguousarray(inverse),
    )


def _as_csr(system: System) -> Any:
    from scipy.sparse import csr_matrix

    rows = system.entries.size
    start = np.zeros(rows + 1, dtype=np.int32)
    start[1:] = np.cumsum(system.entries + 1)
    index = np.empty(start[-1], dtype=np.int32)
    value = np.empty(start[-1])
    _compress(system, start, index, value)
    return csr_matrix((value, index, start), shape=(rows, rows))


@kernel
def _compress(system, start, index, value):
    for i in range(system.entries.size):
        k0 = start[i]
        index[k0] = i
        value[k0] = system.diagonal[i]
        for k in range(system.entries[i]):
            j = system.columns[i, k]
            index[k0 + 1 + k] = j
            value[k0 + 1 + k] = -system.value[i, k] if system.entries[j] > 0 else 0.0


def _flat(matrices: list[Any]) -> tuple[NDArray[np.int64], Indices, Floats]:
    """Return row pointers, columns and values of matrices one behind the other."""
    if not matrices:
        return np.zeros(0, np.int64), np.zeros(0, np.int32), np.zeros(0)
    offsets = np.cumsum([0] + [m.nnz for m in matrices])
    start = np.concatenate(
        [m.indptr + offset for m, offset in zip(matrices, offsets, strict=False)]
    )
    index = np.concatenate([m.indices for m in matrices])
    value = np.concatenate([m.data for m in matrices])
    return start.astype(np.int64), index.astype(np.int32), value.astype(np.float64)


@loop
def _relax_forward(system, right, x):
    """One Gauss-Seidel sweep from zero, within blocks."""
    n = x.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        lower = block * BLOCK
        for i in range(lower, min(lower + BLOCK, n)):
            total = right[i]
            for k in range(system.entries[i]):
                j = system.columns[i, k]
                if lower <= j < i:
                    total += system.value[i, k] * x[j]
            x[i] = total / system.diagonal[i] if system.entries[i] > 0 else 0.0


@loop
def _relax_backward(system, right, old, x):
    """One backward Gauss-Seidel sweep within blocks; other blocks count with their old values."""
    n = x.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        lower, upper = block * BLOCK, min((block + 1) * BLOCK, n)
        for i in range(upper - 1, lower - 1, -1):
            total = right[i]
            for k in range(system.entries[i]):
                j = system.columns[i, k]
                total += system.value[i, k] * (x[j] if lower <= j < upper else old[j])
            x[i] = total / system.diagonal[i] if system.entries[i] > 0 else 0.0


@loop
def _rows_times(start, index, value, x, y):
    for i in prange(y.size):
        total = 0.0
        for k in range(start[i], start[i + 1]):
            total += value[k] * x[index[k]]
        y[i] = total


@loop
def _add_rows_times(start, index, value, x, y):
    for i in prange(y.size):
        total = y[i]
        for k in range(start[i], start[i + 1]):
            total += value[k] * x[index[k]]
        y[i] = total


@loop
def _coarse_forward(start, index, value, diagonal, right, x):
    n = x.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        lower = block * BLOCK
        for i in range(lower, min(lower + BLOCK, n)):
            total = right[i]
            for k in range(start[i], start[i + 1]):
                if lower <= index[k] < i:
                    total -= value[k] * x[index[k]]
            x[i] = total / diagonal[i]


@loop
def _coarse_backward(start, index, value, diagonal, right, old, x):
    n = x.size
    for block in prange((n + BLOCK - 1) // BLOCK):
        lower, upper = block * BLOCK, min((block + 1) * BLOCK, n)
        for i in range(upper - 1, lower - 1, -1):
            total = right[i] + diagonal[i] * x[i]
            for k in range(start[i], start[i + 1]):
                j = index[k]
                total -= value[k] * (x[j] if lower <= j < upper else old[j])
            x[i] = total / diagonal[i]


@kernel
def _descend(h, level, right, x, rest):
    """Relax level 1 and deeper and restrict what is left; returns nothing but fills x and right."""
    a, m = h.first[level], h.size[level]
    row = a + level - 1
    start = h.matrix_start[row : row + m + 1]
    _coarse_forward(
        start, h.matrix_index, h.matrix_value, h.diagonal[a : a + m], right[a : a + m], x[a : a + m]
    )
    _rows_times(start, h.matrix_index, h.matrix_value, x[a : a + m], rest[a : a + m])
    for i in range(a, a + m):
        rest[i] = right[i] - rest[i]


@kernel
def cycle(system, h, right, z, old, coarse_right, coarse, rest):
    """Write ``z``, one symmetric V-cycle from zero for ``system z = right``.

    Parameters
    ----------
    system : System
        The finest level as it is now.
    h : Hierarchy
        The coarse levels, which may be some steps old.
    right, z, old : (m,) float64 array
    coarse_right, coarse, rest : float64 arrays
        Room for all coarse levels.
    """
    _relax_forward(system, right, z)
    residual(system, right, z, old)
    last = h.size.size - 1
    for level in range(1, last + 1):
        a, m = h.first[level], h.size[level]
        row = a + level - 1
        if level == 1:
            fine = old
        else:
            b = h.first[level - 1]
            fine = rest[b : b + h.size[level - 1]]
        _rows_times(
            h.restrict_start[row : row + m + 1],
            h.restrict_index,
            h.restrict_value,
            fine,
            coarse_right[a : a + m],
        )
        if level < last:
            _descend(h, level, coarse_right, coarse, rest)
    a, m = h.first[last], h.size[last]
    for i in range(m):
        total = 0.0
        for j in range(m):
            total += h.inverse[i, j] * coarse_right[a + j]
        coarse[a + i] = total
    for level in range(last, 0, -1):
        a, m = h.first[level], h.size[level]
        p, f = h.prolong_first[level], h.size[level - 1]
        start = h.prolong_start[p : p + f + 1]
        if level == 1:
            _add_rows_times(start, h.prolong_index, h.prolong_value, coarse[a : a + m], z)
        else:
            b = h.first[level - 1]
            _add_rows_times(
                start, h.prolong_index, h.prolong_value, coarse[a : a + m], coarse[b : b + f]
            )
            row = b + level - 2
            for i in range(b, b + f):
                rest[i] = coarse[i]
            _coarse_backward(
                h.matrix_start[row : row + f + 1],
                h.matrix_index,
                h.matrix_value,
                h.diagonal[b : b + f],
                coarse_right[b : b + f],
                rest[b : b + f],
                coarse[b : b + f],
            )
    for i in range(z.size):
        old[i] = z[i] if system.entries[i] > 0 else 0.0
    _relax_backward(system, right, old, z)
