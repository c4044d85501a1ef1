"""Linear solvers on the Laplacian of a lattice, against SciPy's direct solver."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import spsolve

from debrisflow.schemes import linear, multigrid
from debrisflow.schemes.linear import Solver, conjugate_gradients, stabilized_biconjugate_gradients
from debrisflow.schemes.system import empty_system, multiply, residual

SIDE = 50
RADIUS = 3.1
SOLVERS = [conjugate_gradients, stabilized_biconjugate_gradients]


@pytest.fixture
def rng():
    return np.random.default_rng(23)


def lattice_system(side, rng, interface=(0.0, 0.0, 1.0), is_given=True):
    """Return the pressure equation of a square of lattice, with a random right side.

    Water and sediment lie at random; ``own / rho_i + other / rho_j + mean 2/(rho_i + rho_j)`` is
    the coefficient.  The last row of particles is given, like a free surface, the other sides are
    natural boundaries.
    """
    reach = np.arange(-int(RADIUS), int(RADIUS) + 1)
    a, b = (offset.ravel() for offset in np.meshgrid(reach, reach))
    r = np.hypot(a, b)
    a, b, r = (offset[(r > 0) & (r < RADIUS)] for offset in (a, b, r))
    row, column = np.divmod(np.arange(side * side), side)
    row, column = row[:, None] + a, column[:, None] + b
    is_inside = (np.minimum(row, column) >= 0) & (np.maximum(row, column) < side)
    order = np.argsort(~is_inside, axis=1, kind="stable")
    index = np.where(is_inside, row * side + column, 0)
    index = np.take_along_axis(index, order, axis=1).astype(np.int32)
    value = np.take_along_axis(np.where(is_inside, RADIUS / r**3, 0.0), order, axis=1)
    own, other, mean = interface
    density = rng.choice([1.0, 2.65], side * side)
    mine, theirs = density[:, None], density[index]
    system = empty_system(*index.shape)
    system.columns[:] = index
    system.value[:] = value * (own / mine + other / theirs + mean * 2.0 / (mine + theirs))
    system.entries[:] = is_inside.sum(axis=1)
    system.diagonal[:] = system.value.sum(axis=1)
    system.right[:] = rng.normal(size=side * side)
    if is_given:
        system.entries[-side:] = 0
        system.diagonal[-side:] = 2.0
    return system


def matrix_of(system):
    """Return a system as a SciPy matrix; given rows hold their diagonal alone."""
    m, capacity = system.columns.shape
    is_entry = np.arange(capacity) < system.entries[:, None]
    i, j = np.nonzero(is_entry)[0], system.columns[is_entry]
    entries = np.concatenate([system.diagonal, -system.value[is_entry]])
    every = np.arange(m)
    places = (np.concatenate([every, i]), np.concatenate([every, j]))
    return csr_matrix((entries, places), shape=(m, m))


def solved(solve, system, tolerance=1e-10, most=1000, start=None, with_multigrid=False):
    """Return iterations and solution."""
    x = np.zeros(system.right.size) if start is None else start.copy()
    levels = multigrid.hierarchy(system) if with_multigrid else multigrid.NO_HIERARCHY
    partial = np.empty(-(-x.size // linear.BLOCK))
    return solve(system, levels, with_multigrid, tolerance, most, x, partial), x


def v_cycle(system, levels, right):
    """Return one cycle of multigrid from zero."""
    z, old = np.empty(right.size), np.empty(right.size)
    room = np.empty((3, levels.diagonal.size + levels.inverse.shape[0]))
    multigrid.cycle(system, levels, right, z, old, *room)
    return z


def test_multiply_and_residual_are_the_matrix_product(rng):
    system = lattice_system(SIDE, rng, interface=(4.0, -1.0, 0.0))
    x, y, rest = rng.normal(size=(3, SIDE**2))
    multiply(system, x, y)
    expected = matrix_of(system) @ x
    # sums of 29 terms of order 10
    np.testing.assert_allclose(y, expected, atol=1e-13)
    residual(system, system.right, x, rest)
    is_given = system.entries == 0
    np.testing.assert_allclose(rest, np.where(is_given, 0.0, system.right - expected), atol=1e-13)


@pytest.mark.parametrize("with_multigrid", [False, True])
@pytest.mark.parametrize("solve", SOLVERS)
def test_solvers_agree_with_the_direct_one(rng, solve, with_multigrid):
    system = lattice_system(SIDE, rng)
    iterations, x = solved(solve, system, with_multigrid=with_multigrid)
    assert 0 < iterations < (20 if with_multigrid else 300)
    expected = spsolve(matrix_of(system), system.right)
    # the residual is 1e-10 of the right side; the condition number of 50 rows is some 1e3
    np.testing.assert_allclose(x, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("with_multigrid", [False, True])
def test_the_unsymmetric_equation_of_the_study_is_solved(rng, with_multigrid):
    system = lattice_system(SIDE, rng, interface=(4.0, -1.0, 0.0))
    matrix = matrix_of(system)
    free = matrix[:-SIDE, :-SIDE]
    assert np.abs((free - free.T).toarray()).max() > 1.0
    solve = stabilized_biconjugate_gradients
    iterations, x = solved(solve, system, with_multigrid=with_multigrid)
    assert iterations > 0
    expected = spsolve(matrix, system.right)
    np.testing.assert_allclose(x, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("with_multigrid", [False, True])
@pytest.mark.parametrize("solve", SOLVERS)
def test_given_rows_are_kept(rng, solve, with_multigrid):
    system = lattice_system(SIDE, rng)
    start = rng.normal(size=SIDE**2)
    _, x = solved(solve, system, start=start, with_multigrid=with_multigrid)
    assert np.array_equal(x[-SIDE:], system.right[-SIDE:] / system.diagonal[-SIDE:])


def test_the_residual_asked_for_is_reached(rng):
    system = lattice_system(SIDE, rng)
    rest = np.empty(SIDE**2)
    for tolerance in (1e-2, 1e-5, 1e-8):
        _, x = solved(conjugate_gradients, system, tolerance=tolerance)
        residual(system, system.right, x, rest)
        # the recurrence of the residual drifts from the residual by rounding only
        assert np.linalg.norm(rest) <= tolerance * np.linalg.norm(system.right) * (1 + 1e-6)


def test_the_v_cycle_is_symmetric_and_positive(rng):
    system = lattice_system(2 * SIDE, rng)
    levels = multigrid.hierarchy(system)
    assert levels.size.size >= 3
    x, z = rng.normal(size=(2, 4 * SIDE**2)) * (system.entries > 0)
    mx, mz = v_cycle(system, levels, x), v_cycle(system, levels, z)
    # rounding of sums over 10,000 products
    scale = np.linalg.norm(x) * np.linalg.norm(mz)
    assert abs(x @ mz - z @ mx) < 1e-12 * scale
    assert x @ mx > 0
    assert z @ mz > 0
    assert np.all(mx[system.entries == 0] == 0.0)


def test_the_v_cycle_removes_the_smooth_error_that_jacobi_leaves(rng):
    system = lattice_system(2 * SIDE, rng)
    matrix, is_free = matrix_of(system), system.entries > 0
    x = np.sin(np.arange(4 * SIDE**2) / (4 * SIDE**2) * np.pi) * is_free
    right = matrix @ x * is_free
    errors = [v_cycle(system, multigrid.hierarchy(system), right) - x, right / system.diagonal - x]
    left = [np.sqrt(error @ (matrix @ error) / (x @ (matrix @ x))) for error in errors]
    # what decides the count of iterations; aggregates of rock and water cost multigrid the rest
    assert left[0] < 0.6
    assert left[1] > 0.9


def test_iterations_with_multigrid_hardly_grow_with_the_unknowns(rng):
    few, many = (
        solved(conjugate_gradients, lattice_system(side, rng), 1e-8, with_multigrid=True)[0]
        for side in (SIDE, 4 * SIDE)
    )
    # 16 times the unknowns: Jacobi needs four times the iterations
    assert 0 < few <= many < 2 * few


def test_an_old_hierarchy_still_serves(rng):
    # the particles have moved a little since it was built
    system = lattice_system(SIDE, rng)
    levels = multigrid.hierarchy(system)
    system.value[:] *= 1.1
    system.diagonal[:] *= 1.1
    x = np.zeros(SIDE**2)
    iterations = conjugate_gradients(system, levels, True, 1e-10, 1000, x, np.empty(3))
    assert 0 < iterations < 20
    expected = spsolve(matrix_of(system), system.right)
    np.testing.assert_allclose(x, expected, atol=1e-7 * np.abs(expected).max())


def test_a_singular_system_is_solved_up_to_a_constant(rng):
    system = lattice_system(SIDE, rng, is_given=False)
    assert linear.remove_mean(system)
    assert abs(system.right.sum()) < 1e-12 * np.abs(system.right).sum()
    pinned = matrix_of(system).tolil()
    pinned[0] = 0.0
    pinned[0, 0] = 1.0
    expected = spsolve(pinned.tocsr(), np.concatenate([[0.0], system.right[1:]]))
    for with_multigrid in (False, True):
        iterations, x = solved(conjugate_gradients, system, with_multigrid=with_multigrid)
        assert iterations > 0
        np.testing.assert_allclose(x - x[0], expected, atol=1e-7 * np.abs(expected).max())


def test_a_system_with_given_rows_keeps_its_mean(rng):
    system = lattice_system(SIDE, rng)
    before = system.right.copy()
    assert not linear.remove_mean(system)
    assert np.array_equal(system.right, before)


@pytest.mark.parametrize("solve", SOLVERS)
def test_too_few_iterations_are_told(rng, solve):
    system = lattice_system(SIDE, rng)
    enough, _ = solved(solve, system)
    assert solved(solve, system, most=enough)[0] == enough
    assert solved(solve, system, most=enough - 1)[0] == -1


@pytest.mark.parametrize("solve", SOLVERS)
def test_nothing_on_the_right_means_nothing_to_do(rng, solve):
    system = lattice_system(SIDE, rng)
    system.right[:] = 0.0
    iterations, x = solved(solve, system)
    assert iterations == 0
    assert not x.any()


@pytest.mark.parametrize("solve", SOLVERS)
def test_nothing_on_the_right_is_solved_from_any_start(rng, solve):
    system = lattice_system(SIDE, rng)
    system.right[:] = 0.0
    iterations, x = solved(solve, system, 1e-4, start=rng.normal(size=SIDE**2))
    assert iterations >= 0
    np.testing.assert_allclose(x, 0.0, atol=1e-4)


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("side", [SIDE, 80])
def test_the_solver_goes_on_from_its_last_solution(rng, side, symmetric):
    # 50 x 50 with Jacobi, 80 x 80 with multigrid
    system = lattice_system(side, rng)
    solver = Solver(1e-8, symmetric)
    x = np.zeros(side**2)
    first = solver.solve(system, x)
    assert first > 0
    expected = spsolve(matrix_of(system), system.right)
    np.testing.assert_allclose(x, expected, atol=1e-5 * np.abs(expected).max())
    assert solver.solve(system, x) == 0
    solver.forget()
    system.right[:] *= 1.0 + 1e-6
    assert 0 < solver.solve(system, x) < first
