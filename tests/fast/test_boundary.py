"""What walls as surfaces do to a fluid."""

import numpy as np
import pytest

from debrisflow.neighbors.boundary import (
    wall_sums_at,
)
from debrisflow.neighbors.lattice import reference
from debrisflow.physics import compressible
from debrisflow.physics.operators import velocity_gradient_at
from tests.building import (
    Plane,
    acceleration_at,
    fluid_of,
    frame_of,
    lattice_block,
    no_walls,
    numbers_of,
    planes,
    random_patch,
    two_lists,
)

RADIUS = 2.4
LATTICE = reference(3, RADIUS, 1.0)
NORMALS = [(0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (-0.48, 0.6, 0.64)]
ROUNDING = 1e-12


@pytest.fixture
def rng():
    return np.random.default_rng(61)


def turn_of(rng):
    """Return a rotation anywhere."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def accelerations(position, solid, fluid, **changes):
    """Return acceleration and change of velocity by collisions of each particle, (n, 6) array."""
    near, numbers = two_lists(position, LATTICE), numbers_of(LATTICE, **changes)
    return np.array([acceleration_at(i, fluid, near, solid, numbers) for i in range(len(position))])


def corner_of(position, slip=1.0):
    """Return what particles feel of three walls, not at right angles."""
    walls = [
        Plane((0.0, 0.0, 0.0), (0.36, -0.48, 0.8), slip),
        Plane((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), slip),
        Plane((0.0, 5.0, 0.0), (0.0, -0.8, 0.6), slip),
    ]
    return planes(position, LATTICE, *walls)


@pytest.mark.parametrize("apart", [True, False])
def test_what_walls_take_from_motion_is_stored_by_compression(rng, apart):
    # with the same pressure everywhere the walls have it too; alone, there are walls and no fluid
    position = random_patch(3, 300, rng, 6.0)
    solid = corner_of(position)
    s, still = 0.02, {"gravity": np.zeros(3), "artificial_viscosity": 0.0, "diffusion": 0.0}
    near, numbers = two_lists(position, LATTICE), numbers_of(LATTICE, **still)
    if apart:
        near.fluid_count[:] = 0
    pressure = np.full(300, numbers.density * numbers.sound_speed**2 * s)
    fluid = fluid_of(300, velocity=rng.normal(size=(300, 3)), pressure=pressure)
    fluid = fluid._replace(compression=np.full(300, s))
    taken, stored = np.empty((2, 300))
    for i in range(300):
        given = acceleration_at(i, fluid, near, solid, numbers)[:3]
        _, _, rate, _ = compressible.density_rate_at(i, fluid, near, solid, numbers)
        taken[i] = np.dot(given, fluid.velocity[i])
        stored[i] = numbers.sound_speed**2 * s / (1.0 + s) * rate
    assert np.count_nonzero(solid.faces > 1) > 20
    assert np.abs(stored).max() > 10.0
    if apart:  # each by itself
        np.testing.assert_allclose(taken, -stored, atol=ROUNDING * np.abs(stored).max())
    else:
        assert abs(taken.sum() + stored.sum()) < ROUNDING * np.abs(stored).sum()


@pytest.mark.parametrize("normal", [(0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (-0.48, 0.6, -0.64)])
@pytest.mark.parametrize("pressure", [0.0, 800.0])
def test_a_ceiling_does_not_pull(rng, normal, pressure):
    normal, gravity = np.array(normal), np.array([0.0, 0.0, -9.81])
    for height in (-0.2, 0.1, 0.5, 1.0, 2.0):
        position = height * normal[None]
        solid = planes(position, LATTICE, Plane(normal=normal))
        fluid = fluid_of(1, pressure=np.full(1, pressure))
        (found,) = accelerations(position, solid, fluid, gravity=gravity)
        push = -np.array(wall_sums_at(0, solid)[2:5])
        least = 3.0 / LATTICE.number_density * pressure / 1000.0 * push @ normal
        # no less than its own pressure alone does
        assert (found[:3] - gravity) @ normal >= least - ROUNDING * 9.81
        if pressure == 0.0 and normal[2] == -1.0:
            np.testing.assert_allclose(found, [*gravity, *(0.0,) * 9], atol=1e-12)


def standing_on(normal, rows=10):
    """Return a block of lattice on a plane through the origin, and its heights over the plane."""
    turn = frame_of(normal)
    block = lattice_block(3, (9, 9, rows)) - [4.5, 4.5, 0.0]
    return block @ turn, block[:, 2], np.all(np.abs(block[:, :2]) < 0.1, axis=1)


@pytest.mark.parametrize("normal", NORMALS)
def test_fluid_at_rest_on_a_plane_stays_nearly_at_rest(normal):
    # on the two rows over it a wall pushes 0.6 % less and 2.2 % more than its lattice would
    position, height, inner = standing_on(normal)
    solid, gravity = planes(position, LATTICE, Plane(normal=normal)), -9.81 * np.array(normal)
    pressure = 1000.0 * 9.81 * (10.0 - height)
    still = fluid_of(len(position), pressure=pressure)
    found = accelerations(position, solid, still, gravity=gravity)[inner, :3]
    lift, height = found @ normal, height[inner]
    deep = height < 7.0  # the free surface is out of reach
    share = lift[deep] / (pressure[inner][deep] / 1000.0)  # 1 spacing = 1 m
    np.testing.assert_array_less(np.abs(share), np.where(height[deep] < 2.0, 0.025, 1e-12))
    np.testing.assert_allclose(found - np.outer(lift, normal), 0.0, atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_layer_on_a_slope_keeps_all_of_the_gravity_along_it(normal, slip, rng):
    position, height, inner = standing_on(normal)
    normal = np.array(normal)
    along = np.cross(normal, rng.normal(size=3))
    solid = planes(position, LATTICE, Plane(normal=normal, slip=slip))
    pressure = 1000.0 * 9.0 * (10.0 - height)
    still = fluid_of(len(position), pressure=pressure)
    found = accelerations(position, solid, still, gravity=along - 9.0 * normal)
    across = found[inner, :3] @ normal
    lowest = height[inner] < 7.0
    assert np.count_nonzero(lowest) == 7
    np.testing.assert_allclose(
        (found[inner, :3] - across[:, None] * normal)[lowest], np.tile(along, (7, 1)), atol=1e-9
    )


def over_plane(rng, normal, least=0.26, count=600):
    """Return particles anywhere over a plane, none nearer to it than a fourth of a spacing."""
    anywhere = rng.uniform(-3.0, 3.0, (count, 3))
    return anywhere[anywhere @ normal > least]


def shear(position, velocity, solid):
    """Return the velocity gradients of all particles, (n, 3, 3) array."""
    near = two_lists(position, LATTICE)
    return np.array(
        [velocity_gradient_at(i, velocity, near, solid) for i in range(len(position))]
    ).reshape(-1, 3, 3)


@pytest.mark.parametrize("normal", NORMALS)
def test_a_linear_profile_over_a_no_slip_wall_is_exact(normal, rng):
    normal = np.array(normal)
    position = over_plane(rng, normal)
    gradient = np.outer(rng.normal(size=3), normal)
    found = shear(position, position @ gradient.T, planes(position, LATTICE, Plane(normal=normal)))
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
def test_a_linear_profile_along_a_free_slip_wall_is_exact(normal, rng):
    # the velocity along the wall varies along it, that across it with the height
    normal = np.array(normal)
    position = over_plane(rng, normal)
    along = np.eye(3) - np.outer(normal, normal)
    gradient = along @ rng.normal(size=(3, 3)) @ along + rng.normal() * np.outer(normal, normal)
    velocity = position @ gradient.T + along @ rng.normal(size=3)
    solid = planes(position, LATTICE, Plane(normal=normal, slip=1.0))
    found = shear(position, velocity, solid)
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


def test_the_shear_over_a_floor_is_exact_beside_a_free_slip_side(rng):
    turn = turn_of(rng)
    anywhere = rng.uniform(0.0, 3.0, (900, 3))
    upright = anywhere[np.all(anywhere[:, 1:] > 0.26, axis=1)]
    position, gradient = upright @ turn, 7.0 * np.outer(turn[0], turn[2])
    walls = Plane(normal=turn[2]), Plane(normal=turn[1], slip=1.0)
    found = shear(position, position @ gradient.T, planes(position, LATTICE, *walls))
    assert np.count_nonzero((upright[:, 1:] < 1.0).all(axis=1)) > 20
    np.testing.assert_allclose(found, np.tile(gradient, (len(found), 1, 1)), atol=1e-9)


@pytest.mark.parametrize("normal", NORMALS)
def test_walls_hold_what_sticks_to_them_and_nothing_else(normal):
    position, height, inner = standing_on(normal)
    rows = [int(np.flatnonzero(inner & (height == row + 0.5))[0]) for row in range(5)]
    along, viscosity = np.cross(normal, [0.3, -1.0, 0.5]), np.full(len(position), 300.0)
    calm = {"gravity": np.zeros(3), "artificial_viscosity": 0.0}

    def dragged(velocity, slip):
        solid = planes(position, LATTICE, Plane(normal=normal, slip=slip))
        fluid = fluid_of(len(position), velocity=velocity, viscosity=viscosity)
        found = accelerations(position, solid, fluid, **calm)[rows, :3]
        np.testing.assert_allclose(np.cross(found, along), 0.0, atol=1e-10)
        return found @ along / (along @ along)

    sliding = np.tile(along, (len(position), 1))
    np.testing.assert_allclose(dragged(sliding, 1.0), 0.0, atol=1e-10)
    whole = dragged(sliding, 0.0)
    assert np.all(whole[:2] < 0.0)
    np.testing.assert_allclose(whole[3:], 0.0, atol=1e-10)  # out of reach
    # of a straight profile down to the surface 5 % of the drag on the first row are left over
    rest = dragged(height[:, None] * along, 0.0)
    np.testing.assert_allclose(rest, 0.0, atol=0.05 * 0.5 * abs(whole[0]))


def test_what_is_far_from_all_walls_feels_none(rng):
    position = random_patch(3, 50, rng, 4.0) + 3.0
    velocity = rng.normal(size=(50, 3))
    fluid = fluid_of(50, velocity=velocity, pressure=rng.uniform(0.0, 1e3, 50))
    far = planes(position, LATTICE, Plane())
    assert not wall_sums_at(0, far)[0]
    found = accelerations(position, far, fluid)
    np.testing.assert_array_equal(found, accelerations(position, no_walls(50), fluid))
