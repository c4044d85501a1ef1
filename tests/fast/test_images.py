"""Images of the fluid behind free-slip walls."""

import numpy as np
import pytest

from debrisflow.physics import images
from tests.building import lattice_block, random_patch, solid_of, two_lists
from tests.fast.test_exchange import LATTICE, SPACING, coupled_momentum, flow_of, mirrors_of, weight

R_E = LATTICE.effective_radius


def side(slip=1.0, turn=None):
    """Return the wall under y = 0, 12 cells long and high, or turned about the origin."""
    wall = lattice_block(3, (12, 4, 12), SPACING)
    wall[:, 1] -= 4.0 * SPACING
    depth, turn = -wall[:, 1], np.eye(3) if turn is None else turn
    return solid_of(
        wall @ turn.T, turn[:, 1], depth, slip, on_mesh=not np.allclose(turn, np.eye(3))
    )


def mirrored(position, solid):
    """Return the mirrors of particles."""
    return mirrors_of(two_lists(np.atleast_2d(position).astype(float), solid, LATTICE), solid)


def slanted():
    """Return a rotation about the z axis."""
    c, s = np.cos(0.4), np.sin(0.4)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("turn", [np.eye(3), slanted()], ids=["along the axes", "of a mesh"])
def test_an_image_couples_as_a_particle_behind_the_wall_would(turn):
    rng = np.random.default_rng(3)
    position = 1.5 + random_patch(3, 150, rng, 2.0)
    position[:, 1] -= 1.5
    wall = side(turn=turn)
    near = two_lists(position @ turn.T, wall, LATTICE)
    mirrors = mirrors_of(near, wall)
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


def test_a_wall_mirrors_what_stands_over_it_alone():
    middle, out = 3.0, 6.0 + 0.6 * SPACING
    for x, is_over in ((middle, True), (out, False)):
        found = mirrored([x, 0.25, middle], side())
        assert (found.height[0] < R_E) == is_over
        assert found.normal[0, 1] == float(is_over)
    no_slip = mirrored([middle, 0.25, middle], side(slip=0.0))
    assert no_slip.height[0] == R_E
    np.testing.assert_array_equal(no_slip.normal, 0.0)


@pytest.mark.parametrize("dip", [0.0, 1e-9, 0.2 * SPACING])
def test_a_particle_that_dips_under_the_surface_keeps_its_image(dip):
    found = mirrored([3.0, -dip, 3.0], side())
    assert found.height[0] == 0.0
    assert found.normal[0, 1] == 1.0


def test_beside_an_edge_the_face_counts():
    diagonal = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    edge = solid_of(np.zeros((1, 3)), diagonal, 0.5 * SPACING, 1.0)
    for axis in (0, 2):
        position = np.zeros(3)
        position[axis] = 1.2 * SPACING
        found = mirrored(position, edge)
        assert found.height[0] == pytest.approx(0.7 * SPACING, rel=1e-12)
        np.testing.assert_array_equal(found.normal[0], np.eye(3)[axis])


@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_layer_along_a_free_slip_wall_resists_as_inside(slip):
    """The stress across planes of a shear along the wall, over that of the whole lattice."""
    position = lattice_block(3, 12, SPACING)
    flow = flow_of(len(position), viscosity=np.full(len(position), 100.0))
    couplings, near = coupled_momentum(position, side(slip), flow)
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
