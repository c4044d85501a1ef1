"""Grains: closed forms of kinetic theory, concentration, and the pressure between grains."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.physics.collision_stress import (
    collide_grains,
    collision_force_at,
    largest_pressure_step,
)
from debrisflow.physics.concentration import concentrations
from debrisflow.physics.grain_pressure import carried_depths, couple_grains, covered_depth_at
from debrisflow.physics.granular_temperature import (
    algebraic_temperatures,
    fluctuation_temperature_at,
    fluctuation_temperatures,
    neighborhood_temperature_at,
    neighborhood_temperatures,
)
from debrisflow.physics.kinetic_theory import (
    Grains,
    algebraic_temperature,
    granular_pressure,
    granular_viscosity,
    radial_distribution,
)
from debrisflow.physics.operators import number_density, velocity_gradients
from debrisflow.schemes.pair_solver import couplings_of, solve_pairs
from debrisflow.schemes.terms.collision_stress import viscous_step
from tests.building import (
    NOWHERE,
    RADII,
    center_of_block,
    lattice_block,
    no_solid,
    one_list,
    random_patch,
    solid_of,
    started,
    tank_case,
)

GRAINS = Grains(2650.0, 0.003, 0.7, 0.55, 0.5)
SUBMERGED, GRAVITY = 1650.0, np.array([0.0, -9.81, 0.0])
SPACING, BED_ROWS = 0.01, 10
NOTHING = no_solid()


@pytest.fixture
def rng():
    return np.random.default_rng(31)


def test_radial_distribution_follows_equation_11():
    # (C / C*)^(1/3) = 1/2, 0.9 and 0
    assert radial_distribution(0.55 / 8, 0.55) == pytest.approx(2.0, rel=1e-14)
    assert radial_distribution(0.55 * 0.9**3, 0.55) == pytest.approx(10.0, rel=1e-13)
    assert radial_distribution(0.0, 0.55) == 1.0


def test_collision_stress_follows_equation_10():
    c = 0.55 / 8  # g0 = 2
    pressure = 2.0 * 2650.0 * c**2 * 2.0 * 1.7 * 0.09
    viscosity = 0.8 * c**2 * 0.003 * 2650.0 * 2.0 * 1.7 * 0.3 / np.sqrt(np.pi)
    assert granular_pressure(c, 0.09, GRAINS) == pytest.approx(pressure, rel=1e-13)
    assert granular_viscosity(c, 0.09, GRAINS) == pytest.approx(viscosity, rel=1e-13)


def test_collision_stress_grows_with_concentration_and_temperature():
    concentrations, temperatures = np.linspace(0.0, 0.549, 40), np.geomspace(1e-8, 1.0, 20)
    for law in (granular_pressure, granular_viscosity):
        table = np.array([[law(c, t, GRAINS) for t in temperatures] for c in concentrations])
        assert np.all(table[0] == 0.0)
        assert np.all(np.diff(table, axis=0) > 0)
        assert np.all(np.diff(table[1:], axis=1) > 0)
        assert law(0.3, 0.0, GRAINS) == 0.0


@pytest.mark.parametrize("restitution", [0.0, 0.7, 0.95])
def test_plane_shear_has_the_stress_ratio_of_kinetic_theory(restitution):
    grains = GRAINS._replace(restitution=restitution)
    for c, rate in ((0.1, 3.0), (0.5, 200.0)):
        temperature = algebraic_temperature(rate, grains)
        assert temperature == pytest.approx((0.003 * rate) ** 2 / (15 * (1 - restitution)))
        stress = granular_viscosity(c, temperature, grains) * rate
        ratio = stress / granular_pressure(c, temperature, grains)
        assert ratio == pytest.approx(0.4 * np.sqrt(15 * (1 - restitution) / np.pi), rel=1e-13)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_uniform_shear_looks_like_temperature(dimension, radius):
    position, near, i = center_of_block(dimension, radius)
    count = len(position)
    velocity = np.zeros((count, 3))
    velocity[:, 0] = 5.0 + 4.0 * position[:, 1]
    found = neighborhood_temperature_at(i, velocity, np.ones(count), near)
    in_reach = np.linalg.norm(position - position[i], axis=1) < radius
    height = position[in_reach, 1] - position[i, 1]
    expected = 4.0**2 * np.mean(height**2) / dimension
    # differences of squares of 25 m2/s2 each
    assert found == pytest.approx(expected, rel=1e-12)
    # of a disk or a ball of that radius it would be shear^2 r_e^2 / 8 or / 15
    assert found == pytest.approx(4.0**2 * radius**2 / {2: 8, 3: 15}[dimension], rel=0.35)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_uniform_motion_has_no_temperature(dimension, radius, rng):
    position = random_patch(dimension, 200, rng, length=8.0)
    near = one_list(position, reference(dimension, radius, 1.0))
    velocity = np.tile([3.7, -1.3, 0.0], (200, 1))
    for i in range(200):
        found = neighborhood_temperature_at(i, velocity, np.ones(200), near)
        assert 0.0 <= found < 1e-14 * 3.7**2 * 200  # a rounding of each square


def test_only_grains_have_a_temperature(rng):
    position = random_patch(2, 100, rng, length=6.0)
    near = one_list(position, reference(2, 3.1, 1.0))
    velocity = random_patch(2, 100, rng)
    fraction = np.where(np.arange(100) % 3 == 0, 1.0, 0.0)
    velocity[fraction > 0] = [1.0, 2.0, 0.0]
    found = neighborhood_temperature_at(0, velocity, fraction, near)
    assert found < 1e-13  # water moves at random, grains as one


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_a_linear_velocity_is_no_fluctuation(dimension, radius, rng):
    position = random_patch(dimension, 120, rng, length=120 ** (1 / dimension))
    near = one_list(position, reference(dimension, radius, 1.0))
    gradient = np.zeros((3, 3))
    gradient[:dimension, :dimension] = rng.normal(size=(dimension, dimension))
    velocity = np.array([7.0, -2.0, 0.0]) + position @ gradient.T
    fraction = rng.choice([0.0, 1.0], 120, p=(0.2, 0.8))
    velocity[fraction == 0.0] = 1e3  # water does not count
    for i in np.flatnonzero(fraction):
        found = fluctuation_temperature_at(i, velocity, fraction, near)
        spread = neighborhood_temperature_at(i, velocity, fraction, near)
        # rounding of differences of squares, more where the neighbors stand nearly on a line
        assert found <= 1e-9 * max(spread, 1e-9)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_the_fluctuation_temperature_is_that_of_independent_grains_in_the_mean(
    dimension, radius, rng
):
    position, near, i = center_of_block(dimension, radius)
    count = len(position)
    everywhere, found = np.ones(count), []
    for _ in range(400):
        velocity = np.zeros((count, 3))
        velocity[:, :dimension] = rng.normal(0.0, 0.3, (count, dimension))
        velocity[:, 0] += 4.0 * position[:, 1]
        found.append(fluctuation_temperature_at(i, velocity, everywhere, near))
    # the mean of 400 estimates from at least 10 x Ds degrees of freedom each: 1 sigma is 1.6 %
    assert np.mean(found) == pytest.approx(0.3**2, rel=0.05)


def test_too_few_grains_have_no_fluctuation():
    position = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    velocity = np.array([[0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    near = one_list(position, reference(2, 3.1, 1.0))
    assert fluctuation_temperature_at(0, velocity, np.ones(3), near) == 0.0
    row = np.array([[0.5 * k, 0.0, 0.0] for k in range(6)])
    velocity = np.zeros((6, 3))
    velocity[::2, 0] = 1.0
    near = one_list(row, reference(2, 3.1, 1.0))
    assert fluctuation_temperature_at(2, velocity, np.ones(6), near) == 0.0


def temperatures_of(law, velocity, fraction, near):
    """Return the temperature of all particles, (n,) float64 array, by one of the laws."""
    count = len(velocity)
    temperature = np.full(count, np.nan)
    if law == "algebraic":
        gradient, rate = np.empty((count, 9), np.float32), np.empty(count)
        velocity_gradients(velocity, near, NOTHING, gradient, rate)
        algebraic_temperatures(rate, fraction, GRAINS, temperature)
    elif law == "neighborhood":
        c = np.full(count, 0.4)
        neighborhood_temperatures(velocity, fraction, c, 1000.0, np.inf, GRAINS, near, temperature)
    else:
        fluctuation_temperatures(velocity, fraction, near, temperature)
    return temperature


@pytest.mark.parametrize("law", ["algebraic", "neighborhood", "fluctuation"])
def test_every_temperature_is_that_of_the_grains_alone(law, rng):
    position = random_patch(2, 150, rng, length=8.0)
    near = one_list(position, reference(2, 3.1, 1.0))
    velocity, fraction = random_patch(2, 150, rng), rng.choice([0.0, 0.5, 1.0], 150)
    temperature = temperatures_of(law, velocity, fraction, near)
    assert np.all(temperature[fraction == 0.0] == 0.0)
    assert np.all(temperature[fraction > 0.0] > 0.0)


def test_collision_state_is_that_of_the_clipped_concentration(rng):
    position = random_patch(2, 150, rng, length=8.0)
    near = one_list(position, reference(2, 3.1, 1.0))
    fraction = rng.choice([0.0, 0.5, 1.0], 150)
    c = np.where(fraction > 0.0, rng.uniform(0.0, 0.9, 150), 0.0)
    n, temperature = np.empty(150), rng.uniform(0.01, 0.1, 150)
    number_density(near, NOTHING, n)
    pressure, viscosity = np.full(150, np.nan), np.zeros(150)
    collide_grains(c, GRAINS, near.number_density, n, temperature, pressure, viscosity)
    for values in (pressure, viscosity):
        assert np.all(values[fraction == 0.0] == 0.0)
    for i in np.nonzero(fraction)[0]:
        clipped, t = min(c[i], 0.5), temperature[i]
        # fades towards the free surface
        inside = np.clip((n[i] / near.number_density - 0.8) / 0.2, 0.0, 1.0)
        whole = granular_pressure(clipped, t, GRAINS)
        assert pressure[i] == pytest.approx(inside * whole, rel=1e-9, abs=1e-12)
        assert viscosity[i] == pytest.approx(granular_viscosity(clipped, t, GRAINS))


@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_wall_shears_grains_unless_they_slip_along_it(slip):
    position = np.array([[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]])
    solid = solid_of(position[1:], (0.0, 1.0, 0.0), depth=0.5, slip=slip, velocity=(0.5, 0.0, 0.0))
    near = one_list(position, reference(2, 3.1, 1.0), rows=1)
    velocity, one = np.array([[2.0, 0.0, 0.0]]), np.ones(1)
    force = collision_force_at(0, velocity, one, 100.0 * one, 3.0 * one, near, solid)
    # mirrored at the surface: the wall particle has 0.5 - 1.5 m/s
    shear = 4.0 / (near.laplacian_lambda * near.number_density) * 3.0 * 2.1 * (-3.0)
    np.testing.assert_allclose(force, [shear * (1.0 - slip), 0.0, 0.0], rtol=1e-13)


def test_the_collision_step_is_that_of_sound_or_of_diffusion():
    c, none = np.array([0.9, 0.55 / 8]), np.zeros(2)
    grains = GRAINS._replace(largest_concentration=0.55 / 8)  # g0 = 2
    sound = np.sqrt(100.0 / 2650.0 * (2.0 + 2.0 / 3.0))
    rock = np.full(2, 2650.0)

    def step(c, pressure, viscosity, grains, spacing):
        density = rock[: c.size]
        return min(
            largest_pressure_step(c, density, pressure, spacing, grains),
            viscous_step(viscosity, density, spacing),
        )

    assert step(c, np.array([100.0, 1.0]), none, grains, 0.01) == pytest.approx(0.002 / sound)
    diffusion = 0.2 * 0.01**2 * 2650.0 / 50.0
    assert step(c, none, np.array([1.0, 50.0]), grains, 0.01) == pytest.approx(diffusion)
    assert step(c, none, none, grains, 0.01) == np.inf
    assert step(c[:0], none[:0], none[:0], grains, 0.01) == np.inf


def concentrations_of(fraction, near, down=NOWHERE):
    """Return the concentrations around and at the level of all particles."""
    around, level = np.empty((2, fraction.size))
    concentrations(fraction, fraction, down, near, around, level)
    return around, level


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_concentration_is_a_mean(dimension, radius, rng):
    position = random_patch(dimension, 300, rng, length=8.0)
    near = one_list(position, reference(dimension, radius, 1.0))
    c, _ = concentrations_of(np.full(300, 0.37), near)
    np.testing.assert_allclose(c, 0.37, rtol=1e-13)  # also at the rim: walls and air do not count
    fraction = rng.choice([0.0, 1.0], 300)
    c, _ = concentrations_of(fraction, near)
    assert c.min() >= 0.0
    assert c.max() <= 1.0
    smooth, _ = concentrations_of(c, near)
    assert np.std(smooth) < np.std(c) < np.std(fraction)


def test_concentration_counts_the_fluid_in_reach_by_weight():
    # sediment beside water at r_e / 2, so that w = 1, and a wall that does not count
    position = np.array([[0.0, 0.0, 0.0], [1.55, 0.0, 0.0], [0.5, 0.0, 0.0]])
    near = one_list(position, reference(2, 3.1, 1.0), wall_from=2)
    c, _ = concentrations_of(np.array([1.0, 0.0]), near)
    np.testing.assert_allclose(c, [2.0 / 3.0, 1.0 / 3.0], rtol=1e-14)


def balanced_bed(water_rows):
    """Return height of and grain pressure on the fluid of a flat bed, C = 0.5, under water."""
    rows = BED_ROWS + water_rows
    scheme, state = started(tank_case(15, rows, "mixture", (15, rows + 5), SPACING))
    p = state.particles
    height = p.position[p.fluid, 1]
    c = np.where(height < BED_ROWS * SPACING, 0.5, 0.0)
    near = one_list(p.position, scheme.lattice, p.unknown_count, wall_from=p.fluid_count)
    given = np.where(c == 0.0, 0.0, np.nan)
    is_surface, depth = (c > 0.0) & (height > (rows - 1) * SPACING), np.empty(p.fluid_count)
    carried_depths(GRAVITY, is_surface, near, depth)
    assert np.all(depth[~is_surface] == 0.0)
    given[is_surface] = 0.5 * SUBMERGED * 9.81 * depth[is_surface]
    return height, balanced_grains(near, c, given, SUBMERGED * GRAVITY)


def balanced_grains(near, c, given, submerged):
    """Return the pressure between grains that balances their weight; nan is not given."""
    count, is_free = c.size, np.isnan(given)
    system, right = couplings_of(near, is_free), np.empty((count, 1))
    couple_grains(near, c, submerged, system, right)
    x = np.where(is_free, 0.0, given)[:, None]
    solve_pairs("the balance", system, near, right, 1e-26 * np.sum(right[is_free] ** 2), x)
    return x[:, 0]


def test_grains_of_a_flat_bed_carry_its_submerged_weight():
    height, found = balanced_bed(water_rows=0)
    depth = BED_ROWS * SPACING - height
    # the surface row is given at its half row's weight, so that the lattice is exact
    np.testing.assert_allclose(found, 0.5 * SUBMERGED * 9.81 * depth, rtol=1e-9)


def test_water_on_the_bed_adds_nothing_to_the_pressure_between_grains():
    _, bare = balanced_bed(water_rows=0)
    height, shallow = balanced_bed(water_rows=5)
    _, deep = balanced_bed(water_rows=12)
    is_floor = np.isclose(height, 0.5 * SPACING)
    # the jump of C under water costs less than a tenth of a row
    np.testing.assert_allclose(shallow[is_floor], bare[: is_floor.sum()].max(), rtol=0.01)
    # water rows follow the bed's in each column; p = 0 in them
    in_bed = [p.reshape(15, -1)[:, :BED_ROWS] for p in (shallow, deep)]
    np.testing.assert_allclose(*in_bed, rtol=1e-9)
    for p in (shallow, deep):
        assert not p.reshape(15, -1)[:, BED_ROWS:].any()


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_a_linear_grain_pressure_is_exact_on_any_arrangement(rng, dimension, radius):
    position = random_patch(dimension, 400, rng, length=1.0)
    spacing = 400 ** (-1.0 / dimension)
    near = one_list(position, reference(dimension, radius, spacing))
    gravity = np.array([3.0, -9.0, 0.0])
    expected = 2000.0 + 0.4 * SUBMERGED * position @ gravity
    given = np.where(rng.random(400) < 0.1, expected, np.nan)
    found = balanced_grains(near, np.full(400, 0.4), given, SUBMERGED * gravity)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("water_rows", [0, 1, 6])
@pytest.mark.parametrize("slope", [0.0, 15.0])
def test_the_concentration_at_a_level_tells_a_bed_from_water_on_it(water_rows, slope):
    scheme, state = started(tank_case(20, 10 + water_rows, "water", spacing=SPACING))
    p = state.particles
    row = (p.position[p.fluid, 1] / SPACING).astype(int)
    near = one_list(p.position, scheme.lattice, p.unknown_count, wall_from=p.fluid_count)
    c = 0.55 * (row < 10)
    down = np.array([np.sin(np.radians(slope)), -np.cos(np.radians(slope)), 0.0])
    for _ in range(2):
        _, c = concentrations_of(c, near, down)
    if water_rows == 0:
        np.testing.assert_allclose(c, 0.55, rtol=1e-12)
    else:
        inside = np.abs(p.position[p.fluid, 0] / SPACING - 10.0) < 5.0
        assert c[inside & (row == 9)].min() > 0.35
        assert c[inside & (row == 10)].max() < 0.23  # a fifth of the strength


@pytest.mark.parametrize("slope", [0.0, 15.0])
def test_a_sunken_surface_row_carries_what_it_has_sunk(slope):
    rows = lattice_block(2, (9, 4))
    rows[rows[:, 1] > 3.0, 1] -= 0.25
    near = one_list(rows, reference(2, 3.1, 1.0))
    top = int(np.argmin(np.abs(rows[:, 0] - 4.5) - rows[:, 1]))
    angle = np.radians(slope)
    gravity = 9.0 * np.array([np.sin(angle), -np.cos(angle), 0.0])
    depth = covered_depth_at(top, gravity, near)
    assert depth == pytest.approx(1.5 - 0.75 * np.cos(angle), rel=1e-12)


def test_without_grains_or_gravity_there_is_no_grain_pressure(rng):
    position = random_patch(2, 200, rng, length=8.0)
    near = one_list(position, reference(2, 3.1, 1.0))
    given = np.where(np.arange(200) < 20, 0.0, np.nan)
    for c, gravity in ((0.0, GRAVITY), (0.5, NOWHERE)):
        assert not balanced_grains(near, np.full(200, c), given, SUBMERGED * gravity).any()
