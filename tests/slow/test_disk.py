"""A disk that is full or a folder that is gone ends a run in plain words, and loses nothing."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow.case import dump_case, load_case
from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.run import disk, loop, simulation
from debrisflow.run.tables import Series
from tests.building import bed_case
from tests.slow.test_resume import results

SMALL = 800_000  # bytes, of a disk that the run below fills


def case_of(folder: Path, interval: float = 0.004) -> Path:
    """Write a case with many frames."""
    output = {"interval": interval, "checkpoint_interval": 0.03}
    path = folder / "bed.toml"
    path.write_text(dump_case(bed_case(time={"end": 0.15}, output=output)))
    return path


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Yield a folder on a file system of its own, in memory."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(folder)]
    if sys.platform != "linux" or subprocess.run(command, capture_output=True).returncode != 0:
        # leave to mount is the system's to give; test_a_table_that_could_not_be_written needs none
        pytest.skip("mounting a file system is not allowed here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def gone_at(step: int, change: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> None:
    """Change the disk after a step of a run."""
    advance = loop.Run._advance

    def changing(run: loop.Run, due: float) -> int:
        iterations = advance(run, due)
        if run.state.step == step:
            change()
        return iterations

    monkeypatch.setattr(loop.Run, "_advance", changing)


def test_a_full_disk_is_told_and_the_run_goes_on_when_there_is_space(tmp_path, small_disk):
    case, run, whole = case_of(tmp_path), small_disk / "run", tmp_path / "whole"
    simulation.simulate(load_case(case), whole)
    answer = CliRunner().invoke(main, ["run", str(case), "-o", str(run)])
    assert answer.exit_code == 3, answer.output
    assert "no space is left on the disk" in answer.stderr
    assert "a run then goes on with: debrisflow resume" in answer.stderr
    assert "Traceback" not in answer.output
    assert "Logging error" not in answer.output
    again = CliRunner().invoke(main, ["resume", str(run)])
    assert again.exit_code == 3, again.output
    assert "of disk space, and 0 MB are free" in again.stderr
    larger = f"remount,size={100 * SMALL}"
    subprocess.run(["mount", "-o", larger, str(small_disk)], check=True)
    answer = CliRunner().invoke(main, ["resume", str(run)])
    assert answer.exit_code == 0, answer.output
    assert results(run) == results(whole)


@pytest.mark.parametrize("interval", [0.002, 0.1])
@pytest.mark.parametrize("is_moved", [False, True])
def test_a_folder_that_is_gone_is_told_and_not_made_again(
    tmp_path, monkeypatch, interval, is_moved
):
    case, run, away = case_of(tmp_path, interval), tmp_path / "run", tmp_path / "away"
    gone_at(30, lambda: run.rename(away) if is_moved else shutil.rmtree(run), monkeypatch)
    answer = CliRunner().invoke(main, ["run", str(case), "-o", str(run)])
    assert answer.exit_code == 3, answer.output
    assert "was removed or moved" in answer.stderr
    assert "debrisflow resume" in answer.stderr
    assert not run.exists()


# a device of Linux: elsewhere nothing else is full without leave to mount
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no disk that is always full")
def test_a_table_that_could_not_be_written_is_told_once():
    series = Series(Path("/dev/full"), ("time",), ())
    with pytest.raises(OutputError, match="no space is left"):
        series.append([(1.0,)])
    series.close()


@pytest.mark.parametrize(("free", "code"), [(1e5, 3), (6e5, 0), (1e9, 0)])
def test_a_run_that_the_disk_cannot_hold_is_refused_before_it_begins(
    tmp_path, monkeypatch, free, code
):
    case, run = case_of(tmp_path, 0.05), tmp_path / "run"
    usage = shutil.disk_usage(tmp_path)._replace(free=int(free))
    monkeypatch.setattr(disk.shutil, "disk_usage", lambda _: usage)
    answer = CliRunner().invoke(main, ["run", str(case), "-o", str(run)])
    assert answer.exit_code == code, answer.output
    assert ("the run needs about 1 MB of disk space" in answer.stderr) == (free < 1e6)
    assert run.exists() == (code == 0)


def test_the_need_of_disk_is_near_what_a_run_writes(tmp_path):
    case = load_case(case_of(tmp_path, 0.002))
    simulation.simulate(case, tmp_path / "run")
    written = sum(file.stat().st_size for file in (tmp_path / "run").rglob("*") if file.is_file())
    assert 0.5 < written / disk.needed(case, 190.0) < 1.2
