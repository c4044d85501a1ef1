"""Curves of probes: running means, what they come to, references; written, drawn and compared."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results import open_run
from debrisflow.results.compare import compare
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import ProbeCurve, figures_of, smoothed
from debrisflow.results.references import distances, read_reference
from debrisflow.results.survey import survey
from debrisflow.run.folder import DERIVED
from tests.recording import cells, channel_case, placed, record, sliding

TIME = np.arange(0.0, 1.0001, 0.01)
PROBES = [
    {"name": "gauge", "type": "pressure", "wall": "floor", "x": 1.0, "y": 0.0, "interval": 0.01},
    {"name": "level", "type": "height", "x": 1.0, "interval": 0.01},
]


def pulse(time):
    """Return a pressure that rises at 0.4 s to 1 kPa and falls again, Pa."""
    return 1000.0 * np.maximum(1.0 - np.abs(time - 0.5) / 0.1, 0.0)


def of_run(path, late=0.0):
    """Write a run with two probes, whose pressure comes late by a time, and return its folder."""
    case = channel_case(probe=PROBES, output={"interval": 0.25})
    layer = placed(case, cells(case, range(100), range(8)), velocity=1.0)
    record(path, case, sliding(case, layer, [0.0, 0.25, 0.5, 0.75, 1.0]))
    probes = path / "probes"
    probes.mkdir(exist_ok=True)
    for name, columns in (
        ("gauge", {"pressure": 0.5 * pulse(TIME - late), "reaction": pulse(TIME - late)}),
        ("level", {"height": np.full(TIME.size, 0.1), "filled_height": 0.1 + 0.0 * TIME}),
    ):
        rows = np.column_stack([TIME, *columns.values()])
        head = ",".join(["time", *columns])
        np.savetxt(probes / f"{name}.csv", rows, delimiter=",", header=head, comments="")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return of_run(tmp_path_factory.mktemp("probes") / "run")


@pytest.fixture
def found(folder):
    return survey(open_run(folder), smoothing=0.0)


def reference(path, **columns):
    """Write the columns of a reference against time and read them."""
    rows = np.column_stack([TIME, *columns.values()])
    head = ",".join(["time", *(name.replace("__", ".") for name in columns)])
    np.savetxt(path, rows, delimiter=",", header=head, comments="")
    return read_reference(path)


def test_a_running_mean_keeps_straight_lines_and_the_integral_of_a_pulse():
    time = np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 400))
    line = 3.0 - 2.0 * time
    inside = (time > time[0] + 0.05) & (time < time[-1] - 0.05)
    np.testing.assert_allclose(smoothed(time, line, 0.1)[inside], line[inside], atol=1e-12)
    values = pulse(time)
    smooth = smoothed(time, values, 0.1)
    assert np.trapezoid(smooth, time) == pytest.approx(np.trapezoid(values, time), rel=1e-3)
    assert smooth.max() < values.max()
    np.testing.assert_array_equal(smoothed(time, values, 0.0), values)
    np.testing.assert_array_equal(smoothed(time[:1], values[:1], 1.0), values[:1])


def test_a_pulse_comes_to_its_peak_arrival_impulse_and_scatter():
    noise = np.where(np.arange(TIME.size) % 2, 1.0, -1.0) * (TIME > 0.7)
    curve = ProbeCurve("p", "reaction", "Pa", TIME, -pulse(TIME) + noise, -pulse(TIME), 0.1)
    row = figures_of(curve, (0.8, 1.0))
    assert row.peak == pytest.approx(-1000.0)
    assert row.peak_time == pytest.approx(0.5)
    assert row.smooth_peak == pytest.approx(-1000.0)
    assert row.arrival == pytest.approx(0.41)  # the first sample past 5 % of 1 kPa
    assert row.impulse == pytest.approx(-100.0, abs=0.02)
    assert row.mean == pytest.approx(0.0, abs=0.1)
    assert row.scatter == pytest.approx(1.0, abs=0.01)


def test_what_does_not_change_has_no_arrival_and_a_height_no_impulse():
    still = np.full(TIME.size, 0.1)
    row = figures_of(ProbeCurve("level", "filled_height", "m", TIME, still, still, 0.1), (2.0, 3.0))
    assert row.peak == 0.1
    assert np.isnan([row.arrival, row.impulse, row.mean, row.scatter]).all()


def test_probes_have_a_table_and_a_plot(folder, found):
    files, _ = postprocess(found)
    assert {"probes.csv", "probes.png"} <= {file.name for file in files}
    assert {file.name for file in files} <= set(DERIVED)  # removed when the run is repeated
    with (folder / "postprocess" / "probes.csv").open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    named = [(row["probe"], row["column"], row["unit"]) for row in rows]
    assert named == [
        ("gauge", "reaction", "Pa"),
        ("gauge", "pressure", "Pa"),
        ("level", "filled_height", "m"),
    ]
    assert [float(row["peak"]) for row in rows] == pytest.approx([1000.0, 500.0, 0.1])


def test_a_reference_of_a_probe_has_distance_shift_and_band(tmp_path, found):
    late = pulse(TIME - 0.05)
    given = reference(
        tmp_path / "flume.csv",
        gauge__reaction=late,
        gauge__reaction__low=late - 300.0,
        gauge__reaction__high=late + 300.0,
    )
    (row,) = distances(found, given)
    assert row.rms == pytest.approx(np.sqrt(np.mean((pulse(TIME) - late) ** 2)), rel=1e-6)
    assert row.shift == pytest.approx(0.05, abs=1e-9)
    assert row.shifted_rms == pytest.approx(0.0, abs=1e-9)
    inside = np.abs(pulse(TIME) - late) <= 300.0
    assert row.in_band == pytest.approx(inside.mean())
    files, lines = postprocess(found, [given])
    assert "probes.png" in {file.name for file in files}
    assert any("gauge.reaction" in line and "moved by +0.05 s" in line for line in lines)


def test_a_curve_of_the_front_has_a_shift_and_no_band(tmp_path, found):
    front = np.interp(TIME, found.fronts["time"], found.fronts["front_all"])
    (row,) = distances(found, reference(tmp_path / "front.csv", front_all=front))
    assert (row.rms, row.shift, row.shifted_rms) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert np.isnan(row.in_band)


def test_a_column_that_no_probe_has_ends_in_an_error(tmp_path, folder, found):
    given = reference(tmp_path / "flume.csv", gauge__reactoin=TIME)
    with pytest.raises(OutputError, match=r"no column gauge\.reactoin .*'gauge\.reaction'"):
        distances(found, given)
    arguments = ["postprocess", str(folder), "--reference", str(tmp_path / "flume.csv")]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 3
    assert "no column gauge.reactoin" in result.output


def test_runs_are_compared_by_the_probes_that_they_share(tmp_path, folder):
    other = of_run(tmp_path / "late", late=0.1)
    runs = [survey(open_run(path), smoothing=0.0) for path in (folder, other)]
    together, files = compare(runs, tmp_path / "comparison")
    assert "probes.png" in {file.name for file in files}
    known = {quantity: values for _, quantity, _, values in together.figures}
    assert known["gauge_reaction_peak"] == pytest.approx([1000.0, 1000.0])
    first, second = known["gauge_reaction_arrival"]
    assert second - first == pytest.approx(0.1, abs=0.011)


def test_the_report_has_a_table_of_probes(folder):
    result = CliRunner().invoke(main, ["report", str(folder), "--smooth", "0.05"])
    assert result.exit_code == 0, result.output
    page = (folder / "postprocess" / "report.html").read_text()
    assert "<h3>Probes</h3>" in page
    assert "0.05 s" in page
    assert "gauge" in page
