"""Negative controls of flows over beds, and what a slab keeps whatever its number of rows is."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.debris_flows import flume, voellmy_slab
from debrisflow.validation.debris_flows.flume_profiles import concentrations
from tests.slow import bed_controls

TIMES = (5.0, 5.5, 6.0)


@pytest.fixture(scope="module")
def debris_flow() -> flume.Flume:
    return flume.run("flume2d")


def test_where_water_counts_as_load_of_the_grains_the_flow_erodes_less(debris_flow):
    other = flume.run("flume2d", scheme=bed_controls.ShareOfPressure)
    assert other.eroded() < 0.75 * debris_flow.eroded()


def test_without_drag_the_front_carries_less_sediment(debris_flow):
    other = flume.run("flume2d", ("drag.law=none",), end=TIMES[-1])
    without, with_it = (
        np.mean([concentrations(found, time).above for time in TIMES])
        for found in (other, debris_flow)
    )
    assert without < 0.75 * with_it


def test_the_run_out_of_a_slab_depends_little_on_its_rows():
    runs = {rows: voellmy_slab.run(rows) for rows in (1, 2, 4)}
    for rows, found in runs.items():
        assert found.lost == 0
        assert found.times[-1] < voellmy_slab.LATEST
        assert found.reached(0.99) == pytest.approx(runs[4].reached(0.99), rel=0.05), rows
        assert found.reached(0.5) == pytest.approx(runs[4].reached(0.5), rel=0.10), rows
