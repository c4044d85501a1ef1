"""Channels in three dimensions: their walls, what leaves them, and their cells seen from above."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.case.estimate import particle_estimate
from debrisflow.particles.inflow_outflow import remove_leaving
from debrisflow.particles.seeding import seed, wall_particles
from debrisflow.run import probes
from debrisflow.run.wall_pressure import wall_faces
from debrisflow.space.domain import LEFT, WALL_NAMES, domain, wall_layers
from debrisflow.space.fills import fill, inflow_section
from debrisflow.space.floor import height_over_floor, is_over_floor
from debrisflow.space.plan_grid import locate, plan
from debrisflow.space.walls import wall_points
from debrisflow.validation.marching import advance
from tests.building import started

D0 = 0.05
WIDTH, HEIGHT, LENGTH = 0.4, 0.8, 2.6
BED = {"bed_start": 0.5, "bed_end": 0.9, "bed_thickness": 0.15}
START, BEND = 1.4, np.radians(15.0)
RUNOUT = {"runout_start": START, "runout_slope": 5.0}
PLAIN = RUNOUT | {"runout_width": 1.23}
FRONT_EDGE, BACK_EDGE = 0.2 - 0.615, 0.2 + 0.615
BLOCK = {"type": "block", "x": [0.0, 0.4], "y": [0.0, WIDTH], "z": [0.0, 0.4], "material": "water"}


def flume(fill=(BLOCK,), **tables):
    """Return a case: a flume of 20 degrees; fields of its geometry are given as a table."""
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    shape = {"type": "channel3d", "length": LENGTH, "width": WIDTH, "height": HEIGHT}
    return complete(
        Case(
            title="flume",
            particles={"spacing": D0},
            gravity={"slope": 20.0},
            geometry=shape | tables.pop("geometry", PLAIN | BED),
            fill=list(fill),
            **tables,
        )
    )


def raster(*ends):
    """Return the points of a box that is a quarter of a spacing fine, (n, 3) array."""
    axes = [np.arange(a, b, 0.25 * D0) if b > a else np.array([a]) for a, b in ends]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def rising(points):
    """Return points of z = 0 moved onto the run-out, x being the distance along it."""
    x, y, _ = points.T
    return np.column_stack([START + x * np.cos(BEND), y, x * np.sin(BEND)])


def surfaces(kind):
    """Return points of every surface of a flume with a recess, and the normals of the surfaces."""
    depth = BED["bed_thickness"]
    begin, end = BED["bed_start"], BED["bed_end"]
    across, low = (0.0, WIDTH), (-depth, 0.0)
    slope = (LENGTH - START) / np.cos(BEND)
    upward = np.array([-np.sin(BEND), 0.0, np.cos(BEND)])
    found = {
        "left": (raster((0, 0), across, (0, HEIGHT)), [1, 0, 0]),
        "floor before the bed": (raster((0, begin), across, (0, 0)), [0, 0, 1]),
        "floor behind the bed": (raster((end, START), across, (0, 0)), [0, 0, 1]),
        "bed": (raster((begin, end), across, (-depth, -depth)), [0, 0, 1]),
        "first step": (raster((begin, begin), across, low), [1, 0, 0]),
        "second step": (raster((end, end), across, low), [-1, 0, 0]),
        "front of the bed": (raster((begin, end), (0, 0), low), [0, 1, 0]),
        "front": (raster((0, START), (0, 0), (0, HEIGHT)), [0, 1, 0]),
        "back": (raster((0, START), (WIDTH, WIDTH), (0, HEIGHT)), [0, -1, 0]),
    }
    if kind == "plain":
        wide = (FRONT_EDGE, BACK_EDGE)
        found["plain"] = rising(raster((0, slope), wide, (0, 0))), upward
        for side, span in (("front", (FRONT_EDGE, 0.0)), ("back", (WIDTH, BACK_EDGE))):
            head = raster((START, START), span, (0, HEIGHT))
            found[f"head wall, {side}"] = head, [1, 0, 0]
    else:
        inner = (0.5 * D0, WIDTH - 0.5 * D0)  # the cells of the side walls do not follow the slope
        found["run-out"] = rising(raster((0, slope), inner, (0, 0))), upward
        beside = raster((START, LENGTH), (0, 0), (0, HEIGHT))
        beside = beside[beside[:, 2] > (beside[:, 0] - START) * np.tan(BEND)]
        found["front of the run-out"] = beside, [0, 1, 0]
    return found


KINDS = {"plain": PLAIN | BED, "between walls": RUNOUT | BED}


@pytest.mark.parametrize("kind", KINDS)
def test_no_layer_of_any_surface_has_a_hole(kind):
    points = wall_points(flume(geometry=KINDS[kind]))
    near = cKDTree(points.position)
    for name, (surface, normal) in surfaces(kind).items():
        for layer in range(wall_layers(flume())):
            within = surface - (layer + 0.5) * D0 * np.array(normal)
            # beside a missing particle of the lattice there is none nearer than a spacing
            assert near.query(within)[0].max() < 0.9 * D0, (name, layer)


@pytest.mark.parametrize("kind", KINDS)
def test_wall_particles_stand_apart(kind):
    points = wall_points(flume(geometry=KINDS[kind]))
    distance = cKDTree(points.position).query(points.position, k=2)[0][:, 1]
    assert distance.min() > 0.4 * D0
    first = points.position[(points.layer == 1) & (points.position[:, 2] < 0.02)]
    row = first[(np.abs(first[:, 1] - 0.225) < 1e-6) & (first[:, 0] > 1.0)]
    apart = np.linalg.norm(np.diff(row[np.argsort(row[:, 0])], axis=0), axis=1)
    assert row[:, 0].max() > START + D0
    assert apart.min() > 0.5 * D0
    assert apart.max() < 1.5 * D0


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_layer_lies_half_a_spacing_behind_its_surface(kind):
    points = wall_points(flume(geometry=KINDS[kind]))
    first = points.layer == 1
    position, normal, depth = points.position[first], points.normal[first], points.depth[first]
    near = cKDTree(position)
    for name, (surface, expected) in surfaces(kind).items():
        inner = surface[near.query(surface)[0] < 0.51 * D0]
        rows = near.query(inner)[1]
        aligned = normal[rows] @ np.array(expected) > 1.0 - 1e-9
        assert aligned.mean() > 0.6, name
        # an edge is nearest to them, or two faces are whose angle they halve
        at_edges = (depth[rows] > 0.501 * D0) | (np.abs(normal[rows]).max(axis=1) < 0.8)
        assert np.all(aligned | at_edges), name
        assert np.all(normal[rows] @ np.array(expected) > -1e-9), name
        np.testing.assert_allclose(depth[rows][aligned], 0.5 * D0, atol=1e-12)


def test_side_walls_below_a_bent_floor_point_to_its_edge():
    points = wall_points(flume(geometry=RUNOUT))
    x, y, z = points.position.T
    case = flume(geometry=RUNOUT)
    below = -height_over_floor(case, x, z, x)
    rows = (y < 0.0) & (x > START + 0.2) & (below > 0.0)
    assert np.count_nonzero(rows) > 50
    assert below[rows].max() < 3 * D0
    edge = (points.position + points.depth[:, None] * points.normal)[rows]
    np.testing.assert_allclose(edge[:, 1], 0.0, atol=1e-12)
    height = height_over_floor(case, edge[:, 0], edge[:, 2], edge[:, 0])
    np.testing.assert_allclose(height, 0.0, atol=1e-12)


def test_walls_bear_their_names_and_the_head_wall_those_of_the_sides():
    points = wall_points(flume())
    x, y, z = points.position.T
    names = {name: points.name == WALL_NAMES.index(name) for name in WALL_NAMES}
    assert np.all(names["front"][(y < 0) & (x > 0) & (x < START) & (z > 0)])
    assert np.all(names["back"][(y > WIDTH) & (x > 0) & (x < START) & (z > 0)])
    assert np.all(names["floor"][(x > START)])
    assert np.all(names["left"][(x < 0) & (z > 0)])
    assert np.all(names["bed"][(z < -0.1501)])
    assert not names["right"].any()
    assert not names["ceiling"].any()


def test_a_weir_reaches_over_the_width():
    points = wall_points(flume(geometry=BED | {"weir_height": 0.1}))
    weir = points.name == WALL_NAMES.index("right")
    crest = weir & (points.normal[:, 2] > 0.99) & (points.layer == 1)
    rows = np.unique(points.position[crest, 1].round(6))
    np.testing.assert_allclose(rows[(rows > 0) & (rows < WIDTH)], (np.arange(8) + 0.5) * D0)


def test_a_periodic_channel_repeats_along_its_floor():
    case = flume(geometry={"periodic": True})
    points = wall_points(case)
    assert {WALL_NAMES[k] for k in set(points.name)} == {"floor", "front", "back"}
    assert not np.any(points.normal[:, 0])
    assert points.position[:, 0].min() > 0.0
    assert points.position[:, 0].max() < LENGTH
    np.testing.assert_array_equal(domain(case).period, [LENGTH, 0.0, 0.0])


def test_the_supply_enters_below_the_left_wall():
    case = flume(geometry=RUNOUT, inflow={"depth": 0.1, "velocity": 1.0})
    assert inflow_section(case) == (0, 8, 2)
    points = wall_points(case)
    x, y, z = points.position.T
    before = (x < 0.0) & (y > 0.0) & (y < WIDTH)
    assert not np.any(before & (z > 0.0) & (z < 0.1))
    assert np.all(points.name[before & (z > 0.1)] == LEFT)
    upstream = (x < -2.0 * D0) & (x > -3.0 * D0)
    assert np.count_nonzero(upstream & (y < 0.0) & (z > 0.0) & (z < 0.1)) == 3 * 2
    assert np.count_nonzero(upstream & (y > 0.0) & (y < WIDTH) & (z < 0.0)) == 8 * 3


def test_an_obstacle_at_the_mouth_is_whole():
    box = {"type": "box", "name": "pier", "x": [1.1, 1.4], "y": [0.1, 0.3], "z": [0.0, 0.2]}
    points = wall_points(flume(obstacle=[box]))
    own = points.position[points.name == len(WALL_NAMES)]
    assert len(own) == 6 * 4 * 4
    assert len(np.unique(own.round(6), axis=0)) == len(own)


@pytest.mark.parametrize("kind", KINDS)
def test_the_number_of_particles_is_foretold_and_walls_are_none(kind):
    case = flume(geometry=KINDS[kind], inflow={"depth": 0.1, "velocity": 1.0})
    found, particles = particle_estimate(case), seed(case)
    assert found["fluid"] == pytest.approx(particles.fluid_count, rel=1e-12)
    assert found["inflow"] >= particles.inflow_count > 0
    assert found["wall"] == particles.wall_count == 0
    assert particles.count == particles.fluid_count + particles.inflow_count


def left_and_through(case, *places):
    """Return how many of the particles at some places leave, and go through a wall."""
    _, state = started(case)
    p = state.particles
    p.position[: len(places)] = places
    p.velocity[: len(places)] = 0.0
    before = p.fluid_count
    remove_leaving(state, case, domain(case))
    assert before == p.fluid_count + state.left.sum() + state.through_wall.sum()
    return int(state.left.sum()), int(state.through_wall.sum())


FAR = 2.0  # x on the run-out
OVER = 0.3  # z over its floor there
LEAVING = {
    "over the plain": ((FAR, -0.3, OVER), (0, 0)),
    "over the front edge": ((FAR, FRONT_EDGE - 0.01, OVER), (1, 0)),
    "over the back edge": ((FAR, BACK_EDGE + 0.01, OVER), (1, 0)),
    "past the end": ((LENGTH + 0.01, 0.2, 0.5), (1, 0)),
    "under the plain": ((FAR, -0.3, 0.05), (0, 1)),
    "through the side": ((1.0, -0.06, 0.3), (0, 1)),
    "over the side": ((1.0, -0.06, HEIGHT + 0.01), (1, 0)),
    "into the head wall": ((START - 0.06, -0.2, 0.3), (0, 1)),
    "over the head wall": ((START - 0.06, -0.2, HEIGHT + 0.01), (1, 0)),
    "at the head wall": ((START - 0.04, -0.2, 0.3), (0, 0)),
    "through the left wall": ((-0.06, 0.2, 0.3), (0, 1)),
    "under the recess": ((0.7, 0.2, -0.21), (0, 1)),
    "in the recess": ((0.7, 0.2, -0.1), (0, 0)),
    "above": ((0.7, 0.2, 1.2), (1, 0)),
}


@pytest.mark.parametrize("place", LEAVING)
def test_what_passes_an_open_edge_leaves_and_what_passes_a_wall_is_told(place):
    position, expected = LEAVING[place]
    assert left_and_through(flume(), position) == expected


def test_a_runout_between_walls_has_closed_sides():
    case = flume(geometry=RUNOUT)
    assert left_and_through(case, (FAR, -0.06, OVER)) == (0, 1)
    assert left_and_through(case, (LENGTH + 0.01, 0.2, 0.5)) == (1, 0)


def test_cells_cover_flume_and_plain_and_not_what_is_beside_the_flume():
    case = flume()
    grid = plan(case)
    plain = (LENGTH - START) * (BACK_EDGE - FRONT_EDGE)
    assert grid.area.sum() == pytest.approx(START * WIDTH + plain, rel=1e-12)
    assert grid.area.max() == pytest.approx((2 * D0) ** 2)
    assert np.all((grid.x > START) | ((grid.y > 0.0) & (grid.y < WIDTH)))
    found = locate(case, grid, np.column_stack([grid.x, grid.y, np.full(grid.x.size, 0.5)]))
    np.testing.assert_array_equal(found.row, np.arange(grid.x.size))
    np.testing.assert_array_equal(found.cell, found.row)
    rise = np.where(grid.x > START, (grid.x - START) * np.tan(BEND), 0.0)
    tilt = np.where(grid.x > START, np.cos(BEND), 1.0)
    floor = np.where((grid.x > 0.5) & (grid.x < 0.9), -0.15, rise)
    np.testing.assert_allclose(found.height, (0.5 - floor) * tilt, atol=1e-12)
    beside = np.array([[1.0, -0.2, 0.9], [1.0, 0.6, 0.9], [1.0, 0.2, 0.1], [2.0, -0.2, 0.4]])
    np.testing.assert_array_equal(locate(case, grid, beside).row, [2, 3])


def test_the_bed_fills_the_recess_over_the_width():
    case = flume(fill=[{"type": "bed", "material": "mixture"}])
    position = fill(case.fill[0], case)
    assert len(position) == 8 * 8 * 3
    np.testing.assert_allclose(position.min(axis=0), [0.525, 0.025, -0.125])
    np.testing.assert_allclose(position.max(axis=0), [0.875, 0.375, -0.025])


def test_faces_of_walls_are_those_that_the_flow_can_touch():
    case = flume(geometry=PLAIN)
    front = wall_faces(case, wall_particles(case), "front")
    x, y, _ = front.position.T
    side, head = front.normal[:, 1] > 0.99, front.normal[:, 0] > 0.99
    assert np.all(side | head)
    assert np.count_nonzero(side) == 28 * 16
    np.testing.assert_allclose(x[head], START)
    assert y[head].min() > FRONT_EDGE
    floor = wall_faces(case, wall_particles(case), "floor")
    area = START * WIDTH + (LENGTH - START) / np.cos(BEND) * (BACK_EDGE - FRONT_EDGE)
    assert len(floor.position) * D0**2 == pytest.approx(area, rel=0.03)


def test_no_face_of_a_side_wall_lies_below_a_bent_floor():
    case = flume(geometry=RUNOUT)
    x, _, z = wall_faces(case, wall_particles(case), "front").position.T
    assert height_over_floor(case, x, z, x).min() > 0.0


def test_a_height_probe_stands_on_the_plain_beside_the_flume():
    probe = {"type": "height", "name": "far", "interval": 0.1, "x": 2.0, "y": -0.35}
    case = flume(probe=[probe])
    _, state = started(case)
    measure = probes.samplers(case, state)["far"]
    assert measure.base == pytest.approx(0.6 * np.tan(BEND), abs=D0)


def test_water_slides_down_a_flume_and_spreads_on_its_plain():
    scheme, state = started(flume())
    count = state.particles.fluid_count
    advance(scheme, state, until=1.0)
    p = state.particles
    x, y, z = p.position[p.fluid].T
    assert state.through_wall.sum() == 0
    assert p.fluid_count + state.left.sum() == count
    assert np.count_nonzero((y < -D0) | (y > WIDTH + D0)) > 20
    assert np.all(is_over_floor(flume(), x, y))
    assert height_over_floor(flume(), x, z, x).min() > 0.0
