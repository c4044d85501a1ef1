"""The page on a run, and runs beside each other."""

import csv
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results import open_run
from debrisflow.results.compare import compare, table_lines
from debrisflow.results.report import report
from debrisflow.results.survey import survey
from debrisflow.run.names import SUMMARY
from tests.recording import cells, channel3d_case, channel_case, placed, record, sliding

TIMES = np.arange(0.0, 0.55, 0.1)


def recorded(path, speed=1.0, **tables):
    """Write the run of a block that slides along a channel, and return its folder."""
    case = channel_case(notes="Source: nobody.\n\nCalibrated: the speed of the block.", **tables)
    block = placed(case, cells(case, range(20), range(5)), velocity=speed)
    return record(path, case, sliding(case, block, TIMES))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Return the page on a run that is not finished, and of which a picture was rendered."""
    folder = recorded(tmp_path_factory.mktemp("page") / "run", title="a < b & c")
    (folder / "render").mkdir()
    (folder / "render/side.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    return report(survey(open_run(folder))).read_text()


def test_a_page_says_what_was_computed_and_what_is_calibrated(page):
    assert "Calibrated: the speed of the block." in page
    assert re.search(r"particles\.spacing</td><td>0\.02 m</td>", page)
    assert "still running, or interrupted" in page


def test_a_page_holds_its_pictures_and_asks_for_nothing_else(page):
    assert page.count("<img ") == page.count('src="data:image/png;base64,') == 7 + 1
    assert "http" not in re.sub("http://www.w3.org|http-equiv", "", page)
    assert "<link" not in page
    assert "<script" not in page


def test_a_page_states_the_answers(page):
    row = re.search(
        r"front farthest</td><td class=\"number\">([\d.]+)</td>\s*<td[^>]*>m</td>", page
    )
    assert float(row[1]) == pytest.approx(0.5 + 19.5 * 0.02, abs=0.02)


def test_a_page_shows_the_pictures_that_were_rendered_before(page):
    assert 'alt="side"' in page


def test_a_title_with_signs_of_html_is_shown_as_it_is(page):
    assert "<title>a &lt; b &amp; c</title>" in page


class Nesting(HTMLParser):
    """Follows which elements are open."""

    VOID = ("meta", "img")

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_every_element_of_a_page_is_closed(page):
    nesting = Nesting()
    nesting.feed(page)
    assert nesting.open == []


def test_runs_are_compared_by_what_differs_between_them(tmp_path):
    slow = recorded(tmp_path / "slow")
    fast = recorded(tmp_path / "fast", speed=2.0, mixture={"viscosity": 0.5, "concentration": 0.4})
    together, files = compare([survey(open_run(f)) for f in (slow, fast)], tmp_path / "both")
    assert together.names == ["slow", "fast"]
    assert together.differing == [("mixture.viscosity", "0.001 Pa s", "0.5 Pa s")]
    figures = {quantity: values for _, quantity, _, values in together.figures}
    assert figures["front_speed_greatest"] == pytest.approx([1.0, 2.0])
    assert {file.name for file in files} >= {"curves.png", "answers.csv", "parameters.csv"}
    assert all(file.stat().st_size > 50 for file in files)
    with (tmp_path / "both/answers.csv").open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert {row["quantity"]: row["fast"] for row in rows}["front_speed_greatest"] == "2"
    assert any("front_speed_greatest, m/s" in line for line in table_lines(together))


def test_runs_of_the_same_name_are_told_apart(tmp_path):
    folders = [recorded(tmp_path / name / "run") for name in ("a", "b")]
    together, _ = compare([survey(open_run(f)) for f in folders], tmp_path / "both")
    assert together.names == ["a/run", "b/run"]


def test_runs_in_three_dimensions_are_compared_by_their_plans_too(tmp_path):
    folders = []
    for name, speed in (("a", 1.0), ("b", 2.0)):
        case = channel3d_case()
        block = placed(case, cells(case, range(8), range(8), range(4)), velocity=speed)
        folders.append(record(tmp_path / name, case, sliding(case, block, TIMES)))
    _, files = compare([survey(open_run(f)) for f in folders], tmp_path / "both")
    assert "plans.png" in {file.name for file in files}
    mixed = [survey(open_run(f)) for f in (folders[0], recorded(tmp_path / "flat"))]
    with pytest.raises(OutputError, match="of two and of three dimensions"):
        compare(mixed, tmp_path / "mixed")


def test_commands_of_results_say_what_is_wrong(tmp_path):
    folder = recorded(tmp_path / "run")
    (folder / SUMMARY).write_text("{")
    for arguments, code, told in (
        (["report", str(folder)], 3, "summary.json is damaged"),
        (["report", str(tmp_path)], 3, "is no run folder"),
        (["compare", str(folder)], 2, "two runs or more"),
        (["compare", str(folder), str(tmp_path)], 3, "is no run folder"),
    ):
        result = CliRunner().invoke(main, arguments)
        assert result.exit_code == code
        assert told in result.output
        assert result.exception is None or isinstance(result.exception, SystemExit)
