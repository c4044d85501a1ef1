"""Implicit exchange of momentum and the static balance of grains in the explicit scheme."""

import numpy as np
import pytest

from debrisflow._jit import set_threads
from debrisflow.neighbors.boundary import LEAST_HEIGHT
from debrisflow.neighbors.half_space import PULLED_BACK, STRETCH, push_beyond
from debrisflow.neighbors.lattice import reference
from debrisflow.physics import images
from debrisflow.physics.momentum_exchange import Flow, couple_momentum, resist, wall_drag_at
from debrisflow.physics.operators import velocity_gradients
from debrisflow.schemes.pair_solver import Couplings, solve
from tests.building import (
    COULOMB,
    HERSCHEL_BULKLEY,
    MUD,
    NOWHERE,
    Plane,
    lattice_block,
    no_walls,
    numbers_of,
    one_list,
    planes,
    random_patch,
    separations,
    solid_of,
    two_lists,
)

SPACING = 0.5
LATTICE = reference(3, 2.4, SPACING)
GRAVITY = numbers_of(LATTICE).gravity
LENGTH = 9.0 * SPACING
PERIODS = [NOWHERE, np.array([0.0, LENGTH, 0.0])]
DOWN = GRAVITY / np.linalg.norm(GRAVITY)
DT, COUNT = 0.002, 300
NO_WALLS = no_walls(2000)
LAW = HERSCHEL_BULKLEY
SUBMERGED = 1650.0 * np.array([0.0, 0.0, -10.0])

SINGLE = 2.0**-23  # the coefficients are kept in single precision
EXACT = 1e-12  # one rounding of each of some 50 terms, relative to the greatest


@pytest.fixture
def rng():
    return np.random.default_rng(29)


@pytest.fixture(params=PERIODS, ids=["open", "periodic"])
def period(request):
    return request.param


@pytest.fixture
def position(rng):
    return random_patch(3, COUNT, rng, LENGTH)


@pytest.fixture
def solid(position):
    """Return what the particles feel of a free-slip and two no-slip walls, not at right angles."""
    return walls_around(position)


def walls_around(position):
    return planes(
        position,
        LATTICE,
        Plane((0.0, 0.0, 0.2), (0.36, -0.48, 0.8)),
        Plane((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), slip=1.0),
        Plane((0.0, LENGTH, 0.0), (0.0, -0.8, 0.6)),
    )


@pytest.fixture(params=[0.0, 50.0], ids=["", "power law"])
def flow(rng, request):
    return flow_of(
        COUNT,
        density=rng.uniform(1000.0, 1800.0, COUNT),
        consistency=request.param * rng.uniform(1.0, 5.0, COUNT) if request.param else None,
        viscosity=rng.uniform(0.0, 1e5, COUNT),
        strength=rng.uniform(0.0, 5e6, COUNT),
        deepening=rng.uniform(0.0, 1e7, COUNT),
        ramp=np.clip(rng.uniform(-0.5, 1.5, COUNT), 0.0, 1.0),
        gradient=(rng.normal(size=(COUNT, 9)) * rng.uniform(0, 10, (COUNT, 1))).astype("f4"),
        least_viscosity=6e4,
    )


def flow_of(count, **known):
    """Return what resists the shear; by default water without viscosity."""
    fields = {name: np.zeros(count) for name in Flow._fields}
    fields |= {"density": np.full(count, 1000.0), "least_viscosity": 0.0}
    fields |= {"gradient": np.zeros((count, 9), np.float32), "consistency": None}
    return Flow(**(fields | known))


def empty_couplings(near, is_free=None):
    count = near.fluid_count.size
    free = np.ones(count, dtype=bool) if is_free is None else is_free
    return Couplings(
        value=np.full(near.neighbors.shape, np.nan, dtype=np.float32),
        diagonal=np.full(count, np.nan),
        is_free=free,
    )


def mirrors_of(near, solid):
    """Return the mirrors of all particles."""
    mirrors = images.no_mirrors(near.fluid_count.size)
    images.find_mirrors(near, solid, mirrors)
    return mirrors


def coupled_momentum(position, solid, flow, period=NOWHERE, is_free=None, velocity=None):
    """Return couplings of momentum, and who is near whom; of particles at rest by default."""
    near = two_lists(position, LATTICE, period)
    velocity = np.zeros_like(position) if velocity is None else velocity
    found, mirrors = empty_couplings(near, is_free), mirrors_of(near, solid)
    right = np.zeros_like(position)
    drags = np.empty(len(position))
    couple_momentum(DT, velocity, near, solid, flow, mirrors, LAW, DOWN, found, right, drags)
    assert not right.any()  # walls are at rest
    return found, near


