"""Images of the fluid behind free-slip walls."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.physics import images
from tests.building import (
    Plane,
    boxes_from,
    felt,
    lattice_block,
    one_list,
    planes,
    random_patch,
    solid_of,
    two_lists,
)
from tests.fast.test_exchange import LATTICE, SPACING, coupled_momentum, flow_of, mirrors_of, weight

R_E = LATTICE.effective_radius
FLAT = reference(2, 3.1, SPACING)


def side(position, slip=1.0, normal=(0.0, 1.0, 0.0)):
    """Return a wall under the plane through the origin with a normal."""
    return planes(position, LATTICE, Plane(normal=normal, slip=slip))


def mirrored(position, surface=side, **known):
    """Return the mirrors of particles beside a wall."""
    position = np.atleast_2d(position).astype(float)
    return mirrors_of(two_lists(position, LATTICE), surface(position, **known))


def standing(position, normal=(0.0, 1.0, 0.0), slip=1.0):
    """Return a wall of particles that stand under the line y = 0 of a plane, and the mirrors."""
    wall = lattice_block(2, (24, 4), SPACING) - [6.0, 4.0 * SPACING, 0.0]
    solid = solid_of(wall, normal, -wall[:, 1], slip)
    near = one_list(np.concatenate([position, wall]), FLAT, len(position))
    return mirrors_of(near, solid), near


def slanted():
    """Return a rotation about the z axis."""
    c, s = np.cos(0.4), np.sin(0.4)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("turn", [np.eye(3), slanted()], ids=["along the axes", "turned"])
def test_an_image_couples_as_a_particle_behind_the_wall_would(turn):
    rng = np.random.default_rng(3)
    position = 1.5 + random_patch(3, 150, rng, 2.0)
    position[:, 1] -= 1.5
    near = two_lists(position @ turn.T, LATTICE)
    mirrors = mirrors_of(near, side(position @ turn.T, normal=turn[:, 1]))
    assert np.count_nonzero(mirrors.height < R_E) > 50
    image = position * [1.0, -1.0, 1.0]
    compared = 0
    for i in range(0, 150, 3):
        for j in range(150):
            r = position[j] - position[i]
            found = images.image_weight(i, j, *r, mirrors, near)
            if max(mirrors.height[[i, j]]) < R_E:
                distance = np.linalg.norm(image[j] - position[i])
                assert found == pytest.approx(weight(distance), rel=1e-9, abs=1e-9)
                compared += found > 0.0
            else:
                assert found == 0.0
    assert compared > 500


def block(position, slip=1.0):
    """Return a wall whose faces end at its edges."""
    return felt(position, LATTICE, boxes_from([0.0, -6.0, 0.0], [6.0, 0.0, 6.0]), [slip])


def test_a_wall_mirrors_what_it_reaches_alone():
    found = mirrored([[3.0, 0.25, 3.0], [3.0, -1.0, 6.25]], block)
    np.testing.assert_allclose(found.height, 0.25, rtol=1e-12)
    np.testing.assert_allclose(found.normal, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-12)
    far = mirrored([[3.0, 1.01 * R_E, 3.0], [-1.01 * R_E, -3.0, 3.0]], block)
    for found in (far, mirrored([3.0, 0.25, 3.0], block, slip=0.0)):
        np.testing.assert_array_equal(found.height, R_E)
        np.testing.assert_array_equal(found.normal, 0.0)


def test_what_stands_beyond_the_end_of_a_wall_has_no_image_in_it():
    found = mirrored([6.0 + 0.6 * SPACING, 0.25, 3.0], block)
    assert found.height[0] == R_E


def test_the_nearest_free_slip_wall_counts():
    position = np.array([[0.3, 0.4, 0.2]])
    walls = [
        Plane(normal=normal, slip=slip) for normal, slip in zip(np.eye(3), (1, 1, 0), strict=True)
    ]
    found = mirrors_of(two_lists(position, LATTICE), planes(position, LATTICE, *walls))
    assert found.height[0] == pytest.approx(0.3, rel=1e-14)
    np.testing.assert_allclose(found.normal[0], [1.0, 0.0, 0.0], atol=1e-14)


@pytest.mark.parametrize("dip", [0.0, 1e-9, 0.2 * SPACING])
def test_a_particle_that_dips_under_the_surface_keeps_its_image(dip):
    found = mirrored([3.0, -dip, 3.0])
    assert found.height[0] == 0.0
    assert found.normal[0, 1] == 1.0


@pytest.mark.parametrize("height", [-0.1, 0.0, 0.3, 1.2])
def test_a_wall_of_particles_mirrors_as_a_surface_does(height):
    found, near = standing(np.array([[0.1, height, 0.0]]))
    assert found.height[0] == pytest.approx(max(height, 0.0), abs=1e-14)
    np.testing.assert_array_equal(found.normal[0], [0.0, 1.0, 0.0])
    for beyond in ([0.1, 1.01 * near.effective_radius, 0.0], [6.0 + 0.6 * SPACING, 0.25, 0.0]):
        found, _ = standing(np.array([beyond]))
        assert found.height[0] == near.effective_radius
    found, _ = standing(np.array([[0.1, 0.3, 0.0]]), slip=0.0)
    assert found.height[0] == near.effective_radius


def test_beside_an_edge_of_wall_particles_the_face_counts():
    diagonal, edge = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0), np.zeros((1, 3))
    for axis in (0, 1):
        position = np.zeros((1, 3))
        position[0, axis] = 1.2 * SPACING
        near = one_list(np.concatenate([position, edge]), FLAT, 1)
        found = mirrors_of(near, solid_of(edge, diagonal, 0.5 * SPACING, 1.0))
        assert found.height[0] == pytest.approx(0.7 * SPACING, rel=1e-12)
        np.testing.assert_array_equal(found.normal[0], np.eye(3)[axis])


@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_layer_along_a_free_slip_wall_resists_as_inside(slip):
    """The stress across planes of a shear along the wall, over that of the whole lattice."""
    position = lattice_block(3, 12, SPACING)
    flow = flow_of(len(position), viscosity=np.full(len(position), 100.0))
    couplings, near = coupled_momentum(position, side(position, slip), flow)
    stress = np.zeros(12)
    for i, count in enumerate(near.fluid_count):
        if np.any(np.abs(position[i] - 3.0)[[0, 2]] > SPACING):
            continue
        j = near.neighbors[i, :count]
        rise = position[j, 2] - position[i, 2]
        # half the sum over i of K (u_j - u_i) (z_j - z_i) with u = z
        stress[int(position[i, 1] / SPACING)] += 0.5 * couplings.value[i, :count] @ rise**2
    over = stress / stress[6]
    np.testing.assert_allclose(over[2:-2], 1.0, rtol=1e-6)
    if slip:
        np.testing.assert_allclose(over[:2], 1.0, rtol=1e-6)
    else:  # the wall, at rest, is not in the sum
        assert over[0] < 0.85
