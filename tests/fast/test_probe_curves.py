"""Curves of probes: running means, what they come to, references; written, drawn and compared."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results import open_run
from debrisflow.results.compare import compare
from debrisflow.results.plots.probes import compared_probes, curves_to_draw, probe_figure
from debrisflow.results.postprocess import postprocess
from debrisflow.results.probe_curves import ProbeCurve, probe_figures, running_mean
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
        (
            "gauge",
            {
                "pressure": 0.5 * pulse(TIME - late),
                "reaction": pulse(TIME - late),
                "reaction_least": 0.0 * TIME,
                "reaction_greatest": 1.5 * pulse(TIME - late),
            },
        ),
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
    np.testing.assert_allclose(running_mean(time, line, 0.1)[inside], line[inside], atol=1e-12)
    values = pulse(time)
    smooth = running_mean(time, values, 0.1)
    assert np.trapezoid(smooth, time) == pytest.approx(np.trapezoid(values, time), rel=1e-3)
    assert smooth.max() < values.max()
    np.testing.assert_array_equal(running_mean(time, values, 0.0), values)
    np.testing.assert_array_equal(running_mean(time[:1], values[:1], 1.0), values[:1])


def curve_of(values, span=0.1, unit="Pa", time=TIME, **known):
    smooth = running_mean(time, values, span)
    extremes = {"least": values, "greatest": values} | known
    return ProbeCurve("p", "c", unit, time, values, smooth, np.nan, span, **extremes)


def figures_of(curve, window=(0.0, 1.0)):
    """Return the figures of a curve that a probe has alone."""
    (row,) = probe_figures([curve], window)
    return row


def test_the_peak_is_that_of_single_steps_where_the_probe_keeps_them():
    values = 0.6 * pulse(TIME)
    curve = curve_of(values, least=values - 900.0, greatest=pulse(TIME))
    row = figures_of(curve)
    assert (row.peak, row.peak_time) == pytest.approx((1000.0, 0.5))
    assert row.smooth_peak < 600.0
    row = figures_of(curve._replace(least=-2.0 * pulse(TIME)))
    assert row.peak == pytest.approx(-2000.0)


def test_a_pulse_has_its_peak_arrival_and_deviation():
    noise = np.where(np.arange(TIME.size) % 2, 1.0, -1.0) * (TIME > 0.7)
    row = figures_of(curve_of(noise - pulse(TIME)), (0.8, 1.0))
    assert row.peak == pytest.approx(-1000.0)
    assert row.peak_time == pytest.approx(0.5)
    assert -1000.0 < row.smooth_peak < -700.0
    assert row.arrival == pytest.approx(0.41)
    assert row.mean == pytest.approx(0.0, abs=0.1)
    assert row.deviation == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("span", [0.0, 0.05, 0.3])
def test_a_step_arrives_when_it_comes_whatever_the_running_mean(span):
    step = np.where(TIME > 0.395, 500.0, 0.0)
    spike = np.where(np.abs(TIME - 0.1) < 1e-9, 600.0, 0.0)  # of a particle that passes
    assert figures_of(curve_of(step, span)).arrival == pytest.approx(0.40)
    if span == 0.3:
        arrival = figures_of(curve_of(step + 0.01 * spike, span)).arrival
        assert arrival == pytest.approx(0.40)


def test_a_wave_arrives_over_standing_water_when_the_level_rises_half_a_spacing():
    # a ripple of a tenth of a spacing runs ahead of a bore that is 1.2 spacings high
    level = 0.05 + 0.001 * (TIME > 0.095) + 0.012 * np.clip((TIME - 0.4) / 0.1, 0.0, 1.0)
    assert figures_of(curve_of(level, unit="m", rise=0.005)).arrival == pytest.approx(0.44)
    falling = figures_of(curve_of(0.06 - level, unit="m", rise=0.005))
    assert np.isnan(falling.arrival)


def test_what_was_dry_is_reached_when_it_is_wet():
    late = TIME[30:]
    row = figures_of(curve_of(2.0 - late, unit="m/s", time=late, was_dry=True))
    assert row.arrival == pytest.approx(0.30)


def test_the_pressure_of_water_that_stood_there_is_no_arrival():
    # the first row of a mean has no step before it
    values = 500.0 * (TIME > 0.0) + np.where(TIME > 0.595, 4000.0, 0.0)
    row = figures_of(curve_of(values, was_pressed=True))
    assert row.arrival == pytest.approx(0.60)


def test_a_component_without_a_share_of_the_force_does_not_arrive():
    values = {"x": pulse(TIME), "y": np.where(np.arange(TIME.size) % 2, 1.0, -1.0)}
    curves = [curve_of(v)._replace(column=f"force_{axis}") for axis, v in values.items()]
    along, across = probe_figures(curves, (0.0, 1.0))
    assert along.arrival == pytest.approx(0.41)
    assert np.isnan(across.arrival)


def test_what_hardly_changes_has_no_arrival():
    rng = np.random.default_rng(3)
    for values in (np.full(TIME.size, 0.1), 1000.0 + rng.normal(size=TIME.size)):
        row = figures_of(curve_of(values), (2.0, 3.0))
        assert np.isnan([row.arrival, row.mean, row.deviation]).all()
        assert row.peak == values[np.argmax(np.abs(values))]


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
    assert [float(row["peak"]) for row in rows] == pytest.approx([1500.0, 500.0, 0.1])
    impulses = [float(row["impulse"]) for row in rows]
    assert impulses[:2] == pytest.approx([100.0, 50.0])
    assert np.isnan(impulses[2])


def test_means_since_the_row_before_stand_in_the_middle_of_their_time(found):
    mean, sample = found.probe_curves[:2]
    np.testing.assert_allclose(mean.time[1:], TIME[1:] - 0.005)
    np.testing.assert_allclose(sample.time, TIME)


def test_a_reference_of_a_probe_has_distance_shift_and_band(tmp_path, found):
    late = 0.5 * pulse(TIME - 0.05)
    given = reference(
        tmp_path / "flume.csv",
        gauge__pressure=late,
        gauge__pressure__low=np.where(TIME[3] == TIME, np.nan, late - 150.0),
        gauge__pressure__high=late + 150.0,
    )
    (row,) = distances(found, given)
    ours = 0.5 * pulse(TIME)
    assert row.rms == pytest.approx(np.sqrt(np.mean((ours - late) ** 2)), rel=1e-6)
    assert row.shift == pytest.approx(0.05, abs=1e-9)
    assert row.shifted_rms == pytest.approx(0.0, abs=1e-9)
    assert row.in_band == pytest.approx(np.mean(np.abs(ours - late) <= 150.0))
    files, lines = postprocess(found, [given])
    assert "probes.png" in {file.name for file in files}
    (line,) = (line for line in lines if "gauge.pressure" in line)
    assert "if the run is moved by +0.05 s" in line
    assert "of the points within the band" in line


def test_a_shift_does_not_win_by_leaving_out_the_worst_point(tmp_path, found):
    (row,) = distances(found, reference(tmp_path / "steady.csv", gauge__pressure=0.0 * TIME + 7.0))
    assert row.shift == 0.0


def test_a_shift_is_a_share_of_the_time_that_run_and_reference_have_in_common(tmp_path, found):
    given = reference(tmp_path / "flume.csv", gauge__pressure=0.5 * pulse(TIME - 0.05))
    longer = {name: np.append(values, values[-1]) for name, values in given.table.items()}
    longer["time"][-1] = 20.0 * TIME[-1]
    (row,) = distances(found, given._replace(table=longer))
    assert (row.shift, row.shifted_rms) == pytest.approx((0.05, 0.0), abs=1e-9)


def test_a_shift_that_brings_nothing_is_none(found, tmp_path):
    given = reference(tmp_path / "own.csv", gauge__pressure=0.5 * pulse(TIME))
    _, lines = postprocess(found, [given])
    (line,) = (line for line in lines if "gauge.pressure" in line)
    assert "rms 0 (0.0% of the reference's range) at" in line
    assert line.endswith("moving the run in time brings it no nearer")


def test_every_column_of_a_probe_can_be_compared_and_is_drawn(tmp_path, found):
    given = reference(tmp_path / "wire.csv", level__height=0.1 + 0.0 * TIME)
    (row,) = distances(found, given)
    assert row.rms == pytest.approx(0.0, abs=1e-12)
    drawn = [(curve.probe, curve.column) for curve in curves_to_draw(found, [given])]
    assert drawn[-2:] == [("level", "filled_height"), ("level", "height")]


def test_what_is_zero_all_the_time_is_drawn_only_alone_or_where_it_is_measured(tmp_path):
    some, none = curve_of(pulse(TIME)), curve_of(0.0 * TIME)._replace(column="other")
    labels = [
        probe_figure(curves, given).axes[0].get_legend_handles_labels()[1]
        for curves, given in (
            ([some, none], []),
            ([none], []),
            ([some, none], [reference(tmp_path / "flume.csv", p__other=TIME)]),
        )
    ]
    assert labels == [["c"], ["other"], ["c", "other", "flume: other"]]


def test_a_reference_of_other_times_is_told(tmp_path, found):
    given = reference(tmp_path / "clock.csv", gauge__pressure=pulse(TIME))
    given.table["time"] += 50.0
    _, lines = postprocess(found, [given])
    assert any("gauge.pressure" in line and "no points within its range" in line for line in lines)


def test_a_curve_of_the_front_has_a_shift_and_no_band(tmp_path, found):
    front = np.interp(TIME, found.fronts["time"], found.fronts["front_all"])
    (row,) = distances(found, reference(tmp_path / "front.csv", front_all=front))
    assert (row.rms, row.shift, row.shifted_rms) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert np.isnan(row.in_band)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gauge__reactoin", r"probe gauge has no column reactoin, .*; did you mean 'reaction'\?"),
        ("gaug__reaction", r"has no probe gaug; .*; did you mean 'gauge'\?"),
        ("gauge", "no column gauge to compare with among front_liquid, .*, PROBE.COLUMN"),
        ("gauge__reaction__low", "column gauge.reaction.low is a side of the band of gauge.reac"),
    ],
)
def test_a_column_that_no_probe_has_ends_in_an_error(tmp_path, folder, found, name, message):
    with pytest.raises(OutputError, match=message):
        distances(found, reference(tmp_path / "flume.csv", **{name: TIME}))
    arguments = ["postprocess", str(folder), "--reference", str(tmp_path / "flume.csv")]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 3
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("rows", "left"),
    [
        ("time,pressure\n0,1\n0.5,2\n", ["pressure", "filled_height"]),  # an older version's
        ("time,pressure,reaction\n", ["filled_height"]),
        ("time,pressure,reaction\n0,1,nan\n", ["pressure", "filled_height"]),  # on a mesh
    ],
)
def test_what_has_no_samples_is_left_out_and_told(tmp_path, rows, left):
    path = of_run(tmp_path / "run")
    (path / "probes" / "gauge.csv").write_text(rows)
    found = survey(open_run(path))
    assert [curve.column for curve in found.probe_curves] == left
    postprocess(found)
    with pytest.raises(OutputError, match=r"gauge has no samples of reaction"):
        distances(found, reference(tmp_path / "flume.csv", gauge__reaction=TIME))


@pytest.mark.parametrize("value", ["nan", "inf", "-1"])
def test_a_running_mean_needs_a_time(folder, value):
    result = CliRunner().invoke(main, ["postprocess", str(folder), "--smooth", value])
    assert result.exit_code == 2


def test_runs_are_compared_by_the_probes_that_they_share(tmp_path, folder):
    other = of_run(tmp_path / "late", late=0.1)
    runs = [survey(open_run(path)) for path in (folder, other)]
    together, files = compare(runs, tmp_path / "comparison")
    assert "probes.png" in {file.name for file in files}
    known = {quantity: values for _, quantity, _, values in together.figures}
    assert known["gauge_reaction_peak"] == pytest.approx([1500.0, 1500.0])
    first, second = known["gauge_reaction_arrival"]
    assert second - first == pytest.approx(0.1, abs=0.011)


def compared(folders, given, target):
    """Run the command that compares runs with references."""
    options = [part for path in given for part in ("--reference", str(path))]
    return CliRunner().invoke(main, ["compare", *map(str, folders), *options, "-o", str(target)])


def test_runs_are_compared_with_references(tmp_path, folder):
    late = of_run(tmp_path / "late", late=0.1)
    high = pulse(TIME) + 50.0
    known = {"gauge__reaction": pulse(TIME), "level__height": 0.11 + 0.0 * TIME}
    band = {"gauge__reaction__low": pulse(TIME) - 50.0, "gauge__reaction__high": high}
    front = np.interp(TIME, [0.0, 1.0], [1.99, 2.99])
    reference(tmp_path / "flume.csv", **known, **band, front_all=front)
    result = compared([folder, late], [tmp_path / "flume.csv"], tmp_path / "both")
    assert result.exit_code == 0, result.output
    with (tmp_path / "both/distances.csv").open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [(row["run"], row["curve"]) for row in rows] == [
        (run, curve)
        for run in ("run", "late")
        for curve in ("gauge.reaction", "level.height", "front_all")
    ]
    found = {(row["run"], row["curve"]): row for row in rows}
    assert float(found["late", "gauge.reaction"]["shift"]) == pytest.approx(-0.1, abs=0.01)
    assert float(found["run", "level.height"]["rms"]) == pytest.approx(0.01)
    assert float(found["run", "front_all"]["rms"]) == pytest.approx(0.0, abs=1e-6)
    assert float(found["run", "gauge.reaction"]["in_band"]) > 0.8
    assert "distance to flume, gauge.reaction, late: rms" in result.output
    assert "if the run is moved by -0.0" in result.output
    assert "of the points within the band" in result.output
    assert {"references.png", "probes.png"} <= {file.name for file in (tmp_path / "both").iterdir()}


def test_references_are_drawn_into_the_curves_of_compared_runs(tmp_path, folder):
    late = of_run(tmp_path / "late", late=0.1)
    runs = [survey(open_run(path)) for path in (folder, late)]
    given = [reference(tmp_path / "flume.csv", level__height=0.11 + 0.0 * TIME)]
    figure = compared_probes(runs, ["run", "late"], given)
    first = figure.axes[0]  # what is measured comes first
    assert first.get_title(loc="left") == "level height"
    assert first.get_legend_handles_labels()[1] == ["run", "late", "flume: height"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gauge__reactoin", "probe gauge has no column reactoin"),
        ("front_al", "no column front_al to compare with among"),
    ],
)
def test_runs_are_not_compared_with_a_column_that_they_lack(tmp_path, folder, name, message):
    reference(tmp_path / "flume.csv", **{name: TIME})
    result = compared([folder, folder], [tmp_path / "flume.csv"], tmp_path / "both")
    assert result.exit_code == 3
    assert message in result.output
    assert "Traceback" not in result.output


def test_the_report_has_a_table_of_probes(folder):
    result = CliRunner().invoke(main, ["report", str(folder), "--smooth", "0.05"])
    assert result.exit_code == 0, result.output
    page = (folder / "postprocess" / "report.html").read_text()
    assert "<h3>Probes</h3>" in page
    assert "0.05 s" in page
    assert "gauge" in page


def test_the_extremes_of_single_steps_do_not_set_the_scale_of_a_panel():
    values = pulse(TIME)
    greatest = np.where(TIME[50] == TIME, 50.0 * values.max(), values)
    figure = probe_figure([curve_of(values, greatest=greatest)], [])
    (low, high), panel = figure.axes[0].get_ylim(), figure.axes[0]
    assert low <= values.min()
    assert values.max() < high < 1.5 * values.max()
    assert panel.collections[0].get_paths()[0].vertices[:, 1].max() == greatest.max()
