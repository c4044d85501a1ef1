"""The seeding of two phases, and particles that come and go."""

import numpy as np
import pytest

from debrisflow.particles.record import blank
from debrisflow.particles.seeding import seed
from tests.building import tank_case


@pytest.mark.parametrize("share", [0.2, 0.55])
def test_a_mix_has_its_share_everywhere(share):
    columns, rows, spacing = 40, 20, 0.01
    case = tank_case(columns, rows, "two-phase", spacing=spacing)
    fill = case.fill[0].model_copy(update={"sediment_share": share})
    particles = seed(case.model_copy(update={"fill": (fill,)}))
    fluid = particles.fluid
    sediment = np.zeros((columns, rows))
    i, j = (particles.position[fluid, :2] / spacing).astype(int).T
    sediment[i, j] = particles.sediment_fraction[fluid]
    assert sediment.sum() == pytest.approx(share * columns * rows, abs=0.5)
    squares = sediment.reshape(columns // 2, 2, rows // 2, 2).sum(axis=(1, 3))
    # rounding may move one particle at either end of a square; at random it would be far more
    assert np.abs(squares - 4 * share).max() < 2.0
    assert squares.std() < 0.8 * np.sqrt(4 * share * (1 - share))
    # no pattern that repeats: every row holds about its share
    assert np.abs(sediment.mean(axis=0) - share).max() < 0.25


def numbered(count):
    particles = blank(count)
    particles.position[:, 0] = np.arange(count)
    return particles


def test_the_walls_stay_where_they_are_in_memory_while_others_come_and_go():
    particles, walls = numbered(5000), numbered(5000).position
    added = numbered(100)
    added.position[:, 0] += 1e6
    particles.insert(0, added)
    place = particles.position[-5000:].ctypes.data
    particles.insert(100, added)
    particles.keep(np.array([3, 1, 150]), 200)
    np.testing.assert_array_equal(particles.position[:3, 0], [1e6 + 3, 1e6 + 1, 1e6 + 50])
    np.testing.assert_array_equal(particles.position[3:], walls)
    assert particles.position[-5000:].ctypes.data == place
    assert all(len(value) == 5003 for value in particles.arrays().values())
    for _ in range(5):
        particles.insert(3, added)  # more than there is room for
    np.testing.assert_array_equal(particles.position[3:503, 0], np.tile(added.position[:, 0], 5))
    np.testing.assert_array_equal(particles.position[503:], walls)


def test_what_gets_other_arrays_loses_nothing_of_them():
    particles = numbered(50)
    particles.keep(np.arange(40), 40)
    particles.position = -particles.position
    particles.keep(np.arange(0), 10)
    np.testing.assert_array_equal(particles.position[:, 0], -np.arange(10.0, 50.0))
