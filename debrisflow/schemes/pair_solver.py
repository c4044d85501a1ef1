"""Linear systems over the pairs of a fluid, one coefficient a listed neighbor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.errors import NotConvergedError
from debrisflow.neighbors.pairs import BLOCK, Near
from debrisflow.physics.operators import cofactors

Floats = NDArray[np.float64]
MOST_ITERATIONS = 1000


class Couplings(NamedTuple):
    """Rows ``diagonal_i x_i - sum of value_ij x_j`` over the fluid neighbors of each particle.

    Attributes
    ----------
    value : (n, capacity) float32 array
        In the order of the list of neighbors.
    diagonal : (n,) float64 array
    is_free : (n,) bool array
        False where x is given.
    hold : (n, 6) float64 array or None
        What is added to the diagonal of a vector x_i, a symmetric matrix as xx, xy, yy, xz, yz, zz;
        None for nothing.
    """

    value: NDArray[np.float32]
    diagonal: Floats
    is_free: NDArray[np.bool_]
    hold: Floats | None = None


@kernel
def _held(i, a, hold, x):
    """Return component a of what is added to row i of the product with x."""
    if hold is None:
        return 0.0
    else:
        first = 0 if a == 0 else (1 if a == 1 else 3)
        second = 1 if a == 0 else (2 if a == 1 else 4)
        third = 3 if a == 0 else (4 if a == 1 else 5)
        return hold[i, first] * x[i, 0] + hold[i, second] * x[i, 1] + hold[i, third] * x[i, 2]


@kernel
def _eased(i, a, diagonal, hold, rest):
    """Return component a of the residual of row i times the inverse of its diagonal block."""
    if hold is None:
        return rest[i, a] / diagonal[i]
    else:
        d, h = diagonal[i], hold
        xx, xy, yy, xz, yz, zz, determinant = cofactors(
            d + h[i, 0], h[i, 1], d + h[i, 2], h[i, 3], h[i, 4], d + h[i, 5]
        )
        x, y, z = rest[i, 0], rest[i, 1], rest[i, 2]
        along_x, along_y = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z
        along_z = xz * x + yz * y + zz * z
        return (along_x if a == 0 else (along_y if a == 1 else along_z)) / determinant


@kernel
def _apply(first, last, couplings, near, p, q):
    """Write ``q = A p``, 0 where x is given, and return the inner product of both."""
    inner = 0.0
    for i in range(first, last):
        if p.shape[1] == 3:
            x, y, z = 0.0, 0.0, 0.0
            for k in range(near.fluid_count[i]):
                j = np.uint32(near.neighbors[i, k])
                a = couplings.value[i, k]
                x, y, z = x + a * p[j, 0], y + a * p[j, 1], z + a * p[j, 2]
            q[i, 0] = couplings.diagonal[i] * p[i, 0] - x + _held(i, 0, couplings.hold, p)
            q[i, 1] = couplings.diagonal[i] * p[i, 1] - y + _held(i, 1, couplings.hold, p)
            q[i, 2] = couplings.diagonal[i] * p[i, 2] - z + _held(i, 2, couplings.hold, p)
        else:
            x = 0.0
            for k in range(near.fluid_count[i]):
                x += couplings.value[i, k] * p[np.uint32(near.neighbors[i, k]), 0]
            q[i, 0] = couplings.diagonal[i] * p[i, 0] - x
        for a in range(p.shape[1]):
            q[i, a] = q[i, a] if couplings.is_free[i] else 0.0
            inner += p[i, a] * q[i, a]
    return inner


@loop
def _multiply(couplings, near, p, q, partial):
    n = p.shape[0]
    for block in prange(partial.shape[0]):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        partial[block, 0] = _apply(first, last, couplings, near, p, q)


@loop
def _begin(couplings, right, x, rest, p):
    """Write the residual, from ``rest = A x``, and the step p of Jacobi's iteration."""
    n = x.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        for i in range(block * BLOCK, min(block * BLOCK + BLOCK, n)):
            for a in range(x.shape[1]):
                rest[i, a] = right[i, a] - rest[i, a] if couplings.is_free[i] else 0.0
            for a in range(x.shape[1]):
                p[i, a] = _eased(i, a, couplings.diagonal, couplings.hold, rest)


