"""What both schemes compute is the same, away from walls, up to rounding.

On particles anywhere, in two dimensions and in three, in the open and across a period.  The
semi-implicit scheme reads pairs from a list that may hold wall particles and the explicit one from
one that never does; sums of the same pairs are taken by the functions of both, and by NumPy over
all pairs.
"""

from typing import NamedTuple

import numpy as np
import pytest

from debrisflow.neighbors.lattice import Reference, reference
from debrisflow.neighbors.pairs import Near
from debrisflow.physics.collision_stress import collision_force_at
from debrisflow.physics.compressible import density_rate_at
from debrisflow.physics.concentration import concentrations
from debrisflow.physics.contact import collisions_at
from debrisflow.physics.grain_pressure import couple_grains
from debrisflow.physics.granular_temperature import (
    fluctuation_temperature_at,
    neighborhood_temperature_at,
)
from debrisflow.physics.operators import gradient_at, number_density_at, velocity_gradient_at
from debrisflow.physics.pressure import source_sums_at
from debrisflow.physics.viscosity import viscous_force_at
from debrisflow.schemes.linear import Solver
from debrisflow.schemes.pair_solver import couplings_of, solve_pairs
from debrisflow.schemes.system import empty_system
from tests.building import (
    NOWHERE,
    RADII,
    acceleration_at,
    fluid_of,
    no_solid,
    no_walls,
    numbers_of,
    one_list,
    random_patch,
    separations,
    two_lists,
)

SPACING, COUNT, SUPPLY = 0.5, 300, 40
SIDE = {2: 11.0 * SPACING, 3: 9.0 * SPACING}  # more than three radii of the list
NOTHING, NO_WALLS = no_solid(), no_walls(COUNT)  # of particles, of surfaces
GRAVITY = np.array([2.0, -9.0, 0.0])
SINGLE = 2.0**-23  # the coefficients between pairs are kept in single precision
EXACT = 1e-12  # one rounding of each of some 50 terms, relative to the greatest


class Patch(NamedTuple):
    """Particles anywhere, the last of which are supply where that matters."""

    position: np.ndarray
    velocity: np.ndarray
    period: np.ndarray
    lattice: Reference
    one: Near
    two: Near

    @property
    def dimension(self):
        return self.lattice.dimension

    @property
    def pairs(self):
        """Separation, distance, infinite of a particle to itself, and weight of all pairs."""
        r = separations(self.position, self.period)
        distance = np.linalg.norm(r, axis=2)
        distance[distance == 0.0] = np.inf
        return r, distance, np.maximum(self.lattice.effective_radius / distance - 1.0, 0.0)

    @property
    def differences(self):
        return self.velocity[None] - self.velocity[:, None]

    def with_supply(self):
        """Return the same patch, whose last particles are supply."""
        one, two = (near._replace(supply_from=COUNT - SUPPLY) for near in (self.one, self.two))
        return self._replace(one=one, two=two)


@pytest.fixture
def rng():
    return np.random.default_rng(59)


@pytest.fixture(params=[False, True], ids=["open", "periodic"])
def is_periodic(request):
    return request.param


@pytest.fixture(params=RADII, ids=lambda p: f"{p[0]}D-{p[1]}")
def patch(request, is_periodic, rng):
    dimension, radius = request.param
    lattice, side = reference(dimension, radius, SPACING), SIDE[dimension]
    period = np.array([0.0, side, 0.0]) if is_periodic else NOWHERE
    position = random_patch(dimension, COUNT, rng, side)
    velocity = random_patch(dimension, COUNT, rng, 2.0)
    one = one_list(position, lattice, period=period)
    two = two_lists(position, lattice, period)
    return Patch(position, velocity, period, lattice, one, two)


def each(function, *arguments):
    """Return what a function of one particle returns for each, (n, ...) float64 array."""
    return np.array([function(i, *arguments) for i in range(COUNT)])


def accelerations(patch, density, **known):
    """Return acceleration and change of velocity by collisions, with nothing but what is known."""
    changes = {"gravity": np.zeros(3), "artificial_viscosity": 0.0, "restitution": 0.2}
    fluid = fluid_of(COUNT, density=density, **known)
    found = each(acceleration_at, fluid, patch.two, NO_WALLS, numbers_of(patch.lattice, **changes))
    return found[:, :3], found[:, 3:6]


def assert_alike(found, expected):
    """Assert that values are equal up to rounding relative to the greatest of them."""
    scale = np.abs(expected).max()
    assert scale > 0.0
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=EXACT * scale)


def test_number_density(patch):
    _, _, w = patch.pairs
    found = each(number_density_at, patch.one, NOTHING)[:, 0]
    assert_alike(found, w.sum(axis=1))
    fluid, numbers = fluid_of(COUNT), numbers_of(patch.lattice)
    ratio = each(density_rate_at, fluid, patch.two, NO_WALLS, numbers)[:, 0]
    assert_alike(ratio * patch.lattice.number_density, found)
    sums = each(source_sums_at, patch.velocity, np.zeros(3), patch.one, NOTHING)
    assert_alike(sums[:, 0], found)


