"""Is a bed at rest, does it yield, erode and come to rest as it should: slopes and flumes."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.beds import endless_bed
from debrisflow.validation.debris_flows import flume
from tests.slow import bed_controls as controls


@pytest.mark.parametrize(("friction_angle", "spacing"), [(30.0, 0.02), (35.0, 0.01)])
def test_an_endless_bed_slides_from_its_limit_slope_on(friction_angle, spacing):
    limit = endless_bed.limit_slope(friction_angle)
    below = endless_bed.rest(limit - 1.0, friction_angle, spacing)
    assert below.mean < 0.1
    assert below.greatest < 1.0
    assert endless_bed.rest(limit + 1.0, friction_angle, spacing).mean > 10.0


def test_a_bed_is_not_at_rest_where_friction_comes_before_the_projection():
    other = endless_bed.rest(15.0, 35.0, 0.02, scheme=controls.FrictionBeforeProjection)
    assert other.mean > 0.1
    assert other.mean > 10.0 * endless_bed.rest(15.0, 35.0, 0.02).mean


@pytest.mark.parametrize("friction_angle", [35.0, 40.0])
@pytest.mark.parametrize(("depth", "water_rows"), [(0.02, 6), (0.04, 8)])
def test_a_bed_yields_under_a_flow_as_deep_as_takahashi_says(friction_angle, depth, water_rows):
    spacing = depth / water_rows
    expected = endless_bed.yield_depth(15.0, friction_angle, depth)
    rows = int(1.5 * expected / spacing) + 3
    found = endless_bed.moving_depth(15.0, friction_angle, spacing, rows, water_rows, 2.0)
    assert found == pytest.approx(expected, rel=0.3)


def test_without_water_on_it_nothing_of_a_bed_yields():
    assert endless_bed.moving_depth(15.0, 35.0, 0.005, 16, 0, 1.0) == 0.0


@pytest.fixture(scope="module")
def debris_flow() -> flume.Flume:
    return flume.run("flume2d")


def test_the_flume_is_supplied_exactly_and_its_bed_rests_until_the_water_comes(debris_flow):
    moved = debris_flow.moved(0.0, 2.0)
    assert moved.mean() < 0.1
    assert moved.max() < 1.0
    case = debris_flow.case
    assert debris_flow.supplied == pytest.approx(case.inflow.discharge * case.time.end, rel=0.01)
    assert debris_flow.through_wall == 0


def test_the_front_of_the_flume_takes_the_time_of_the_study(debris_flow):
    arrivals = [debris_flow.arrival(x) for x in (2.0, 6.9)]
    assert arrivals[0] == pytest.approx(2.60, rel=0.1)  # calibrated
    assert arrivals[1] - arrivals[0] == pytest.approx(5.24, rel=0.1)


def test_the_flume_erodes_its_bed_from_upstream(debris_flow):
    assert debris_flow.eroded() > 0.2
    last = debris_flow.frames[10.0]
    rock = last.position[last.fraction > 0.0]
    count = np.histogram(rock[:, 0], [2.0, 2.5, 4.0, 4.5])[0]
    assert count[0] < 0.5 * count[2]


def test_the_flow_of_the_flume_carries_sediment_under_water(debris_flow):
    for time in (6.0, 7.0, 8.0):
        found = debris_flow.concentrations(time)
        assert found["surface"] < 0.5 * found["base"]
        assert 0.2 < found["body"] < 0.55
    head = [debris_flow.concentrations(time)["above"] for time in np.arange(60, 81) / 10.0]
    assert 0.1 < np.mean(head) < 0.6


# a bound that is missed and stays, see docs/limits.md; not strict, since the head's 30 particles
# move chaotically, so that the last bits decide on which side a single time falls
@pytest.mark.xfail(reason="at single times 30 particles of a head scatter, from 0.36 to 0.68")
def test_the_head_of_the_flume_carries_sediment_at_any_time(debris_flow):
    for time in (6.0, 7.0, 8.0):
        assert 0.1 < debris_flow.concentrations(time)["above"] < 0.6


def test_where_water_counts_as_load_of_the_grains_the_flow_erodes_less(debris_flow):
    other = flume.run("flume2d", scheme=controls.ShareOfPressure)
    assert other.eroded() < 0.75 * debris_flow.eroded()


def test_without_drag_the_front_carries_less_sediment(debris_flow):
    other = flume.run("flume2d", ("drag.law=none",), end=6.0)
    times = (5.0, 5.5, 6.0)
    above = [
        np.mean([found.concentrations(time)["above"] for time in times])
        for found in (other, debris_flow)
    ]
    assert above[0] < 0.75 * above[1]


def test_the_short_flume_is_at_rest_within_five_seconds_of_its_supply():
    found = flume.run("bed_erosion2d", end=8.0, width=0.05, depth=0.002, supply_until=2.0)
    assert found.rested(6.0, 8.0).mean() < 0.1
    depth = flume.still_depths(found, 8.0, np.array([0.1, 0.4, 0.7, 1.0]))
    assert np.all(np.diff(depth) > 0.0)


def test_a_debris_flow_comes_to_rest_behind_a_bend_of_its_flume():
    found = flume.deposit("flume_deposit2d")
    assert found.moved.mean() < 0.1
    assert found.on_runout > 0.1
    # thicker than the two rows of a film, and thinning downstream; no steeper than a bed can be.
    # The last digits of a processor choose among deposits of 26 to 38 mm, as other seedings do.
    assert found.depth > 0.02
    assert 4.0 < found.slope < 18.4
