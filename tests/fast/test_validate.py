"""``debrisflow validate``: what it says, writes, keeps and refuses; physics has its own rung."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from math import inf, nan
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import CaseError, DivergedError, OutputError
from debrisflow.validation import publication, runner, selection
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.convergence import Step, convergence
from debrisflow.validation.curves import Panel, computed, exact, measured
from debrisflow.validation.page import page
from debrisflow.validation.publication import Validation, results_in
from debrisflow.validation.register import COMPARISONS
from debrisflow.validation.result import Origin, Result, level_result, read_result, write_result
from debrisflow.validation.row import (
    Row,
    Verdict,
    at_least,
    at_most,
    between,
    near,
    none_of,
    stated,
)
from debrisflow.validation.runner import Task, tasks_of

TODAY = Origin("2026-01-02", "1.0", "a processor", "3.11", "ab12")
ROWS = (
    at_most("error of the pressure", 0.008, 0.02, "free surface of particles", "%"),
    near("front", 1.2, 1.0, "scatter", share=0.1, unit="m", miss="no gate, tried two", worst=1.3),
    stated("speed", 3.0, "m/s"),
    none_of("particles lost", 0),
)
PANEL = Panel(
    "front", "t (s)", "x (m)", (exact([0, 1], [0, 2]), measured([0, 1], [0, 3]), computed([0], [1]))
)


def fall(level: Level) -> Measured:
    return Measured(ROWS, level.across**-2.0, (PANEL,))


def broken(_: Level) -> Measured:
    raise DivergedError("particle 3 is nowhere")


def faulty(_: Level) -> Measured:
    raise ZeroDivisionError("by zero")


def wrong(_: Level) -> Measured:
    return Measured((at_most("error", 0.5, 0.1, "resolution", "%"), at_most("other", nan, 1.0, "")))


def comparison(name: str = "tank", measure=fall, group: Group = Group.AT_REST) -> Comparison:
    levels = [Level(n, f"{n} rows", 10.0 / n, is_quick=n == 10) for n in (10, 20, 40)]
    about = "a tank", group, "Pressure over depth.", "Stevin 1586, doi:10.1/tank", "water"
    return Comparison(name, *about, tuple(levels), measure, error="rms of the pressure")


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> dict[str, Comparison]:
    """Put comparisons that take no time in the place of the real ones."""
    found = {
        "tank": comparison(),
        "jet": comparison("jet", group=Group.DAM_BREAKS),
        "broken": comparison("broken", broken),
        "faulty": comparison("faulty", faulty),
        "wrong": comparison("wrong", wrong),
    }
    for module in (publication, runner, selection):
        monkeypatch.setattr(module, "COMPARISONS", found)
    return found


def validate(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(main, ["validate", *arguments], catch_exceptions=False)
    assert done.exit_code == code, done.output
    return done.output


def test_a_row_says_whether_it_is_within():
    verdicts = [row.verdict for row in ROWS]
    assert verdicts == [Verdict.WITHIN, Verdict.KNOWN, Verdict.STATED, Verdict.WITHIN]
    assert at_least("share", 0.5, 0.4, "").verdict is Verdict.WITHIN
    assert between("slope", 3.0, 4.0, 18.4, "").verdict is Verdict.MISSED
    assert none_of("lost", 1).verdict is Verdict.MISSED
    assert none_of("lost", 0).verdict is Verdict.WITHIN


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (1.05, Verdict.WITHIN),
        (1.2, Verdict.KNOWN),
        (1.31, Verdict.MISSED),  # worse than what is known
        (0.8, Verdict.MISSED),  # on the other side
        (nan, Verdict.MISSED),
    ],
)
def test_a_known_miss_excuses_only_what_it_speaks_of(value: float, verdict: Verdict):
    row = near("front", value, 1.0, "scatter", share=0.1, miss="no gate", worst=1.3)
    assert row.verdict is verdict


def test_a_miss_without_a_worst_value_excuses_nothing():
    assert at_most("error", 1.2, 1.0, "scatter", miss="no gate").verdict is Verdict.MISSED


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_what_is_no_number_is_within_no_limit(value):
    assert at_most("error", value, 1.0, "").verdict is Verdict.MISSED
    assert at_least("error", value, 1.0, "").verdict is Verdict.MISSED


def test_limits_about_a_negative_value_are_in_order():
    row = near("shift", -0.08, -0.10, "", share=0.5)
    assert (row.low, row.high) == pytest.approx((-0.15, -0.05))
    assert row.verdict is Verdict.WITHIN


@pytest.mark.parametrize(
    ("row", "limit"),
    [
        (ROWS[0], "at most 2 %"),
        (ROWS[1], "0.9 to 1.1 m"),
        (ROWS[2], ""),
        (at_least("share", 0.5, 0.4, "", "%"), "at least 40 %"),
        (none_of("lost", 0), "0"),
    ],
)
def test_a_limit_in_words(row: Row, limit: str):
    assert row.shown_limit() == limit


def test_an_order_needs_three_levels_and_an_error_that_falls():
    def of(*errors: float) -> str:
        steps = [Step("", 10.0 * 2**k, error, 1.0) for k, error in enumerate(errors)]
        return convergence(steps).in_words()

    assert of(0.4, 0.1, 0.025) == "observed order 2.0"
    assert of(0.4, 0.1).startswith("no order: 2 of the three")
    assert "does not fall" in of(0.1, 0.2, 0.05)
    assert "hardly falls" in of(0.11, 0.105, 0.10)
    assert of(0.1, nan, 0.05).startswith("no order: 2 of the three")


def test_results_are_read_as_they_were_written(tmp_path: Path):
    one = comparison()
    levels = [level_result(level, fall(level), TODAY, 2.0) for level in one.levels]
    result = Result(one, tuple(levels))
    write_result(tmp_path, result)
    assert repr(read_result(tmp_path, one).levels) == repr(result.levels)  # some are nan


def test_a_newer_level_takes_the_place_of_the_older_and_other_kernels_are_left_out(tmp_path: Path):
    one = comparison()
    first, second, third = one.levels
    old = [level_result(level, fall(level), TODAY, 2.0) for level in (first, third)]
    result = Result(one, ()).with_levels(old)
    newer = level_result(second, fall(second), TODAY, 3.0)
    assert [level.label for level in result.with_levels([newer]).levels] == [
        "10 rows",
        "20 rows",
        "40 rows",
    ]
    other = newer._replace(origin=TODAY._replace(kernels="cd34"))
    assert [level.label for level in result.with_levels([other]).levels] == ["20 rows"]


@pytest.mark.parametrize("text", ["{", "[1]", '[{"label": "a"}]', "[[]]"])
def test_damaged_results_are_refused_in_words(tmp_path: Path, text: str):
    one = comparison()
    write_result(
        tmp_path, Result(one, (level_result(one.levels[0], fall(one.levels[0]), TODAY, 1.0),))
    )
    (tmp_path / "results/tank.json").write_text(text)
    with pytest.raises(
        OutputError, match=r"tank\.json: cannot be read .* debrisflow validate tank"
    ):
        read_result(tmp_path, one)


def test_the_quick_set_is_a_part_of_all_and_the_longest_come_first(known):
    every = tasks_of(list(known.values()), is_quick=False)
    quick = tasks_of(list(known.values()), is_quick=True)
    assert set(quick) < set(every)
    assert {task.label for task in quick} == {"10 rows"}
    assert {task.label for task in every[:5]} == {"10 rows"}  # 1 s each, the others less


def test_what_fails_is_told_and_the_others_go_on(known, tmp_path: Path):
    printed = validate(
        "tank", "broken", "faulty", "--quick", "--workers=1", "-o", str(tmp_path), code=5
    )
    assert "broken, 10 rows: particle 3 is nowhere" in printed
    assert "a fault of the program: ZeroDivisionError: by zero" in printed
    assert "1 of 2 rows within their limits (50 %), 1 missed as the table discusses" in printed
    assert "2 not computed" in printed
    assert "| particle 3 is nowhere" not in (tmp_path / "report.html").read_text()
    assert "particle 3 is nowhere" in (tmp_path / "report.html").read_text()


def test_an_unexplained_miss_has_an_exit_code_and_a_known_one_has_none(known, tmp_path: Path):
    printed = validate("tank", "--workers=1", "-o", str(tmp_path))
    assert printed.startswith("levels to compute: 3, of 1 comparisons, 1 at a time; about 2 s")
    assert "why: no gate, tried two" in printed
    printed = validate("wrong", "--quick", "--workers=1", "-o", str(tmp_path), code=5)
    assert "wrong, 10 rows: error, 50 % (at most 10 %)" in printed
    assert "wrong, 10 rows: other, none (at most 1)" in printed


def test_a_folder_keeps_what_it_has_of_others(known, tmp_path: Path):
    validate("tank", "--quick", "--workers=1", "-o", str(tmp_path))
    validate("jet", "--workers=1", "-o", str(tmp_path))
    found = results_in(tmp_path)
    assert [(one.comparison.name, len(one.levels)) for one in found] == [("tank", 1), ("jet", 3)]
    text = (tmp_path / "validation.md").read_text()
    assert text.index("## At rest") < text.index("## Dam breaks and impact")
    for name in ("tank", "jet"):
        assert (tmp_path / f"figures/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert f"](figures/{name}.png)" in text
    with (tmp_path / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 + 12
    assert float(rows[0]["value"]) == 0.008
    assert rows[1]["verdict"] == "missed"


def test_the_page_has_every_row_with_limit_reason_and_reference(known, tmp_path: Path):
    validate("tank", "--workers=1", "-o", str(tmp_path))
    text = (tmp_path / "validation.md").read_text()
    assert (
        "| 10 rows | error of the pressure | 0.8 % | at most 2 % | free surface of particles |"
        in text
    )
    assert "| front | 1.2 m (1 m) | 0.9 to 1.1 m | scatter | **missed** [1] |" in text
    assert text.count("[1] No gate, tried two.") == 1
    assert "[doi:10.1/tank](https://doi.org/10.1/tank)" in text
    assert "observed order 2.0" in text
    assert "At the finest spacing of each alone: 1 of 2 rows" in text
    assert "| a tank | `tank` | 3 of 6 | 1 → 0.25 → 0.0625 % | 2.0 |" in text
    assert "| [At rest](#at-rest) | 6 | 3 | 3 | 3 of 3 |" in text


def test_the_page_of_nothing_says_so():
    assert "Computed never" in page([], ())


def test_json_has_a_line_for_each_level_and_one_for_all(known, tmp_path: Path):
    lines = validate("tank", "--workers=1", "--json", "-o", str(tmp_path)).splitlines()
    told = [json.loads(line) for line in lines]
    assert [one["event"] for one in told] == ["level"] * 3 + ["result"]
    assert told[0]["rows"][0]["measure"] == "error of the pressure"
    assert (told[-1]["within"], told[-1]["known"]) == (3, 3)


def test_the_list_has_groups_names_and_times(known):
    printed = validate("--list")
    assert "At rest (at_rest)" in printed
    assert "Dam breaks and impact (dam_breaks_and_impact)" in printed
    named = json.loads(validate("dam_breaks_and_impact", "--list", "--json"))["comparisons"]
    assert [one["name"] for one in named] == ["jet"]
    assert named[0]["quick_seconds"] == 1.0


def test_a_misspelled_name_is_refused_with_the_likely_one(known):
    assert "did you mean 'tank'" in validate("tanc", code=2)
    with pytest.raises(CaseError, match="debrisflow validate --list"):
        selection.chosen(["nothing"])


def test_what_is_not_in_the_quick_set_is_said(known, monkeypatch, tmp_path: Path):
    slow = comparison("slow")
    slow = replace(slow, levels=tuple(level._replace(is_quick=False) for level in slow.levels))
    monkeypatch.setitem(known, "slow", slow)
    printed = validate("slow", "--quick", "-o", str(tmp_path / "new"), code=2)
    assert "not in the quick set: slow; leave out --quick" in printed
    assert not (tmp_path / "new").exists()


def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_computed(
    known, tmp_path: Path
):
    (tmp_path / "file").write_text("")
    assert "cannot be written" in validate("tank", "-o", str(tmp_path / "file" / "inside"), code=3)


def test_levels_are_added_to_the_folder_as_they_end(known, tmp_path: Path):
    run = Validation.begin(tmp_path, [known["tank"]])
    run.add(
        "tank", level_result(known["tank"].levels[0], fall(known["tank"].levels[0]), TODAY, 1.0)
    )
    assert (tmp_path / "results/tank.json").is_file()


@pytest.mark.parametrize("one", COMPARISONS.values(), ids=COMPARISONS)
def test_a_comparison_says_what_a_reader_needs(one: Comparison):
    assert one.title
    assert one.compared.endswith((".", ")"))
    # a year, as of a paper
    assert re.search(r"\b(1[6-9]|20)\d\d\b|closed form|series|study", one.reference)
    assert one.calibrated
    labels = [level.label for level in one.levels]
    assert len(set(labels)) == len(labels)
    across = [level.across for level in one.levels]
    assert across == sorted(across)
    # three spacings, or the reason why there are fewer
    assert len(set(across)) >= 3 or one.discussion


def test_the_quick_set_leaves_two_of_ten_minutes_to_compilation_on_two_cores():
    quick = [level for one in COMPARISONS.values() for level in one.levels if level.is_quick]
    assert sum(level.seconds for level in quick) < 2 * 480


def test_two_processes_give_what_one_gives():
    tasks = [Task("couette", "10 rows"), Task("film", "10 rows")]
    alone, together = (
        {task: [row.value for row in found.rows] for task, found in runner.compute(tasks, workers)}
        for workers in (1, 2)
    )
    assert together == alone
    assert all(len(values) == 3 for values in alone.values())