def test_divergence(patch):
    # the schemes weigh it differently, so that each is compared with the sum over all pairs
    r, d, w = patch.pairs
    along = np.sum(patch.differences * r, axis=2)
    r_e, n0 = patch.lattice.effective_radius, patch.lattice.number_density
    higher_order = (along * np.where(w > 0.0, r_e / d**3, 0.0)).sum(axis=1)
    found = each(source_sums_at, patch.velocity, np.zeros(3), patch.one, NOTHING)[:, 2]
    assert_alike(found, higher_order)
    fluid = fluid_of(COUNT, velocity=patch.velocity)
    numbers = numbers_of(patch.lattice, diffusion=0.0)
    rate = each(density_rate_at, fluid, patch.two, NO_WALLS, numbers)[:, 2]
    assert_alike(-rate, patch.dimension / n0 * (along * w / d**2).sum(axis=1))


def test_velocity_gradient(patch):
    found = each(velocity_gradient_at, patch.velocity, patch.one, NOTHING)
    assert_alike(each(velocity_gradient_at, patch.velocity, patch.two, NO_WALLS), found)
    r, d, w = patch.pairs
    axes, f = slice(0, patch.dimension), w / d**2
    moments = np.einsum("ij,ijk,ijl->ikl", f, r[..., axes], r[..., axes])
    differences = np.einsum("ij,ijk,ijl->ikl", f, patch.differences[..., axes], r[..., axes])
    # of those whose neighbors stand in all directions: others lose digits, or have no gradient
    is_spread = np.linalg.cond(moments) < 20.0
    assert np.count_nonzero(is_spread) > 0.8 * COUNT
    expected = np.zeros((COUNT, 3, 3))
    expected[is_spread, axes, axes] = differences[is_spread] @ np.linalg.inv(moments[is_spread])
    assert_alike(found[is_spread], expected[is_spread].reshape(-1, 9))


def test_concentration(patch, rng):
    patch, (fraction, level) = patch.with_supply(), rng.uniform(0.0, 0.6, (2, COUNT))
    down = GRAVITY / np.linalg.norm(GRAVITY)
    r, d, w = patch.pairs
    aside = w * (1.0 - (r @ down / d) ** 2)
    for near in (patch.one, patch.two):
        around, at_level = np.empty((2, COUNT))
        concentrations(fraction, level, down, near, around, at_level)
        for found, weights, shares in ((around, w, fraction), (at_level, aside, level)):
            # the supply counts
            expected = (2.0 * shares + weights @ shares) / (2.0 + weights.sum(axis=1))
            assert_alike(found, expected)
        assert np.ptp(around - at_level) > 0.01


@pytest.mark.parametrize("has_supply", [False, True])
def test_collisions(patch, rng, has_supply):
    patch = patch.with_supply() if has_supply else patch
    density, distance = rng.uniform(1000.0, 2650.0, COUNT), 0.8 * SPACING
    found = 1.2 * each(collisions_at, patch.velocity, density, distance, patch.one)
    _, impulse = accelerations(patch, density, velocity=patch.velocity)
    assert_alike(impulse, found)
    r, d, _ = patch.pairs
    along = np.sum(patch.differences * r, axis=2)
    hits = np.where((d < distance) & (along < 0.0), along / d**2, 0.0)
    mass = np.broadcast_to(density / (density[:, None] + density), (COUNT, COUNT)).copy()
    mass[:, patch.one.supply_from :] = 1.0  # nothing moves the supply
    assert_alike(found, 1.2 * np.einsum("ij,ijk->ik", hits * mass, r))


def test_viscous_force(patch, rng):
    viscosity, density = rng.uniform(0.1, 10.0, COUNT), rng.uniform(1000.0, 2650.0, COUNT)
    found = each(viscous_force_at, patch.velocity, viscosity, patch.one, NOTHING)
    known = {"velocity": patch.velocity, "viscosity": viscosity}
    acceleration, _ = accelerations(patch, density, **known)
    assert_alike(density[:, None] * acceleration, found)
    _, _, w = patch.pairs
    n0, lambda_ = patch.lattice.number_density, patch.lattice.laplacian_lambda
    fluidity = 1.0 / viscosity
    mean = 2.0 / (fluidity[None] + fluidity[:, None])  # of the plane between two layers
    factor = 2.0 * patch.dimension / (lambda_ * n0) * mean
    assert_alike(found, np.einsum("ij,ijk->ik", factor * w, patch.differences))


