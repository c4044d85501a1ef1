"""Operators on the lattice, next to walls and on random patches."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.wall_access import velocity_difference
from debrisflow.physics import momentum, pressure
from debrisflow.physics.collision_stress import throw
from debrisflow.physics.operators import (
    gradient_at,
    number_density,
    number_density_at,
    shear_rate_at,
)
from debrisflow.schemes.system import empty_system
from tests.building import (
    NOWHERE,
    RADII,
    center_of_block,
    lattice_block,
    no_walls,
    random_patch,
    stencil_of,
)

# Of r^2 and of r on the lattice: dimension, radius, HL Laplacian, HS divergence, unit of the
# last digit given.
HIGHER_ORDER = [
    (2, 3.1, 7.4265, 2.4755, 1e-4),
    (2, 2.1, 8.5048, 2.8349, 1e-4),
    (3, 2.4, 6.910, 3.455, 1e-3),
    (3, 2.1, 6.439, 3.219, 1e-3),
]
NONE = np.zeros(0)

# One rounding of each of some 50 terms.
EXACT = 1e-12


@pytest.fixture
def rng():
    return np.random.default_rng(11)


@pytest.fixture(params=RADII, ids=lambda p: f"{p[0]}D-{p[1]}")
def block(request):
    """Return positions relative to the center of a block, its stencil and the central particle."""
    position, stencil, i = center_of_block(*request.param)
    return position - position[i], stencil, i


@pytest.fixture(params=RADII, ids=lambda p: f"{p[0]}D-{p[1]}")
def patch(request, rng):
    """Return the stencil of a random patch, with densities and velocities."""
    dimension, radius = request.param
    position = random_patch(dimension, 200, rng, length=8.0)
    velocity = random_patch(dimension, 200, rng) - 0.5
    density = rng.uniform(1000.0, 2650.0, 200)
    return position, stencil_of(position, reference(dimension, radius, 1.0)), density, velocity


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
    n, asymmetry = np.empty(len(position)), np.empty(len(position))
    number_density(stencil_of(position, lattice, period=period), n, asymmetry)
    # w = r_e / r - 1 magnifies the rounding of positions 0.2 m from the origin
    np.testing.assert_allclose(n, lattice.number_density, rtol=1e-12)
    np.testing.assert_allclose(asymmetry, 0.0, atol=1e-11)


def test_the_sum_gradient_of_a_linear_field_is_exact(block, rng):
    position, stencil, i = block
    slope = on_plane(int(stencil.dimension), rng)
    for with_walls in (True, False):
        found = gradient_at(i, 3.0 + position @ slope, with_walls, stencil)
        np.testing.assert_allclose(found, slope, atol=EXACT)


def test_dummy_walls_take_the_value_of_the_particle_or_none():
    position, _, _ = center_of_block(2, 3.1)
    position -= position[len(position) // 2]
    position = position[np.argsort(position[:, 1] < -1.2, kind="stable")]
    rows = int(np.sum(position[:, 1] > -1.2))
    stencil = stencil_of(position, reference(2, 3.1, 1.0), rows=rows)
    i = int(np.nonzero(~position.any(axis=1))[0][0])
    values = np.full(rows, 5.0)
    np.testing.assert_allclose(gradient_at(i, values, True, stencil), 0.0, atol=EXACT)
    r = np.linalg.norm(position[rows:], axis=1)
    weight = np.maximum(3.1 / r - 1.0, 0.0) / r**2
    missing = 2.0 / stencil.number_density * 2.0 * 5.0 * weight @ position[rows:]
    np.testing.assert_allclose(gradient_at(i, values, False, stencil), -missing, atol=EXACT)
    assert missing[1] < -0.5


def test_the_cmps_form_of_a_linear_field_is_zero(block, rng):
    # why it is not the default: the bracket of equation (4) is constant on a lattice
    position, stencil, i = block
    values = 3.0 + position @ on_plane(int(stencil.dimension), rng)
    least = np.empty(len(values))
    pressure.least_pressure(values, stencil, least)
    velocity = np.zeros_like(position)
    pressure.correct(1.0, values - least, np.ones(len(values)), False, stencil, velocity)
    np.testing.assert_allclose(velocity[i], 0.0, atol=EXACT)


def assembled(stencil, velocity, density, interface, rate=0.0):
    """Return the pressure equation of a patch without free surface, for a step of 1 s."""
    m = len(velocity)
    system = empty_system(stencil.neighbors)
    pressure.assemble(
        m,
        velocity,
        density,
        stencil,
        pressure.FreeSurface(-1.0, -1.0, np.inf),
        pressure.Interface(*interface),
        pressure.Source(1.0, rate, 0.0),
        system,
        np.empty(m),
        np.empty(m, dtype=bool),
    )
    return system


def pressure_forms(i, values, velocity, stencil, density=None, interface=None):
    """Return Laplacian of values and divergence of velocity at i in the pressure equation."""
    density = np.ones(len(values)) if density is None else density
    interface = interface or (0.0, 0.0, 5.0 - stencil.dimension)
    system = assembled(stencil, velocity, density, interface)
    entries = slice(0, system.entries[i])
    row = system.value[i, entries] @ values[system.columns[i, entries]]
    laplacian = (row - system.diagonal[i] * values[i]) / stencil.number_density
    return laplacian, -system.right[i] / stencil.number_density


def viscous_force(i, values, stencil):
    """Return the viscous force on i of a velocity along x, with a viscosity of 1."""
    velocity = np.zeros((len(values), 3))
    velocity[:, 0] = values
    walls = no_walls(len(values))
    return momentum.viscous_force_at(i, velocity, np.ones(len(values)), walls, stencil)[0]


def test_least_pressure_is_the_least_of_a_particle_and_its_neighbors(rng):
    position = random_patch(2, 200, rng, length=8.0)
    stencil = stencil_of(position, reference(2, 3.1, 1.0), rows=150)
    values, least = rng.normal(size=150), np.empty(150)
    pressure.least_pressure(values, stencil, least)
    for i in range(150):
        listed = stencil.neighbors[i, : stencil.unknown_count[i]]
        assert least[i] == min([values[i], *values[listed]])


def test_the_laplacian_of_r2_is_exact(block):
    position, stencil, i = block
    found = viscous_force(i, np.sum(position**2, axis=1), stencil)
    assert found == pytest.approx(2 * stencil.dimension, rel=EXACT)


@pytest.mark.parametrize(("dimension", "radius", "hl", "hs", "unit"), HIGHER_ORDER)
def test_higher_order_forms_have_their_lattice_constants(dimension, radius, hl, hs, unit):
    position, stencil, i = center_of_block(dimension, radius)
    position = position - position[i]
    laplacian, divergence = pressure_forms(i, np.sum(position**2, axis=1), position, stencil)
    assert laplacian == pytest.approx(hl, abs=unit)
    assert divergence == pytest.approx(hs, abs=unit)
    # the pressure equation lives on the ratio: 3 in two dimensions, 2 in three
    assert laplacian / divergence == pytest.approx(5 - dimension, rel=EXACT)


def test_operators_do_not_depend_on_the_unit_of_length():
    position, stencil, i = center_of_block(2, 3.1, spacing=0.005)
    position = position - position[i]
    r2 = np.sum(position**2, axis=1)
    assert viscous_force(i, r2, stencil) == pytest.approx(4.0, rel=EXACT)
    hl, hs = pressure_forms(i, r2, position, stencil)
    assert hl == pytest.approx(7.4265, abs=1e-4)
    assert hs == pytest.approx(2.4755, abs=1e-4)


def test_the_interface_coefficients_differ_in_the_sign_of_the_density_gradient():
    # 1/rho = a + b x and p = x: div(grad p / rho) = b, of which the symmetric form gives its
    # lattice share 1.5 * 2.4755 / 2 and the study's equation (9) -2.4755 / 2
    position, stencil, i = center_of_block(2, 3.1)
    x = position[:, 0] - position[i, 0]
    b = 1e-4  # weak: the mean of the densities is harmonic in the specific volumes
    density = 1.0 / (1.0 + b * x)
    forms = {}
    for name, interface in (("symmetric", (0.0, 0.0, 3.0)), ("study", (4.0, -1.0, 0.0))):
        forms[name], _ = pressure_forms(i, x, position, stencil, density, interface)
    assert forms["symmetric"] == pytest.approx(1.5 * 2.4755 / 2 * b, rel=1e-4)
    assert forms["study"] == pytest.approx(-2.4755 / 2 * b, rel=1e-4)


def test_denser_than_the_lattice_drives_the_pressure_up():
    position, _, i = center_of_block(2, 3.1)
    squeezed = stencil_of(0.98 * position, reference(2, 3.1, 1.0))
    rest = np.zeros_like(position)
    right = assembled(squeezed, rest, np.ones(len(position)), (0.0, 0.0, 3.0), rate=2.0).right
    n, _ = number_density_at(i, squeezed)
    assert n > squeezed.number_density
    assert right[i] == pytest.approx(2.0 * (n - squeezed.number_density), rel=EXACT)


def test_the_shear_rate_of_a_linear_profile_is_exact(block, rng):
    position, stencil, i = block
    dimension = int(stencil.dimension)
    gradient = np.zeros((3, 3))
    gradient[:dimension, :dimension] = rng.normal(size=(dimension, dimension))
    walls = no_walls(len(position))
    found = shear_rate_at(i, 2.0 + position @ gradient.T, walls, stencil)
    strain = 0.5 * (gradient + gradient.T)
    assert found == pytest.approx(np.sqrt(2.0 * np.sum(strain**2)), rel=EXACT)


def test_rotation_and_translation_have_no_shear_rate(block, rng):
    position, stencil, i = block
    walls = no_walls(len(position))
    uniform = np.ones_like(position) * on_plane(int(stencil.dimension), rng)
    assert shear_rate_at(i, uniform, walls, stencil) == 0.0
    rotation = np.cross([0.0, 0.0, 3.0], position)
    assert shear_rate_at(i, rotation, walls, stencil) < 3.0 * EXACT


def over_a_wall(slip, wall_velocity):
    """Return positions, stencil, walls and velocities of eight rows on a wall, at rest."""
    position = lattice_block(2, (17, 12))
    position[:, :2] -= [8.5, 4.0]  # four layers of wall below y = 0
    position = position[np.argsort(position[:, 1] < 0.0, kind="stable")]
    is_wall = position[:, 1] < 0.0
    stencil = stencil_of(
        position, reference(2, 3.1, 1.0), rows=len(position), wall_from=int(np.sum(~is_wall))
    )
    walls = no_walls(len(position))
    walls.normal[is_wall, 1] = 1.0
    walls.depth[is_wall] = -position[is_wall, 1]
    walls.slip[is_wall] = slip
    velocity = np.zeros_like(position)
    velocity[is_wall, 0] = wall_velocity
    return position, is_wall, stencil, walls, velocity


@pytest.mark.parametrize("wall_velocity", [0.0, 0.7])
def test_the_shear_rate_is_exact_up_to_a_no_slip_wall(wall_velocity):
    position, is_wall, stencil, walls, velocity = over_a_wall(0.0, wall_velocity)
    velocity[~is_wall, 0] = wall_velocity + 3.0 * position[~is_wall, 1]
    column = np.nonzero((position[:, 0] == 0.0) & (position[:, 1] > 0) & (position[:, 1] < 5))[0]
    assert column.size == 5
    for i in column:
        assert shear_rate_at(i, velocity, walls, stencil) == pytest.approx(3.0, rel=EXACT)
        force = momentum.viscous_force_at(i, velocity, np.ones(len(position)), walls, stencil)
        # a linear profile needs no force
        np.testing.assert_allclose(force, 0.0, atol=10 * EXACT)


@pytest.mark.parametrize(("slip", "wall_velocity"), [(1.0, 0.0), (0.0, 2.0)])
def test_a_wall_that_slips_or_moves_along_shears_nothing(slip, wall_velocity):
    _, is_wall, stencil, walls, velocity = over_a_wall(slip, wall_velocity)
    velocity[~is_wall, 0] = 2.0
    for i in np.nonzero(~is_wall)[0]:
        assert shear_rate_at(i, velocity, walls, stencil) == 0.0


def test_a_particle_that_sinks_into_a_wall_counts_as_half_a_spacing_above():
    position = np.array([[0.0, 0.5, 0.0], [0.0, -1.5, 0.0]])
    walls = no_walls(2)
    walls.normal[1, 1], walls.depth[1] = 1.0, 1.5
    velocity = np.array([[2.0, -3.0, 0.0], [0.0, 0.0, 0.0]])
    for height, factor in ((1.0, 2.5), (0.5, 4.0), (0.1, 4.0), (-0.2, 4.0)):
        position[0, 1] = height
        stencil = stencil_of(position, reference(2, 3.1, 1.0), wall_from=1)
        found = velocity_difference(0, 0, velocity, walls, stencil)
        np.testing.assert_allclose(found, -factor * velocity[0], rtol=EXACT)


def test_the_sum_gradient_conserves_momentum(patch, rng):
    position, stencil, density, _ = patch
    force = np.zeros_like(position)
    pressure.correct(1.0, rng.uniform(0, 1e4, 200), density, True, stencil, force)
    force *= density[:, None]
    assert balance(force) < EXACT
    # the pair forces are central
    assert balance(np.cross(position, force)) < EXACT


def test_the_viscous_force_conserves_momentum(patch, rng):
    _, stencil, density, velocity = patch
    found = np.empty_like(velocity)
    viscosity = rng.choice([0.0, 1e-3, 10.0], 200)
    walls = no_walls(200)
    matter = momentum.Matter(velocity, density, viscosity, NONE, NONE, NONE, NONE)
    thrown = np.zeros((0, 3))
    momentum.predict(1.0, NOWHERE, velocity, matter, thrown, True, walls, stencil, found)
    force = density[:, None] * (found - velocity)
    assert np.abs(force).max() > 1.0
    assert balance(force) < EXACT


def test_the_collision_stress_conserves_momentum_and_spares_water(patch, rng):
    _, stencil, density, velocity = patch
    found = np.empty_like(velocity)
    fraction = rng.choice([0.0, 0.4, 1.0], 200)
    grain_pressure, viscosity = rng.uniform(0, 1e3, 200), rng.uniform(0, 10.0, 200)
    walls = no_walls(200)
    thrown = np.empty((200, 3))
    throw(velocity, density, fraction, grain_pressure, viscosity, walls, stencil, thrown)
    matter = momentum.Matter(velocity, density, NONE, NONE, NONE, NONE, NONE)
    momentum.predict(1.0, NOWHERE, velocity, matter, thrown, False, walls, stencil, found)
    np.testing.assert_allclose(found, velocity + thrown, rtol=1e-14)
    force = density[:, None] * thrown
    assert np.abs(force).max() > 1.0
    assert balance(force) < EXACT
    assert np.all(force[fraction == 0.0] == 0.0)
