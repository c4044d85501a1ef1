"""Implicit exchange of momentum and the static balance of grains in the explicit scheme."""

import numpy as np
import pytest

from debrisflow import agitation, exchange, granular
from debrisflow._jit import set_threads
from debrisflow.lattice import reference
from tests.building import (
    NO_STRENGTH,
    NOWHERE,
    fluid_of,
    lattice_block,
    near_of,
    numbers_of,
    random_patch,
    separations,
    solid_of,
    stencil_of,
)

SPACING = 0.5
LATTICE = reference(3, 2.4, SPACING)
NUMBERS = numbers_of(LATTICE)
LENGTH = 9.0 * SPACING
PERIODS = [NOWHERE, np.array([0.0, LENGTH, 0.0])]
NO_WALLS = solid_of(np.zeros((0, 3)))
DOWN = NUMBERS.gravity / np.linalg.norm(NUMBERS.gravity)
DT, COUNT = 0.002, 300
LAW = NO_STRENGTH._replace(friction=0.7)
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
def fluid(rng):
    return fluid_of(random_patch(3, COUNT, rng, LENGTH))


@pytest.fixture
def solid(rng):
    """Return 150 wall particles anywhere, with normals in all directions, some free-slip."""
    normal = rng.normal(size=(150, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    depth, slip = rng.uniform(0.0, 3.0, 150) * SPACING, rng.choice([0.0, 1.0], 150)
    return solid_of(random_patch(3, 150, rng, LENGTH), normal, depth, slip)


@pytest.fixture
def flow(rng):
    return flow_of(
        COUNT,
        density=rng.uniform(1000.0, 1800.0, COUNT),
        viscosity=rng.uniform(0.0, 1e5, COUNT),
        strength=rng.uniform(0.0, 5e6, COUNT),
        deepening=rng.uniform(0.0, 1e7, COUNT),
        ramp=np.clip(rng.uniform(-0.5, 1.5, COUNT), 0.0, 1.0),
        gradient=(rng.normal(size=(COUNT, 9)) * rng.uniform(0, 10, (COUNT, 1))).astype("f4"),
        least_viscosity=6e4,
    )


def flow_of(count, **known):
    """Return what resists the shear; by default water without viscosity."""
    fields = {name: np.zeros(count) for name in exchange.Flow._fields}
    fields |= {"density": np.full(count, 1000.0), "least_viscosity": 0.0}
    fields |= {"gradient": np.zeros((count, 9), np.float32), "consistency": None}
    return exchange.Flow(**(fields | known))


def empty_couplings(near, is_free=None):
    count = near.fluid_count.size
    free = np.ones(count, dtype=bool) if is_free is None else is_free
    return exchange.Couplings(
        np.full(near.fluid.shape, np.nan, dtype=np.float32), np.full(count, np.nan), free
    )


def coupled_momentum(fluid, solid, flow, period=NOWHERE, is_free=None, dt=DT):
    """Return couplings of momentum, and who is near whom."""
    near = near_of(fluid, solid, LATTICE, period)
    found, mirror = empty_couplings(near, is_free), np.empty((near.fluid_count.size, 4))
    exchange.find_mirrors(fluid, solid, near, NUMBERS, mirror)
    exchange.couple_momentum(dt, fluid, solid, near, flow, mirror, LAW, DOWN, NUMBERS, found)
    return found, near


def dense(couplings, near):
    """Return the matrix of a system, (n, n) array, with all rows free."""
    matrix = np.diag(couplings.diagonal)
    for i, count in enumerate(near.fluid_count):
        np.subtract.at(matrix[i], near.fluid[i, :count], couplings.value[i, :count])
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
    w = np.maximum(LATTICE.effective_radius / distance - 1.0, 0.0)
    return 6.0 / LATTICE.number_density * w / distance**2


def weights(position, others=None, period=NOWHERE):
    """Return separation and coupling weight of all pairs, 0 of a particle with itself."""
    r = separations(position, period, others)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    return r, weight(distance)


def mirrored_weights(fluid, solid, period):
    """Return the coupling weight of the images of all pairs in their nearest free-slip wall."""
    r = separations(fluid.position, period, solid.position)
    height = -np.einsum("ijk,jk->ij", r, solid.normal) - solid.depth
    listed = np.linalg.norm(r, axis=2) < LATTICE.effective_radius
    height[(solid.slip == 0.0) | (height < 0.0) | ~listed] = np.inf
    nearest = height.min(axis=1, initial=np.inf)
    is_near = nearest < LATTICE.effective_radius
    normal = np.zeros_like(fluid.position)
    normal[is_near] = solid.normal[height.argmin(axis=1)[is_near]] if is_near.any() else 0.0
    alike = (normal @ normal.T >= 0.9) & ~np.eye(len(normal), dtype=bool)
    r = np.linalg.norm(separations(fluid.position, period), axis=2)
    nearest[~is_near] = 0.0
    distance = np.sqrt(r**2 + 4.0 * nearest[:, None] * nearest)
    return np.where(alike, weight(np.where(alike, distance, 1.0)), 0.0)


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


def mean(values):
    return 0.5 * (values[None] + values[:, None])


def expected_matrix(fluid, solid, flow, period):
    """Return the matrix of the exchange from sums over all pairs."""
    r, w = weights(fluid.position, period=period)
    w = w + mirrored_weights(fluid, solid, period) * (w > 0.0)
    gradient = flow.gradient.reshape(-1, 3, 3)
    difference = fluid.velocity[None] - fluid.velocity[:, None]
    rate = shear_rates(mean(gradient), r, difference)
    strength = np.minimum(flow.ramp[None], flow.ramp[:, None]) * mean(flow.strength)
    mu = mean(flow.viscosity) + yielding(strength, rate)
    coefficient = DT * w * np.maximum(mu, flow.least_viscosity)
    r, w = weights(fluid.position, solid.position, period)
    depth = 0.5 * r @ DOWN
    deeper = flow.strength[:, None] + depth * flow.deepening[:, None]
    on_wall = flow.ramp[:, None] * np.maximum(deeper, 0.0)
    height = -np.einsum("ijk,jk->ij", r, solid.normal) - solid.depth
    over = np.maximum(height, 0.5 * SPACING)[..., None]
    normal = np.broadcast_to(solid.normal, r.shape)
    rate = shear_rates(gradient[:, None], normal, fluid.velocity[:, None] / over)
    mu = flow.viscosity[:, None] + yielding(on_wall, rate)
    factor = 1.0 + solid.depth / over[..., 0]
    drag = (w * mu * factor * (1.0 - solid.slip)).sum(axis=1)
    return np.diag(flow.density + coefficient.sum(axis=1) + DT * drag) - coefficient


def test_the_exchange_of_momentum_is_the_sum_over_all_pairs(fluid, solid, flow, period):
    couplings, near = coupled_momentum(fluid, solid, flow, period)
    expected = expected_matrix(fluid, solid, flow, period)
    assert np.count_nonzero(expected - np.diag(np.diag(expected))) > 15 * COUNT
    # rounded when written, and twice more where images are added
    np.testing.assert_allclose(dense(couplings, near), expected, rtol=3.0 * SINGLE)


def test_what_one_particle_loses_the_other_gains(fluid, flow, period):
    couplings, near = coupled_momentum(fluid, NO_WALLS, flow, period)
    matrix = dense(couplings, near)
    np.testing.assert_array_equal(matrix, matrix.T)
    # what is left of a row is the density: motion in common is not resisted
    rest = matrix.sum(axis=1) - flow.density
    assert np.abs(rest).max() < 1e-14 * np.abs(matrix).max()


def test_the_exchange_conserves_momentum_and_takes_energy(fluid, flow, rng, period):
    couplings, near = coupled_momentum(fluid, NO_WALLS, flow, period)
    velocity = rng.normal(size=(COUNT, 3))
    right = flow.density[:, None] * velocity
    after = np.zeros((COUNT, 3))
    assert exchange.solve(couplings, near, right, 1e-26 * np.sum(right**2), 2000, after) > 0
    before = flow.density @ velocity
    np.testing.assert_allclose(flow.density @ after, before, atol=EXACT * np.abs(right).sum())
    energy = [flow.density @ np.sum(u**2, axis=1) for u in (velocity, after)]
    assert energy[1] < 0.5 * energy[0]


@pytest.mark.parametrize("columns", [1, 3])
@pytest.mark.parametrize("supplied", [0, 40])
def test_the_solution_is_that_by_elimination(fluid, solid, flow, rng, columns, supplied):
    free = np.arange(COUNT) < COUNT - supplied
    couplings, near = coupled_momentum(fluid, solid, flow, PERIODS[1], free)
    right, start = rng.normal(size=(2, COUNT, columns))
    right *= 1000.0
    found = start.copy()
    goal = 1e-26 * np.sum(right[free] ** 2)
    iterations = exchange.solve(couplings, near, right, goal, 2000, found)
    assert 1 < iterations < 1000
    expected = solved_exactly(couplings, near, right, start)
    np.testing.assert_array_equal(found[~free], start[~free])
    # the residual, over the least eigenvalue, which is not less than the least density
    error = np.linalg.norm(found - expected)
    assert error < 1e-13 * np.linalg.norm(right) / 1000.0 + EXACT * np.linalg.norm(expected)
    # less was asked, less was done, and no more is left than was asked
    loose = start.copy()
    goal = 1e-4 * np.sum(right[free] ** 2)
    assert exchange.solve(couplings, near, right, goal, 2000, loose) < iterations
    rest = (right - dense(couplings, near) @ loose)[free]
    assert np.sum(rest**2) <= goal * (1.0 + 1e-9)


def test_a_solution_is_found_at_once_and_an_unreachable_one_is_told(fluid, flow, rng):
    couplings, near = coupled_momentum(fluid, NO_WALLS, flow)
    right = 1000.0 * rng.normal(size=(COUNT, 3))
    goal = 1e-20 * np.sum(right**2)
    x = np.zeros((COUNT, 3))
    exchange.solve(couplings, near, right, goal, 2000, x)
    assert exchange.solve(couplings, near, right, 10.0 * goal, 2000, x.copy()) == 1
    assert exchange.solve(couplings, near, right, goal, 3, np.zeros((COUNT, 3))) == -1
    right[7, 1] = np.nan
    assert exchange.solve(couplings, near, right, goal, 2000, np.zeros((COUNT, 3))) == -1


def crowd_and_stray(viscosity):
    """Return particles in a stiff block, with a last one far from all of them, and the flow."""
    block = lattice_block(3, 6, SPACING)
    position = np.concatenate([block, [[50.0, 0.0, 0.0]]])
    return fluid_of(position), flow_of(len(position), viscosity=np.full(len(position), viscosity))


@pytest.mark.parametrize("goal", [1e-12, 1e3, np.inf])
def test_what_touches_nothing_falls_freely_however_lax_the_goal(goal, rng):
    fluid, flow = crowd_and_stray(viscosity=1e6)
    couplings, near = coupled_momentum(fluid, NO_WALLS, flow)
    started = rng.normal(size=fluid.position.shape)
    fallen = started + DT * np.array([0.0, 0.0, -9.81])
    x = started.copy()
    exchange.solve(couplings, near, 1000.0 * fallen, goal, 2000, x)
    np.testing.assert_allclose(x[-1], fallen[-1], rtol=1e-15)


def test_what_touches_only_a_wall_gets_its_solution_however_lax_the_goal():
    fluid, flow = crowd_and_stray(viscosity=1e3)
    floor = lattice_block(3, (5, 5, 2), SPACING) + np.array([48.75, -1.25, -1.25])
    solid = solid_of(floor, depth=-0.25 - floor[:, 2])
    couplings, near = coupled_momentum(fluid, solid, flow)
    x, right = np.zeros_like(fluid.position), np.full_like(fluid.position, 500.0)
    exchange.solve(couplings, near, right, np.inf, 2000, x)
    assert near.wall_count[-1] > 9
    np.testing.assert_allclose(x[-1], 500.0 / couplings.diagonal[-1], rtol=1e-15)
    assert couplings.diagonal[-1] > 1001.0


def test_nobody_is_solved_for():
    fluid = fluid_of(np.zeros((0, 3)))
    couplings, near = coupled_momentum(fluid, NO_WALLS, flow_of(0))
    assert exchange.solve(couplings, near, np.zeros((0, 3)), 0.0, 10, np.zeros((0, 3))) == 1


@pytest.mark.parametrize("columns", [1, 3])
def test_two_threads_solve_to_the_same_bits_as_one(rng, columns):
    count = 2000
    fluid = fluid_of(random_patch(3, count, rng, 6.0))
    flow = flow_of(count, viscosity=rng.uniform(0.0, 1e6, count))
    right, found = 1000.0 * rng.normal(size=(count, columns)), []
    try:
        for threads in (1, 2):
            assert set_threads(threads) == threads
            couplings, near = coupled_momentum(fluid, NO_WALLS, flow)
            x = np.zeros((count, columns))
            iterations = exchange.solve(couplings, near, right, 1e-12 * np.sum(right**2), 2000, x)
            found.append((iterations, couplings.diagonal.tobytes(), x.tobytes()))
    finally:
        set_threads(1)
    assert found[0][0] > 5
    assert found[0] == found[1]


def pair(rate=0.0, law=LAW, **known):
    """Return the viscosity between two particles at a shear rate."""
    flow = flow_of(2, **{k: v if np.isscalar(v) else np.array(v) for k, v in known.items()})
    found = exchange.pair_viscosity(0, 1, rate, flow, law)
    assert exchange.pair_viscosity(1, 0, rate, flow, law) == found
    return found


def test_two_particles_below_yield_are_as_viscous_as_the_law_allows():
    held = {"strength": (300.0, 500.0), "ramp": (1.0, 1.0)}
    # the mean strength, 400 Pa, over the least rate, 0.001 1/s, below the greatest viscosity
    for rate in (0.0, 3e-4, 1e-3):
        assert pair(rate, **held) == pytest.approx(4e5, rel=1e-13)
    assert pair(2.0, **held) == pytest.approx(200.0, rel=1e-13)
    strong = {"strength": (1e9, 1e9), "ramp": (1.0, 1.0)}
    assert pair(**strong) == LAW.largest_viscosity
    viscous = {"viscosity": (10.0, 30.0)}
    assert pair(**viscous) == pytest.approx(20.0, rel=1e-15)
    assert pair(**strong, **viscous) == pytest.approx(LAW.largest_viscosity + 20.0, rel=1e-15)


def test_the_lesser_ramp_of_two_particles_counts():
    strength = {"strength": (300.0, 500.0)}
    assert pair(2.0, ramp=(1.0, 0.25), **strength) == pytest.approx(0.25 * 200.0, rel=1e-13)
    assert pair(2.0, ramp=(1.0, 0.0), **strength) == 0.0  # water does not stick to a bed


def test_the_consistency_between_two_particles_is_their_mean():
    law = LAW._replace(consistency=1.0, exponent=0.5)
    found = pair(4.0, law, ramp=(1.0, 0.5), consistency=(4.0, 6.0), viscosity=(1.0, 3.0))
    assert found == pytest.approx(2.0 + 0.5 * 5.0 / 2.0, rel=1e-13)


def test_the_least_viscosity_adds_nothing_to_what_is_more_viscous():
    assert pair(viscosity=(10.0, 30.0), least_viscosity=25.0) == 25.0
    assert pair(viscosity=(10.0, 30.0), least_viscosity=15.0) == pytest.approx(20.0, rel=1e-15)
    held = {"strength": (400.0, 400.0), "ramp": (1.0, 1.0)}
    assert pair(2.0, least_viscosity=150.0, **held) == pytest.approx(200.0, rel=1e-13)


def shear_rate_between(gradient, a, difference):
    """Return the shear rate between two particles with gradients, (2, 3, 3) array."""
    one, other = (tuple(g.ravel()) for g in gradient)
    return exchange.pair_shear_rate(one, other, *(2.0 * a), 0.5, *(2.0 * np.array(difference)))


def plane_shear(*rates):
    """Return gradients of a velocity along x that grows with z."""
    found = np.zeros((len(rates), 3, 3))
    found[:, 0, 2] = rates
    return found


@pytest.mark.parametrize("angle", [20.0, 45.0, 90.0, -60.0])
def test_the_shear_rate_between_two_particles_is_that_of_their_layers(angle):
    up = np.sin(np.radians(angle))
    a = np.array([np.cos(np.radians(angle)), 0.0, up])

    def between(rate):
        return shear_rate_between(plane_shear(1.0, 5.0), a, [rate * up, 0.0, 0.0])

    # the mean of their gradients is 3 1/s; the profile between them may be steeper or less
    assert between(3.0) == pytest.approx(3.0, rel=1e-14)
    floor = 0.1 / np.sqrt(up**2 + 0.01)  # what is left where layers move as one
    assert between(0.0) == pytest.approx(3.0 * floor, rel=1e-14)
    for rate in (1.0, 9.0):
        assert between(rate) == pytest.approx(rate, abs=abs(rate - 3.0) * floor)


def test_motion_as_of_a_rigid_body_is_no_shear():
    spin = np.array([[0.0, -2.0, 1.0], [2.0, 0.0, -3.0], [-1.0, 3.0, 0.0]])
    a = np.array([2.0, 1.0, -2.0]) / 3.0
    assert shear_rate_between([spin, spin], a, spin @ a) == 0.0
    assert shear_rate_between(np.zeros((2, 3, 3)), a, [0.0, 0.0, 0.0]) == 0.0


def test_two_particles_side_by_side_in_a_shear_have_its_rate():
    aside = np.array([0.0, 1.0, 0.0])
    for noise in (0.0, 0.03):
        found = shear_rate_between(plane_shear(2.0, 2.0), aside, [0.0, 0.0, noise])
        assert found == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_layer_along_a_free_slip_wall_resists_as_inside(slip):
    """The stress across planes of a shear along the wall, over that of the whole lattice."""
    position = lattice_block(3, 12, SPACING)
    wall = lattice_block(3, (12, 4, 12), SPACING)
    wall[:, 1] -= 4.0 * SPACING
    normal = np.tile([0.0, 1.0, 0.0], (len(wall), 1))
    solid = solid_of(wall, normal, -wall[:, 1], np.full(len(wall), slip))
    flow = flow_of(len(position), viscosity=np.full(len(position), 100.0))
    couplings, near = coupled_momentum(fluid_of(position), solid, flow)
    stress = np.zeros(12)
    for i, count in enumerate(near.fluid_count):
        if np.any(np.abs(position[i] - 3.0)[[0, 2]] > SPACING):
            continue
        j = near.fluid[i, :count]
        rise = position[j, 2] - position[i, 2]
        # half the sum over i of K (u_j - u_i) (z_j - z_i) with u = z
        stress[int(position[i, 1] / SPACING)] += 0.5 * couplings.value[i, :count] @ rise**2
    over = stress / stress[6]
    np.testing.assert_allclose(over[2:-2], 1.0, rtol=1e-6)
    if slip:
        np.testing.assert_allclose(over[:2], 1.0, rtol=1e-6)
    else:  # the wall, at rest, is not in the sum
        assert over[0] < 0.85


@pytest.mark.parametrize("height", [0.3, 0.7, 1.1])
@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_wall_resists_with_the_strength_at_the_depth_between(height, slip):
    # over the middle of one wall particle in the first layer of a floor, 0.25 m deep
    down, velocity = np.array([0.0, 0.0, -1.0]), np.array([[0.3, 0.4, 0.0]])
    fluid = fluid_of(np.array([[0.0, 0.0, height]]), velocity=velocity)
    solid = solid_of(np.array([[0.0, 0.0, -0.25]]), depth=0.25, slip=slip)
    near = near_of(fluid, solid, LATTICE)
    flow = flow_of(
        1,
        viscosity=np.array([3.0]),
        strength=np.array([100.0]),
        deepening=np.array([800.0]),
        ramp=np.array([0.5]),
        least_viscosity=1e9,  # does not act on walls
    )
    flow.gradient[0, [2, 5]] = 3.0, 4.0  # of another shear rate, of the same direction
    drag = exchange.wall_drag_at(0, fluid, solid, near, flow, LAW, down, NUMBERS)
    r, rate = height + 0.25, 0.5 / height  # of the straight profile down to the surface
    rate = 5.0 * np.sqrt((rate**2 + 0.25) / (25.0 + 0.25))
    w = weight(r)
    mu = 3.0 + 0.5 * (100.0 + 800.0 * 0.5 * r) / rate
    factor = (height + 0.25) / height
    assert drag == pytest.approx(w * mu * factor * (1.0 - slip), rel=1e-12)
    # sideways, as on a side wall, the depth between is that of the particle
    drag = exchange.wall_drag_at(0, fluid, solid, near, flow, LAW, np.array([1.0, 0, 0]), NUMBERS)
    mu = 3.0 + 0.5 * 100.0 / rate
    assert drag == pytest.approx(w * mu * factor * (1.0 - slip), rel=1e-12)


def test_what_would_pull_under_a_ceiling_has_no_strength():
    fluid, down = fluid_of(np.array([[0.0, 0.0, 0.3]])), np.array([0.0, 0.0, 1.0])
    solid = solid_of(np.array([[0.0, 0.0, -0.25]]), depth=0.25)
    strong = {"strength": np.array([100.0]), "deepening": np.array([800.0]), "ramp": np.ones(1)}
    near = near_of(fluid, solid, LATTICE)
    flow = flow_of(1, **strong)
    assert exchange.wall_drag_at(0, fluid, solid, near, flow, LAW, down, NUMBERS) == 0.0


def test_strength_and_its_growth_with_depth_are_those_of_the_law():
    law = LAW._replace(yield_stress=20.0, yield_growth=3.0, consistency=5.0, exponent=0.5)
    pressure, weight = np.array([0.0, 400.0]), np.array([0.0, 9000.0])
    c = np.array([0.1, 0.3])
    flow = flow_of(
        2,
        concentration=c,
        viscosity=np.array([0.1, 0.2]),
        shear_rate=np.array([4.0, 0.0]),
    )
    exchange.resist(pressure, weight, SPACING, 0.05, law, flow)
    cohesion = 20.0 * np.exp(3.0 * c)
    np.testing.assert_allclose(flow.ramp, [0.0, 2.0 / 3.0], rtol=1e-12)
    np.testing.assert_allclose(flow.strength, cohesion + 0.7 * pressure, rtol=1e-13)
    np.testing.assert_allclose(flow.deepening, 0.7 * weight, rtol=1e-11)
    # with that of eddies; the consistency is one of pairs
    np.testing.assert_allclose(flow.viscosity, [0.1 + 1000.0 * 0.05**2 * 4.0, 0.2], rtol=1e-12)


def balanced_grains(position, c, is_free, pressure, submerged=SUBMERGED):
    """Return the pressure between grains that balances their weight, with some of it given."""
    fluid = fluid_of(position)
    near = near_of(fluid, NO_WALLS, LATTICE)
    system, right = empty_couplings(near, is_free), np.empty((len(position), 1))
    exchange.couple_grains(fluid, near, c, submerged, NUMBERS, system, right)
    x = np.where(is_free, 0.0, pressure)[:, None]
    goal = 1e-24 * np.sum(right[is_free] ** 2)
    assert exchange.solve(system, near, right, goal, 5000, x) > 0
    return x[:, 0]


def bed(rng, counts=(6, 6, 8)):
    """Return a disordered bed whose lowest point is the origin."""
    position = lattice_block(3, counts, SPACING)
    return position + rng.uniform(-0.3, 0.3, position.shape) * SPACING


@pytest.mark.parametrize("submerged", [SUBMERGED, 1650.0 * np.array([3.0, -2.0, -9.0])])
def test_a_linear_pressure_between_grains_is_exact_on_a_disordered_bed(rng, submerged):
    position = bed(rng)
    c, surface = np.full(len(position), 0.45), position[:, 2] > 3.5
    expected = 2e4 + 0.45 * position @ submerged
    found = balanced_grains(position, c, ~surface, expected, submerged)
    # 0.45 rho' g over the depth of the bed, as little as the solution by iteration leaves
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.ptp(expected))


def test_the_balance_of_grains_is_the_sum_over_all_pairs(fluid, rng, period):
    near, c = near_of(fluid, NO_WALLS, LATTICE, period), rng.uniform(0.0, 0.5, COUNT)
    system, right = empty_couplings(near), np.empty((COUNT, 1))
    exchange.couple_grains(fluid, near, c, SUBMERGED, NUMBERS, system, right)
    r, w = weights(fluid.position, period=period)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    a = np.where(w > 0.0, (SPACING / distance) ** 3, 0.0)
    matrix = np.diag(np.maximum(a.sum(axis=1), 1e-6)) - a
    np.testing.assert_allclose(dense(system, near), matrix, rtol=SINGLE)
    expected = -np.sum(a * mean(c) * (r @ SUBMERGED), axis=1)
    scale = np.sum(a * mean(c) * np.abs(r @ SUBMERGED), axis=1)
    np.testing.assert_array_less(np.abs(right[:, 0] - expected), SINGLE * scale + 1e-300)


def test_water_above_a_bed_adds_nothing_to_the_pressure_between_grains(rng):
    under = bed(rng)
    above = bed(rng, (6, 6, 12)) + np.array([0.0, 0.0, 4.0])
    found = []
    for rows in (4, 12):
        water = above[above[:, 2] < 4.0 + rows * SPACING]
        position = np.concatenate([under, water])
        is_bed = np.arange(len(position)) < len(under)
        found.append(balanced_grains(position, 0.45 * is_bed, is_bed, 0.0)[: len(under)])
    np.testing.assert_allclose(found[0], found[1], atol=1e-9 * found[0].max())
    # the pressure is that of the depth below the bed's surface
    depth = 4.0 - under[:, 2]
    weight = 0.45 * 1650.0 * 10.0
    # to within half a row, over which the surface is spread
    inner = np.all((under[:, :2] > 1.0) & (under[:, :2] < 2.0), axis=1)
    error = (found[0] - weight * depth)[inner]
    assert np.abs(error).max() < 0.5 * weight * SPACING


def test_concentrations_are_those_of_the_semi_implicit_scheme(fluid, rng, period):
    fraction, level = rng.uniform(0.0, 0.6, (2, COUNT))
    near = near_of(fluid, NO_WALLS, LATTICE, period)
    around, at_level = np.empty((2, COUNT))
    agitation.concentrations(fraction, level, DOWN, fluid, near, NUMBERS, around, at_level)
    stencil = stencil_of(fluid.position, LATTICE, period=period)
    expected, leveled = np.empty((2, COUNT))
    granular.concentration(COUNT, fraction, stencil, expected)
    granular.level_concentration(COUNT, level, DOWN, stencil, leveled)
    np.testing.assert_allclose(around, expected, rtol=EXACT)
    np.testing.assert_allclose(at_level, leveled, rtol=EXACT)
    assert np.ptp(around - at_level) > 0.01
