"""Lines of JSON, quiet runs, levels of messages and exit codes: what batch jobs rely on."""

from __future__ import annotations

import io
import json
import logging
import re
import signal
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from debrisflow import errors, simulate
from debrisflow.cli import main
from debrisflow.errors import Interrupted
from debrisflow.run.events import FIELDS, LEDGER
from tests.building import tank_case

SHORT = ["--set", "time.end=0.02", "--set", "output.interval=0.01", "--threads", "1"]
DOUBT = "sediment.density = 2.65 kg/m3: 2650 is usual"
DOUBTFUL = ["--set", "sediment.density=2.65"]
PAGE = Path(__file__).parents[2] / "docs/long_runs.md"


def ran(tank: Path, *more: str) -> Result:
    return CliRunner().invoke(
        main, ["run", str(tank), *SHORT, "-o", str(tank.parent / "run"), *more]
    )


def lines(text: str) -> list[dict]:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    return [json.loads(line, parse_constant=refuse) for line in text.splitlines()]


def test_a_run_is_lines_of_json_and_ends_with_the_summary(tank):
    result = ran(tank, "--json")

    assert result.exit_code == 0, result.output
    events = lines(result.stdout)
    assert events[0]["event"] == "start"
    assert events[0]["state"] == "starting"
    assert {event["event"] for event in events[1:-1]} >= {"progress"}
    for event in events[:-1]:
        assert list(event) == ["event", *(field.name for field in FIELDS)]
        assert list(event["ledger_mass"]) == list(event["ledger_particles"]) == list(LEDGER)
    last, answer = events[-2:]
    assert (last["state"], last["time"], last["reason"]) == (
        "ended",
        0.02,
        "end of the simulated time",
    )
    assert answer["event"] == "result"
    summary = json.loads((tank.parent / "run/summary.json").read_text())
    assert answer == {"event": "result", "folder": str(tank.parent / "run")} | summary
    assert result.stderr == ""


def test_the_balance_closes(tank):
    events = lines(ran(tank, "--json").stdout)[:-1]

    for event in events:
        count, mass = event["ledger_particles"], event["ledger_mass"]
        assert count["difference"] == 0
        assert count["initial"] == 200
        assert count["inside"] == event["particles"]
        assert mass["initial"] == pytest.approx(200 * 0.01**2 * 1000.0)
        assert mass["difference"] == pytest.approx(0.0, abs=1e-9)


def test_what_is_over_is_a_result_too(tank):
    ran(tank)

    result = CliRunner().invoke(main, ["resume", str(tank.parent / "run"), "--json"])

    (answer,) = lines(result.stdout)
    assert (answer["event"], answer["end_reason"]) == ("result", "end of the simulated time")


@pytest.mark.parametrize(
    ("arguments", "kind", "message"),
    [
        (["--set", "time.ende=1"], "CaseError", "did you mean 'end'?"),
        (["--threads", "none"], "BadParameter", "none"),
        (["--quiet"], "UsageError", "--json prints progress and --quiet none"),
    ],
)
def test_errors_are_objects_and_text(tank, arguments, kind, message):
    result = CliRunner().invoke(main, ["run", str(tank), "--json", *arguments])

    assert result.exit_code == 2
    (error,) = lines(result.stdout)
    assert (error["event"], error["exit_code"], error["class"]) == ("error", 2, kind)
    assert message in error["message"]
    assert message in result.stderr


def test_warnings_are_lines_and_text(tank):
    result = ran(tank, "--json", *DOUBTFUL)

    told = [event["message"] for event in lines(result.stdout) if event["event"] == "warning"]
    assert len(told) == 1
    assert told[0].startswith(DOUBT)
    assert result.stderr == f"warning: {told[0]}\n"


def test_a_quiet_run_says_nothing_but_warnings(tank):
    result = ran(tank, "--quiet")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")

    result = ran(tank, "--quiet", "--overwrite", *DOUBTFUL)
    assert result.stdout == ""
    assert result.stderr.startswith(f"warning: {DOUBT}")
    assert result.stderr.count("\n") == 1


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize("stream", [Terminal, io.StringIO])
def test_warnings_stand_in_lines_of_their_own_above_the_bar(tmp_path, monkeypatch, stream):
    shown = stream()
    monkeypatch.setattr("sys.stderr", shown)
    case = tank_case(6, 6, "water", time={"end": 0.002}, sediment={"density": 2.65})
    simulate(case, tmp_path / "run", threads=1)

    text = shown.getvalue()
    assert re.search(rf"(?m)(^|\r)warning: {re.escape(DOUBT)}[^\r]*\n", text)
    assert "100% |" in text.splitlines()[-1]