def test_sum_gradient(patch, rng):
    pressure, density = rng.uniform(0.0, 1e4, COUNT), rng.uniform(1000.0, 2650.0, COUNT)
    found = each(gradient_at, pressure, True, patch.one, NOTHING)
    acceleration, _ = accelerations(patch, density, pressure=pressure)
    assert_alike(-density[:, None] * acceleration, found)
    r, d, w = patch.pairs
    f = patch.dimension / patch.lattice.number_density * w / d**2
    assert_alike(found, np.einsum("ij,ijk->ik", f * (pressure[None] + pressure[:, None]), r))


def test_collision_stress(patch, rng):
    # all hold sediment, as mixtures do
    pressure, viscosity = rng.uniform(0.0, 1e3, COUNT), rng.uniform(0.0, 7.0, COUNT)
    density, everywhere = rng.uniform(1000.0, 2650.0, COUNT), np.ones(COUNT)
    stress = patch.velocity, everywhere, pressure, viscosity
    found = each(collision_force_at, *stress, patch.one, NOTHING)
    known = {"velocity": patch.velocity, "grain_pressure": pressure, "viscosity": viscosity}
    acceleration, _ = accelerations(patch, density, **known)
    assert_alike(density[:, None] * acceleration, found)


def test_granular_temperature(patch, rng):
    patch, fraction = patch.with_supply(), rng.choice([0.0, 0.4, 1.0], COUNT)
    given = patch.velocity, fraction
    found = each(neighborhood_temperature_at, *given, patch.one)
    assert_alike(each(neighborhood_temperature_at, *given, patch.two), found)
    _, _, w = patch.pairs
    is_grain = (fraction > 0.0) & (np.arange(COUNT) < COUNT - SUPPLY)
    for i in range(0, COUNT, 10):
        grains = patch.velocity[((w[i] > 0.0) & is_grain) | (np.arange(COUNT) == i)]
        expected = np.var(grains, axis=0).sum() / patch.dimension
        assert found[i] == pytest.approx(expected, rel=EXACT, abs=EXACT)
    fluctuation = each(fluctuation_temperature_at, *given, patch.one)
    assert_alike(each(fluctuation_temperature_at, *given, patch.two), fluctuation)


def balance_of_grains(near, c, is_free):
    """Return the static balance of grains over pairs, and its right side."""
    couplings, right = couplings_of(near, is_free), np.full((COUNT, 1), np.nan)
    couplings.value[:] = 0.0  # beyond the end of a row too
    couple_grains(near, c, 1650.0 * GRAVITY, couplings, right)
    return couplings, right


def dense(columns, value, count, diagonal):
    """Return the matrix of rows of neighbors, (n, n) array."""
    matrix = np.diag(diagonal)
    for i, entries in enumerate(count):
        np.subtract.at(matrix[i], columns[i, :entries], value[i, :entries])
    return matrix


def test_static_weight_of_grains(patch, rng):
    r, d, w = patch.pairs
    c, everyone = rng.uniform(0.2, 0.5, COUNT), np.ones(COUNT, dtype=bool)
    a = np.where(w > 0.0, (SPACING / d) ** 3, 0.0)
    pushed = a * 0.5 * (c[None] + c[:, None]) * (r @ GRAVITY) * 1650.0
    for near in (patch.one, patch.two):
        couplings, right = balance_of_grains(near, c, everyone)
        found = dense(near.neighbors, couplings.value, near.fluid_count, couplings.diagonal)
        expected = np.diag(np.maximum(a.sum(axis=1), 1e-6)) - a
        np.testing.assert_allclose(found, expected, rtol=SINGLE)
        error = np.abs(right[:, 0] + pushed.sum(axis=1))
        np.testing.assert_array_less(error, SINGLE * np.abs(pushed).sum(axis=1) + 1e-300)


def test_conjugate_gradients(patch, rng):
    is_free, near = rng.random(COUNT) < 0.9, patch.two
    couplings, right = balance_of_grains(near, rng.uniform(0.2, 0.5, COUNT), is_free)
    couplings.diagonal[:] += 0.1  # of groups too in which nothing is given
    start = np.where(is_free, 0.0, 1e3 * rng.normal(size=COUNT))
    over_pairs = start[:, None].copy()
    goal = 1e-28 * np.sum(right[is_free] ** 2)
    solve_pairs("the balance", couplings, near, right, goal, over_pairs)
    system = empty_system(*near.neighbors.shape)
    system.columns[:] = near.neighbors
    system.value[:] = couplings.value
    system.entries[:] = np.where(is_free, near.fluid_count, 0)
    system.diagonal[:] = np.where(is_free, couplings.diagonal, 1.0)
    system.right[:] = np.where(is_free, right[:, 0], start)
    in_rows = start.copy()
    assert Solver(1e-14).solve(system, in_rows) > 0
    matrix = dense(system.columns, system.value, system.entries, system.diagonal)
    expected = np.linalg.solve(matrix, system.right)
    for found in (over_pairs[:, 0], in_rows):
        # the residual over the least eigenvalue, which is not less than 0.1
        np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())