def dense(couplings, near):
    """Return the matrix of a system, (n, n) array, with all rows free."""
    matrix = np.diag(couplings.diagonal)
    for i, count in enumerate(near.fluid_count):
        np.subtract.at(matrix[i], near.neighbors[i, :count], couplings.value[i, :count])
    return matrix


def solved_exactly(couplings, near, right, x):
    """Return the solution by elimination, with x in the rows that are given."""
    matrix, free = dense(couplings, near), couplings.is_free
    known = right[free] - matrix[np.ix_(free, ~free)] @ x[~free]
    found = x.copy()
    found[free] = np.linalg.solve(matrix[np.ix_(free, free)], known)
    return found


def weight(distance):
    """Return ``(2 Ds/n0) w/r^2`` at a distance, m."""
    distance = np.maximum(distance, 0.1 * SPACING)
    w = np.maximum(LATTICE.effective_radius / distance - 1.0, 0.0)
    return 6.0 / LATTICE.number_density * w / distance**2


def weights(position, others=None, period=NOWHERE):
    """Return separation and coupling weight of all pairs, 0 of a particle with itself."""
    r = separations(position, period, others)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    return r, weight(distance)


def image_weights(position, solid, period):
    """Return the coupling weight of the images of all pairs in the wall that both are near."""
    mirrors = mirrors_of(two_lists(position, LATTICE, period), solid)
    alike = mirrors.normal @ mirrors.normal.T >= images.ALIKE
    r = separations(position, period)
    across = mirrors.height[:, None] * mirrors.height
    distance = np.sqrt(np.sum(r**2, axis=2) + 4.0 * across)
    return np.where(alike, weight(distance), 0.0)


def strain_rates(gradient):
    """Return ``sqrt(2 D : D)`` of gradients, (..., 3, 3) array."""
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    return np.sqrt(2.0 * np.sum(strain**2, axis=(-1, -2)))


def shear_rates(gradient, r, difference):
    """Return the shear rates between particles, from mean gradient, separation and difference."""
    distance = np.linalg.norm(r, axis=-1, keepdims=True)
    distance[distance == 0.0] = 1.0
    along = np.einsum("...kl,...l->...k", gradient, r / distance)
    rate = strain_rates(gradient)
    own, mean = (np.sum(d**2, axis=-1) for d in (difference / distance, along))
    return rate * np.sqrt((own + 0.01 * rate**2) / np.maximum(mean + 0.01 * rate**2, 1e-300))


def yielding(strength, rate):
    return np.minimum(strength / np.maximum(rate, LAW.smallest_shear_rate), LAW.largest_viscosity)


def thinning(consistency, rate):
    rate = np.maximum(rate, LAW.smallest_shear_rate)
    return np.minimum(consistency * rate ** (LAW.exponent - 1.0), LAW.largest_viscosity)


def mean(values):
    return 0.5 * (values[None] + values[:, None])


def harmonic(values):
    return 2.0 * values[None] * values[:, None] / (values[None] + values[:, None])


def expected_matrix(position, velocity, solid, flow, period):
    """Return the matrix of the exchange from sums over all pairs."""
    r, w = weights(position, period=period)
    w = w + image_weights(position, solid, period) * (w > 0.0)
    gradient = flow.gradient.reshape(-1, 3, 3)
    difference = velocity[None] - velocity[:, None]
    rate = shear_rates(mean(gradient), r, difference)
    share = np.minimum(flow.ramp[None], flow.ramp[:, None])
    strength = share * mean(flow.strength)
    mu = harmonic(flow.viscosity) + yielding(strength, rate)
    if flow.consistency is not None:
        mu += share * thinning(mean(flow.consistency), rate)
    coefficient = DT * w * np.maximum(mu, flow.least_viscosity)
    drag = [wall_drag(i, velocity[i], solid, flow, gradient[i]) for i in range(len(position))]
    return np.diag(flow.density + coefficient.sum(axis=1) + DT * np.array(drag)) - coefficient


