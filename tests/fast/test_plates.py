"""Thin boxes, boxes that touch, and lists of boxes that last while particles move."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import Neighbors
from debrisflow.neighbors.near_boxes import cut_pairs, near_boxes
from debrisflow.neighbors.pairs import repeats_of
from debrisflow.schemes.surfaces import boxes_of, walls_of
from debrisflow.space.domain import domain
from tests.building import NOWHERE, boxes_from, felt, random_patch, tank3d_case

D0 = 0.1
LATTICE = reference(3, 2.4, D0)


@pytest.fixture
def rng():
    return np.random.default_rng(17)


def box(name, x, y, z):
    return {"type": "box", "name": name, "x": x, "y": y, "z": z}


def around(case, position):
    """Return what particles feel of the walls of a case."""
    surfaces = walls_of(case, 0.6)[0]
    surfaces.build(position, 0.0)
    return surfaces.survey(position)


def sums_of(solid):
    """Return the sums of all particles, 0 of those far from walls."""
    found = np.zeros((solid.row.size, solid.sums.shape[1]))
    found[solid.row >= 0] = solid.sums[solid.row[solid.row >= 0]]
    return found


def passes(a, b, lower, upper):
    """Return whether the way from a to b passes through a box, by small steps."""
    steps = a + np.linspace(0.0, 1.0, 2001)[:, None] * (b - a)
    return bool(np.any(np.all((steps > lower) & (steps < upper), axis=1)))


@pytest.mark.parametrize("period", [NOWHERE, np.array([0.0, 1.0, 0.0])])
def test_only_pairs_between_which_a_thin_box_stands_are_cut(rng, period):
    lower, upper = np.array([0.45, -np.inf, -np.inf]), np.array([0.55, np.inf, 0.6])
    thin = np.array([[True, False, False]])
    plate = boxes_from(lower, upper, is_thin=thin)
    position = random_patch(3, 400, rng, 1.0)
    position = position[(position[:, 0] < 0.45) | (position[:, 0] > 0.55) | (position[:, 2] > 0.6)]
    lists = Neighbors(0.24, D0, period, skin=0.0)
    lists.build(position, len(position))
    listed = [set(lists.index[i, : lists.count[i]]) for i in range(len(position))]
    row = np.arange(len(position), dtype=np.int32)
    cut_pairs(position, row, repeats_of(period), plate, lists.index, lists.count)
    cut = 0
    for i, before in enumerate(listed):
        after = set(lists.index[i, : lists.count[i]])
        for j in before:
            b = position[j] - position[i]
            b -= period * np.rint(b / np.where(period > 0.0, period, np.inf))
            assert (j in after) != passes(position[i], position[i] + b, lower, upper)
            cut += j not in after
    assert cut > 50


@pytest.mark.parametrize("thickness", [0.5, 1.0])
def test_a_plate_is_felt_as_a_thick_wall_before_and_just_inside_it(thickness):
    end = thickness * D0
    thin = boxes_from([0.0, -9.0, -9.0], [end, 9.0, 9.0], is_thin=[[True, False, False]])
    thick = boxes_from([0.0, -9.0, -9.0], [9.0, 9.0, 9.0])
    places = np.array([[-x * D0, 0.0, 0.0] for x in (0.3, 0.5, 1.5, 0.01, -0.05)])
    plate, wall = felt(places, LATTICE, thin), felt(places, LATTICE, thick)
    np.testing.assert_allclose(plate.sums, wall.sums, atol=1e-12)
    np.testing.assert_allclose(plate.distance, wall.distance, atol=1e-12)


def test_a_step_one_spacing_high_is_felt_as_the_floor_is():
    size = {"size": (2.0, 2.0, 1.0)}
    step = tank3d_case(obstacle=[box("step", [0.5, 1.5], [0.5, 1.5], [0.0, 0.1])], **size)
    over = np.array([[1.0, 1.0, 0.1 + h * D0] for h in (0.3, 0.5, 1.0, 1.5)])
    found, plain = around(step, over), around(tank3d_case(**size), over - [0.0, 0.0, 0.1])
    # by a table, which is right to 0.3 %, and in closed form
    np.testing.assert_allclose(sums_of(found), sums_of(plain), rtol=0.005, atol=0.02)
    np.testing.assert_array_equal(found.faces, 1)  # not the floor behind it too
    np.testing.assert_allclose(found.distance[:, 0], plain.distance[:, 0], atol=1e-12)


def test_what_feels_a_wall_and_is_in_none_has_a_face(rng):
    # a dam of which blocks leave a bay free, and a floor on which other blocks stand
    blocks = [
        box("dam", [1.0, 1.5], [0.0, 4.0], [0.0, 0.8]),
        box("one", [0.5, 1.0], [0.0, 1.3], [0.0, 0.8]),
        box("other", [0.5, 1.0], [1.9, 4.0], [0.0, 0.8]),
    ]
    case = tank3d_case(size=(2.0, 4.0, 1.0), obstacle=blocks)
    position = rng.uniform((0.5, 1.3, 0.0), (1.0, 1.9, 1.0), (3000, 3))
    position = np.concatenate([position, rng.uniform((0, 0, 0), (2, 4, 1), (3000, 3))])
    boxes = boxes_of(case)
    inside = np.zeros(len(position), dtype=bool)
    for b in range(len(boxes.origin)):
        place = position - boxes.origin[b]
        inside |= np.all((place > boxes.lower[b]) & (place < boxes.upper[b]), axis=1)
    position = position[~inside]
    solid = around(case, position)
    push = np.linalg.norm(sums_of(solid)[:, 2:5], axis=1) * D0
    faces = np.zeros(len(position), dtype=int)
    faces[solid.row >= 0] = solid.faces[solid.row[solid.row >= 0]]
    assert np.count_nonzero(push > 0.01) > 1000
    np.testing.assert_array_less(0, faces[push > 0.01])


def test_boxes_near_a_place_are_those_within_reach(rng):
    lower = rng.uniform(0.0, 3.0, (20, 3))
    boxes = boxes_from(lower, lower + rng.uniform(0.1, 0.5, (20, 3)))
    position, reach = rng.uniform(-0.5, 4.0, (500, 3)), 0.3
    nearby = near_boxes(position, boxes, reach)
    for i, place in enumerate(position):
        gap = np.maximum(np.maximum(boxes.lower - place, place - boxes.upper), 0.0)
        exact = np.flatnonzero(np.linalg.norm(gap, axis=1) < reach)
        np.testing.assert_array_equal(nearby.box[nearby.start[i] : nearby.start[i + 1]], exact)


def test_lists_last_while_particles_move_and_come_in_again_at_the_other_end(rng):
    d0 = 0.02
    case = complete(
        Case(
            title="a recess that repeats",
            particles={"spacing": d0},
            geometry={
                "type": "channel3d",
                "length": 1.0,
                "width": 0.2,
                "height": 0.4,
                "bed_start": 0.3,
                "bed_end": 0.7,
                "bed_thickness": 0.1,
                "periodic": True,
            },
            obstacle=[box("sill", [0.94, 1.0], [0.0, 0.2], [0.0, 0.04])],
            fill=[
                {"type": "block", "x": [0.3, 0.7], "y": [0.0, 0.2], "z": [-0.1, 0.0]}
                | {"material": "water"}
            ],
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )
    period, skin = domain(case).period, 0.5 * d0
    position = rng.uniform((0.0, 0.0, 0.0), (1.0, 0.2, 0.1), (2000, 3))
    position = np.concatenate([position, rng.uniform((0.97, 0, 0.041), (1, 0.2, 0.1), (500, 3))])
    surfaces = walls_of(case, 0.6)[0]
    surfaces.build(position, skin)
    moved = position + rng.uniform(-0.28, 0.28, position.shape) * skin * [1.0, 0.1, 0.1]
    moved[:, 2] = np.maximum(moved[:, 2], 1e-4)
    moved[:, 0] %= period[0]
    assert np.any(np.abs(moved - position) > 0.5)
    kept = surfaces.survey(moved)
    kept_sums, kept_faces = sums_of(kept), kept.distance[kept.row, 0] * (kept.row >= 0)
    fresh = around(case, moved)
    np.testing.assert_allclose(kept_sums, sums_of(fresh), atol=1e-9)
    has_face = (fresh.row >= 0) & (np.append(fresh.faces, 0)[fresh.row] > 0)
    np.testing.assert_allclose(
        kept_faces[has_face], fresh.distance[fresh.row[has_face], 0], atol=1e-12
    )
