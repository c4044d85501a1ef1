"""Solvers of linear systems: conjugate gradients and stabilized biconjugate gradients.

Every sum runs over blocks of a fixed number of rows, so that the result has the same bits on any
number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.schemes.multigrid import NO_HIERARCHY, Hierarchy, cycle, hierarchy
from debrisflow.schemes.system import Floats, System, multiply, residual

BLOCK = 1024


@loop
def _dot(x, y, partial):
    n = x.size
    for block in prange(partial.size):
        total = 0.0
        for i in range(block * BLOCK, min((block + 1) * BLOCK, n)):
            total += x[i] * y[i]
        partial[block] = total


@kernel
def _inner(x, y, partial):
    _dot(x, y, partial)
    total = 0.0
    for block in range(partial.size):
        total += partial[block]
    return total


@loop
def _add(x, factor, y):
    for i in prange(x.size):
        x[i] += factor * y[i]


@loop
def _scale_and_add(x, factor, y):
    for i in prange(x.size):
        x[i] = y[i] + factor * x[i]


@kernel
def _divide(system, right, z):
    """Jacobi: write ``right / diagonal`` where the solution is not given."""
    for i in range(z.size):
        z[i] = right[i] / system.diagonal[i] if system.entries[i] > 0 else 0.0


@kernel
def _precondition(system, h, use_multigrid, right, z, old, room):
    if use_multigrid:
        cycle(system, h, right, z, old, room[0], room[1], room[2])
    else:
        _divide(system, right, z)


@allocating_kernel
def conjugate_gradients(system, h, use_multigrid, tolerance, most, x, partial):
    """Solve a symmetric positive definite system from the given start.

    Stops when the residual's 2-norm is below ``tolerance`` times that of the right side.

    Parameters
    ----------
    system : System
    h : Hierarchy
        Used if ``use_multigrid``, else the diagonal is the preconditioner.
    use_multigrid : bool
    tolerance : float
    most : int
        Iterations after which the solver gives up.
    x : (m,) float64 array
        The start; holds the solution on return.
    partial : (blocks,) float64 array
        Room for partial sums.

    Returns
    -------
    int
        Iterations, or -1 if they did not suffice.
    """
    n = x.size
    rest, z, p = np.empty(n), np.empty(n), np.zeros(n)
    old = np.empty(n)
    room = np.empty((3, h.diagonal.size + h.inverse.shape[0]))
    for i in range(n):
        if system.entries[i] == 0:
            x[i] = system.right[i] / system.diagonal[i]
    residual(system, system.right, x, rest)
    goal = tolerance * tolerance * _inner(system.right, system.right, partial)
    if goal == 0.0:
        x[:] = 0.0
        return 0
    if _inner(rest, rest, partial) <= goal:
        return 0
    last = 1.0
    for iteration in range(1, most + 1):
        _precondition(system, h, use_multigrid, rest, z, old, room)
        rz = _inner(rest, z, partial)
        _scale_and_add(p, rz / last, z)
        last = rz
        multiply(system, p, z)
        curvature = _inner(p, z, partial)
        if not curvature > 0.0:
            return -1
        _add(x, rz / curvature, p)
        _add(rest, -rz / curvature, z)
        if _inner(rest, rest, partial) <= goal:
            return iteration
    return -1


@allocating_kernel
def stabilized_biconjugate_gradients(system, h, use_multigrid, tolerance, most, x, partial):
    """Solve a system that need not be symmetric; parameters as in :func:`conjugate_gradients`.

    References
    ----------
    van der Vorst 1992, doi:10.1137/0913035.
    """
    n = x.size
    rest, p, v = np.empty(n), np.zeros(n), np.zeros(n)
    z, t, old = np.empty(n), np.empty(n), np.empty(n)
    room = np.empty((3, h.diagonal.size + h.inverse.shape[0]))
    for i in range(n):
        if system.entries[i] == 0:
            x[i] = system.right[i] / system.diagonal[i]
    residual(system, system.right, x, rest)
    shadow = rest.copy()
    goal = tolerance * tolerance * _inner(system.right, system.right, partial)
    if goal == 0.0:
        x[:] = 0.0
        return 0
    if _inner(rest, rest, partial) <= goal:
        return 0
    rho, alpha, omega = 1.0, 1.0, 1.0
    for iteration in range(1, most + 1):
        rho_next = _inner(shadow, rest, partial)
        beta = rho_next / rho * alpha / omega
        rho = rho_next
        _add(p, -omega, v)
        _scale_and_add(p, beta, rest)
        _precondition(system, h, use_multigrid, p, z, old, room)
        multiply(system, z, v)
        alpha = rho / _inner(shadow, v, partial)
        _add(x, alpha, z)
        _add(rest, -alpha, v)
        if _inner(rest, rest, partial) <= goal:
            return iteration
        _precondition(system, h, use_multigrid, rest, z, old, room)
        multiply(system, z, t)
        omega = _inner(t, rest, partial) / _inner(t, t, partial)
        if not abs(omega) < np.inf:
            return -1
        _add(x, omega, z)
        _add(rest, -omega, t)
        if _inner(rest, rest, partial) <= goal:
            return iteration
    return -1


@kernel
def remove_mean(system):
    """Make the right side orthogonal to the constants if no row of the system is given.

    Returns whether the system is singular, that is defined up to a constant.
    """
    for i in range(system.entries.size):
        if system.entries[i] == 0:
            return False
    mean = system.right.sum() / system.right.size
    for i in range(system.right.size):
        system.right[i] -= mean
    return True


class Solver:
    """Solves systems of one shape after another, from the last solution.

    A large system is preconditioned by multigrid, unless many rows are given: so it is where the
    fluid is thin and its free surface near everywhere, and conjugate gradients are fast alone.

    Parameters
    ----------
    tolerance : float
        Greatest residual relative to the right side.
    symmetric : bool
        Conjugate gradients if true, else stabilized biconjugate gradients.
    """

    MULTIGRID_FROM = 6000
    MULTIGRID_BELOW = 0.05  # share of given rows
    MOST_ITERATIONS = 1000

    def __init__(self, tolerance: float, symmetric: bool = True) -> None:
        self.tolerance = tolerance
        self._solve = conjugate_gradients if symmetric else stabilized_biconjugate_gradients
        self._hierarchy: Hierarchy | None = None

    def forget(self) -> None:
        """Drop the multigrid hierarchy, so that the next solve builds a new one."""
        self._hierarchy = None

    def solve(self, system: System, x: Floats) -> int:
        """Write the solution into ``x``, which holds the start; return iterations, or -1."""
        rows = system.entries.size
        given = rows - np.count_nonzero(system.entries)
        use_multigrid = rows >= self.MULTIGRID_FROM and given < self.MULTIGRID_BELOW * rows
        if not use_multigrid:
            self._hierarchy = NO_HIERARCHY
        elif self._hierarchy is None or self._hierarchy.size[0] != rows:
            self._hierarchy = hierarchy(system)
        partial = np.empty(-(-rows // BLOCK))
        return int(
            self._solve(
                system,
                self._hierarchy,
                use_multigrid,
                self.tolerance,
                self.MOST_ITERATIONS,
                x,
                partial,
            )
        )
