"""Run folders that are running, damaged or empty: read as far as possible, or told in one line."""

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import CaseError, OutputError
from debrisflow.particles.record import Kind
from debrisflow.results import open_run
from debrisflow.results.answers import answers
from debrisflow.results.survey import survey
from debrisflow.run.folder import RunFolder
from debrisflow.run.tables import read_table
from tests.recording import (
    cells,
    channel3d_case,
    channel_case,
    placed,
    record,
    sliding,
    state_of,
)

D0 = 0.02
NOTHING = np.zeros((0, 3))


@pytest.fixture
def run(tmp_path):
    """Return the folder of a run that has written three frames and no summary."""
    case = channel_case()
    particles = placed(case, cells(case, range(50), range(5)), velocity=1.0)
    return record(tmp_path / "run", case, sliding(case, particles, [0.0, 0.1, 0.2]))


def surveyed(folder):
    """Return the survey of a folder and its answers by quantity."""
    found = survey(open_run(folder))
    return found, {row.quantity: row.value for row in answers(found)}


def test_a_running_run_is_read_as_far_as_it_got(run):
    opened = open_run(run)
    assert opened.summary == {}
    assert opened.warnings == []
    np.testing.assert_allclose(opened.times, [0.0, 0.1, 0.2])
    _, told = surveyed(run)
    assert told["front_farthest"] == pytest.approx(49.5 * D0 + 0.2)


@pytest.mark.parametrize("name", ["history", "deposit"])
def test_a_last_line_that_is_half_written_is_left_out(run, name):
    whole = getattr(open_run(run), name)
    with (run / f"{name}.csv").open("a") as file:
        file.write("0.3,17,0.0")
    found = getattr(open_run(run), name)
    assert list(found) == list(whole)
    for column, values in whole.items():
        np.testing.assert_array_equal(found[column], values)
    surveyed(run)


def test_a_damaged_history_is_told(run):
    with (run / "history.csv").open("a") as file:
        file.write("0.3,17\n")
    with pytest.raises(OutputError, match=r"history\.csv is damaged"):
        survey(open_run(run))


@pytest.mark.parametrize("name", ["history", "maxima"])
def test_a_missing_table_is_told(run, name):
    (run / f"{name}.csv").unlink()
    with pytest.raises(OutputError, match=rf"{name}\.csv is missing"):
        surveyed(run)