def wall_drag(i, velocity, solid, flow, gradient):
    """Return the sum of ``(2 Ds/n0) mu G / h`` over the no-slip faces before a particle."""
    found, row = 0.0, solid.row[i]
    for f in range(solid.faces[row] if row >= 0 else 0):
        normal, number = solid.normal[row, f], solid.number[row, f]
        height = max(solid.distance[row, f], LEAST_HEIGHT * SPACING)
        depth = -height * normal @ DOWN
        on_wall = flow.ramp[i] * max(flow.strength[i] + depth * flow.deepening[i], 0.0)
        rate = shear_rates(gradient, normal, velocity / height)
        mu = flow.viscosity[i] + yielding(on_wall, rate)
        if flow.consistency is not None:
            mu += flow.ramp[i] * thinning(flow.consistency[i], rate)
        pull = 6.0 / LATTICE.number_density * solid.push[row, f] / height
        found += pull * mu * (1.0 - solid.slip[number])
    return found


@pytest.mark.parametrize("is_moving", [False, True])
def test_the_exchange_of_momentum_is_the_sum_over_all_pairs(
    position, solid, flow, period, is_moving, rng
):
    velocity = is_moving * rng.normal(size=(COUNT, 3))
    couplings, near = coupled_momentum(position, solid, flow, period, velocity=velocity)
    expected = expected_matrix(position, velocity, solid, flow, period)
    assert np.count_nonzero(expected - np.diag(np.diag(expected))) > 15 * COUNT
    # rounded when written, and twice more where images are added
    np.testing.assert_allclose(dense(couplings, near), expected, rtol=3.0 * SINGLE)


def test_what_one_particle_loses_the_other_gains(position, solid, flow, period):
    couplings, near = coupled_momentum(position, solid, flow, period)
    matrix = dense(couplings, near)
    np.testing.assert_array_equal(matrix, matrix.T)
    couplings, near = coupled_momentum(position, NO_WALLS, flow, period)
    matrix = dense(couplings, near)
    # what is left of a row is the density: motion in common is not resisted
    rest = matrix.sum(axis=1) - flow.density
    assert np.abs(rest).max() < 1e-14 * np.abs(matrix).max()


def test_the_exchange_conserves_momentum_and_takes_energy(position, flow, rng, period):
    couplings, near = coupled_momentum(position, NO_WALLS, flow, period)
    velocity = rng.normal(size=(COUNT, 3))
    right = flow.density[:, None] * velocity
    after = np.zeros((COUNT, 3))
    assert solve(couplings, near, right, 1e-26 * np.sum(right**2), 2000, after) > 0
    before = flow.density @ velocity
    np.testing.assert_allclose(flow.density @ after, before, atol=EXACT * np.abs(right).sum())
    energy = [flow.density @ np.sum(u**2, axis=1) for u in (velocity, after)]
    assert energy[1] < 0.5 * energy[0]


@pytest.mark.parametrize("columns", [1, 3])
@pytest.mark.parametrize("supplied", [0, 40])
def test_the_solution_is_that_by_elimination(position, solid, flow, rng, columns, supplied):
    free = np.arange(COUNT) < COUNT - supplied
    couplings, near = coupled_momentum(position, solid, flow, PERIODS[1], free)
    right, start = rng.normal(size=(2, COUNT, columns))
    right *= 1000.0
    found = start.copy()
    goal = 1e-26 * np.sum(right[free] ** 2)
    iterations = solve(couplings, near, right, goal, 2000, found)
    assert 1 < iterations < 1000
    expected = solved_exactly(couplings, near, right, start)
    np.testing.assert_array_equal(found[~free], start[~free])
    # the residual, over the least eigenvalue, which is not less than the least density
    error = np.linalg.norm(found - expected)
    assert error < 1e-13 * np.linalg.norm(right) / 1000.0 + EXACT * np.linalg.norm(expected)
    # less was asked, less was done, and no more is left than was asked
    loose = start.copy()
    goal = 1e-4 * np.sum(right[free] ** 2)
    assert solve(couplings, near, right, goal, 2000, loose) < iterations
    rest = (right - dense(couplings, near) @ loose)[free]
    assert np.sum(rest**2) <= goal * (1.0 + 1e-9)


