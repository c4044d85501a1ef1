"""The start of a weakly compressible fluid."""

import numpy as np
import pytest

from debrisflow.particles import hydrostatic_start
from debrisflow.particles.seeding import seed
from tests.building import tank3d_case

C, G, D0 = 20.0, 9.81, 0.1


def started(**tables):
    case = tank3d_case(scheme={"sound_speed": C, "jitter": 0.05}, **tables)
    particles = seed(case)
    return case, particles, particles.position[particles.fluid].copy()


def settled(z, h):
    return C**2 / G * np.log((1 + G * h / C**2) / (1 + G * (h - z) / C**2))


def test_a_column_on_the_floor_is_compressed_by_its_weight():
    case, particles, before = started()
    hydrostatic_start.compress(particles, case)
    fluid = particles.fluid
    z = before[:, 2]
    np.testing.assert_allclose(particles.compression[fluid], G * (0.5 - z) / C**2, rtol=1e-12)
    np.testing.assert_allclose(particles.position[fluid, 2], settled(z, 0.5), rtol=1e-12)
    np.testing.assert_array_equal(particles.position[fluid, :2], before[:, :2])


def test_the_mass_above_a_settled_particle_is_what_it_was():
    case, particles, before = started()
    hydrostatic_start.compress(particles, case)
    top = settled(0.5, 0.5)
    z = particles.position[particles.fluid, 2]
    for row in range(0, z.size, 7):
        heights = np.linspace(z[row], top, 2001)
        # compression of the matter that is now at a height, from the inverse of the formula
        density = (1 + G * 0.5 / C**2) * np.exp(-G * heights / C**2)
        mass = np.trapezoid(density, heights)
        assert mass == pytest.approx(0.5 - before[row, 2], rel=1e-6)


def layers():
    """Return a case, its particles on the lattice and before: water on a mixture, 0.3 m each."""
    block = {"type": "block", "x": [0.0, 0.8], "y": [0.0, 0.6]}
    fill = [
        block | {"z": [0.0, 0.3], "material": "mixture"},
        block | {"z": [0.3, 0.6], "material": "water"},
    ]
    return started(fill=fill, mixture={"concentration": 0.4})


def test_each_layer_of_a_column_weighs_as_its_matter():
    case, particles, before = layers()
    hydrostatic_start.compress(particles, case)
    z, heavy = before[:, 2], 1000.0 + 0.4 * 1650.0
    np.testing.assert_allclose(particles.density[particles.fluid], np.where(z < 0.3, heavy, 1e3))
    load = G * np.where(z < 0.3, heavy * (0.3 - z) + 1000.0 * 0.3, 1000.0 * (0.6 - z))
    # one stiffness for both, that of the heavier matter
    pressure = heavy * C**2 * particles.compression[particles.fluid]
    np.testing.assert_allclose(pressure, load, rtol=1e-12)


def test_each_layer_of_a_column_sinks_by_the_compression_below_it():
    case, particles, before = layers()
    hydrostatic_start.compress(particles, case)
    heavy = 1660.0
    z = np.unique(before[:, 2])
    for height in z:
        fine = np.linspace(0.0, height, 6001)
        load = np.where(fine < 0.3, heavy * (0.3 - fine) + 300.0, 1000.0 * (0.6 - fine))
        expected = np.trapezoid(1.0 / (1.0 + G * load / (heavy * C**2)), fine)
        found = particles.position[particles.fluid, 2][before[:, 2] == height]
        # the rule of trapezoids, whose error is of the order of the squared step
        np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_a_hanging_block_is_left_as_it_is():
    case, particles, before = started(z=[0.3, 0.6])
    hydrostatic_start.compress(particles, case)
    np.testing.assert_array_equal(particles.position[particles.fluid], before)
    assert not np.any(particles.compression)


def test_a_column_on_an_obstacle_stands_and_one_above_a_gap_hangs():
    pier = {"type": "box", "name": "pier", "x": [0.0, 0.2], "y": [0.0, 0.2], "z": [0.0, 0.3]}
    case, particles, before = started(z=[0.3, 0.6], obstacle=[pier])
    hydrostatic_start.compress(particles, case)
    on_pier = np.all(before[:, :2] < 0.2, axis=1)
    assert on_pier.sum() == 12
    head = before[on_pier, 2] - 0.3
    found = particles.compression[particles.fluid]
    np.testing.assert_allclose(found[on_pier], G * (0.3 - head) / C**2, rtol=1e-12)
    np.testing.assert_allclose(
        particles.position[particles.fluid][on_pier, 2], 0.3 + settled(head, 0.3), rtol=1e-12
    )
    assert not np.any(found[~on_pier])
    np.testing.assert_array_equal(particles.position[particles.fluid][~on_pier], before[~on_pier])


def test_the_jitter_is_bounded_and_that_of_the_seed():
    case, particles, before = started()
    walls = particles.position[particles.fluid_count :].copy()
    hydrostatic_start.jitter(particles, case)
    moved = particles.position[particles.fluid] - before
    assert 0.8 * 0.05 * D0 < np.abs(moved).max() <= 0.05 * D0
    assert np.all(np.ptp(moved, axis=0) > 0)
    np.testing.assert_array_equal(particles.position[particles.fluid_count :], walls)
    _, again, _ = started()
    hydrostatic_start.jitter(again, case)
    np.testing.assert_array_equal(again.position, particles.position)
    other = tank3d_case(scheme={"jitter": 0.05}, particles={"seed": 2})
    third = seed(other)
    hydrostatic_start.jitter(third, other)
    assert np.any(third.position[third.fluid] != particles.position[particles.fluid])