@pytest.mark.parametrize(
    ("level", "has_steps", "has_start", "has_doubt"),
    [
        ("debug", True, True, True),
        ("info", False, True, True),
        ("warning", False, False, True),
        ("error", False, False, False),
    ],
)
def test_the_level_says_what_is_logged(tank, level, has_steps, has_start, has_doubt):
    before = logging.getLogger("debrisflow").level
    result = ran(tank, "--quiet", "--log-level", level, *DOUBTFUL)

    log = (tank.parent / "run/run.log").read_text()
    assert ("DEBUG step 1:" in log) == has_steps
    assert ("200 fluid of" in log) == has_start
    assert (DOUBT in log) == has_doubt
    assert (DOUBT in result.stderr) == has_doubt
    assert logging.getLogger("debrisflow").level == before


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (RuntimeError("a fault"), 1),
        (errors.CaseError("a case"), 2),
        (errors.OutputError("a disk"), 3),
        (errors.DivergedError("a limit"), 4),
        (errors.NotConvergedError("a system"), 4),
        (Interrupted(signal.SIGINT), 130),
        (KeyboardInterrupt(), 130),
        (Interrupted(signal.SIGTERM), 143),
    ],
    ids=repr,
)
@pytest.mark.parametrize("as_json", [False, True])
def test_each_end_has_its_exit_code(tank, monkeypatch, error, code, as_json):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("debrisflow.run.simulation.simulate", fail)
    result = ran(tank, *(["--json"] if as_json else []))

    assert result.exit_code == code
    assert f"\n| {code} |" in PAGE.read_text(encoding="utf-8")
    if as_json:
        (told,) = lines(result.stdout)
        assert (told["event"], told["exit_code"]) == ("error", code)
        assert told["class"] == type(error).__name__
    else:
        assert result.stdout == ""
    if code > 4:
        assert "goes on with: debrisflow resume" in result.stderr


def test_every_error_has_an_exit_code_that_is_documented():
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type)]
    codes = {kind.exit_code for kind in kinds if issubclass(kind, errors.DebrisflowError)}
    assert codes - {1} == {2, 3, 4}  # 1 is that of the base, which is never raised


def test_a_run_goes_on_when_nobody_reads_its_progress(tmp_path):
    heard = []

    def closed(event):
        heard.append(event)
        raise BrokenPipeError(32, "Broken pipe")

    case = tank_case(6, 6, "water", time={"end": 0.002}, output={"interval": 0.001})
    summary = simulate(case, tmp_path / "run", threads=1, on_event=closed)

    assert summary["end_reason"] == "end of the simulated time"
    assert len(heard) == 1
    assert "WARNING progress is shown no more" in (tmp_path / "run/run.log").read_text()


def test_a_function_takes_the_place_of_the_bar(tmp_path, capsys):
    heard = []
    case = tank_case(6, 6, "water", time={"end": 0.002}, output={"interval": 0.001})
    simulate(case, tmp_path / "run", threads=1, on_event=heard.append)

    assert [heard[0]["event"], heard[-1]["state"]] == ["start", "ended"]
    assert capsys.readouterr() == ("", "")


def test_a_check_and_facts_are_one_object(channel):
    result = CliRunner().invoke(main, ["check", str(channel), "--json", *DOUBTFUL])

    text = CliRunner().invoke(main, ["check", str(channel), *DOUBTFUL]).stdout

    (answer,) = lines(result.stdout)
    assert len(answer["warnings"]) == text.count("\nwarning ")
    assert answer.pop("event") == "result"
    page = PAGE.read_text(encoding="utf-8")
    rows = page.partition("field of `check --json`")[2].partition("\n\n")[0]
    assert set(answer) == set(re.findall(r"`(\w+)`(?=[^|]*\|[^|]*\|[^|]*\|$)", rows, re.M)) - {
        "null"
    }
    assert answer["counts"]["liquid"] > 0
    assert answer["memory"] > 0
    assert answer["steps"] >= answer["fewest_steps"] > 0
    assert any(DOUBT in line for line in answer["warnings"])

    assert all(f"warning        {line}\n" in f"{text}\n" for line in answer["warnings"])

    (facts,) = lines(CliRunner().invoke(main, ["info", "--json"]).stdout)
    assert facts["event"] == "result"
    assert {"debrisflow", "numba", "cores", "cache folder"} <= facts.keys()
