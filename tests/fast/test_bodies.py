"""The walls of cases as boxes: what is in one, and what is felt where floors bend."""

from pathlib import Path

import numpy as np
import pytest

from debrisflow.case import Case, load_case
from debrisflow.case.defaults import complete
from debrisflow.neighbors.boundary import (
    wall_sums_at,
)
from debrisflow.particles.seeding import seed
from debrisflow.schemes.surfaces import walls_of
from debrisflow.space.bodies import bodies_of, in_walls
from debrisflow.space.domain import domain
from debrisflow.space.floor import runout_bend
from debrisflow.space.walls import wall_points

CASES = Path(__file__).parents[2] / "cases"


@pytest.fixture
def rng():
    return np.random.default_rng(61)


BENT = {"runout_start": 1.4, "runout_slope": 5.0}
RECESS = {"bed_start": 0.5, "bed_end": 0.9, "bed_thickness": 0.15}
CHANNELS = {
    "weir": RECESS | {"weir_height": 0.1},
    "straight": {},
    "periodic": {"periodic": True},
    "periodic with a recess": RECESS | {"periodic": True},
    "plain": BENT | {"runout_width": 1.23},
    "run-out between walls": BENT,
    "recess before a run-out": BENT | RECESS | {"runout_width": 1.23},
}
IN_THREE = [*sorted(path.stem for path in CASES.glob("*3d.toml")), *CHANNELS]


def flume(shape):
    """Return a case: a flume of 20 degrees with water in it, spacing 0.05 m."""
    shape = {"type": "channel3d", "length": 2.6, "width": 0.4, "height": 0.8} | shape
    block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.4], "z": [0.0, 0.4]}
    return complete(
        Case(
            title="flume",
            particles={"spacing": 0.05},
            gravity={"slope": 20.0},
            geometry=shape,
            fill=[block | {"material": "water"}],
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )


@pytest.fixture(params=IN_THREE, scope="module")
def walled(request):
    """Return a case of three dimensions, each that is shipped and some flumes."""
    name = request.param
    return flume(CHANNELS[name]) if name in CHANNELS else load_case(CASES / f"{name}.toml")


def around(case, rng, count=200_000):
    """Return places anywhere in the space of a case and as far beyond as walls are felt."""
    space, reach = domain(case), case.particles.effective_radius * case.particles.spacing
    repeats = space.period > 0.0
    lower = np.where(repeats, 0.0, space.lower) - reach
    upper = np.where(repeats, space.period, space.upper) + reach
    return rng.uniform(lower, upper, (count, 3))


def test_no_two_bodies_overlap_but_parts_of_a_floor(walled, rng):
    places, bodies = around(walled, rng), bodies_of(walled)
    count = np.zeros(len(places), dtype=int)
    for body in bodies:
        if not body.is_floor:
            count += body.holds(places)
    count += np.any([body.holds(places) for body in bodies if body.is_floor] or False, axis=0)
    assert np.count_nonzero(count == 1) > 1000
    np.testing.assert_array_equal(places[count > 1], np.zeros((0, 3)))


def test_drawn_cells_of_wall_are_in_the_walls_and_open_ones_beside_them_are_not(walled):
    points, d0 = wall_points(walled), walled.particles.spacing
    assert in_walls(walled, points.position).all()
    first = points.layer == 1
    # half a spacing over each of up to three faces that meet at an edge or corner, and not so high
    # that it is in a head wall, to which a run-out leans
    out = (points.depth[first] + 0.6 * d0)[:, None] * points.normal[first]
    assert not in_walls(walled, points.position[first] + out).any()


def test_a_fill_stands_in_no_wall(walled):
    particles = seed(walled)
    assert not in_walls(walled, particles.position[particles.fluid]).any()


def test_a_corner_of_a_rising_floor_is_as_solid_as_one_of_a_level_floor():
    case = flume(BENT)
    surfaces, rise, d0 = walls_of(case, 0.0)[0], runout_bend(case), 0.05
    up, half = np.array([-np.sin(rise), 0.0, np.cos(rise)]), 0.5 * d0
    on_floor = np.array([2.0, half, (2.0 - BENT["runout_start"]) * np.tan(rise)])
    places = np.array([[0.8, half, half], on_floor + half * up])
    surfaces.build(places, 0.0)
    level, rising = (np.array(wall_sums_at(i, surfaces.survey(places))) for i in (0, 1))
    # what the octants lose of the half space of the floor beside it
    np.testing.assert_allclose(rising[:2], level[:2], rtol=0.015)
    np.testing.assert_allclose(np.linalg.norm(rising[2:5]), np.linalg.norm(level[2:5]), rtol=0.01)


def test_a_run_out_is_not_felt_in_the_recess_before_it():
    place, found = np.array([[0.88, 0.2, -0.12]]), []
    for shape in (RECESS, RECESS | BENT):
        surfaces = walls_of(flume(shape), 0.0)[0]
        surfaces.build(place, 0.0)
        found.append(surfaces.survey(place))
    np.testing.assert_array_equal(*[solid.faces for solid in found])
    np.testing.assert_allclose(*[wall_sums_at(0, solid) for solid in found], rtol=1e-12)
