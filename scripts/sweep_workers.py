"""Compute a study on workers that die, stop it, and count what is lost or computed twice.

    python scripts/sweep_workers.py [STUDY] [--folder FOLDER] [--members N]

1. A cluster of two workers on this machine: the wall time beyond that of the runs.
2. A scheduler and two workers as processes of their own, on the loopback; one worker is killed by
   SIGKILL in the middle of a run, and a third one joins.  All members must be there, none computed
   twice, with the bytes of the first sweep.
3. The command line, stopped by SIGTERM when a third of the members are over, and started again:
   nothing is computed again.

Each part has a folder of its own, so that none finds what another has computed.  The exit code is
1 if anything differs, is lost or was computed twice.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic, sleep

import click
from run_files import differing_files, result_files

from debrisflow import Sweep
from debrisflow.study.loading import load_study
from debrisflow.study.names import MEMBERS
from debrisflow.study.outcome import FINISHED, read_outcome

WORKERS = 2
PAUSE = 0.2  # s, between two looks
PATIENCE = 7200.0  # s
LOOPBACK = ("--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0")  # also for the pages


class Failure(SystemExit):
    """What must hold does not."""


def made(study: Path, folder: Path, members: int | None) -> Sweep:
    """Return the sweep of a study in a folder, with its own number of members or another one."""
    stated = load_study(study)
    if members is not None:
        design = stated.design.model_copy(update={"members": members})
        stated = stated.model_copy(update={"design": design})
    return Sweep(stated, folder)


def expect(holds: bool, what: str) -> None:
    """End with a message if something does not hold."""
    print(f"{'holds' if holds else 'FAILS'}: {what}", flush=True)
    if not holds:
        raise Failure(1)


def local(sweep: Sweep) -> None:
    """Compute a sweep on a cluster of this machine, and print its overhead."""
    begin = monotonic()
    with sweep.workers(WORKERS) as client:
        results = sweep.run(client)
    wall = monotonic() - begin
    inside = sum(outcome.seconds for outcome in results.outcomes)
    beyond = 1.0 - inside / (WORKERS * wall)
    ends = sorted((one.folder / "member.json").stat().st_mtime for one in results.members)
    idle = (ends[-1] - ends[-WORKERS]) / (WORKERS * wall)
    expect(len(results.finished) == len(results.members), f"{len(results.finished)} finished")
    print(
        f"{len(results.members)} members, {WORKERS} workers: {wall:.1f} s of wall time, "
        f"{inside:.1f} s of runs; beyond the runs {100 * beyond:.2f} % of the workers' time, of "
        f"which {100 * idle:.2f} % idle at the end, when fewer members than workers were left",
        flush=True,
    )


def dask(*arguments: str, log: Path) -> subprocess.Popen[bytes]:
    """Start a process of dask's command line."""
    with log.open("wb") as out:
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]],
            stdout=out,
            stderr=subprocess.STDOUT,
            env=os.environ | {"NUMBA_NUM_THREADS": "1"},
        )


def worker(address: str, log: Path) -> subprocess.Popen[bytes]:
    """Start a worker without a process that would start it again."""
    return dask("worker", address, "--nthreads", "1", "--no-nanny", *LOOPBACK, log=log)


def scheduler_at(log: Path) -> subprocess.Popen[bytes]:
    """Start a scheduler at any port."""
    return dask("scheduler", "--port", "0", *LOOPBACK, log=log)


def wait_for(text: str, log: Path) -> re.Match[str]:
    """Return where a text stands in a log, once it is there."""
    end = monotonic() + 60.0
    while monotonic() < end:
        if found := re.search(text, log.read_text(errors="replace")):
            return found
        sleep(PAUSE)
    raise Failure(f"{log} has no {text}: {log.read_text(errors='replace')}")