def test_a_table_that_is_no_text_is_told(run):
    (run / "maxima.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(OutputError, match=r"maxima\.csv cannot be read"):
        surveyed(run)


def test_a_damaged_summary_is_told(run):
    (run / "summary.json").write_text('{"end_reason":')
    with pytest.raises(OutputError, match=r"summary\.json is damaged"):
        _ = open_run(run).summary


@pytest.mark.parametrize("name", ["000000.vtu", "000002.vtu"])
@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_a_truncated_frame_is_told(run, name, share):
    file = run / "vtu" / name
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(OutputError, match=rf"{name} is damaged"):
        survey(open_run(run))


def test_a_frame_without_one_of_its_arrays_is_told(run):
    file = run / "vtu/000001.vtu"
    file.write_bytes(file.read_bytes().replace(b'Name="concentration"', b'Name="Concentration"'))
    with pytest.raises(OutputError, match=r"000001\.vtu is damaged"):
        survey(open_run(run))


def test_the_nearest_frame_and_the_last_are_found_by_time(run):
    opened = open_run(run)
    assert opened.frame().time == opened.frame(0.24).time == pytest.approx(0.2)
    assert opened.frame(0.12).time == pytest.approx(0.1)
    assert [frame.time for frame in opened.frames()] == pytest.approx([0.0, 0.1, 0.2])
    for time in (9.0, -1.0):
        with pytest.raises(OutputError, match=r"no frame at t = .* 3 frames from 0 to 0\.2 s"):
            opened.frame(time)


def test_a_frame_holds_what_was_written(run):
    frame = open_run(run).frame(0.0)
    case = open_run(run).case
    np.testing.assert_array_equal(frame.position, cells(case, range(50), range(5)))
    np.testing.assert_allclose(frame.speed, 1.0)
    assert frame.fluid.all()
    np.testing.assert_array_equal(frame.id, np.arange(250))


def test_warnings_are_those_of_the_log(tmp_path):
    with RunFolder.create(tmp_path, channel_case()) as folder:
        folder.log.info("a step")
        folder.log.warning("it is steep")
        folder.log.error("it is too steep")
    assert open_run(tmp_path).warnings == ["it is steep", "it is too steep"]


def test_a_damaged_case_is_a_case_error(run):
    (run / "case.toml").write_text("title = ")
    with pytest.raises(CaseError, match=r"case\.toml"):
        open_run(run)


def test_a_run_whose_fills_settle_has_fronts_but_no_budget(tmp_path):
    case = channel_case()
    states = sliding(
        case, placed(case, cells(case, range(50), range(5)), velocity=1.0), [-0.2, -0.1]
    )
    found, told = surveyed(record(tmp_path, case, states))
    assert found.budget["time"].size == 0
    np.testing.assert_allclose(found.hydrographs["volume"][found.hydrographs["station"] > 1.0], 0.0)
    assert np.isnan(found.station_figures["arrival"]).all()
    assert "mass_in_water" not in told


def test_a_run_without_sediment_has_no_deposit(tmp_path):
    case = channel_case()
    particles = placed(case, cells(case, range(50), range(5)), Kind.LIQUID, 1.0)
    found, told = surveyed(record(tmp_path, case, sliding(case, particles, [0.0, 0.1])))
    assert not found.has_grains
    assert [name for name in told if "deposit" in name or "sediment" in name] == []
    assert told["mass_inside_water"] == pytest.approx(250 * D0**2 * 1000.0)


@pytest.mark.parametrize("build", [channel_case, channel3d_case])
def test_a_run_without_any_fluid_left_has_no_front(tmp_path, build):
    case = build()
    height = 4.0 * case.particles.spacing
    block = cells(case, range(20), range(4), *([range(4)] if case.dimension == 3 else []))
    assert block[:, case.dimension - 1].max() < height
    states = [
        state_of(case, placed(case, block, velocity=1.0), 0.0),
        state_of(case, placed(case, NOTHING), 0.1),
    ]
    found, told = surveyed(record(tmp_path, case, states))
    assert np.isnan(found.fronts["front_all"][-1])
    assert told["front_farthest_time"] == 0.0
    assert told["deposit_volume"] == 0.0
    assert told["mass_inside_water"] == 0.0


@pytest.mark.parametrize("build", [channel_case, channel3d_case])
def test_a_run_that_never_had_fluid_answers_with_nothing(tmp_path, build):
    case = build()
    found, told = surveyed(record(tmp_path, case, [state_of(case, placed(case, NOTHING))]))
    assert np.isnan([told["front_farthest"], told["fall_height"]]).all()
    assert found.profiles["time"].size == 0
    assert told["kinetic_energy_greatest"] == 0.0


def test_a_single_frame_has_places_but_no_rates(tmp_path):
    case = channel_case()
    states = [state_of(case, placed(case, cells(case, range(50), range(5)), velocity=1.0))]
    found, told = surveyed(record(tmp_path, case, states))
    assert len(found.deposits) == 1
    assert told["front_farthest"] == pytest.approx(49.5 * D0)
    rates = [found.fronts["speed_all"][0], found.momentum["resistance_x"][0]]
    assert np.isnan([*rates, *found.station_figures["discharge_peak"]]).all()


def test_frames_of_the_deposit_are_the_first_the_nearest_and_the_last(run):
    found = survey(open_run(run), times=[0.08, 0.11, 0.24])
    assert [one.time for one in found.deposits] == pytest.approx([0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"stations": [-0.1]}, r"station x = -0\.1 m is outside the domain, 0 to "),
        ({"stations": [50.0]}, r"station x = 50 m is outside the domain"),
        ({"window": (5.0, 6.0)}, r"no frame is between 5 and 6 s: .* has 3 from 0 to 0\.2 s"),
        ({"times": [7.0]}, r"no frame at t = 7 s: .* has 3 frames from 0 to 0\.2 s"),
    ],
)
def test_what_is_asked_for_outside_the_run_is_told(run, options, message):
    with pytest.raises(OutputError, match=message):
        survey(open_run(run), **options)