def test_a_solution_is_found_at_once_and_an_unreachable_one_is_told(position, flow, rng):
    couplings, near = coupled_momentum(position, NO_WALLS, flow)
    right = 1000.0 * rng.normal(size=(COUNT, 3))
    goal = 1e-20 * np.sum(right**2)
    x = np.zeros((COUNT, 3))
    solve(couplings, near, right, goal, 2000, x)
    assert solve(couplings, near, right, 10.0 * goal, 2000, x.copy()) == 1
    assert solve(couplings, near, right, goal, 3, np.zeros((COUNT, 3))) == -1
    right[7, 1] = np.nan
    assert solve(couplings, near, right, goal, 2000, np.zeros((COUNT, 3))) == -1


def crowd_and_stray(viscosity):
    """Return particles in a stiff block, with a last one far from all of them, and the flow."""
    block = lattice_block(3, 6, SPACING)
    position = np.concatenate([block, [[50.0, 0.0, 0.0]]])
    return position, flow_of(len(position), viscosity=np.full(len(position), viscosity))


@pytest.mark.parametrize("goal", [1e-12, 1e3, np.inf])
def test_what_touches_nothing_falls_freely_however_lax_the_goal(goal, rng):
    position, flow = crowd_and_stray(viscosity=1e6)
    couplings, near = coupled_momentum(position, NO_WALLS, flow)
    started = rng.normal(size=position.shape)
    fallen = started + DT * np.array([0.0, 0.0, -9.81])
    x = started.copy()
    solve(couplings, near, 1000.0 * fallen, goal, 2000, x)
    np.testing.assert_allclose(x[-1], fallen[-1], rtol=1e-15)


def test_what_touches_only_a_wall_gets_its_solution_however_lax_the_goal():
    position, flow = crowd_and_stray(viscosity=1e3)
    solid = planes(position, LATTICE, Plane((0.0, 0.0, -0.25)))
    couplings, near = coupled_momentum(position, solid, flow)
    x, right = np.zeros_like(position), np.full_like(position, 500.0)
    solve(couplings, near, right, np.inf, 2000, x)
    assert solid.faces[solid.row[-1]] == 1
    np.testing.assert_allclose(x[-1], 500.0 / couplings.diagonal[-1], rtol=1e-15)
    assert couplings.diagonal[-1] > 1001.0


def test_nobody_is_solved_for():
    couplings, near = coupled_momentum(np.zeros((0, 3)), NO_WALLS, flow_of(0))
    assert solve(couplings, near, np.zeros((0, 3)), 0.0, 10, np.zeros((0, 3))) == 1


@pytest.mark.parametrize("columns", [1, 3])
def test_two_threads_solve_to_the_same_bits_as_one(rng, columns):
    count = 2000
    position, velocity = random_patch(3, count, rng, 6.0), rng.normal(size=(count, 3))
    solid = walls_around(position)
    viscosity, strength = rng.uniform(0.0, 1e6, (2, count))
    flow = flow_of(count, viscosity=viscosity, strength=strength, ramp=np.ones(count))
    right, found = 1000.0 * rng.normal(size=(count, columns)), []
    try:
        for threads in (1, 2):
            assert set_threads(threads) == threads
            near, rate = two_lists(position, LATTICE), np.empty(count)
            velocity_gradients(velocity, near, solid, flow.gradient, rate)
            couplings, near = coupled_momentum(position, solid, flow, velocity=velocity)
            x = np.zeros((count, columns))
            iterations = solve(couplings, near, right, 1e-12 * np.sum(right**2), 2000, x)
            found.append((iterations, couplings.diagonal.tobytes(), x.tobytes()))
    finally:
        set_threads(1)
    assert found[0][0] > 5
    assert found[0] == found[1]


def over_floor(height, **known):
    """Return who is near whom, and the floor under one particle at a height."""
    position = np.array([[0.0, 0.0, height]])
    return two_lists(position, LATTICE), planes(position, LATTICE, Plane(**known))


def seen(height):
    """Return the integral of ``w r_n / r^2`` under a floor, times d0."""
    q = STRETCH * (height / SPACING + PULLED_BACK)
    return push_beyond(q, LATTICE.effective_radius / SPACING)


def floor_pull(height):
    """Return ``(2 Ds/n0)`` times the integral of ``(w/r^2) (r_n / h)`` under a floor, 1/m2."""
    return 6.0 / LATTICE.number_density * seen(height) / (SPACING * height)


