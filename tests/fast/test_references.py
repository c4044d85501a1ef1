"""Distances to curves, and the parameters in which cases differ."""

import numpy as np
import pytest

from debrisflow.errors import OutputError
from debrisflow.results.parameters import differences, parameters, summary
from debrisflow.results.references import dilatant_profile, distances, read_reference
from tests.recording import cells, channel3d_case, channel_case, placed, sliding, surveyed

D0 = 0.02


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return the survey of a sheared layer that slides along a channel."""
    case = channel_case(output={"interval": 0.1, "rest_speed": 0.5})
    position = cells(case, range(100), range(10))
    velocity = np.where(position[:, 1] < 0.06, 0.0, 5.0 * position[:, 1])
    particles = placed(case, position, velocity=velocity)
    folder = tmp_path_factory.mktemp("layer")
    return surveyed(folder, case, sliding(case, particles, 0.1 * np.arange(6)), (0.5, 1.0))


def written(path, text):
    """Return the reference that a file of a text holds."""
    path.write_text(text)
    return read_reference(path)


def as_text(columns):
    """Return columns as the text of a CSV file."""
    names = ",".join(columns)
    rows = (",".join(repr(float(v)) for v in row) for row in zip(*columns.values(), strict=True))
    return "# of a test\n" + "\n".join([names, *rows]) + "\n"


@pytest.mark.parametrize("shift", [0.0, 0.25])
def test_the_distance_to_a_shifted_front_is_the_shift(tmp_path, found, shift):
    curves = {"time": found.fronts["time"], "front_all": found.fronts["front_all"] + shift}
    (row,) = distances(found, written(tmp_path / "seen.csv", as_text(curves)))
    # in the first frame the layer counts as resting where it stands
    assert (row.reference, row.curve, row.ours, row.points) == ("seen", "front_all", "run", 5)
    assert row.rms == pytest.approx(shift, abs=1e-12)
    assert row.share == pytest.approx(shift / np.ptp(curves["front_all"][1:]), abs=1e-12)


def test_a_deposit_is_compared_with_that_of_the_last_frame(tmp_path, found):
    last = found.deposits[-1]
    curves = {"x": last.grid.x, "deposit_height": last.table["deposit_height"] - 0.01}
    (row,) = distances(found, written(tmp_path / "lidar.csv", as_text(curves)))
    assert last.table["deposit_height"].max() == pytest.approx(5 * D0)  # slower than 0.5 m/s
    assert row.ours == "t = 0.5 s"
    assert row.rms == pytest.approx(0.01)


def test_profiles_are_compared_by_station_and_together(tmp_path, found):
    profile = found.pooled_profile
    curves = {"y": profile["y"], "velocity": profile["velocity"] + 0.1}
    rows = distances(found, written(tmp_path / "piv.csv", as_text(curves)))
    assert [row.ours for row in rows] == ["x = 0.5 m", "x = 1 m", "mean of the stations"]
    assert rows[-1].rms == pytest.approx(0.1)


def test_a_scaled_profile_may_have_any_name(tmp_path, found):
    profile = found.pooled_profile
    known = ~np.isnan(profile["y_over_h"])
    curves = {"y_over_h": profile["y_over_h"][known], "theory": profile["u_over_us"][known]}
    rows = distances(found, written(tmp_path / "exact.csv", as_text(curves)))
    assert rows[-1].curve == "theory"
    assert rows[-1].rms == pytest.approx(0.0, abs=1e-12)


def test_only_points_within_the_range_of_the_reference_count(tmp_path, found):
    curves = {"time": [0.15, 0.35], "front_all": [7.0, 7.0]}
    (row,) = distances(found, written(tmp_path / "part.csv", as_text(curves)))
    assert row.points == 2
    assert np.isnan(row.share)  # it does not vary
    curves["time"] = [5.0, 6.0]
    (row,) = distances(found, written(tmp_path / "later.csv", as_text(curves)))
    assert row.points == 0
    assert np.isnan(row.rms)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,front\n0,1\n1,2\n", "reference bad: no column front to compare with among front_"),
        ("x,front_all\n0,1\n1,2\n", "reference bad: no column front_all to compare with"),
    ],
)
def test_a_column_that_we_do_not_have_is_told(tmp_path, found, text, message):
    reference = written(tmp_path / "bad.csv", text)
    with pytest.raises(OutputError, match=message):
        distances(found, reference)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time\n0\n1\n", r"bad\.csv has the one column time: a curve needs two"),
        ("time,front_all\n0,1\n0,2\n", r"bad\.csv: its first column, time, does not increase"),
        ("time,front_all\n1,1\n0,2\n", r"bad\.csv: its first column, time, does not increase"),
        ("station,velocity\n0,1\n1,2\n", r"bad\.csv: its first column is station, and should be"),
        ("time;front_all\n0;1\n", r"bad\.csv is damaged: .* with commas between them"),
        ("time,front_all,p.x\n0,1,\n", r"bad\.csv is damaged: .*, and nan where there is none"),
        ("time,front_all\n", r"bad\.csv has no rows"),
        ("time,front_all", r"bad\.csv has no rows"),
        ("", r"bad\.csv is damaged: it names no columns"),
        ("time,front_all\n0,one\n", r"bad\.csv is damaged"),
        ("time,front_all\n0,1,2\n", r"bad\.csv is damaged"),
    ],
)
def test_a_reference_that_is_no_curve_is_told(tmp_path, text, message):
    with pytest.raises(OutputError, match=message):
        written(tmp_path / "bad.csv", text)


def test_a_reference_that_is_missing_is_told(tmp_path):
    with pytest.raises(OutputError, match=r"gone\.csv is missing"):
        read_reference(tmp_path / "gone.csv")


def test_a_last_line_without_its_end_belongs_to_a_reference(tmp_path):
    reference = written(tmp_path / "typed.csv", "time,front_all\n0,1\n1,2")
    np.testing.assert_array_equal(reference.table["front_all"], [1.0, 2.0])


def test_cases_differ_where_they_were_told_to():
    one = channel_case(slope=10.0)
    other = channel_case(slope=12.5, water={"viscosity": 0.02}, title="another")
    found = {row[0].key: [part.told for part in row] for row in differences([one, other])}
    assert found == {
        "gravity.slope": ["10 degree", "12.5 degree"],
        "water.viscosity": ["0.001 Pa s", "0.02 Pa s"],
    }


def test_equal_cases_do_not_differ():
    assert differences([channel_case(), channel_case(), channel_case()]) == []


def test_what_only_one_case_has_is_a_difference():
    one, other = channel_case(), channel_case(inflow={"depth": 0.1, "velocity": 1.0})
    found = {next(part.key for part in row if part): row for row in differences([one, other])}
    none, depth = found["inflow.depth"]
    assert none is None
    assert depth.told == "0.1 m"
    assert [part and part.told for part in found["inflow"]] == ["none", None]


def test_values_are_told_with_their_unit():
    told = {one.key: one.told for one in parameters(channel_case())}
    assert told["particles.spacing"] == "0.02 m"
    assert told["fill.0.x"] == "0, 0.1 m"
    assert told["gravity.vector"] == "none"
    assert told["obstacle"] == "none"
    assert told["geometry.periodic"] == "no"
    assert told["geometry.type"] == "channel"
    assert all(text for text in told.values())


def test_entries_with_a_name_are_called_by_it():
    level = {"type": "height", "name": "level", "x": 1.0, "interval": 0.1}
    wider = [{"type": "section", "name": "mouth", "x": 1.5, "interval": 0.1}, level | {"size": 0.3}]
    rows = differences([channel_case(probe=[level | {"size": 0.2}]), channel_case(probe=wider)])
    found = {next(part.key for part in row if part): row for row in rows}
    assert [part and part.told for part in found["probe.level.size"]] == ["0.2 m", "0.3 m"]
    assert [part and part.told for part in found["probe.mouth.x"]] == [None, "1.5 m"]


def test_a_case_in_one_line_names_what_matters():
    line = summary(channel3d_case(slope=15.0, inflow={"depth": 0.2, "discharge": 0.05}))
    words = ("d0 = 50 mm", "slope 15°", "water 1000 kg/m³", "supply 0.05 m³/s")
    assert [word for word in words if word not in line] == []


def test_what_is_not_known_of_a_reference_is_left_out(tmp_path, found):
    time, front = found.fronts["time"], found.fronts["front_all"]
    rows = [f"{t!r}, {x + 0.25!r}" for t, x in zip(time.tolist(), front.tolist(), strict=True)]
    rows[0] = f"{time[0]}, nan"
    reference = written(tmp_path / "gap.csv", "\ufefftime, front_all\n" + "\n".join(rows))
    (row,) = distances(found, reference)
    assert row.points == len(rows) - 1
    assert row.rms == pytest.approx(0.25)


def test_a_profile_of_two_layers_has_no_distance(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(100), range(2)), velocity=1.0)
    thin = surveyed(tmp_path, case, sliding(case, particles, [0.0, 0.1]), (1.0,))
    (row,) = distances(thin, dilatant_profile())
    assert row.points == 0
    assert np.isnan(row.rms)


def test_a_deposit_along_x_is_compared_with_the_greatest_across(tmp_path):
    case = channel3d_case()
    particles = placed(case, cells(case, range(40), range(4), range(6)))
    flat = surveyed(tmp_path / "run", case, sliding(case, particles, [0.0, 0.1]))
    (row,) = distances(flat, written(tmp_path / "x.csv", "x,deposit_height\n0,0.3\n1.9,0.3\n"))
    assert row.points == 19
    assert row.rms == pytest.approx(0.0, abs=1e-12)
