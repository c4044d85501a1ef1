"""Members of a study on workers: computed once, and reported if they fail."""

import json
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import monotonic, sleep

import pytest
import tomli_w

from debrisflow import Sweep
from debrisflow.errors import OutputError
from debrisflow.run.loop import program
from debrisflow.study import engine
from debrisflow.study.computing import compute
from debrisflow.study.engine import computed
from debrisflow.study.outcome import FAILED, FINISHED, STOPPED
from debrisflow.study.plan import plan_figures
from debrisflow.study.status import sweep_status

pytest.importorskip("distributed")
WATER = {
    "title": "a block of water that collapses",
    "particles": {"spacing": 0.02},
    "geometry": {"type": "tank3d", "length": 0.4, "width": 0.1, "height": 0.3},
    "fill": [
        {
            "type": "block",
            "x": [0.0, 0.1],
            "y": [0.0, 0.1],
            "z": [0.0, 0.2],
            "material": "water",
        }
    ],
    "scheme": {"type": "explicit"},
    "time": {"end": 0.2},
    "output": {"interval": 0.1},
}


def study_file(folder, speeds, **more):
    """Write a case and a study of it, in which the speed of sound differs."""
    (folder / "water.toml").write_text(tomli_w.dumps(WATER))
    parameter = {"name": "sound", "key": "scheme.sound_speed", "distribution": "values"}
    tables = {
        "title": "speeds of sound",
        "case": "water.toml",
        "parameter": [parameter | {"values": speeds}],
        "design": {"type": "grid"},
    }
    path = folder / "study.toml"
    path.write_text(tomli_w.dumps(tables | more))
    return path


