"""Is a flow right that is a few rows of particles deep: a slab by Voellmy's law, a large flume."""

from __future__ import annotations

import pytest

from debrisflow.validation.debris_flows import usgs_flume, voellmy_slab


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


@pytest.fixture(scope="module")
def smooth() -> dict[str, usgs_flume.Station]:
    return usgs_flume.run((*usgs_flume.SMOOTH, "time.end=8.5"))


def test_the_front_in_the_flume_is_where_it_was_measured(flume):
    measured = usgs_flume.measured("sgm")
    assert flume["h32"].mean == pytest.approx(measured["h32"].mean, abs=0.1)  # fitted
    for probe in ("h66", "h90"):
        assert flume[probe].mean == pytest.approx(measured[probe].mean, rel=0.15)
        assert flume[probe].first == pytest.approx(measured[probe].first, rel=0.15)
    assert usgs_flume.front_speed(flume) == pytest.approx(10.0, rel=0.15)


def test_the_front_on_the_smooth_bed_follows_from_the_same_fit(smooth):
    measured = usgs_flume.measured("sg_smooth")
    for probe in ("h32", "h66"):
        assert smooth[probe].mean == pytest.approx(measured[probe].mean, rel=0.15)


def excess(found: dict[str, usgs_flume.Station], sand: str, probe: str) -> float:
    """Return by how many standard deviations of the releases a flow is too deep."""
    measured = usgs_flume.measured(sand)[probe]
    return (found[probe].peak - measured.peak) / measured.deviation


@pytest.mark.parametrize("probe", ["h66", "h90"])
def test_the_flow_in_the_flume_is_as_deep_as_measured(flume, probe):
    assert abs(excess(flume, "sgm", probe)) < 1.0


# a bound that is missed at 0.1 m and stays, see docs/validation.md; 67 mm are within it
@pytest.mark.xfail(
    strict=True, reason="the tip is too deep: without a dry front it is not held back"
)
def test_the_head_is_as_deep_as_measured(flume):
    assert abs(excess(flume, "sgm", "h32")) < 1.0


# a bound that is missed and stays, see docs/validation.md: the one fitted number is kept for the
# smooth bed, whose own would be three times as great
@pytest.mark.xfail(strict=True, reason="too deep: the fitted drag is that of bumps")
def test_the_flow_on_the_smooth_bed_is_as_deep_as_measured(smooth):
    assert abs(excess(smooth, "sg_smooth", "h66")) < 1.0
