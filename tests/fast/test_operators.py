"""Operators on the lattice, next to walls and on random patches."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.wall_access import height_over, wall_pair, wall_velocity_difference
from debrisflow.physics import pressure
from debrisflow.physics.collision_stress import collision_acceleration
from debrisflow.physics.free_surface import FreeSurface
from debrisflow.physics.operators import (
    gradient_at,
    number_density,
    number_density_at,
)
from debrisflow.physics.viscosity import viscous_acceleration, viscous_force_at
from debrisflow.schemes.system import empty_system
from tests.building import (
    RADII,
    center_of_block,
    lattice_block,
    no_solid,
    one_list,
    random_patch,
    shear_rate_at,
    solid_of,
    within,
)

# Of r^2 and of r on the lattice: dimension, radius, HL Laplacian, HS divergence, unit of the
# last digit given.
HIGHER_ORDER = [
    (2, 3.1, 7.4265, 2.4755, 1e-4),
    (2, 2.1, 8.5048, 2.8349, 1e-4),
    (3, 2.4, 6.910, 3.455, 1e-3),
    (3, 2.1, 6.439, 3.219, 1e-3),
]
NOTHING = no_solid()

# One rounding of each of some 50 terms.
EXACT = 1e-12


@pytest.fixture
def rng():
    return np.random.default_rng(11)


@pytest.fixture(params=RADII, ids=lambda p: f"{p[0]}D-{p[1]}")
def block(request):
    """Return positions relative to the center of a block, who is near whom, central particle."""
    position, near, i = center_of_block(*request.param)
    return position - position[i], near, i


@pytest.fixture(params=RADII, ids=lambda p: f"{p[0]}D-{p[1]}")
def patch(request, rng):
    """Return positions of a random patch, who is near whom, densities and velocities."""
    dimension, radius = request.param
    position = random_patch(dimension, 200, rng, length=8.0)
    velocity = random_patch(dimension, 200, rng) - 0.5
    density = rng.uniform(1000.0, 2650.0, 200)
    return position, one_list(position, reference(dimension, radius, 1.0)), density, velocity


def on_plane(dimension, rng, shape=()):
    """Return a random array whose entries along axes beyond the dimension are 0."""
    array = rng.normal(size=(*shape, 3))
    array[..., dimension:] = 0.0
    return array


def balance(force):
    """Return the sum of forces relative to the sum of their magnitudes."""
    return np.abs(force.sum(axis=0)).max() / np.abs(force).sum()


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_number_density_of_a_periodic_lattice_is_n0_everywhere(dimension, radius):
    lattice = reference(dimension, radius, 0.02)
    position = lattice_block(dimension, 12, 0.02)
    period = np.where(np.arange(3) < dimension, 12 * 0.02, 0.0)
    near, n = one_list(position, lattice, period=period), np.empty(len(position))
    number_density(near, NOTHING, n)
    asymmetry = [number_density_at(i, near, NOTHING)[1] for i in range(n.size)]
    # w = r_e / r - 1 magnifies the rounding of positions 0.2 m from the origin
    np.testing.assert_allclose(n, lattice.number_density, rtol=1e-12)
    np.testing.assert_allclose(asymmetry, 0.0, atol=1e-11)


def test_the_sum_gradient_of_a_linear_field_is_exact(block, rng):
    position, near, i = block
    slope = on_plane(int(near.dimension), rng)
    for with_walls in (True, False):
        found = gradient_at(i, 3.0 + position @ slope, with_walls, near, NOTHING)
        np.testing.assert_allclose(found, slope, atol=EXACT)


def walls_of(position, **known):
    """Return wall particles that may move."""
    return solid_of(position, **({"velocity": 0.0} | known))


def test_dummy_walls_take_the_value_of_the_particle_or_none():
    position, _, _ = center_of_block(2, 3.1)
    position -= position[len(position) // 2]
    position = position[np.argsort(position[:, 1] < -1.2, kind="stable")]
    rows = int(np.sum(position[:, 1] > -1.2))
    near, solid = one_list(position, reference(2, 3.1, 1.0), rows=rows), walls_of(position[rows:])
    i = int(np.nonzero(~position.any(axis=1))[0][0])
    values = np.full(rows, 5.0)
    np.testing.assert_allclose(gradient_at(i, values, True, near, solid), 0.0, atol=EXACT)
    r = np.linalg.norm(position[rows:], axis=1)
    weight = np.maximum(3.1 / r - 1.0, 0.0) / r**2
    missing = 2.0 / near.number_density * 2.0 * 5.0 * weight @ position[rows:]
    np.testing.assert_allclose(gradient_at(i, values, False, near, solid), -missing, atol=EXACT)
    assert missing[1] < -0.5


def test_the_cmps_form_of_a_linear_field_is_zero(block, rng):
    # why it is not the default: the bracket of equation (4) is constant on a lattice
    position, near, i = block
    values = 3.0 + position @ on_plane(int(near.dimension), rng)
    least = np.empty(len(values))
    pressure.least_pressure(values, near, NOTHING, least)
    velocity = np.zeros_like(position)
    pressure.correct(1.0, values - least, np.ones(len(values)), False, near, NOTHING, velocity)
    np.testing.assert_allclose(velocity[i], 0.0, atol=EXACT)


def assembled(near, velocity, density, interface, rate=0.0):
    """Return the pressure equation of a patch without free surface, for a step of 1 s."""
    m = len(velocity)
    system = empty_system(*near.neighbors.shape)
    pressure.assemble(
        velocity,
        density,
        near,
        NOTHING,
        FreeSurface(lower=-1.0, upper=-1.0, asymmetry=np.inf),
        interface,
        pressure.Source(1.0, rate, disorder=0.0, consistency=1.0, fall=np.zeros(3)),
        system,
        np.empty(m),
        np.empty(m, dtype=bool),
        np.empty(m),
    )
    return system


def pressure_forms(i, values, velocity, near, density=None, interface=None):
    """Return Laplacian of values and divergence of velocity at i in the pressure equation."""
    density = np.ones(len(values)) if density is None else density
    interface = interface or pressure.symmetric_interface(near.dimension)
    system = assembled(near, velocity, density, interface)
    entries = slice(0, system.entries[i])
    row = system.value[i, entries] @ values[system.columns[i, entries]]
    laplacian = (row - system.diagonal[i] * values[i]) / near.number_density
    return laplacian, -system.right[i] / near.number_density


def viscous_force(i, values, near):
    """Return the viscous force on i of a velocity along x, with a viscosity of 1."""
    velocity = np.zeros((len(values), 3))
    velocity[:, 0] = values
    return viscous_force_at(i, velocity, np.ones(len(values)), near, NOTHING)[0]


def test_least_pressure_is_the_least_of_a_particle_and_its_neighbors(rng):
    position = random_patch(2, 200, rng, length=8.0)
    # the last fluid particles, then walls that carry a pressure, then others
    near = one_list(position, reference(2, 3.1, 1.0), rows=150, wall_from=120)
    values, least = rng.normal(size=150), np.empty(150)
    pressure.least_pressure(values, near, walls_of(position[120:]), least)
    is_near = within(position, 3.1)[:150, :150] == 1
    for i in range(150):
        assert least[i] == min([values[i], *values[is_near[i]]])


def test_the_laplacian_of_r2_is_exact(block):
    position, near, i = block
    found = viscous_force(i, np.sum(position**2, axis=1), near)
    assert found == pytest.approx(2 * near.dimension, rel=EXACT)


@pytest.mark.parametrize(("dimension", "radius", "hl", "hs", "unit"), HIGHER_ORDER)
def test_higher_order_forms_have_their_lattice_constants(dimension, radius, hl, hs, unit):
    position, near, i = center_of_block(dimension, radius)
    position = position - position[i]
    laplacian, divergence = pressure_forms(i, np.sum(position**2, axis=1), position, near)
    assert laplacian == pytest.approx(hl, abs=unit)
    assert divergence == pytest.approx(hs, abs=unit)
    # the pressure equation lives on the ratio: 3 in two dimensions, 2 in three
    assert laplacian / divergence == pytest.approx(5 - dimension, rel=EXACT)


def test_operators_do_not_depend_on_the_unit_of_length():
    position, near, i = center_of_block(2, 3.1, spacing=0.005)
    position = position - position[i]
    r2 = np.sum(position**2, axis=1)
    assert viscous_force(i, r2, near) == pytest.approx(4.0, rel=EXACT)
    hl, hs = pressure_forms(i, r2, position, near)
    assert hl == pytest.approx(7.4265, abs=1e-4)
    assert hs == pytest.approx(2.4755, abs=1e-4)


def test_the_interface_coefficients_differ_in_the_sign_of_the_density_gradient():
    # 1/rho = a + b x and p = x: div(grad p / rho) = b, of which the symmetric form gives its
    # lattice share 1.5 * 2.4755 / 2 and the study's equation (9) -2.4755 / 2
    position, near, i = center_of_block(2, 3.1)
    x = position[:, 0] - position[i, 0]
    b = 1e-4  # weak: the mean of the densities is harmonic in the specific volumes
    density = 1.0 / (1.0 + b * x)
    symmetric, study = pressure.symmetric_interface(2), pressure.study_interface(2)
    assert (symmetric, study) == ((0.0, 0.0, 3.0), (4.0, -1.0, 0.0))
    found, _ = pressure_forms(i, x, position, near, density, symmetric)
    assert found == pytest.approx(1.5 * 2.4755 / 2 * b, rel=1e-4)
    found, _ = pressure_forms(i, x, position, near, density, study)
    assert found == pytest.approx(-2.4755 / 2 * b, rel=1e-4)


def test_denser_than_the_lattice_drives_the_pressure_up():
    position, _, i = center_of_block(2, 3.1)
    squeezed = one_list(0.98 * position, reference(2, 3.1, 1.0))
    rest, interface = np.zeros_like(position), pressure.symmetric_interface(2)
    right = assembled(squeezed, rest, np.ones(len(position)), interface, rate=2.0).right
    n, _ = number_density_at(i, squeezed, NOTHING)
    assert n > squeezed.number_density
    assert right[i] == pytest.approx(2.0 * (n - squeezed.number_density), rel=EXACT)


def test_the_shear_rate_of_a_linear_profile_is_exact(block, rng):
    position, near, i = block
    dimension = int(near.dimension)
    gradient = np.zeros((3, 3))
    gradient[:dimension, :dimension] = rng.normal(size=(dimension, dimension))
    found = shear_rate_at(i, 2.0 + position @ gradient.T, near, NOTHING)
    strain = 0.5 * (gradient + gradient.T)
    assert found == pytest.approx(np.sqrt(2.0 * np.sum(strain**2)), rel=EXACT)


def test_rotation_and_translation_have_no_shear_rate(block, rng):
    position, near, i = block
    uniform = np.ones_like(position) * on_plane(int(near.dimension), rng)
    assert shear_rate_at(i, uniform, near, NOTHING) == 0.0
    rotation = np.cross([0.0, 0.0, 3.0], position)
    assert shear_rate_at(i, rotation, near, NOTHING) < 3.0 * EXACT


def over_a_wall(slip, wall_velocity):
    """Return positions of eight rows on a wall, who is near whom, and the wall."""
    position = lattice_block(2, (17, 12))
    position[:, :2] -= [8.5, 4.0]  # four layers of wall below y = 0
    position = position[np.argsort(position[:, 1] < 0.0, kind="stable")]
    fluid = int(np.sum(position[:, 1] > 0.0))
    near = one_list(position, reference(2, 3.1, 1.0), wall_from=fluid)
    wall = position[fluid:]
    solid = solid_of(
        wall, (0.0, 1.0, 0.0), depth=-wall[:, 1], slip=slip, velocity=(wall_velocity, 0.0, 0.0)
    )
    return position[:fluid], near, solid


@pytest.mark.parametrize("wall_velocity", [0.0, 0.7])
def test_the_shear_rate_is_exact_up_to_a_no_slip_wall(wall_velocity):
    position, near, solid = over_a_wall(0.0, wall_velocity)
    velocity, viscosity = np.zeros_like(position), np.ones(len(position))
    velocity[:, 0] = wall_velocity + 3.0 * position[:, 1]
    column = np.nonzero((position[:, 0] == 0.0) & (position[:, 1] < 5))[0]
    assert column.size == 5
    for i in column:
        assert shear_rate_at(i, velocity, near, solid) == pytest.approx(3.0, rel=EXACT)
        force = viscous_force_at(i, velocity, viscosity, near, solid)
        # a linear profile needs no force
        np.testing.assert_allclose(force, 0.0, atol=10 * EXACT)


def test_the_shear_rate_of_a_stretching_flow_is_exact_up_to_a_free_slip_wall():
    # of the way to the wall only what leads across it counts
    position, near, solid = over_a_wall(1.0, 0.0)
    velocity = 2.0 * position * [1.0, -1.0, 0.0]
    column = np.nonzero((position[:, 0] == 0.0) & (position[:, 1] < 5))[0]
    for i in column:
        assert shear_rate_at(i, velocity, near, solid) == pytest.approx(4.0, rel=EXACT)


@pytest.mark.parametrize(("slip", "wall_velocity"), [(1.0, 0.0), (0.0, 2.0)])
def test_a_wall_that_slips_or_moves_along_shears_nothing(slip, wall_velocity):
    position, near, solid = over_a_wall(slip, wall_velocity)
    velocity = np.zeros_like(position)
    velocity[:, 0] = 2.0
    for i in range(len(position)):
        assert shear_rate_at(i, velocity, near, solid) == 0.0


def test_a_particle_that_sinks_into_a_wall_counts_as_half_a_spacing_above():
    position = np.array([[0.0, 0.5, 0.0], [0.0, -1.5, 0.0]])
    solid = walls_of(position[1:], normal=(0.0, 1.0, 0.0), depth=1.5)
    velocity = np.array([2.0, -3.0, 0.0])
    for height, factor in ((1.0, 2.5), (0.5, 4.0), (0.1, 4.0), (-0.2, 4.0)):
        position[0, 1] = height
        near = one_list(position, reference(2, 3.1, 1.0), rows=1)
        j, dx, dy, dz, _ = wall_pair(0, 0, near, solid)
        above = height_over(dx, dy, dz, j, solid)
        assert above == pytest.approx(height, rel=EXACT)
        found = wall_velocity_difference(*velocity, above, j, solid, near)
        np.testing.assert_allclose(found, -factor * velocity, rtol=EXACT)


def test_the_sum_gradient_conserves_momentum(patch, rng):
    position, near, density, _ = patch
    force = np.zeros_like(position)
    pressure.correct(1.0, rng.uniform(0, 1e4, 200), density, True, near, NOTHING, force)
    force *= density[:, None]
    assert balance(force) < EXACT
    # the pair forces are central
    assert balance(np.cross(position, force)) < EXACT


def test_the_viscous_force_conserves_momentum(patch, rng):
    _, near, density, velocity = patch
    found = np.empty_like(velocity)
    viscosity = rng.choice([0.0, 1e-3, 10.0], 200)
    viscous_acceleration(velocity, density, viscosity, near, NOTHING, found)
    force = density[:, None] * found
    assert np.abs(force).max() > 1.0
    assert balance(force) < EXACT


def test_the_collision_stress_conserves_momentum_and_spares_water(patch, rng):
    _, near, density, velocity = patch
    found = np.empty_like(velocity)
    fraction = rng.choice([0.0, 0.4, 1.0], 200)
    grain_pressure, viscosity = rng.uniform(0, 1e3, 200), rng.uniform(0, 10.0, 200)
    collision_acceleration(
        velocity, density, fraction, grain_pressure, viscosity, near, NOTHING, found
    )
    force = density[:, None] * found
    assert np.abs(force).max() > 1.0
    assert balance(force) < EXACT
    assert np.all(force[fraction == 0.0] == 0.0)
