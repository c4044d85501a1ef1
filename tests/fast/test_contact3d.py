"""Grains and contacts of the explicit scheme: agitation, collisions, bounces off walls."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.physics import compressible
from debrisflow.physics.collision_stress import collide_grains
from debrisflow.physics.contact import bounce_at, is_inside_wall_at, touches_wall_at
from debrisflow.physics.granular_temperature import (
    algebraic_temperatures,
    capped_temperature,
    neighborhood_temperature_at,
    neighborhood_temperatures,
)
from debrisflow.physics.kinetic_theory import Grains, algebraic_temperature, granular_pressure
from debrisflow.physics.motion import survey_motion
from debrisflow.physics.operators import velocity_gradient_at, velocity_gradients
from tests.building import (
    fluid_of,
    lattice_block,
    numbers_of,
    random_patch,
    solid_of,
    started,
    tank3d_case,
    two_lists,
)

LATTICE = reference(3, 2.4, 1.0)
NUMBERS = numbers_of(LATTICE)
DISTANCE, RESTITUTION = NUMBERS.collision_distance, NUMBERS.restitution
GRAINS = Grains(
    density=2650.0, diameter=0.3, restitution=0.7, packing_limit=0.55, largest_concentration=0.5
)
NO_WALLS = solid_of(np.zeros((0, 3)))
MIDDLE = 9**3 // 2
REACH = 0.3  # height below which a particle bounces: the collision distance less half a spacing


@pytest.fixture
def rng():
    return np.random.default_rng(23)


def sheared(rate, drift=0.0):
    """Return places and velocities of a lattice in plane shear; the middle one has all near it."""
    position = lattice_block(3, 9)
    velocity = np.zeros_like(position)
    velocity[:, 0] = drift + rate * position[:, 2]
    return position, velocity


def variance(position, velocity, i=MIDDLE):
    near = two_lists(position, NO_WALLS, LATTICE)
    return neighborhood_temperature_at(i, velocity, np.ones(len(position)), near)


def test_uniform_motion_has_no_agitation(rng):
    position, velocity = random_patch(3, 200, rng, length=6.0), np.tile([3.7, -1.3, 0.4], (200, 1))
    assert all(variance(position, velocity, i) == 0.0 for i in range(200))


def test_uniform_shear_looks_like_agitation():
    position, velocity = sheared(4.0, drift=50.0)
    z = position[:, 2] - position[MIDDLE, 2]
    near = np.linalg.norm(position - position[MIDDLE], axis=1) < 2.4
    found = variance(position, velocity)
    # velocities of 50 m/s are subtracted from each other
    assert found == pytest.approx(4.0**2 * np.mean(z[near] ** 2) / 3.0, rel=1e-12)
    # of a ball; the 57 points have 198 d0^2 in sum of r^2, 0.5 % more than a ball
    assert found == pytest.approx(4.0**2 * 2.4**2 / 15.0, rel=0.01)


def test_agitation_is_the_variance_of_those_in_reach(rng):
    position, velocity = random_patch(3, 300, rng, length=6.0), rng.normal(size=(300, 3))
    for i in range(0, 300, 20):
        near = np.linalg.norm(position - position[i], axis=1) < 2.4
        expected = np.var(velocity[near], axis=0).sum() / 3.0
        assert variance(position, velocity, i) == pytest.approx(expected, rel=1e-12)


def test_the_pressure_of_agitated_grains_stays_below_a_share_of_that_of_sound():
    def capped(temperature, c=0.5):
        density, sound_speed = NUMBERS.density, NUMBERS.sound_speed
        return capped_temperature(temperature, c, density, sound_speed, GRAINS)

    most = capped(1e9)
    # K sqrt(3 T) = 0.1 rho0 c: at the cap a fluctuation pushes a tenth as hard as sound does
    pushed = granular_pressure(0.5, 1.0, GRAINS)
    assert pushed * np.sqrt(3.0 * most) == pytest.approx(0.1 * 1000.0 * 20.0, rel=1e-13)
    assert capped(1.001 * most) == most
    assert capped(0.999 * most) == 0.999 * most
    assert capped(1e9, c=0.4) > most
    # an incompressible fluid has no cap
    assert capped_temperature(1e9, 0.5, 1000.0, np.inf, GRAINS) == 1e9


@pytest.mark.parametrize("is_algebraic", [True, False])
def test_the_study_and_the_algebraic_law_stir_a_shear(is_algebraic):
    (position, velocity), temperature = sheared(0.5), np.empty(9**3)
    near, everywhere = two_lists(position, NO_WALLS, LATTICE), np.ones(9**3)
    grains = GRAINS._replace(diameter=0.01)
    if is_algebraic:
        gradient, rate = np.empty((9**3, 9), np.float32), np.empty(9**3)
        velocity_gradients(velocity, near, NO_WALLS, gradient, rate)
        np.testing.assert_allclose(rate, 0.5, rtol=1e-12)
        expected = np.zeros(9)
        expected[2] = 0.5
        np.testing.assert_allclose(gradient, np.tile(expected, (9**3, 1)), atol=1e-12)
        algebraic_temperatures(rate, everywhere, grains, temperature)
    else:
        c = np.full(9**3, 0.1)
        numbers = NUMBERS.density, NUMBERS.sound_speed
        neighborhood_temperatures(velocity, everywhere, c, *numbers, grains, near, temperature)
    expected = algebraic_temperature(0.5, grains) if is_algebraic else variance(position, velocity)
    # at the surface too the shear of a linear profile is exact
    rows = slice(None) if is_algebraic else MIDDLE
    np.testing.assert_allclose(temperature[rows], expected, rtol=1e-12)


def collided_grains(c, temperature, n, grains=GRAINS, viscosity=20.0):
    """Return pressure, Pa, and viscosity, Pa s, on top of another, for densities over n0."""
    n0 = LATTICE.number_density
    n = np.asarray(n, dtype=float) * n0
    pressure, total = np.empty(n.size), np.full(n.size, viscosity)
    c, temperatures = np.full(n.size, c), np.full(n.size, temperature)
    collide_grains(c, grains, n0, n, temperatures, pressure, total)
    return pressure, total


def test_colliding_grains_have_the_stress_of_equation_10():
    c = 0.55 / 8  # g0 = 2
    pressure, viscosity = collided_grains(c, 0.09, [1.0])
    assert pressure[0] == pytest.approx(2.0 * 2650.0 * c**2 * 2.0 * 1.7 * 0.09, rel=1e-13)
    collisions = 0.8 * c**2 * 0.3 * 2650.0 * 2.0 * 1.7 * 0.3 / np.sqrt(np.pi)
    assert viscosity[0] == pytest.approx(20.0 + collisions, rel=1e-13)


def test_the_pressure_of_grains_fades_towards_a_free_surface_and_their_viscosity_does_not():
    pressure, viscosity = collided_grains(0.4, 0.1, [1.2, 1.0, 0.95, 0.9, 0.8, 0.5])
    np.testing.assert_allclose(pressure / pressure[0], [1.0, 1.0, 0.75, 0.5, 0.0, 0.0], atol=1e-13)
    assert np.ptp(viscosity) == 0.0


@pytest.mark.parametrize("restitution", [0.0, 0.7, 0.95])
def test_plane_shear_has_the_stress_ratio_of_kinetic_theory(restitution):
    grains = GRAINS._replace(restitution=restitution)
    for c, rate in ((0.1, 3.0), (0.5, 200.0)):
        temperature = algebraic_temperature(rate, grains)
        pressure, viscosity = collided_grains(c, temperature, [1.0], grains, viscosity=0.0)
        ratio = viscosity[0] * rate / pressure[0]
        assert ratio == pytest.approx(0.4 * np.sqrt(15 * (1 - restitution) / np.pi), rel=1e-13)


def test_each_particle_collides_at_its_own_concentration_and_temperature():
    c, temperature, n0 = np.array([0.1, 0.4]), np.array([0.2, 0.05]), LATTICE.number_density
    pressure, viscosity = np.empty(2), np.zeros(2)
    full = np.full(2, n0)
    collide_grains(c, GRAINS, n0, full, temperature, pressure, viscosity)
    for i in range(2):
        alike = collided_grains(c[i], temperature[i], [1.0, 1.0], viscosity=0.0)
        # the last digit depends on the place in a vector of the processor
        assert pressure[i] == pytest.approx(alike[0][i], rel=1e-14)
        assert viscosity[i] == pytest.approx(alike[1][i], rel=1e-14)


def after_collision(position, velocity, restitution, density=None):
    """Return the velocities of particles after their collisions alone."""
    position = np.array(position)
    fluid = fluid_of(len(position), velocity=np.array(velocity), density=density)
    near = two_lists(position, NO_WALLS, LATTICE)
    numbers = NUMBERS._replace(restitution=restitution)
    hits = [
        compressible.acceleration_at(i, fluid, near, NO_WALLS, numbers)[3:6]
        for i in range(len(position))
    ]
    return fluid.velocity + hits


@pytest.mark.parametrize("density", [None, (1000.0, 1000.0), (1000.0, 250.0)])
@pytest.mark.parametrize("restitution", [0.0, 0.2, 1.0])
def test_two_particles_part_with_their_restitution(restitution, density):
    density = None if density is None else np.array(density)
    mass = np.ones((2, 1)) if density is None else density[:, None] / 1000.0
    position = np.array([[0.0, 0.0, 0.0], [0.2, 0.3, 0.6]])  # 0.7 apart
    velocity = np.array([[1.0, 2.0, -1.0], [-1.0, 0.5, -2.0]])
    after = after_collision(position, velocity, restitution, density)
    normal = position[1] / 0.7
    approach = (velocity[0] - velocity[1]) @ normal
    assert approach > 0.0
    assert (after[1] - after[0]) @ normal == pytest.approx(restitution * approach, abs=1e-14)
    np.testing.assert_allclose(
        (mass * after).sum(axis=0), (mass * velocity).sum(axis=0), atol=1e-15
    )
    change = after - velocity
    np.testing.assert_allclose(np.cross(change, normal), 0.0, atol=1e-15)
    # those that part, or are farther than the distance, do not collide
    for free in ((position, -velocity), (1.15 * position, velocity)):
        assert np.array_equal(after_collision(*free, restitution, density), free[1])


def bounce(position, velocity, solid):
    """Return a velocity after the bounce off the walls, from a place."""
    near = two_lists(np.array([position], dtype=float), solid, LATTICE)
    return bounce_at(0, *velocity, DISTANCE, RESTITUTION, near, solid)


def bounced(height, velocity, normal=(0.0, 0.0, 1.0), aside=(0.0, 0.0), layers=1.0):
    """Return a velocity after the bounce off one wall particle, from a height over its face."""
    solid = solid_of(np.array([[0.0, 0.0, -0.5]]), normal, 0.5, layers=layers)
    return bounce((*aside, height), velocity, solid)


def test_a_wall_throws_back_what_comes_near_and_lets_it_slide():
    np.testing.assert_allclose(bounced(0.29, [1.0, 3.0, -2.0]), [1.0, 3.0, 0.4], rtol=1e-14)
    np.testing.assert_allclose(bounced(-0.2, [1.0, 3.0, -2.0]), [1.0, 3.0, 0.4], rtol=1e-14)
    for free in (
        bounced(0.31, [1.0, 3.0, -2.0]),  # out of reach
        bounced(0.2, [1.0, 3.0, -2.0], aside=(0.51, 0.0)),  # over the next wall particle
        bounced(0.2, [1.0, 3.0, -2.0], layers=2.0),
    ):
        assert free == (1.0, 3.0, -2.0)
    assert bounced(0.1, [1.0, 3.0, 2.0]) == (1.0, 3.0, 2.0)  # receding


@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.45, -0.4)])
def test_a_floor_of_many_particles_throws_back_once_everywhere(aside):
    floor = lattice_block(3, (7, 7, 3)) - [3.5, 3.5, 3.0]
    solid = solid_of(floor, depth=-floor[:, 2], layers=0.5 - floor[:, 2])
    found = bounce((*aside, 0.2), (1.0, 3.0, -2.0), solid)
    np.testing.assert_allclose(found, [1.0, 3.0, 0.4], rtol=1e-14)


@pytest.mark.parametrize("diagonal", [(1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 0.0, 1.0)])
def test_at_the_edge_or_corner_of_a_box_the_face_that_looks_at_the_particle_counts(diagonal):
    normal = np.array(diagonal) / np.linalg.norm(diagonal)
    for axis in np.flatnonzero(normal):
        outward = np.zeros(3)
        outward[axis] = np.sign(normal[axis])
        velocity = np.array([0.3, -0.2, 0.1]) - 2.0 * outward
        found = bounce(0.75 * outward, velocity, solid_of(np.zeros((1, 3)), normal, 0.5))
        approach = -velocity @ outward
        np.testing.assert_allclose(found, velocity + 1.2 * approach * outward, rtol=1e-14)


@pytest.mark.parametrize("depth", [0.1, 0.6, 1.2])
def test_the_face_of_a_mesh_is_the_plane_at_its_depth(depth):
    normal = np.array([0.6, 0.0, 0.8])
    solid = solid_of(np.zeros((1, 3)), normal, depth, on_mesh=True)

    def found(height, aside, velocity):
        place = (depth + height) * normal + [-0.8 * aside, 0.0, 0.6 * aside]
        return bounce(place, velocity, solid)

    velocity = -2.0 * normal + [0.8, 1.0, -0.6]  # the rest is along the plane
    for aside in (0.0, -0.9, 0.9):
        after = found(REACH - 0.01, aside, velocity)
        np.testing.assert_allclose(after, velocity + 1.2 * 2.0 * normal, rtol=1e-14)
    for free in (found(REACH + 0.01, 0.0, velocity), found(0.1, 1.01, velocity)):
        np.testing.assert_array_equal(free, velocity)


@pytest.mark.parametrize("distance", [0.8, 1.0])
def test_whatever_bounces_has_been_found_in_contact(rng, distance):
    # a step looks for bounces of those only whose sum of forces has met a wall that near
    box = {"type": "box", "name": "box", "x": [0.3, 0.5], "y": [0.2, 0.4], "z": [0.0, 0.3]}
    numbers = {"sound_speed": 20.0, "collision_distance": distance}
    scheme, state = started(tank3d_case(obstacle=[box], scheme=numbers))
    solid, lattice = scheme.observe(state).solid, scheme.lattice
    numbers = numbers_of(lattice, collision_distance=distance * lattice.spacing)
    anywhere = rng.uniform(-0.02, [0.82, 0.62, 0.4], (4000, 3))
    at_a_corner = rng.uniform([0.25, 0.15, 0.25], [0.35, 0.25, 0.35], (1000, 3))
    position = np.concatenate([anywhere, at_a_corner])
    fluid, near, bounces = fluid_of(len(position)), two_lists(position, solid, lattice), 0
    reach = numbers.collision_distance, numbers.restitution
    for i in range(len(position)):
        *_, contacts = compressible.acceleration_at(i, fluid, near, solid, numbers)
        assert contacts == touches_wall_at(i, near, solid)
        for velocity in np.concatenate([np.eye(3), -np.eye(3)]):
            after = bounce_at(i, *velocity, *reach, near, solid)
            if not np.array_equal(after, velocity):
                bounces += 1
                assert contacts > 0.0, position[i]
    assert bounces > 500


def test_particles_at_one_place_have_no_direction_and_no_end(rng):
    position = random_patch(3, 100, rng, length=4.0)
    position[40] = position[3]
    fluid = fluid_of(
        100,
        velocity=rng.normal(size=(100, 3)),
        compression=rng.uniform(0.0, 0.02, 100),
        pressure=rng.uniform(0.0, 1e3, 100),
        viscosity=np.full(100, 1e-3),
    )
    solid = solid_of(np.concatenate([position[7:8], position[20:25] + 0.1]), depth=0.5)
    near = two_lists(position, solid, LATTICE)
    for i in (3, 7, 40):
        for function in (compressible.density_rate_at, compressible.acceleration_at):
            assert np.all(np.isfinite(function(i, fluid, near, solid, NUMBERS)))
        assert np.all(np.isfinite(velocity_gradient_at(i, fluid.velocity, near, solid)))
    hits = compressible.acceleration_at(3, fluid, near, solid, NUMBERS)[3:6]
    assert np.linalg.norm(hits) < 100.0  # they are not thrown apart


@pytest.mark.parametrize(
    ("aside", "depth", "is_inside"),
    [(0.49, 1.5, True), (0.51, 1.5, False), (0.0, 0.5, False), (0.0, 2.5, True)],
)
def test_a_particle_is_in_a_wall_where_its_second_layer_stands(aside, depth, is_inside):
    solid = solid_of(np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), depth=depth)
    for axis in range(3):
        position = np.zeros((1, 3))
        position[0, axis] = aside
        near = two_lists(position, solid, LATTICE)
        assert is_inside_wall_at(0, near, solid) == is_inside


@pytest.mark.parametrize("count", [0, 3, 100])
def test_the_survey_finds_the_fastest_and_who_is_outside(rng, count):
    position, velocity = rng.uniform(-1.0, 1.0, (2, count, 3))
    fastest, outside = np.empty(16), np.empty(16, dtype=np.int64)
    lower, upper = np.array([-0.9, -2.0, -2.0]), np.array([2.0, 2.0, 0.9])
    mouth = np.array([0.5, -0.3, 0.6])
    survey_motion(position, velocity, lower, upper, mouth, fastest, outside)
    square = np.sum(velocity**2, axis=1)
    assert fastest.max() == pytest.approx(square.max(initial=0.0), rel=1e-15)
    # a particle in a corner counts for each bound that it passed
    x, y, z = position.T
    beside = (x < 0.5) & ((y < -0.3) | (y > 0.6))
    assert outside.sum() == np.sum(x < -0.9) + np.sum(z > 0.9) + np.sum(beside)
    if count:
        velocity[count // 2, 1] = np.nan
        survey_motion(position, velocity, lower, upper, mouth, fastest, outside)
        assert fastest.max() == np.inf