@pytest.mark.parametrize("height", [0.3, 0.7, 1.1])
@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_wall_resists_with_the_strength_at_its_surface(height, slip):
    down, velocity = np.array([0.0, 0.0, -1.0]), np.array([[0.3, 0.4, 0.0]])
    near, solid = over_floor(height, slip=slip)
    flow = flow_of(
        1,
        viscosity=np.array([3.0]),
        strength=np.array([100.0]),
        deepening=np.array([800.0]),
        ramp=np.array([0.5]),
        least_viscosity=1e9,  # does not act on walls
    )
    flow.gradient[0, [2, 5]] = 3.0, 4.0  # of another shear rate, of the same direction
    drag, *_ = wall_drag_at(0, velocity, near, solid, flow, LAW, down)
    rate = 0.5 / height  # of the straight profile down to the surface
    rate = 5.0 * np.sqrt((rate**2 + 0.25) / (25.0 + 0.25))
    mu = 3.0 + 0.5 * (100.0 + 800.0 * height) / rate
    assert drag == pytest.approx(floor_pull(height) * mu * (1.0 - slip), rel=1e-12)
    # sideways, as on a side wall, the depth at the surface is that of the particle
    drag, *_ = wall_drag_at(0, velocity, near, solid, flow, LAW, np.array([1.0, 0, 0]))
    mu = 3.0 + 0.5 * 100.0 / rate
    assert drag == pytest.approx(floor_pull(height) * mu * (1.0 - slip), rel=1e-12)


@pytest.mark.parametrize("roughness", [0.0, 0.01])
def test_a_wall_of_particles_that_moves_drags_along_and_a_rough_one_takes_no_eddies(roughness):
    velocity, wall = np.array([[0.5, 0.2, 0.0]]), np.array([[2.0, -1.0, 0.0]])
    below = np.array([[0.0, 0.0, -0.25]])
    solid = solid_of(below, depth=0.25, roughness=roughness, velocity=wall)
    near = one_list(np.concatenate([[[0.0, 0.0, 0.25]], below]), LATTICE, rows=1)
    flow = flow_of(1, viscosity=np.array([3.0]), eddies=np.array([2.0]))
    drag, *pull = wall_drag_at(0, velocity, near, solid, flow, LAW, DOWN)
    viscosity = 1.0 if roughness else 3.0
    assert drag == pytest.approx(2.0 * weight(0.5) * viscosity, rel=1e-12)
    np.testing.assert_allclose(pull, drag * wall[0], rtol=1e-12)


def test_the_drag_of_a_wall_stays_bounded_where_contact_holds_the_particle():
    flow, velocity = flow_of(1, viscosity=np.array([3.0])), np.ones((1, 3))
    heights = SPACING * np.array([0.5, LEAST_HEIGHT, 0.1, 0.0])
    drags = [wall_drag_at(0, velocity, *over_floor(h), flow, LAW, DOWN)[0] for h in heights]
    assert np.all(np.diff(drags) > 0.0)
    # it grows no more than the push of the half space, from 5.2 to 7.2
    assert drags[-1] < 1.6 * drags[1]


def test_what_would_pull_under_a_ceiling_has_no_strength():
    up = np.array([0.0, 0.0, 1.0])
    near, solid = over_floor(0.3)
    strong = {"strength": np.array([100.0]), "deepening": np.array([800.0]), "ramp": np.ones(1)}
    drag, *_ = wall_drag_at(0, np.zeros((1, 3)), near, solid, flow_of(1, **strong), LAW, up)
    assert drag == 0.0


def test_strength_and_its_growth_with_depth_are_those_of_the_law():
    pressure, weight = np.array([0.0, 400.0]), np.array([0.0, 9000.0])
    c = np.array([0.1, 0.3])
    flow = flow_of(
        2,
        concentration=c,
        viscosity=np.array([0.1, 0.2]),
        shear_rate=np.array([4.0, 0.0]),
    )
    resist(pressure, weight, SPACING, COULOMB, flow)
    np.testing.assert_allclose(flow.ramp, [0.0, 2.0 / 3.0], rtol=1e-12)
    np.testing.assert_allclose(flow.strength, 0.7 * pressure, rtol=1e-13)
    np.testing.assert_allclose(flow.deepening, 0.7 * weight, rtol=1e-11)
    np.testing.assert_array_equal(flow.viscosity, [0.1, 0.2])  # the consistency is one of pairs
    resist(pressure, weight, SPACING, MUD, flow)
    np.testing.assert_array_equal(flow.ramp, 1.0)
    np.testing.assert_allclose(flow.strength, 0.0181 * np.exp(25.7 * c), rtol=1e-13)
    np.testing.assert_array_equal(flow.deepening, 0.0)
