"""``debrisflow status``: of runs that go on, are over, were killed, or never began."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path
from time import process_time

import pytest
from click.testing import CliRunner

from debrisflow import simulate
from debrisflow.cli import main
from debrisflow.commands.console import JsonLines
from debrisflow.errors import DivergedError
from debrisflow.particles.start import initial_state
from debrisflow.run.events import FIELDS
from debrisflow.run.folder_status import MORE_FIELDS, status_of
from debrisflow.run.listeners import Listeners
from debrisflow.run.lock import locked
from debrisflow.run.progress import Progress
from debrisflow.run.status import StatusFile, read_status
from debrisflow.run.status_lines import status_lines
from debrisflow.schemes.clock import Clock
from tests.building import tank_case

TIMES = {"time": {"end": 0.004}, "output": {"interval": 0.001}}


@pytest.fixture
def case():
    return tank_case(6, 6, "water", **TIMES)


@pytest.fixture
def done(case, tmp_path):
    simulate(case, tmp_path / "run", threads=1, on_event=lambda _: None)
    return tmp_path / "run"


def seen(folder: Path) -> tuple[dict, str]:
    """Return what the command says of a folder, as JSON and as text."""
    told = CliRunner().invoke(main, ["status", str(folder), "--json"])
    text = CliRunner().invoke(main, ["status", str(folder)])
    assert told.exit_code == text.exit_code == 0, text.output
    return json.loads(told.stdout), text.stdout


def change(folder: Path, **values: object) -> None:
    path = folder / "status.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def test_a_finished_run(done):
    status, text = seen(done)

    names = [field.name for field in (*FIELDS, *MORE_FIELDS)]
    assert list(status) == ["event", *names]
    assert (status["state"], status["reason"]) == ("ended", "end of the simulated time")
    assert (status["time"], status["end"], status["held"]) == (0.004, 0.004, False)
    assert status["next"] is None
    assert text.splitlines()[0].startswith(f"{done}: ended, ")
    assert "0.004 of 0.004 s, step " in text
    assert "36 initial + 0 entered + 0 released = 36 inside + 0 left + 0 lost\n" in text
    assert "3.6 inside + 0 left + 0 lost kg per meter of width" in text
    assert not list(done.glob("*.unfinished"))


def test_a_run_that_goes_on(case, tmp_path):
    found = []

    def look(event):
        if event["event"] == "progress" and event["state"] == "running" and not found:
            found.extend([status_of(tmp_path / "run"), read_status(tmp_path / "run")])

    simulate(case, tmp_path / "run", threads=1, on_event=look)

    status, written = found
    assert (status["held"], status["state"], status["next"]) == (True, "running", None)
    assert status["particles"] == 36
    assert status["step"] > 0
    assert {name: status[name] for name in written} == written
    assert any("running on" in line for line in status_lines(status))


def test_a_killed_run_says_how_to_go_on(done):
    change(done, state="running", updated="2026-11-30T05:11:20+00:00")

    status, text = seen(done)

    assert status["state"] == "killed"
    assert status["next"] == f"debrisflow resume {done}"
    first, *_, last = text.splitlines()
    when = f"{datetime(2026, 11, 30, 5, 11, 20, tzinfo=UTC).astimezone():%Y-%m-%d %H:%M:%S}"
    assert f"killed on {status['host']}, process {status['process']}, after {when}" in first
    assert last == f"go on with   debrisflow resume {done}".replace("   ", "  ")


def test_a_run_that_has_just_been_resumed(done):
    change(done, state="interrupted")
    assert status_of(done)["next"] is not None
    with locked(done):
        assert status_of(done)["state"] == "starting"


@pytest.mark.parametrize(("silent", "state"), [(5, "running"), (3600, "unknown")])
def test_another_machine_is_believed_for_a_while(done, silent, state):
    updated = (datetime.now(UTC) - timedelta(seconds=silent)).isoformat()
    change(done, state="running", host="elsewhere", updated=updated)

    status, text = seen(done)

    assert (status["state"], status["next"]) == (state, None)
    assert "running on elsewhere" in text


@pytest.mark.parametrize("is_alive", [False, True])
def test_where_no_lock_can_be_seen_the_process_counts(done, monkeypatch, is_alive):
    change(done, state="running", process=4711)
    monkeypatch.setattr("debrisflow.run.folder_status.is_locked", lambda _: None)

    def kill(process: int, number: int) -> None:
        assert (process, number) == (4711, 0)
        if not is_alive:
            raise ProcessLookupError

    monkeypatch.setattr("os.kill", kill)
    assert status_of(done)["state"] == ("running" if is_alive else "killed")


def test_an_interrupted_run(case, tmp_path, interrupt):
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulate(tank_case(6, 6, "water"), tmp_path / "run", threads=1, on_event=lambda _: None)

    status, text = seen(tmp_path / "run")

    assert (status["state"], status["reason"]) == ("interrupted", "interrupted")
    assert status["checkpoint_time"] == status["time"] > 0.0
    assert "go on with  debrisflow resume" in text


def test_a_failed_run(case, tmp_path, monkeypatch):
    monkeypatch.setattr("debrisflow.run.watchdogs.time_step.LEAST_STEP", 2.0)
    with pytest.raises(DivergedError):
        simulate(case, tmp_path / "run", threads=1, on_event=lambda _: None)

    status, text = seen(tmp_path / "run")

    assert status["state"] == "failed"
    assert "the time step has fallen" in status["reason"]
    assert "once the cause is removed" in text


@pytest.mark.parametrize(
    ("removed", "state"),
    [
        ((), "ended"),
        (("summary.json",), "killed"),
        (("summary.json", "history.csv"), "not started"),
    ],
)
def test_a_folder_without_the_file(done, removed, state):
    for name in ("status.json", *removed):
        (done / name).unlink()

    status, text = seen(done)

    assert status["state"] == state
    assert status["title"] == json.loads(json.dumps(status["title"]))
    assert status["end"] == 0.004
    assert status["time"] == (None if state == "not started" else 0.004)
    assert (status["next"] is not None) == (state == "killed")
    assert f"{done}: {state}" in text


def test_a_folder_that_is_none(tmp_path):
    result = CliRunner().invoke(main, ["status", str(tmp_path / "none"), "--json"])

    assert result.exit_code == 3
    assert json.loads(result.stdout)["class"] == "OutputError"
    assert "is no folder" in result.stderr
    assert seen(tmp_path)[0]["state"] == "not started"


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        "[" * 100_000,
        '{"state": "running, surely"}',
        '{"state": "ended", "time": "noon"}',
        '{"state": "ended", "step": 1.5}',
        '{"state": "ended", "time": NaN}',
        '{"state": "ended", "time": 1' + 400 * "0" + "}",
        '{"state": "ended", "ledger_mass": {"initial": 1}}',
        "\udcff",
    ],
    ids=range(10),
)
def test_a_damaged_file_is_an_error_for_people(done, text):
    (done / "status.json").write_bytes(text.encode("utf-8", "surrogateescape"))

    result = CliRunner().invoke(main, ["status", str(done)])

    assert result.exit_code == 3
    assert result.stderr.startswith(f"{done / 'status.json'} is damaged: ")
    assert "Traceback" not in result.stderr


def test_numbers_that_are_none_are_left_out(done):
    ledger = read_status(done)["ledger_mass"] | {"inside": None}
    change(done, time=None, dt=None, rate=None, ledger_mass=ledger)

    _, text = seen(done)

    assert " = ? inside + " in text
    assert "\ntime" not in text


def test_what_is_no_file_is_not_waited_for(done):
    (done / "status.json").unlink()
    os.mkfifo(done / "status.json")
    assert seen(done)[0]["state"] == "ended"


def test_a_file_commands_no_terminal(done):
    change(done, state="failed", reason="\x1b[2Jgone\n\x07")

    _, text = seen(done)

    assert "reason      \\x1b[2Jgone \\x07\n" in text
    assert "\x1b" not in text


def test_writing_is_rare_where_it_is_slow(done, monkeypatch):
    event = {"event": "progress"} | read_status(done)
    file = StatusFile(done)
    assert file.pause == 2.0
    times = iter([0.0, 0.05])
    monkeypatch.setattr("debrisflow.run.status.perf_counter", lambda: next(times))
    file(event)
    assert file.pause == pytest.approx(50.0)


def test_no_folder_is_made_anew_and_no_error_ends_a_run(done, tmp_path):
    event = {"event": "progress"} | read_status(done)

    StatusFile(tmp_path / "gone")(event)
    assert not (tmp_path / "gone").exists()

    (done / "status.json").unlink()
    (done / "status.json").mkdir()
    StatusFile(done)(event)


def test_an_answer_takes_no_solver_and_no_time(done):
    script = (
        "import sys\n"
        "from debrisflow.cli import main\n"
        f"main(['status', {str(done)!r}], standalone_mode=False)\n"
        "heavy = {'numba', 'scipy', 'vtk', 'matplotlib', 'h5py', 'pydantic', 'shapely'}\n"
        "assert not heavy & set(sys.modules)\n"
        "import time\n"
        "assert time.process_time() < 0.7, time.process_time()\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


def test_counting_a_step_costs_little(done, case):
    state = initial_state(case)
    state.dt = 1e-4
    listeners = Listeners([StatusFile(done), JsonLines()])
    with Progress(case, state, Clock(), listeners) as shown:
        shown.count(state)
        before = process_time()
        for _ in range(1000):
            shown.count(state)
        assert process_time() - before < 0.1  # 2 us a step were measured
