"""Is a flow right that is a few rows of particles deep: a slab by Voellmy's law, a large flume."""

from __future__ import annotations

import pytest

from tests.validation import usgs_flume, voellmy_slab


def test_the_run_out_of_a_slab_depends_little_on_its_rows():
    runs = {rows: voellmy_slab.run(rows) for rows in (1, 2, 4)}
    for rows, found in runs.items():
        assert found.lost == 0
        assert found.time < voellmy_slab.LATEST
        assert found.front == pytest.approx(runs[4].front, rel=0.05), rows
        assert found.middle == pytest.approx(runs[4].middle, rel=0.10), rows


@pytest.fixture(scope="module")
def flume() -> dict[str, usgs_flume.Station]:
    return usgs_flume.run()


def test_the_front_in_the_flume_is_where_it_was_measured(flume):
    measured = usgs_flume.measured("sgm")
    assert flume["h32"].mean == pytest.approx(measured["h32"].mean, abs=0.1)  # fitted
    for probe in ("h66", "h90"):
        assert flume[probe].mean == pytest.approx(measured[probe].mean, rel=0.15)
        assert flume[probe].first == pytest.approx(measured[probe].first, rel=0.15)
    assert usgs_flume.front_speed(flume) == pytest.approx(10.0, rel=0.15)


@pytest.mark.parametrize("probe", ["h66", "h90"])
def test_the_flow_in_the_flume_is_as_deep_as_measured(flume, probe):
    measured = usgs_flume.measured("sgm")[probe]
    assert abs(flume[probe].peak - measured.peak) < measured.deviation


@pytest.mark.xfail(strict=True, reason="the head is 0.3 m deep at 32 m, 1.4 deviations too much")
def test_the_head_is_as_deep_as_measured(flume):
    measured = usgs_flume.measured("sgm")["h32"]
    assert abs(flume["h32"].peak - measured.peak) < measured.deviation