def distributed(sweep: Sweep, reference: Sweep) -> None:
    """Compute a sweep on workers of which one is killed and another joins, and compare."""
    logs = sweep.folder.parent
    processes = [scheduler_at(logs / "scheduler")]
    try:
        address = wait_for(r"tcp://127\.0\.0\.1:\d+", logs / "scheduler")[0]
        processes += [worker(address, logs / f"worker{k}") for k in range(WORKERS)]
        for k in range(WORKERS):
            wait_for("Registered to", logs / f"worker{k}")
        told: list[int] = []

        def tell(member: object, outcome: object) -> None:
            told.append(1)
            if len(told) == len(sweep.members) // 3:
                sleep(2.0)  # into the middle of a run
                processes[1].send_signal(signal.SIGKILL)
                print(f"killed a worker after {len(told)} members; another joins", flush=True)
                processes.append(worker(address, logs / "joined"))

        with sweep.workers(scheduler=address) as client:
            results = sweep.run(client, told=tell)
    finally:
        for process in reversed(processes):
            process.terminate()
        for process in processes:
            process.wait()
    expect(len(told) >= len(sweep.members) // 3 > 0, "a worker was killed")
    expect(len(results.finished) == len(sweep.members), "all members are there")
    begun, resumed = starts(sweep)
    expect(begun == len({m.digest for m in sweep.members}), f"{begun} members begun, none twice")
    expect(resumed <= 1, f"{resumed} member begun anew or resumed, that of the killed worker")
    files, differing = 0, []
    for one, other in zip(sweep.members, reference.members, strict=True):
        files += len(result_files(one.folder))
        differing += [f"{one.folder}: {name}" for name in differing_files(one.folder, other.folder)]
    expect(not differing, f"{files} files, {len(differing)} differ: {differing[:5]}")


def starts(sweep: Sweep) -> tuple[int, int]:
    """Return how many members have run, and how many runs were begun beyond one of each."""
    logs = list(sweep.store.glob("*/run.log"))
    begun = sum(log.read_text().count("threads by") for log in logs)
    return len(logs), begun - len(logs)


def stopped(study: Path, sweep: Sweep, reference: Sweep) -> None:
    """Stop the command line and start it again, and count what is computed twice."""
    command = [sys.executable, "-m", "debrisflow", "sweep", str(study), "-o", str(sweep.folder)]
    command += ["--workers", str(WORKERS), "--quiet"]
    process = subprocess.Popen(command)
    end = monotonic() + PATIENCE
    while len(over(sweep)) < len(sweep.members) // 3 and monotonic() < end:
        sleep(PAUSE)
    process.terminate()
    code = process.wait()
    before = over(sweep)
    expect(code == 143, f"stopped after {len(before)} members, exit code {code}")
    subprocess.run(command, check=True)
    after = over(sweep)
    again = [name for name, time in before.items() if after[name] != time]
    expect(len(after) == len({m.digest for m in sweep.members}), f"{len(after)} members are there")
    expect(not again, f"{len(again)} of {len(before)} computed again")
    differing = [
        name
        for one, other in zip(sweep.members, reference.members, strict=True)
        for name in differing_files(one.folder, other.folder)
    ]
    expect(not differing, f"{len(differing)} files differ from those of the sweep without a stop")


def over(sweep: Sweep) -> dict[str, int]:
    """Return the members that are over, with the time at which that was written."""
    found = {}
    for one in sweep.members:
        outcome = read_outcome(one.folder)
        if outcome is not None and outcome.state == FINISHED:
            found[one.digest] = (one.folder / "member.json").stat().st_mtime_ns
    return found


@click.command()
@click.argument("study", type=click.Path(path_type=Path), default=Path("cases/studies/fan.toml"))
@click.option("--folder", type=click.Path(path_type=Path), help="For the runs; kept.")
@click.option("--members", type=int, help="Instead of the number that the study states.")
def main(study: Path, folder: Path | None, members: int | None) -> None:
    """Compute STUDY in three ways."""
    work = folder or Path(tempfile.mkdtemp(prefix="sweep-"))
    work.mkdir(parents=True, exist_ok=True)
    reference = made(study, work / "local" / "sweep", members)
    local(reference)
    apart = made(study, work / "apart" / "sweep", members)
    apart.folder.mkdir(parents=True, exist_ok=True)
    distributed(apart, reference)
    if members is None:
        stopped(study, made(study, work / "stopped" / "sweep", None), reference)
    print(json.dumps({"folder": str(work), "runs": MEMBERS}))


if __name__ == "__main__":
    main()