@loop
def _advance(couplings, alpha, p, q, x, rest, partial):
    """Go on by alpha along p, q = A p; write the sums of ``rest^2`` and of ``rest z`` by blocks."""
    n = x.shape[0]
    for block in prange(partial.shape[0]):
        square, inner = 0.0, 0.0
        for i in range(block * BLOCK, min(block * BLOCK + BLOCK, n)):
            for a in range(x.shape[1]):
                x[i, a] += alpha * p[i, a]
                r = rest[i, a] - alpha * q[i, a]
                rest[i, a] = r
                square += r * r
            for a in range(x.shape[1]):
                inner += rest[i, a] * _eased(i, a, couplings.diagonal, couplings.hold, rest)
        partial[block, 0] = square
        partial[block, 1] = inner


@loop
def _turn(couplings, rest, beta, p):
    n = p.shape[0]
    for block in prange((n + BLOCK - 1) // BLOCK):
        for i in range(block * BLOCK, min(block * BLOCK + BLOCK, n)):
            for a in range(p.shape[1]):
                eased = _eased(i, a, couplings.diagonal, couplings.hold, rest)
                p[i, a] = eased + beta * p[i, a]


@allocating_kernel
def solve(couplings, near, right, goal, most, x):
    """Solve for x, (n, m) float64 array, by conjugate gradients from the start that it holds.

    A first step of Jacobi's iteration takes a particle that touches nothing to its solution,
    however few such there are; the criterion, a mean, would not see them.  Then until the sum of
    the squared residual is not above the goal.  Sums run over blocks of a fixed size, so that the
    result has the same bits on any number of threads.

    Returns
    -------
    int
        Iterations, or -1 if ``most`` did not suffice.
    """
    partial = np.zeros(((x.shape[0] + BLOCK - 1) // BLOCK, 2))
    rest, p, q = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    _multiply(couplings, near, x, rest, partial)
    _begin(couplings, right, x, rest, p)
    _multiply(couplings, near, p, q, partial)
    _advance(couplings, 1.0, p, q, x, rest, partial)
    square, inner, beta = partial[:, 0].sum(), partial[:, 1].sum(), 0.0
    for iteration in range(1, most + 1):
        if square <= goal:
            return iteration
        _turn(couplings, rest, beta, p)
        _multiply(couplings, near, p, q, partial)
        curvature = partial[:, 0].sum()
        if not curvature > 0.0:
            return -1
        _advance(couplings, inner / curvature, p, q, x, rest, partial)
        square, last = partial[:, 0].sum(), inner
        inner = partial[:, 1].sum()
        beta = inner / last
    return -1


def couplings_of(near: Near, is_free: NDArray[np.bool_]) -> Couplings:
    """Return room for the rows of fluid and supply, and which of them are unknowns."""
    return Couplings(
        value=np.empty((is_free.size, near.neighbors.shape[1]), dtype=np.float32),
        diagonal=np.empty(is_free.size),
        is_free=is_free,
    )


def solve_pairs(
    name: str, system: Couplings, near: Near, right: Floats, goal: float, x: Floats
) -> int:
    """Solve for x, which holds the start, and return the iterations.

    Parameters
    ----------
    name : str
        What is solved, for the error.
    system : Couplings
    near : Near
    right, x : (n, m) float64 array
    goal : float
        Sum of the squared residual at which to stop.

    Raises
    ------
    NotConvergedError
    """
    iterations = int(solve(system, near, right, goal, MOST_ITERATIONS, x))
    if iterations < 0:
        raise NotConvergedError(name)
    return iterations


def left_undone(system: Couplings, near: Near, right: Floats, x: Floats) -> Floats:
    """Return the sum of the residual ``right - A x`` over all unknowns, (m,) float64 array."""
    product = np.empty_like(x)
    partial = np.zeros(((x.shape[0] + BLOCK - 1) // BLOCK, 2))
    _multiply(system, near, x, product, partial)
    rest: Floats = np.sum(right - product, axis=0, where=system.is_free[:, None])
    return rest
