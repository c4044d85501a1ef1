"""What the commands say of a run on a terrain: a mass that was slid down a slope by hand."""

import csv
import re

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results import open_run
from debrisflow.results.answers import answers
from debrisflow.results.compare import compare
from debrisflow.results.postprocess import postprocess
from debrisflow.results.references import distances, read_reference
from debrisflow.results.survey import survey_of
from debrisflow.results.terrain_answers import terrain_answers
from debrisflow.results.terrain_report import terrain_report
from debrisflow.results.terrain_survey import TerrainSurvey, survey_terrain
from debrisflow.results.words import Words
from debrisflow.run.folder import RunFolder
from debrisflow.run.names import LEDGER
from tests.recording import cells, channel3d_case, placed, record, sliding
from tests.terrain_recording import CELL, FALL, GAUGE, MIDDLE, SOUTH, WEST, slide, sloping_case


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a run that comes to rest 40 m farther down, with a gauge."""
    return slide(tmp_path_factory.mktemp("slope") / "run", probe=[GAUGE | {"interval": 1.0}])


@pytest.fixture(scope="module")
def found(folder):
    return survey_terrain(open_run(folder))


def figures(found):
    return {row.quantity: row for row in answers(found)}


class TestAnswers:
    """The foremost particles, at x = 59.5 m, are spread up to 60.5 m: the next cell has 0.05 m."""

    def test_run_out_along_the_path_and_straight(self, found):
        told = figures(found)
        assert found.path.coords[0] == pytest.approx(MIDDLE)
        assert told["runout_length"].value == pytest.approx(57.5 - 15.0, abs=0.5)
        assert told["reach"].value == pytest.approx(np.hypot(57.5 - 15.0, 2.5))
        assert f"({WEST + 57.5:.1f}, " in told["runout_length"].meaning

    def test_fall_and_travel_from_the_highest_released_cell(self, found):
        """It is one of two at x = 12.5 m; the farthest cell is in the row of the other."""
        told = figures(found)
        assert told["travel_distance"].value == pytest.approx(np.hypot(57.5 - 12.5, 5.0))
        assert told["fall_height"].value == pytest.approx(FALL * (57.5 - 12.5))
        slope = FALL * 45.0 / np.hypot(45.0, 5.0)
        assert told["equivalent_friction"].value == pytest.approx(slope)
        assert told["travel_angle"].value == pytest.approx(np.degrees(np.arctan(slope)))

    def test_a_flow_at_rest_on_the_map_has_come_to_its_end(self, found):
        told = figures(found)
        assert "bound" not in told["runout_length"].meaning

    def test_speed_and_rest(self, found):
        told = figures(found)
        assert told["front_speed_greatest"].value == pytest.approx(5.0, rel=0.2)
        assert told["rest_time"].value == 8.0
        assert told["moving_share_end"].value == 0.0

    def test_the_area_is_that_of_the_cells_ever_reached(self, found):
        # x from 10 to 60 m, y from 15 to 25 m; the cells beside have 0.05 m, which does not count
        area = 10 * 2 * CELL**2
        assert figures(found)["affected_area"].value == found.fronts["area"][-1] == area
        assert found.fronts["area"][0] == 2 * 2 * CELL**2

    def test_greatest_values_have_their_places(self, found):
        told = figures(found)
        # of the outermost row of five a quarter is beside the cell, along x and along y
        assert told["depth_greatest"].value == pytest.approx((4.75 / 5.0) ** 2, rel=1e-3)
        assert told["speed_greatest"].value == pytest.approx(5.0)
        density = 0.4 * 2650.0 + 0.6 * 1000.0
        assert told["pressure_greatest"].value == pytest.approx(density * 25.0 / 1000.0)
        place = re.search(r"\(([\d.]+), ([\d.]+)\)", told["depth_greatest"].meaning)
        assert WEST + 5.0 < float(place[1]) < WEST + 65.0
        assert SOUTH + 15.0 < float(place[2]) < SOUTH + 25.0

    def test_the_deposit_and_the_ledger(self, found):
        told = figures(found)
        assert told["deposit_volume"].value == pytest.approx(100.0, rel=0.02)
        assert told["volume_released"].value == told["volume_at_rest"].value == 100.0
        assert told["volume_left"].value == told["volume_moving"].value == 0.0
        assert told["ledger_error"].value == 0.0

    def test_the_budget_closes_from_the_first_release_on(self, found):
        told = figures(found)
        assert told["mass_in_sediment"].value == pytest.approx(100.0 * 0.4 * 2650.0)
        assert told["mass_inside_water"].value == pytest.approx(100.0 * 0.6 * 1000.0)
        assert told["mass_closure_water"].value == pytest.approx(0.0, abs=1e-6)
        assert told["mass_closure_sediment"].value == pytest.approx(0.0, abs=1e-6)

    def test_what_left_is_told_and_bounds_the_run_out(self, tmp_path):
        left = survey_terrain(open_run(slide(tmp_path / "run", leave=7)))
        told = figures(left)
        assert told["volume_left"].value == 7.0
        assert told["volume_at_rest"].value == 93.0
        assert told["ledger_error"].value == 0.0
        assert told["mass_closure_sediment"].value == pytest.approx(0.0, abs=1e-6)
        assert "a lower bound: some of it left over an edge" in told["runout_length"].meaning

    def test_a_flow_that_still_moves_bounds_the_run_out(self, tmp_path):
        moving = survey_terrain(open_run(slide(tmp_path / "run", stop=20.0)))
        assert moving.mobility.bound == "a lower bound: the flow still moves at the end"


def test_the_flow_along_its_path(found):
    table = found.profile
    s, wet = table["s"], table["width"] > 0.0
    assert np.diff(s[:-1]) == pytest.approx(CELL)
    assert table["elevation"][:5] == pytest.approx(100.0 - FALL * (table["east"] - WEST)[:5])
    assert s[wet].max() == pytest.approx(57.5 - 15.0, abs=CELL)
    assert table["width"][2:6] == pytest.approx(10.0, abs=0.1 * CELL)
    assert table["width"].max() <= 15.0  # what is released above the start is not beside it
    assert np.all(np.diff(table["arrival"][wet]) >= 0.0)
    assert table["arrival"][wet][-1] == pytest.approx(8.0)
    assert np.isnan(table["peak_depth"][~wet]).all()


def test_the_front_in_time(found):
    table = found.fronts
    assert table["time"] == pytest.approx(np.arange(11.0))
    known = ~np.isnan(table["moving_front"])
    assert known.sum() == 8  # at rest nothing moves
    assert np.all(np.diff(table["front"]) >= 0.0)
    assert table["front"][0] == pytest.approx(17.5 - 15.0, abs=0.5)
    apart = table["reach"] - table["moving_front"]
    assert np.all(np.abs(apart[known]) < 1.5 * CELL)


def test_tables_and_plots_are_written(found):
    files, told = postprocess(found)
    names = {file.name for file in files}
    assert names >= {"answers.csv", "front.csv", "path.csv", "budget.csv", "probes.csv"}
    assert names >= {"front.png", "path.png", "ledger.png", "budget.png", "probes.png"}
    assert "profiles.csv" not in names
    assert any(line.startswith("runout_length = 42") for line in told)
    assert not any(line.startswith("section") for line in told)
    with (found.run.folder / "postprocess/answers.csv").open() as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    assert rows[0] == ["quantity", "value", "unit", "meaning"]
    assert ["ledger_error", "0"] in [row[:2] for row in rows]


class TestReferences:
    def test_curves_of_probes_and_of_the_front(self, found, tmp_path):
        lines = ["time,gauge.velocity_x,front", *(f"{t},{5 * t},{47.5}" for t in range(11))]
        (tmp_path / "known.csv").write_text("\n".join(lines))
        speed, front = distances(found, read_reference(tmp_path / "known.csv"))
        assert (speed.curve, front.curve) == ("gauge.velocity_x", "front")
        assert speed.points > 0
        assert front.rms > 0.0
        _, told = postprocess(found, [read_reference(tmp_path / "known.csv")])
        assert any("distance to known, gauge.velocity_x, run: rms" in line for line in told)

    def test_curves_over_a_place_are_refused(self, found, tmp_path):
        (tmp_path / "along.csv").write_text("x,deposit_height\n0,1\n1,1\n")
        with pytest.raises(OutputError, match="curves over the time only, and not over x"):
            postprocess(found, [read_reference(tmp_path / "along.csv")])


class TestReport:
    def test_titles_are_escaped_and_the_map_is_there(self, tmp_path):
        folder = slide(tmp_path / "run", title="a < b & <script>c</script>")
        page = terrain_report(survey_terrain(open_run(folder))).read_text(encoding="utf-8")
        assert "a &lt; b &amp; &lt;script&gt;" in page
        assert "<script>c" not in page
        assert 'id="map"' in page
        assert "Stations" not in page
        for heading in ("Run-out", "Extent", "Deposit", "Ledger", "Budgets"):
            assert f"<h3>{heading}</h3>" in page
        assert "runout length</td>" in page
        assert "Terrain, greatest values, arrival and width along the flow path." in page

    def test_a_page_in_japanese_names_its_figures(self, folder):
        page = terrain_report(survey_terrain(open_run(folder)), language="ja").read_text(
            encoding="utf-8"
        )
        assert f">{Words('ja')('runout length')}</td>" in page
        found = survey_terrain(open_run(folder))
        english, japanese = terrain_answers(found), terrain_answers(found, Words("ja"))
        for heading in ("Run-out", "Extent", "Deposit", "Ledger"):
            for one, other in zip(english[heading], japanese[heading], strict=True):
                assert one.meaning != other.meaning or one.meaning == "H / L"
        for rows in english.values():
            for row in rows:
                assert f">{row.quantity.replace('_', ' ')}</td>" not in page

    def test_a_ledger_that_does_not_add_up_is_warned_of(self, tmp_path):
        folder = slide(tmp_path / "run")
        lines = (folder / LEDGER).read_text().splitlines()
        cells = lines[-1].split(",")
        cells[1] = str(int(cells[1]) + 3)
        (folder / LEDGER).write_text("\n".join([*lines[:-1], ",".join(cells)]) + "\n")
        found = survey_terrain(open_run(folder))
        assert found.ledger_error == 3.0
        assert "the ledger fails to add up by 3 particles" in terrain_report(found).read_text(
            "utf-8"
        )


class TestCommands:
    def test_what_means_nothing_on_a_terrain_is_refused(self, folder):
        told = CliRunner().invoke(main, ["postprocess", str(folder), "--stations", "1,2"])
        assert told.exit_code == OutputError.exit_code
        assert "stations are places along x, and a flow on a terrain follows no axis" in told.output
        told = CliRunner().invoke(main, ["postprocess", str(folder), "--times", "1"])
        assert told.exit_code == OutputError.exit_code
        assert "output.layer_interval keeps the depth at times" in told.output

    def test_a_free_surface_is_refused_before_anything_is_written(self, tmp_path):
        folder = slide(tmp_path / "run")
        told = CliRunner().invoke(main, ["postprocess", str(folder), "--surface"])
        assert told.exit_code == OutputError.exit_code
        assert "of which no free surface can be drawn yet" in told.output
        assert not (folder / "postprocess").exists()

    def test_postprocess_and_compare(self, folder, tmp_path):
        told = CliRunner().invoke(main, ["postprocess", str(folder)])
        assert told.exit_code == 0, told.output
        assert "equivalent_friction = " in told.output
        other = slide(tmp_path / "slow", speed=3.0)
        together = ["compare", str(folder), str(other), "-o", str(tmp_path / "both")]
        told = CliRunner().invoke(main, together)
        assert told.exit_code == 0, told.output
        row = re.search(r"runout_length, m +([\d.]+) +([\d.]+)", told.output)
        assert float(row[1]) - float(row[2]) == pytest.approx(57.5 - 42.5, abs=1.0)
        assert (tmp_path / "both/curves.png").is_file()
        assert (tmp_path / "both/path.png").is_file()

    def test_runs_of_two_kinds_are_not_compared(self, found, tmp_path):
        case = channel3d_case()
        block = placed(case, cells(case, range(4), range(4), range(2)))
        other = survey_of(open_run(record(tmp_path / "run", case, sliding(case, block, [0.0]))))
        assert not isinstance(other, TerrainSurvey)
        with pytest.raises(OutputError, match="a run on a terrain cannot be compared"):
            compare([found, other], tmp_path / "both")

    def test_a_run_without_layers_yet_says_so(self, tmp_path):
        with RunFolder.create(tmp_path / "run", sloping_case(tmp_path)):
            pass
        with pytest.raises(OutputError, match="holds no layers yet"):
            survey_of(open_run(tmp_path / "run"))
