"""Walls of a channel whose floor bends up to a run-out."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.particles.record import Kind
from debrisflow.run.measures import deposit_profile
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.floor import floor_level, floor_roughness, height_over_floor
from debrisflow.space.walls import wall_points
from debrisflow.validation.marching import advance
from tests.building import started

D0 = 0.02


def bent_channel(**tables):
    """Return a case: a channel of 15 degrees that bends to 3 degrees at x = 1 m."""
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    return complete(
        Case(
            title="bend",
            particles={"spacing": D0},
            gravity={"slope": 15.0},
            geometry={
                "type": "channel",
                "length": 2.0,
                "height": 0.6,
                "runout_start": 1.0,
                "runout_slope": 3.0,
            },
            **tables,
        )
    )


def test_the_floor_of_a_runout_lies_at_its_slope():
    case = bent_channel()
    level = floor_level(case, np.array([0.5, 1.0, 1.5]))
    np.testing.assert_allclose(level, [0.0, 0.0, 0.5 * np.tan(np.radians(12.0))], atol=1e-12)


CHANNELS = {
    "weir": {"bed_start": 0.5, "bed_end": 1.5, "weir_height": 0.1},
    "level": {"bed_start": 0.5, "bed_end": 1.5},
    "periodic": {"bed_start": 0.0, "bed_end": 1.5, "periodic": True},
}


@pytest.mark.parametrize("kind", CHANNELS)
def test_the_roughness_under_a_point_is_that_of_the_wall_below_it(kind):
    roughness = {"floor": 0.01, "bed": 0.002, "right": 0.003}
    channel = {"type": "channel", "length": 2.0, "height": 0.5, "bed_thickness": 0.1}
    case = complete(
        Case(
            title="recess",
            particles={"spacing": D0},
            geometry=channel | CHANNELS[kind],
            walls={name: {"roughness": value} for name, value in roughness.items()},
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )
    x = (np.arange(100) + 0.5) * D0
    points = wall_points(case)
    columns = [np.flatnonzero(np.abs(points.position[:, 0] - at) < 1e-9) for at in x]
    top = [column[np.argmax(points.position[column, 1])] for column in columns]
    below = [roughness[WALL_NAMES[name]] for name in points.name[top]]
    assert len(set(below)) >= 2
    np.testing.assert_array_equal(floor_roughness(case, x), below)
    if case.geometry.periodic:
        np.testing.assert_array_equal(floor_roughness(case, x + 2.0), below)


def test_no_law_of_the_wall_acts_on_a_floor_without_roughness():
    case = bent_channel()
    assert np.all(np.isinf(floor_roughness(case, np.array([0.5, 1.5]))))


@pytest.mark.parametrize("layer", [1, 2, 3, 4])
def test_wall_layers_follow_the_bend_without_gap_or_overlap(layer):
    points = wall_points(bent_channel())
    row = points.position[(points.layer == layer) & (points.position[:, 1] < 0.5)]
    row = row[(row[:, 0] > 0.0) & (row[:, 0] < 1.9)]
    row = row[np.argsort(row[:, 0])]
    apart = np.linalg.norm(np.diff(row, axis=0), axis=1) / D0
    assert apart.min() > 0.4
    assert apart.max() < 1.6
    away = np.abs(row[:-1, 0] - 1.0) > 0.1
    np.testing.assert_allclose(apart[away], 1.0, rtol=1e-9)


def test_heights_of_a_deposit_on_a_runout_are_along_its_normal():
    case = bent_channel()
    bend = np.radians(12.0)
    along = np.arange(0.2, 0.8, D0 / 2)
    depth = 0.05
    rows = 5 * along.size
    along, height = (v.ravel() for v in np.meshgrid(along, depth * np.arange(1, 6) / 5.0))
    position = np.zeros((rows, 3))
    position[:, 0] = 1.0 + along * np.cos(bend) - height * np.sin(bend)
    position[:, 1] = along * np.sin(bend) + height * np.cos(bend)
    profile = deposit_profile(
        case,
        position,
        np.zeros((rows, 3)),
        np.full(rows, int(Kind.SEDIMENT)),
        np.full(rows, 0.55),
        np.ones(rows),
        np.full(rows, 18.0),
        18.0,
    )
    inside = (profile.x > 1.25) & (profile.x < 1.7)
    np.testing.assert_allclose(profile.flow_height[inside], depth + 0.5 * D0, rtol=1e-9)


def test_a_film_runs_along_a_tilted_floor_and_not_through_it():
    block = {"type": "block", "x": [0.6, 1.0], "y": [0.0, 0.08], "material": "water"}
    case = bent_channel(fill=[block | {"velocity": [1.0, 0.0]}])
    scheme, state = started(case)
    advance(scheme, state, until=0.5)
    p = state.particles
    x, y = p.position[p.fluid, 0], p.position[p.fluid, 1]
    assert state.through_wall.sum() == 0
    assert x.max() > 1.3
    height = height_over_floor(case, x, y, x)
    assert height.min() > 0.2 * D0
