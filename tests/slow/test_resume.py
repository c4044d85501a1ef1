"""A run that was stopped, however and wherever, goes on to the bytes of one that was not."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import CaseError, OutputError
from debrisflow.run import checkpoint, loop, simulation
from debrisflow.run.lock import is_locked, locked
from debrisflow.run.names import CHECKPOINT, CHECKPOINT_BEFORE, LOCK, STATUS
from tests.building import bed_case, tank_case

OUTPUT = {"interval": 0.05, "checkpoint_interval": 0.03}
NOT_COMPARED = {"run.log", "summary.json", STATUS, CHECKPOINT, CHECKPOINT_BEFORE}


def bed(end=0.15, **output):
    return bed_case(time={"end": end}, output=OUTPUT | output)


def results(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all results by their names."""
    files = (file for file in folder.rglob("*") if file.is_file() and file.name not in NOT_COMPARED)
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def broken_off(case, folder: Path, interrupt) -> None:
    """Run a case to its interruption."""
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(case, folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """Return the folder of a run without interruption."""
    folder = tmp_path_factory.mktemp("whole")
    simulation.simulate(bed(), folder)
    return folder


def test_without_a_checkpoint_a_run_begins_anew(tmp_path, whole):
    run = tmp_path / "run"
    shutil.copytree(whole, run)
    for name in (CHECKPOINT, CHECKPOINT_BEFORE, "summary.json", "maxima.csv", "deposit.csv"):
        (run / name).unlink(missing_ok=True)
    simulation.resume(run)
    assert results(run) == results(whole)
    assert "begins anew" in (run / "run.log").read_text()


def test_a_run_that_was_stopped_before_its_case_was_written_is_started_again(tmp_path):
    run, case = tmp_path / "run", bed()
    answer = CliRunner().invoke(main, ["resume", str(run)])
    assert answer.exit_code == 3
    assert "stopped before it began; start it with: debrisflow run CASE" in answer.stderr
    assert not run.exists()
    run.mkdir()
    (run / "run.log").touch()
    (run / "case.toml.unfinished").write_text("tit")
    simulation.simulate(case, run)  # without --overwrite
    assert (run / "summary.json").is_file()


def test_a_damaged_checkpoint_gives_way_to_the_one_before(tmp_path, whole):
    run = tmp_path / "run"
    shutil.copytree(whole, run)
    (run / "summary.json").unlink()
    data = bytearray((run / CHECKPOINT).read_bytes())
    data[len(data) // 2] ^= 1
    (run / CHECKPOINT).write_bytes(data)
    simulation.resume(run)
    assert results(run) == results(whole)
    assert "checkpoint_before.h5" in (run / "run.log").read_text()


def test_a_later_end_gives_what_a_longer_run_gives(tmp_path, whole):
    short = tmp_path / "short"
    simulation.simulate(bed(end=0.1), short)
    last = checkpoint.load(short / CHECKPOINT).state.time
    assert last > 0.0
    assert simulation.resume(short, until=0.05) is None
    (short / "summary.json").unlink()
    with pytest.raises(CaseError, match="is before the last checkpoint"):
        simulation.resume(short, until=0.5 * last)
    answer = CliRunner().invoke(main, ["resume", str(short), "--until", "0.15"])
    assert answer.exit_code == 0, answer.output
    assert results(short) == results(whole)


@pytest.mark.parametrize("old", ["seed = 1", "end = 0.15"])
def test_an_edited_case_is_refused_unless_it_is_accepted(tmp_path, interrupt, old):
    run = tmp_path / "run"
    broken_off(bed(), run, interrupt)
    text = (run / "case.toml").read_text()
    (run / "case.toml").write_text(text.replace(old, old + "2"))
    before = results(run)
    if old.startswith("end"):  # says nothing of what has been computed
        simulation.resume(run)
        return
    with pytest.raises(OutputError, match=r"(?s)changes:\n  particles.seed: 1, now 12\n.*accept"):
        simulation.resume(run)
    assert results(run) == before
    answer = CliRunner().invoke(main, ["resume", str(run), "--accept-changes"])
    assert answer.exit_code == 0, answer.output
    assert "changed since the last checkpoint: particles.seed" in (run / "run.log").read_text()


def test_another_version_of_the_program_is_refused(tmp_path, interrupt, monkeypatch):
    run = tmp_path / "run"
    broken_off(bed(), run, interrupt)
    monkeypatch.setattr(loop, "KERNELS", "0123456789abcdef")
    with pytest.raises(OutputError, match=r"the program: debrisflow .*, now .* 0123456789abcdef"):
        simulation.resume(run)


def test_a_second_process_is_refused(tmp_path):
    case = tank_case(6, 6, "water", time={"end": 0.01}, output={"interval": 0.01})
    run = tmp_path / "run"
    with locked(run):
        assert is_locked(run)
        with pytest.raises(OutputError, match="another process is writing"):
            simulation.simulate(case, run)
    assert not is_locked(run)
    (run / LOCK).touch()  # left by a crash
    simulation.simulate(case, run)
    assert not (run / LOCK).exists()


def started_run(folder: Path, case: Path) -> subprocess.Popen[bytes]:
    """Start a run as a process, and return it once it computes."""
    command = ["run", str(case), "-o", str(folder), "--threads", "1"]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "debrisflow", *command],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
    )
    history, deadline = folder / "history.csv", time.monotonic() + 120.0
    while time.monotonic() < deadline and process.poll() is None:
        with suppress(OSError):
            if history.read_text().count("\n") > history.read_text().count("#") + 3:
                return process
        time.sleep(0.02)
    process.kill()
    raise AssertionError(process.communicate()[1].decode())


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)], ids=["SIGTERM", "SIGINT"]
)
def test_a_signal_stops_a_run_where_it_can_be_resumed(tmp_path, number, code):
    from debrisflow.case import dump_case

    case = tmp_path / "case.toml"
    case.write_text(dump_case(bed(end=100.0)))
    run = tmp_path / "run"
    with started_run(run, case) as process:
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == code, errors
    assert errors.decode().endswith(
        "interrupted; a run that has begun goes on with: debrisflow resume RUN\n"
    )
    assert checkpoint.load(run / CHECKPOINT).state.step % 40 == 0