def states_of(results):
    return [outcome.state for outcome in results.outcomes]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Compute three members, one of which cannot be: its fluid is far too soft."""
    folder = tmp_path_factory.mktemp("sweep")
    sweep = Sweep.from_file(study_file(folder, [0.05, 20.0, 25.0]), folder / "swept")
    with sweep.workers(2) as client:
        results = sweep.run(client)
    return sweep, results


def test_one_member_that_diverges_is_reported_and_the_others_are_complete(swept):
    sweep, results = swept
    assert states_of(results) == [FAILED, FINISHED, FINISHED]
    ((member, outcome),) = results.unfinished
    assert member.values == {"sound": 0.05}
    assert "what to do" in outcome.message
    assert (member.folder / "failed.vtu").exists()
    status = sweep_status(sweep.folder)
    assert (status["members"], status["finished"], status["failed"]) == (3, 2, 1)
    assert [one["number"] for one in status["shown"]] == [0]
    table = results.table
    assert list(table.state.values) == [FAILED, FINISHED, FINISHED]
    assert table.front_farthest.isnull().values.tolist() == [True, False, False]
    assert table.front_farthest.attrs["units"] == "m"


def test_what_is_over_is_not_computed_again_and_a_failed_member_neither(swept):
    sweep, results = swept
    files = [one.folder / "member.json" for one in results.members]
    before = [file.stat().st_mtime_ns for file in files]
    told = []
    again = Sweep(sweep.study, sweep.folder)
    with again.workers(1) as client:
        found = again.run(client, told=lambda member, outcome: told.append(member.number))
    assert sorted(told) == [0, 1, 2]
    assert [file.stat().st_mtime_ns for file in files] == before
    assert repr(found.outcomes) == repr(results.outcomes)  # nan is not nan


def test_the_plan_counts_what_is_known_and_no_more_workers_than_members(swept, tmp_path):
    sweep, _ = swept
    known = plan_figures(sweep, 8)
    assert (known["members"], known["known"], known["wall_seconds"]) == (3, 3, 0.0)
    path = study_file(tmp_path, [25.0, 30.0, 35.0])
    further = plan_figures(Sweep.from_file(path, tmp_path / "other", store=sweep.store), 8)
    assert (further["known"], further["workers"]) == (1, 2)
    assert further["wall_seconds"] == further["seconds"]


def test_another_study_with_the_same_store_takes_what_is_there(swept, tmp_path):
    sweep, results = swept
    path = study_file(tmp_path, [25.0, 30.0], title="another title")
    other = Sweep.from_file(path, tmp_path / "other", store=sweep.store)
    assert other.members[0].folder == results.members[2].folder


def test_a_study_that_runs_is_refused_to_a_second_process(swept):
    sweep, _ = swept
    with (
        sweep.open(),
        pytest.raises(OutputError, match="another process"),
        Sweep(sweep.study, sweep.folder).open(),
    ):
        pass


def test_the_command_stopped_in_a_run_goes_on_and_computes_nothing_twice(tmp_path):
    path = study_file(tmp_path, [20.0, 25.0, 30.0], set={"time": {"end": 0.8}})
    command = [sys.executable, "-m", "debrisflow", "sweep", str(path), "-o", str(tmp_path / "out")]
    command += ["--workers", "1", "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert json.loads(process.stdout.readline())["event"] == "member"
    end = monotonic() + 60.0
    while not list(tmp_path.glob("out/members/*/status.json"))[1:] and monotonic() < end:
        sleep(0.02)
    process.terminate()
    process.communicate()
    assert process.returncode == 128 + signal.SIGTERM
    over = {file: file.stat().st_mtime_ns for file in tmp_path.glob("out/members/*/member.json")}
    assert 1 <= len(over) < 3

    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    result = json.loads(done.stdout.splitlines()[-1])
    assert result["finished"] == 3
    assert {file: file.stat().st_mtime_ns for file in over} == over
    logs = [log.read_text().count("threads by") for log in tmp_path.glob("out/members/*/run.log")]
    assert sum(logs) <= 4  # only the run that was stopped was begun twice


def test_workers_that_would_compute_two_members_in_one_process_are_refused(tmp_path):
    from distributed import LocalCluster

    sweep = Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / "out")
    with (
        LocalCluster(
            1, threads_per_worker=2, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
        pytest.raises(OutputError, match="--nthreads 1"),
        sweep.workers(scheduler=cluster.scheduler_address),
    ):
        pass


def test_a_scheduler_that_is_not_there_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "PATIENCE", "1s")
    sweep = Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / "out")
    with (
        pytest.raises(OutputError, match="dask scheduler --host HOST"),
        sweep.workers(scheduler="tcp://127.0.0.1:9"),
    ):
        pass


def test_two_processes_on_one_member_compute_it_once(tmp_path):
    sweep = Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / "out")
    member = sweep.members[0]
    asked = (member.case, member.folder, member.digest, program())
    member.folder.parent.mkdir(parents=True)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = list(pool.map(compute, *zip(asked, asked, strict=True)))
    assert [outcome.state for outcome in found] == [FINISHED, FINISHED]
    assert repr(found[0].answers) == repr(found[1].answers)
    assert (member.folder / "run.log").read_text().count("threads by") == 1


def test_two_studies_on_one_scheduler_each_have_their_members(tmp_path):
    from distributed import Client, LocalCluster

    sweeps = [
        Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / name)
        for name in ("one", "two")
    ]
    with (
        LocalCluster(1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster,
        Client(cluster) as one,
        Client(cluster) as two,
    ):
        found = [
            computed(client, sweep.members, program(), 1)
            for client, sweep in zip((one, two), sweeps, strict=True)
        ]
        states = [[outcome.state for _, outcome in results] for results in found]
    assert states == [[FINISHED] * 2, [FINISHED] * 2]
    assert all((one.folder / "history.csv").exists() for sweep in sweeps for one in sweep.members)


def test_a_member_whose_case_is_not_what_it_was_is_stopped_and_not_kept(tmp_path):
    sweep = Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / "out")
    one, other = sweep.members
    outcome = compute(other.case, one.folder, one.digest, program())
    assert outcome.state == STOPPED
    assert "has changed since the sweep began" in outcome.message
    assert not one.folder.exists()
    assert compute(one.case, one.folder, one.digest, "another").state == STOPPED


def test_a_member_that_another_study_began_goes_on_with_the_files_of_this_one(tmp_path):
    sweep = Sweep.from_file(study_file(tmp_path, [20.0, 25.0]), tmp_path / "out")
    member = sweep.members[0]
    asked = (member.case, member.folder, member.digest, program())
    assert compute(*asked).state == FINISHED
    (member.folder / "member.json").unlink()
    case = member.folder / "case.toml"
    case.write_text(case.read_text().replace("a block of water that collapses", "elsewhere"))
    assert compute(*asked).state == FINISHED
    assert "a block of water that collapses" in case.read_text()
