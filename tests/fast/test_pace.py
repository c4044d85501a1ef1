"""The wall time that check tells: from the last run of this kind, or from a trial."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow import load_case, simulate
from debrisflow.cli import main
from debrisflow.run import pace
from debrisflow.run.forecast import forecast
from debrisflow.run.pace import Pace, last_pace, remember
from debrisflow.run.trial import measured_pace
from tests.building import tank3d_case, tank_case

A_MINUTE = Pace(particle_steps=6.0e7, steps=6.0e4, seconds=60.0, threads=2)


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Return the file in which paces are kept, which is not there yet."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "debrisflow/rates.json"


def wall_time(*arguments):
    """Return the line that check tells of the wall time."""
    result = CliRunner().invoke(main, ["check", *map(str, arguments)])
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.stdout.splitlines() if line.startswith("wall time")]
    return line


def test_the_last_run_of_a_kind_tells(kept):
    tank = tank_case(20, 10, "water")
    remember(tank, A_MINUTE._replace(seconds=30.0))
    remember(tank, A_MINUTE)
    assert last_pace(tank_case(9, 9, "water")) == A_MINUTE
    assert last_pace(tank3d_case()) is None
    assert last_pace(tank_case(9, 9, "water", scheme={"form": "study"})) is None


def test_runs_of_other_kinds_are_kept_beside_it(kept):
    remember(tank_case(9, 9, "water"), A_MINUTE)
    remember(tank3d_case(), A_MINUTE._replace(steps=9.0))
    assert last_pace(tank_case(9, 9, "water")) == A_MINUTE
    assert last_pace(tank3d_case()).steps == 9.0


def test_a_run_that_is_too_short_tells_nothing(kept):
    remember(tank3d_case(), A_MINUTE._replace(seconds=1.9))
    remember(tank3d_case(), A_MINUTE._replace(steps=0.0))
    assert not kept.exists()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[1]",
        "null",
        '{"3D explicit stable": 3}',
        '{"3D explicit stable": {"steps": 1}}',
        '{"3D explicit stable": {"particle_steps": 1, "steps": 1, "seconds": 0, "threads": 1}}',
        '{"3D explicit stable": {"particle_steps": 1, "steps": 1, "seconds": NaN, "threads": 1}}',
        '{"3D explicit stable": {"particle_steps": "a", "steps": 1, "seconds": 1, "threads": 1}}',
        '{"3D explicit stable": {"particle_steps": 1, "steps": 1, "seconds": 1, "threads": 1e999}}',
    ],
)
def test_a_damaged_file_is_no_error_and_is_mended(kept, text):
    kept.parent.mkdir()
    kept.write_text(text)
    assert last_pace(tank3d_case()) is None
    remember(tank3d_case(), A_MINUTE)
    assert last_pace(tank3d_case()) == A_MINUTE


def test_bytes_that_are_no_text_are_no_error(kept):
    kept.parent.mkdir()
    kept.write_bytes(b"\xff\xfe")
    assert last_pace(tank3d_case()) is None


def test_a_folder_that_cannot_be_written_is_no_error(kept):
    kept.parent.write_text("a file where the folder should be")
    remember(tank3d_case(), A_MINUTE)
    assert last_pace(tank3d_case()) is None


def test_a_user_without_a_home_is_no_error(monkeypatch):
    def nowhere(_):
        raise RuntimeError("could not determine home directory")

    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setattr(Path, "home", classmethod(nowhere))
    remember(tank3d_case(), A_MINUTE)
    assert last_pace(tank3d_case()) is None


@pytest.mark.parametrize(
    ("platform", "folder"),
    [
        ("linux", ".local/state"),
        ("darwin", "Library/Application Support"),
        ("win32", "AppData/Local"),
    ],
)
@pytest.mark.parametrize("given", [None, "", "relative"])
def test_the_folder_is_that_of_the_platform(monkeypatch, tmp_path, platform, folder, given):
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    if given is not None:
        monkeypatch.setenv("XDG_STATE_HOME", given)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.setattr(sys, "platform", platform)
    remember(tank3d_case(), A_MINUTE)
    assert (tmp_path / folder / pace.FILE).is_file()


def test_a_longer_run_is_kept_and_a_file_is_no_part_of_its_results(kept, tmp_path, monkeypatch):
    monkeypatch.setattr(pace, "SHORTEST", 0.0)
    case = load_case("cases/hydrostatic2d.toml", ["time.end=0.004", "output.interval=0.002"])
    told = simulate(case, tmp_path / "run")
    found = last_pace(case)
    assert found.steps == told["steps"] > 0
    assert found.particle_steps / found.seconds == pytest.approx(
        told["particle_steps_per_second"], rel=0.5
    )  # the summary is written a moment before
    assert found.threads == told["threads"]
    assert set(json.loads(kept.read_text())) == {"2D semi-implicit stable"}


def test_check_tells_the_wall_time_with_its_basis(kept, tank):
    assert wall_time(tank) == (
        "wall time      unknown before the first run of this kind here; --measure takes a few steps"
    )
    remember(tank_case(9, 9, "water"), A_MINUTE)
    line = wall_time(tank, "--set", "time.end=100")
    assert line.endswith(
        "at 1e+06 particle-steps/s on 2 threads, from the last run of this kind here"
    )
    told = forecast(load_case(tank, ["time.end=100"]), A_MINUTE)
    least, most = told.wall_time
    a_step = 60.0 * (200 + 150) / (6.0e7 + 150 * 6.0e4)  # 200 particles, and the cost of a step
    assert least == pytest.approx(told.fewest_steps * a_step)
    assert most == pytest.approx(told.steps * a_step)
    assert told.fewest_steps <= told.steps


def test_a_supply_counts_with_the_particles_that_it_brings(kept):
    case = load_case("cases/flume2d.toml")
    told = forecast(case, A_MINUTE)
    assert told.fluid > 1.2 * (told.counts["liquid"] + told.counts["sediment"])


def test_measure_takes_steps_of_the_case_itself(kept, tank, monkeypatch):
    monkeypatch.setattr("debrisflow.run.trial.SECONDS", 0.05)
    remember(tank_case(9, 9, "water"), A_MINUTE)
    assert wall_time(tank, "--measure").endswith("from a trial of this case")
    found = measured_pace(load_case(tank))
    assert found.steps >= 1
    assert found.particle_steps == 200 * found.steps
    assert 0.05 <= found.seconds < 5.0


def test_a_trial_counts_one_step_at_least(kept, tank, monkeypatch):
    monkeypatch.setattr("debrisflow.run.trial.SECONDS", 0.0)
    assert measured_pace(load_case(tank), threads=1)[1:4:2] == (1, 1)


def test_check_without_measure_imports_no_compiler(kept, tank):
    remember(tank_case(9, 9, "water"), A_MINUTE)
    script = (
        "import sys\n"
        "from debrisflow.cli import main\n"
        f"main(['check', {str(tank)!r}], standalone_mode=False)\n"
        "assert 'numba' not in sys.modules\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, timeout=60, capture_output=True, text=True
    )
    assert "from the last run of this kind here" in done.stdout
    assert os.environ["XDG_STATE_HOME"] in str(kept)