@pytest.mark.parametrize("kept", [0, 2])
def test_maxima_that_are_cut_off_are_told(run, kept):
    file = run / "maxima.csv"
    head = [line for line in file.read_text().splitlines() if line.startswith(("#", "x"))]
    rows = file.read_text().splitlines()[len(head) :][:kept]
    file.write_text("\n".join([*head, *rows, ""]))
    with pytest.raises(OutputError, match=rf"maxima\.csv is damaged: it has {kept} rows for"):
        answers(survey(open_run(run)))


def test_a_history_without_a_column_is_told(run):
    file = run / "history.csv"
    file.write_text(file.read_text().replace("front_all", "front_none"))
    with pytest.raises(OutputError, match=r"history\.csv has no column front_all"):
        survey(open_run(run))


class TestTables:
    def test_columns_are_found_by_name(self, tmp_path):
        file = tmp_path / "t.csv"
        file.write_text("# head\n\na,b\n1,nan\n2,3e-4\n")
        table = read_table(file)
        np.testing.assert_array_equal(table["a"], [1.0, 2.0])
        np.testing.assert_array_equal(table["b"], [np.nan, 3e-4])

    def test_a_table_of_one_column_or_one_row_is_one(self, tmp_path):
        file = tmp_path / "t.csv"
        file.write_text("a\n1\n2\n")
        np.testing.assert_array_equal(read_table(file)["a"], [1.0, 2.0])
        file.write_text("a,b\n1,2\n")
        assert {name: v.tolist() for name, v in read_table(file).items()} == {"a": [1], "b": [2]}

    def test_a_table_without_rows_has_empty_columns(self, tmp_path):
        file = tmp_path / "t.csv"
        file.write_text("a,b\n")
        assert {name: v.size for name, v in read_table(file).items()} == {"a": 0, "b": 0}

    @pytest.mark.parametrize("text", ["", "# head\n", "a,b", "a,b\n1\n", "a,b\n1,x\n", "a\n1,2\n"])
    def test_what_is_no_table_is_told(self, tmp_path, text):
        file = tmp_path / "t.csv"
        file.write_text(text)
        with pytest.raises(OutputError, match=r"t\.csv is damaged"):
            read_table(file)


class TestCommand:
    def invoked(self, *arguments):
        """Return what the command says; its exit must be one that it intends."""
        result = CliRunner().invoke(main, ["postprocess", *map(str, arguments)])
        assert result.exception is None or isinstance(result.exception, SystemExit)
        return result

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--stations", "1;2"], "not a list of numbers with commas between them"),
            (["--stations", ""], "not a list of numbers"),
            (["--stations", "1,nan"], "not a list of numbers"),
            (["--times", "inf"], "not a list of numbers"),
            (["--window", "1"], "1 has 1 numbers where 2 are needed"),
            (["--window", "1,2,3"], "has 3 numbers where 2 are needed"),
            (["--window", "2,1"], "2,1: an interval must end after it starts"),
        ],
    )
    def test_numbers_that_are_none_are_a_usage_error(self, run, options, message):
        result = self.invoked(run, *options)
        assert result.exit_code == 2
        assert message in result.stderr
        assert not (run / "postprocess").exists()

    def test_a_folder_without_a_run_ends_with_3_and_one_line(self, tmp_path):
        result = self.invoked(tmp_path)
        assert result.exit_code == 3
        assert result.stderr == f"{tmp_path} is no run folder: it holds no case.toml\n"

    def test_a_damaged_frame_ends_with_3(self, run):
        (run / "vtu/000001.vtu").write_text("<VTKFile>")
        result = self.invoked(run)
        assert result.exit_code == 3
        last = result.stderr.splitlines()[-1]
        assert last.endswith("000001.vtu is damaged: it is cut off before its end")

    def test_a_missing_reference_ends_with_3_before_anything_is_read(self, run):
        result = self.invoked(run, "--reference", run / "none.csv")
        assert result.exit_code == 3
        assert result.stderr == f"{run / 'none.csv'} is missing\n"
