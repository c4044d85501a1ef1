"""The static balance of grains: their pressure against their weight."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.physics.grain_pressure import couple_grains
from debrisflow.schemes.pair_solver import solve
from tests.building import NOWHERE, lattice_block, random_patch, separations, two_lists
from tests.fast.test_exchange import dense, empty_couplings, mean

SPACING = 0.5
LATTICE = reference(3, 2.4, SPACING)
LENGTH, COUNT = 9.0 * SPACING, 300
SUBMERGED = 1650.0 * np.array([0.0, 0.0, -10.0])
SINGLE = 2.0**-23  # the coefficients are kept in single precision


@pytest.fixture
def rng():
    return np.random.default_rng(29)


def balanced_grains(position, c, is_free, pressure, submerged=SUBMERGED):
    """Return the pressure between grains that balances their weight, with some of it given."""
    near = two_lists(position, LATTICE)
    system, right = empty_couplings(near, is_free), np.empty((len(position), 1))
    couple_grains(near, c, submerged, system, right)
    x = np.where(is_free, 0.0, pressure)[:, None]
    goal = 1e-24 * np.sum(right[is_free] ** 2)
    assert solve(system, near, right, goal, 5000, x) > 0
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


@pytest.mark.parametrize("period", [NOWHERE, np.array([0.0, LENGTH, 0.0])])
def test_the_balance_of_grains_is_the_sum_over_all_pairs(rng, period):
    position = random_patch(3, COUNT, rng, LENGTH)
    near, c = two_lists(position, LATTICE, period), rng.uniform(0.0, 0.5, COUNT)
    system, right = empty_couplings(near), np.empty((COUNT, 1))
    couple_grains(near, c, SUBMERGED, system, right)
    r = separations(position, period)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    a = np.where(distance < LATTICE.effective_radius, (SPACING / distance) ** 3, 0.0)
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