def test_the_second_signal_stops_at_once(tmp_path):
    from debrisflow.case import dump_case

    case = tmp_path / "case.toml"
    case.write_text(dump_case(bed(end=100.0)))
    run = tmp_path / "run"
    with started_run(run, case) as process:
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode in (130, 143, -signal.SIGTERM)  # a shell has 143 for the last
    assert not is_locked(run)
    if (run / CHECKPOINT).exists():
        checkpoint.load(run / CHECKPOINT)


def test_a_link_out_of_a_folder_is_refused_before_anything_is_removed(tmp_path, whole):
    run, away = tmp_path / "run", tmp_path / "away"
    shutil.copytree(whole, run)
    (run / "vtu").rename(away)
    (run / "vtu").symlink_to(away)
    with pytest.raises(OutputError, match="is a link out of the folder of its run"):
        simulation.simulate(bed(), run, overwrite=True)
    assert list(away.iterdir())


def test_a_table_that_is_missing_is_told(tmp_path, whole):
    run = tmp_path / "run"
    shutil.copytree(whole, run)
    for name in ("summary.json", "history.csv"):
        (run / name).unlink()
    simulation.resume(run)
    assert "history.csv is missing: it begins anew" in (run / "run.log").read_text()


def test_another_kind_of_processor_is_told(tmp_path, interrupt, monkeypatch):
    run = tmp_path / "run"
    broken_off(bed(), run, interrupt)
    monkeypatch.setattr(loop, "PROCESSOR", "z80")
    simulation.resume(run)
    assert "from another kind of processor" in (run / "run.log").read_text()
    assert "this one is z80" in (run / "run.log").read_text()
