"""Neighbor lists against all pairs, and the pairs that kernels read from them."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import SKIN, FixedNeighbors, Neighbors, group, order_by_cell
from debrisflow.neighbors.pairs import fluid_pair, weight
from debrisflow.neighbors.wall_access import wall_pair
from tests.building import (
    NOWHERE,
    lattice_block,
    one_list,
    random_patch,
    separations,
    solid_of,
    times_listed,
    two_lists,
    within,
)

RADIUS, SPACING = 3.1, 1.0
REACH = RADIUS + SKIN * SPACING
LENGTH = 12.0  # a little more than three reaches, the least for a period
PERIODS = [
    (2, NOWHERE),
    (3, NOWHERE),
    (2, np.array([LENGTH, 0.0, 0.0])),
    (2, np.array([0.0, LENGTH, 0.0])),
    (2, np.array([LENGTH, LENGTH, 0.0])),
    (3, np.array([0.0, 0.0, LENGTH])),
    (3, np.array([LENGTH, 0.0, LENGTH])),
    (3, np.array([LENGTH, LENGTH, LENGTH])),
]


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def built(position, period=NOWHERE, rows=None):
    """Return the neighbor list of the first ``rows`` particles."""
    near = Neighbors(RADIUS, SPACING, period)
    near.build(position, len(position) if rows is None else rows)
    return near


def is_all_pairs(near, position, period=NOWHERE):
    """Return whether a list holds each pair within reach once and nothing else."""
    listed = times_listed(near.index, near.count, len(position))
    return np.array_equal(listed, within(position, REACH, period)[: near.count.size])


def in_reach(near):
    """Return how often each fluid particle is a neighbor of each with a weight above 0."""
    times = np.zeros((near.fluid_count.size, len(near.position)), dtype=int)
    for i, count in enumerate(near.fluid_count):
        for k in range(count):
            j, *_, inverse = fluid_pair(i, k, near)
            times[i, j] += weight(inverse, near) > 0.0
    return times


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
@pytest.mark.parametrize("count", [1, 2, 700])
def test_the_list_holds_all_pairs_in_reach(rng, dimension, period, count):
    position = random_patch(dimension, count, rng, LENGTH)
    assert is_all_pairs(built(position, period), position, period)


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
def test_particles_on_cell_faces_are_found(dimension, period):
    # three cells along each axis, particles on every face, edge and corner
    position = LENGTH / 6 * (lattice_block(dimension, 7) - 0.5)
    position[:, dimension:] = 0.0
    assert is_all_pairs(built(position, period), position, period)
    beside = np.concatenate([np.nextafter(position, -1.0), np.nextafter(position, LENGTH)])
    assert is_all_pairs(built(beside, period), beside, period)


def test_particles_outside_the_period_are_found_through_it(rng):
    period = np.array([LENGTH, LENGTH, 0.0])
    position = random_patch(2, 400, rng, LENGTH)
    away = position + period * rng.integers(-3, 4, (400, 3))
    assert is_all_pairs(built(away, period), away, period)


def test_particles_far_away_do_not_hide_the_others(rng):
    position = random_patch(2, 300, rng, LENGTH)
    position[7] = [2000.0, -1500.0, 0.0]
    near = built(position)
    assert is_all_pairs(near, position)
    assert near.count[7] == 0


def test_coincident_particles_are_neighbors_of_each_other(rng):
    position = random_patch(2, 200, rng, LENGTH)
    position[50:60] = position[3]
    assert is_all_pairs(built(position), position)


@pytest.mark.parametrize("crowd", [9, 128, 129, 400])
def test_a_row_that_overflows_is_made_longer(rng, crowd):
    sparse = random_patch(2, crowd, rng, 1000.0)
    near = built(sparse)
    narrow = near.index.shape[1]
    dense = random_patch(2, crowd, rng, 2.0)
    near.build(dense, crowd)
    assert narrow <= crowd - 1 < near.index.shape[1]
    assert is_all_pairs(near, dense)


def test_rows_are_those_of_the_first_particles(rng):
    position = random_patch(2, 300, rng, LENGTH)
    near = built(position, rows=120)
    assert near.count.size == 120
    assert is_all_pairs(near, position)


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
def test_nobody_is_missed_before_half_the_skin_is_passed(rng, dimension, period):
    lattice = reference(dimension, RADIUS, SPACING)
    position = random_patch(dimension, 500, rng, LENGTH)
    near = built(position, period)
    shift = rng.normal(size=position.shape)
    shift[:, dimension:] = 0.0
    shift *= 0.499 * SKIN * SPACING / np.linalg.norm(shift, axis=1, keepdims=True)
    moved = position + shift
    assert not near.is_stale(moved, 500)
    pairs = one_list(moved, lattice, period=period, lists=near)
    assert np.array_equal(in_reach(pairs), within(moved, RADIUS, period))


def test_a_list_is_stale_when_one_particle_passed_half_the_skin(rng):
    position = random_patch(3, 100, rng, LENGTH)
    near = built(position)
    assert not near.is_stale(position.copy(), 100)
    for distance, stale in ((0.499, False), (0.501, True)):
        moved = position.copy()
        moved[99] += distance * SKIN * SPACING * np.array([2.0, -1.0, 2.0]) / 3.0
        assert near.is_stale(moved, 100) == stale


def test_a_list_is_stale_when_the_number_of_particles_or_rows_changes(rng):
    position = random_patch(2, 100, rng, LENGTH)
    near = built(position, rows=80)
    assert not near.is_stale(position, 80)
    assert near.is_stale(position[:99], 80)
    assert near.is_stale(np.concatenate([position, position[:1] + 1.0]), 80)
    assert near.is_stale(position, 79)
    assert near.is_stale(position, 81)


def listed_pairs(near, solid, fluid):
    """Yield i, j, r_ij and 1 / r of all listed pairs; walls are numbered from ``fluid`` on."""
    for i, moving in enumerate(near.fluid_count):
        for k in range(moving):
            j, *between, inverse = fluid_pair(i, k, near)
            yield i, j, between, inverse
        for k in range(0 if solid is None else near.wall_count[i]):
            j, *between, inverse = wall_pair(i, k, near, solid)
            yield i, fluid + j, between, inverse


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
@pytest.mark.parametrize("walls", ["particles", "surfaces"])
def test_kernels_read_the_geometry_of_each_pair(rng, dimension, period, walls):
    lattice, fluid = reference(dimension, RADIUS, SPACING), 200
    position = random_patch(dimension, 300, rng, LENGTH)
    if walls == "particles":
        solid = solid_of(position[fluid:])
        near = one_list(position, lattice, period=period, wall_from=fluid)
    else:
        solid, near = None, two_lists(position, lattice, period)
    rows, between = near.fluid_count.size, separations(position, period)
    times = np.zeros((rows, 300), dtype=int)
    for i, j, found, inverse in listed_pairs(near, solid, fluid):
        times[i, j] += 1
        # differences of positions of order 10 and one period
        np.testing.assert_allclose(found, between[i, j], atol=1e-14)
        assert inverse * np.linalg.norm(between[i, j]) == pytest.approx(1.0, rel=1e-12)
    assert np.array_equal(times, within(position, REACH, period)[:rows])


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
def test_separations_of_a_pair_are_opposite_to_the_bit(rng, dimension, period):
    position = random_patch(dimension, 300, rng, LENGTH)
    position[20:23] = position[4]  # no direction of their own
    near = one_list(position, reference(dimension, RADIUS, SPACING), period=period, wall_from=200)
    tables = np.zeros((4, 300, 300))
    for i, j, between, inverse in listed_pairs(near, solid_of(position[200:]), 200):
        tables[:, i, j] = *between, inverse
    for table in tables[:3]:
        assert np.array_equal(table, -table.T)
    assert np.array_equal(tables[3], tables[3].T)
    assert np.all(np.isfinite(tables))
    assert tables[3, 20, 4] == pytest.approx(1e6 / SPACING)  # kept apart by 1e-6 d0


@pytest.mark.parametrize(("moving", "pressed"), [(250, 300), (0, 300), (300, 300)])
def test_what_moves_stands_first_in_a_row_and_then_the_walls_with_a_pressure(rng, moving, pressed):
    near = built(random_patch(2, 400, rng, LENGTH), rows=pressed)
    index, count = near.index.copy(), near.count
    moving_count, pressed_count = np.empty((2, pressed), dtype=np.int32)
    group(index, count, moving, pressed, moving_count, pressed_count)
    for i in range(pressed):
        listed = near.index[i, : count[i]]
        is_moving, is_other = listed < moving, listed >= pressed
        is_pressed = ~is_moving & ~is_other
        # each group in the order of the list
        expected = [*listed[is_moving], *listed[is_pressed], *listed[is_other]]
        assert index[i, : count[i]].tolist() == expected
        assert (moving_count[i], pressed_count[i]) == (is_moving.sum(), is_pressed.sum())


@pytest.mark.parametrize(("dimension", "period"), PERIODS)
@pytest.mark.parametrize("side", [0.3, 1.0])
def test_the_list_among_fixed_points_holds_all_pairs_in_reach(rng, dimension, period, side):
    # the points fill a part of the space, so that some particles are far from all of them
    points, reach = random_patch(dimension, 200, rng, side * LENGTH), RADIUS + SKIN * SPACING
    fixed = FixedNeighbors(points, RADIUS, SPACING, period)
    for count in (0, 1, 400, 150):  # the same lists for more particles and for fewer
        position = random_patch(dimension, count, rng, LENGTH)
        fixed.build(position)
        distance = np.linalg.norm(separations(position, period, points), axis=2)
        for i in range(count):
            listed = fixed.index[fixed.row[i], : fixed.count[i]]
            assert sorted(listed) == np.flatnonzero(distance[i] < reach).tolist()
        assert np.all(fixed.count[fixed.row < 0] == 0)


def test_order_by_cell_is_a_permutation_that_joins_cells(rng):
    position = random_patch(2, 500, rng, LENGTH)
    order = order_by_cell(position, SPACING)
    assert np.array_equal(np.sort(order), np.arange(500))
    cell = np.floor((position[order] - position.min(axis=0)) / SPACING) @ [100.0, 1.0, 0.0]
    assert np.all(np.diff(cell) >= 0)
