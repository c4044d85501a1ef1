"""Grains and contacts: agitation and stress of grains, collisions of particles, bounces."""

import numpy as np
import pytest

from debrisflow.neighbors.boundary import find_inside, rebounded
from debrisflow.neighbors.lattice import reference
from debrisflow.physics import compressible
from debrisflow.physics.collision_stress import collide_grains
from debrisflow.physics.contact import collisions_at
from debrisflow.physics.granular_temperature import (
    algebraic_temperatures,
    capped_temperature,
    neighborhood_temperature_at,
    neighborhood_temperatures,
)
from debrisflow.physics.kinetic_theory import Grains, algebraic_temperature, granular_pressure
from debrisflow.physics.motion import survey_motion
from debrisflow.physics.operators import velocity_gradient_at, velocity_gradients
from debrisflow.schemes.surfaces import walls_of
from debrisflow.validation.marching import advance
from tests.building import (
    acceleration_at,
    boxes_from,
    felt,
    fluid_of,
    frame_of,
    lattice_block,
    no_walls,
    numbers_of,
    random_patch,
    started,
    tank3d_case,
    tank_case,
    two_lists,
)

LATTICE = reference(3, 2.4, 1.0)
NUMBERS = numbers_of(LATTICE)
GRAINS = Grains(
    density=2650.0, diameter=0.3, restitution=0.7, packing_limit=0.55, largest_concentration=0.5
)
NO_WALLS = no_walls(9**3)
MIDDLE = 9**3 // 2
REACH = 0.3  # distance to a face below which a particle bounces


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
    near = two_lists(position, LATTICE)
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
    near, everywhere = two_lists(position, LATTICE), np.ones(9**3)
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


def after_collision(position, velocity, restitution, density):
    """Return the velocities of particles after their collisions alone."""
    near, distance = two_lists(position, LATTICE), 0.8
    hits = [collisions_at(i, velocity, density, distance, near) for i in range(len(position))]
    return velocity + (1.0 + restitution) * np.array(hits)


@pytest.mark.parametrize("density", [(1000.0, 1000.0), (1000.0, 250.0)])
@pytest.mark.parametrize("restitution", [0.0, 0.2, 1.0])
def test_two_particles_part_with_their_restitution(restitution, density):
    density = np.array(density)
    mass = density[:, None] / 1000.0
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


def bounced(place, velocity, boxes, restitution=0.2):
    """Return a velocity after the bounce off the boxes of wall, from a place."""
    solid = felt(np.array([place], dtype=float), LATTICE, boxes, np.zeros(len(boxes.origin)))
    return rebounded(0, *velocity, REACH, restitution, solid)


def floor(normal=(0.0, 0.0, 1.0)):
    """Return the half space under a plane through the origin."""
    return boxes_from([-np.inf] * 3, [np.inf, np.inf, 0.0], axes=[frame_of(normal)])


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.6, 0.48, 0.64)])
def test_a_wall_throws_back_what_comes_near_and_lets_it_slide(normal):
    normal = np.array(normal)
    along = np.cross(normal, [0.3, 1.0, -2.0])
    for height in (0.29, -0.2):
        for restitution in (0.0, 0.2, 1.0):
            found = bounced(height * normal, along - 2.0 * normal, floor(normal), restitution)
            np.testing.assert_allclose(found, along + 2.0 * restitution * normal, atol=1e-14)
    # out of reach, and on its way out
    for height, velocity in ((0.31, along - 2.0 * normal), (0.1, along + 2.0 * normal)):
        found = bounced(height * normal, velocity, floor(normal))
        np.testing.assert_array_equal(found, velocity)


@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.5, 0.0), (0.02, -0.01), (-0.45, 0.4)])
def test_a_floor_of_boxes_that_touch_throws_back_once_everywhere(aside):
    x, y = np.mgrid[-3:3, -3:3].reshape(2, -1)
    lower = np.stack([x, y, np.full(36, -np.inf)], axis=1)
    boxes = boxes_from(lower, np.stack([x + 1.0, y + 1.0, np.zeros(36)], axis=1))
    found = bounced((*aside, 0.2), (1.0, 3.0, -2.0), boxes)
    np.testing.assert_allclose(found, [1.0, 3.0, 0.4], rtol=1e-14)


def corner(count):
    """Return what is not in front of the first planes at right angles through the origin."""
    lower, upper = np.full((count, 3), -np.inf), np.full((count, 3), np.inf)
    for k in range(count):
        lower[k, :k], upper[k, k] = 0.0, 0.0
    return boxes_from(lower, upper)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("restitution", [0.0, 0.2, 1.0])
def test_in_a_corner_a_particle_bounces_off_each_face_that_it_meets(count, restitution):
    place, velocity = np.array([0.1, 0.2, 0.15]), np.array([-1.0, -3.0, -2.0])
    expected = np.where(np.arange(3) < count, -restitution * velocity, velocity)
    found = bounced(place, velocity, corner(count), restitution)
    np.testing.assert_allclose(found, expected, atol=1e-14)
    # off the face alone that it comes nearer to
    velocity[0] = 1.0
    expected = np.where(np.arange(3) < count, -restitution * velocity, velocity)
    expected[0] = 1.0
    found = bounced(place, velocity, corner(count), restitution)
    np.testing.assert_allclose(found, expected, atol=1e-14)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("aside", [0.0, 0.3, 0.49])
