"""Tests of the shares that the particles of a column have of the drag of a wall."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.wall_shares import GREATEST_SHARE, LEAST_SHARE, share_drag
from tests.building import Plane, frame_of, lattice_block, planes, two_lists

LATTICE = reference(3, 2.4, 1.0)
NORMALS = [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 1.0, 0.0)]
ACROSS, ROWS = 13, 5


def layer(sink=0.0, across=ACROSS, apart=(1.0, 1.0)):
    """Return rows over z = 0, and which particles stand in the column in the middle."""
    places = lattice_block(3, (across, across, ROWS)) - [0.5 * across, 0.5 * across, 0.0]
    column = np.all(np.abs(places[:, :2]) < 0.1, axis=1)
    return places * [apart[0], apart[0], apart[1]] - [0.0, 0.0, sink], column


def shared(places, normal=(0.0, 0.0, 1.0), slip=0.0):
    """Return the share of the only face of all particles, 0 far from it, and its push."""
    places = np.ascontiguousarray(places @ frame_of(normal))
    solid = planes(places, LATTICE, Plane(normal=normal, slip=slip))
    share_drag(two_lists(places, LATTICE), solid)
    there = solid.row >= 0
    share, push = np.zeros((2, len(places)))
    share[there], push[there] = solid.share[solid.row[there], 0], solid.push[solid.row[there], 0]
    return share, push


@pytest.mark.parametrize("normal", NORMALS)
def test_rows_of_the_lattice_bear_their_own_drag(normal):
    places, column = layer()
    share, push = shared(places, normal)
    np.testing.assert_allclose(share[column & (push > 0.0)], 1.0, atol=0.04)


@pytest.mark.parametrize("sink", [0.1, 0.2, -0.2])
@pytest.mark.parametrize("normal", NORMALS)
def test_rows_that_sank_or_rose_bear_the_whole_stress(sink, normal):
    places, column = layer(sink)
    share, push = shared(places, normal)
    whole = LATTICE.number_density / 6.0
    assert np.sum(share[column] * push[column]) == pytest.approx(whole, rel=0.04)
    assert abs(np.sum(push[column]) / whole - 1.0) > 0.05  # which they do not by themselves


def test_a_layer_that_is_drawn_apart_bears_the_whole_stress():
    places, column = layer(0.11, apart=(0.85**-0.5, 0.87))
    share, push = shared(places)
    whole = LATTICE.number_density / 6.0 / 0.85  # on the wall under one column
    assert np.sum(share[column] * push[column]) == pytest.approx(whole, rel=0.04)


def test_at_the_rim_a_column_does_not_bear_the_stress_beside_it():
    places, column = layer()
    half = places[:, 0] > -0.1
    share, push = shared(places[half])
    rim = column[half] & (push > 0.0)
    np.testing.assert_allclose(share[rim], 1.0, atol=0.1)


def test_what_is_alone_bears_no_more_than_twice_its_own():
    share, _ = shared(np.array([[0.0, 0.0, 0.5], [0.3, 0.0, 0.1], [0.0, 0.3, 0.1]]))
    assert np.all((share >= LEAST_SHARE) & (share <= GREATEST_SHARE))


def test_free_slip_walls_have_no_drag_to_share():
    share, push = shared(layer(0.2)[0], slip=1.0)
    np.testing.assert_array_equal(share[push > 0.0], 1.0)