def test_at_the_edge_of_a_box_the_face_that_looks_at_the_particle_counts(axis, aside):
    box, outward = boxes_from([-0.5] * 3, [0.5] * 3), np.eye(3)[axis]
    place = 0.75 * outward + aside * (1.0 - outward)
    velocity = np.array([0.3, -0.2, 0.1]) - 2.0 * outward
    found = bounced(place, velocity, box)
    expected = velocity - 1.2 * (velocity @ outward) * outward
    np.testing.assert_allclose(found, expected, rtol=1e-14)


@pytest.mark.parametrize("diagonal", [(1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 0.0, 1.0)])
def test_off_an_edge_or_corner_a_particle_bounces_along_the_line_to_it(diagonal):
    toward, box = np.array(diagonal), boxes_from([-0.5] * 3, [0.5] * 3)
    out = toward / np.linalg.norm(toward)
    across = np.cross(out, [1.0, 2.0, 3.0])
    for distance, restitution in ((0.29, 0.2), (0.31, -1.0)):
        place = 0.5 * toward + distance * out
        found = bounced(place, across - 2.0 * out, box)
        np.testing.assert_allclose(found, across + 2.0 * restitution * out, atol=1e-14)


def test_nothing_passes_a_wall_of_a_case_from_any_side(rng):
    box = {"type": "box", "name": "box", "x": [0.3, 0.5], "y": [0.2, 0.4], "z": [0.0, 0.3]}
    case = tank3d_case(obstacle=[box], scheme={"sound_speed": 20.0})
    position = rng.uniform(0.0, [0.8, 0.6, 0.4], (3000, 3))
    surfaces = walls_of(case, 0.0)[0]
    surfaces.build(position, 0.0)
    solid, near, reach = surfaces.survey(position), 0, 0.03
    gap = np.maximum([0.3, 0.2, 0.0] - position, position - [0.5, 0.4, 0.3])
    for i in range(len(position)):
        sides = np.concatenate([position[i], [0.8, 0.6] - position[i, :2]])
        walls = [*np.eye(3), *-np.eye(3)[:2]]
        faces = [wall for side, wall in zip(sides, walls, strict=True) if side < reach]
        outside = np.maximum(gap[i], 0.0)
        if 0.0 < np.linalg.norm(outside) < reach:
            away = outside * np.where(position[i] > [0.4, 0.3, 0.15], 1.0, -1.0)
            faces.append(away / np.linalg.norm(away))
        if gap[i].max() <= 0.0:
            continue
        for normal in faces:
            after = rebounded(i, *(-2.0 * normal), reach, 0.2, solid)
            assert np.dot(after, normal) > 0.0, position[i]
            near += 1
    assert near > 700


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
    (x, _, z), (_, y, _) = position[[7, 3]]  # on faces of a box
    lower = [x, y, -np.inf]
    solid = felt(position, LATTICE, boxes_from(lower, [np.inf, np.inf, z]))
    near = two_lists(position, LATTICE)
    for i in (3, 7, 40):
        assert solid.row[i] >= 0
        for function in (compressible.density_rate_at, acceleration_at):
            assert np.all(np.isfinite(function(i, fluid, near, solid, NUMBERS)))
        assert np.all(np.isfinite(velocity_gradient_at(i, fluid.velocity, near, solid)))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("depth", "is_inside"), [(0.49, False), (0.51, True), (1.4, True)])
def test_a_particle_is_in_a_wall_half_a_spacing_under_its_surface(axis, depth, is_inside):
    box = boxes_from([-1.5] * 3, [1.5] * 3)
    position = np.zeros((3, 3))
    position[:2, axis] = 1.5 - depth, 1.5 + depth  # and one in the middle, 1.5 deep
    inside = np.zeros(3, dtype=bool)
    find_inside(1.0, felt(position, LATTICE, box), inside)
    np.testing.assert_array_equal(inside, [is_inside, False, True])


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


@pytest.mark.parametrize(("dimension", "touch"), [(2, REACH), (3, 0.0)])
@pytest.mark.parametrize("shift", [-0.55, -0.25, -0.15, 0.0])
def test_what_is_too_near_to_a_wall_and_approaches_it_is_counted(dimension, touch, shift):
    case = tank_case(6, 4, "water", tank=(6, 12)) if dimension == 2 else tank3d_case()
    scheme, state = started(case)
    p, up, d0 = state.particles, dimension - 1, case.particles.spacing
    lowest = p.position[p.fluid, up] < d0
    p.position[p.fluid, up] = np.where(lowest, (0.5 + shift) * d0, p.position[p.fluid, up])
    p.velocity[p.fluid, up] = -1.0
    scheme.step(state, 1e-6)
    assert state.particle_steps == p.fluid_count
    assert state.bounces == (np.count_nonzero(lowest) if 0.5 + shift < touch else 0)


def test_a_floor_does_not_throw_back_what_falls_on_it_alone():
    box = {"x": (0.4, 0.5), "y": (0.3, 0.4), "z": (0.6, 0.7)}
    case = tank3d_case(
        fill=[{"type": "block", "material": "water"} | box],
        scheme={"type": "explicit", "sound_speed": 30.0, "jitter": 0.0},
    )
    scheme, state = started(case)
    advance(scheme, state, until=0.4)  # it falls for a third of a second
    heights = []
    while state.time < 1.0:
        advance(scheme, state, steps=1)
        heights.append(float(state.particles.position[0, 2]))
    assert 0.02 < min(heights) < max(heights) < 0.2
