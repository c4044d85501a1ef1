"""Stop runs in every way that a computer knows, resume them, and compare their files.

    python scripts/torture.py [--quick] [--seed N] [--kills N] [--terms N] [--full N] [--removed N]
                              [--case 2D] [--folder FOLDER]

Each case runs once without interruption.  Then it runs again and again in folders of its own, is
stopped at moments that the random numbers of ``--seed`` choose, and goes on with ``debrisflow
resume``, or begins anew with ``debrisflow run`` where it was stopped before its case was written.
When a run has come to its end, its files must have the bytes of the run without interruption; only
the log, status and checkpoints are left out, and wall times in the summary.

A run is stopped by

- SIGKILL: in start-up, within the write of a checkpoint, within that of another file, after the
  last step, anywhere.  A kill is aimed by what appears in the folder, and counted by what is found
  there afterwards;
- SIGTERM, one or two, after which the exit code is 143, or that of the signal itself where it comes
  before the program can take it or when all results are there;
- a full disk: the folder is a small file system in memory, and a file takes all that is free but a
  few pages (without leave to mount, a limit on the size of files stands in for it).  The run must
  end with a message and exit code 3, and go on when there is space;
- removing the folder or moving it away: a message, exit code 3, and nothing is made anew there.

After some kills bytes of the last checkpoint are changed: the run goes on from the one before.
A run that cannot be brought to its end, that goes back behind a time at which it was resumed
before, or that cannot be read while it stands is "lost".  The exit code is 1 if anything differs
or is lost.
"""

from __future__ import annotations

import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, sleep

import click
from run_files import differing_files, result_files
from torture_cases import CHANGES, write_case
from torture_disk import fill, remove, small_file_system
from torture_process import CHECKPOINT, LostError, Process, unfinished

from debrisflow.results import open_run

COMPILING = 900.0  # s, for the first process, which may compile kernels
START_UP, IN_CHECKPOINT, IN_WRITING, AT_END, STEPPING = (
    "start-up",
    "within a checkpoint's write",
    "within another write",
    "after the last step",
    "in a step",
)
PHASES = (START_UP, IN_CHECKPOINT, IN_WRITING, AT_END, STEPPING)
WEIGHTS = (18, 22, 18, 5, 37)
QUICK = {"kills": 36, "terms": 4, "full": 3, "removed": 2}


@dataclass
class Torture:
    """The runs of one case, their reference, and what was counted.

    Attributes
    ----------
    counts : Counter
    failures : list of str
    """

    name: str
    work: Path
    random: random.Random
    counts: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    start_up: float = 2.0
    damaged_share: float = 0.1

    def __post_init__(self) -> None:
        """Write the case, and compute it without interruption."""
        self.work.mkdir(parents=True)
        self.case = write_case(self.name, self.work)
        self.reference = self.work / "reference"
        for _ in range(2):  # the first may compile kernels
            shutil.rmtree(self.reference, ignore_errors=True)
            begin = monotonic()
            process = self.start(self.reference)
            if process.wait(COMPILING) != 0:
                raise SystemExit(f"{self.name}: no reference: {process.text()}")
            self.whole = monotonic() - begin
        self.size = sum(f.stat().st_size for f in self.reference.rglob("*") if f.is_file())

    # a process of the command line

    def start(self, folder: Path) -> Process:
        """Start the run of a folder, or its continuation."""
        can_go_on = (folder / "case.toml").exists()
        what = ["resume", str(folder)] if can_go_on else ["run", str(self.case), "-o", str(folder)]
        messages = self.work / "messages.txt"
        log = folder / "run.log"
        mark = log.stat().st_size if log.exists() else 0
        before = unfinished(folder)
        with messages.open("wb") as out:
            popen = subprocess.Popen(
                [sys.executable, "-m", "debrisflow", *what, "--threads", "1"],
                stdout=out,
                stderr=subprocess.STDOUT,
                env=os.environ | {"NUMBA_NUM_THREADS": "1"},
            )
        return Process(folder, popen, messages, mark, before)

    # a run from its start to its end

    def live(self, folder: Path, stop: Callable[[Process], str | None]) -> None:
        """Run in a folder, stopped until nothing stops it any more, and compare its files.

        Parameters
        ----------
        folder : Path
        stop : callable
            Stops a process and returns how, or None if it let it come to its end.
        """
        try:
            latest = -1e9
            while True:
                begun, was_damaged = (folder / CHECKPOINT).exists(), self.has_damaged
                self.has_damaged = False
                process = self.start(folder)
                try:
                    way = stop(process)
                    code = process.wait()
                finally:
                    if not process.has_ended:
                        process.popen.kill()
                        process.popen.wait()
                self.check_messages(process, code, way)
                latest = self.check_resumed(process, begun, latest, was_damaged)
                if code == 0:
                    break
                if folder.exists():
                    self.check_readable(folder)
            self.compare(folder)
            shutil.rmtree(folder, ignore_errors=True)
        except LostError as error:
            self.fail("lost", folder, str(error))

    def check_messages(self, process: Process, code: int, way: str | None) -> None:
        """Check the exit code and what was printed."""
        text = process.text()
        if "Traceback" in text or "Logging error" in text:
            is_own = way != "SIGTERM twice"
            raise LostError(f"traceback{'' if is_own else ' after the second SIGTERM'}: {text}")
        if code == 0:
            return
        # The program takes signals from its start-up until all results are there.
        is_outside = not process.has_started() or process.has_finished()
        expected = {
            "SIGKILL": {-signal.SIGKILL},
            "SIGTERM": {143, -signal.SIGTERM} if is_outside else {143},
            "SIGTERM twice": {143, -signal.SIGTERM},
            "full": {3},
            "removed": {3},
        }.get(way or "", set())
        if code not in expected:
            raise LostError(f"exit code {code} after {way}: {text[-2000:]}")

    def check_resumed(
        self, process: Process, begun: bool, latest: float, was_damaged: bool
    ) -> float:
        """Check that a run went on from its checkpoint, and not from an earlier one than before."""
        with contextlib.suppress(OSError), (process.folder / "run.log").open("rb") as log:
            log.seek(process.mark)
            for line in log.read().decode(errors="replace").splitlines():
                if begun and "begins anew" in line:
                    raise LostError(f"begins anew although there was a checkpoint: {line}")
                if "resumed at t = " in line:
                    time = float(line.partition("resumed at t = ")[2].split()[0])
                    if time < latest - 1e-6 * abs(latest) and not was_damaged:
                        raise LostError(f"{line}, before t = {latest:g} s of an earlier one")
                    return time
        self.has_damaged |= was_damaged
        return latest

    def check_readable(self, folder: Path) -> None:
        """Read a run as post-processing does, while it stands."""
        pvd = folder / "particles.pvd"
        if not (folder / "history.csv").exists() or not pvd.exists():
            return
        try:
            run = open_run(folder)
            assert run.history["time"].size >= 0
            if "DataSet" in pvd.read_text():
                run.frame()
        except Exception as error:
            raise LostError(f"cannot be read while it stands: {error}") from error

    has_damaged = False

    def fail(self, count: str, folder: Path, message: str) -> None:
        """Keep the folder of a run that failed."""
        self.counts[count] += 1
        kept = self.work.parent / f"failed_{self.name}_{len(self.failures)}"
        with contextlib.suppress(OSError, shutil.Error):
            shutil.copytree(folder, kept)
            shutil.copy(self.work / "messages.txt", kept / "messages.txt")
        shutil.rmtree(folder, ignore_errors=True)
        self.failures.append(f"{self.name}: {count}: {message} ({kept})")
        print(self.failures[-1], flush=True)

    def compare(self, folder: Path) -> None:
        """Compare all files with those of the run without interruption."""
        self.counts["runs compared"] += 1
        self.counts["files compared"] += len(result_files(self.reference))
        differing = differing_files(folder, self.reference)
        if differing:
            self.counts["files differing"] += len(differing) - 1
            self.fail("files differing", folder, ", ".join(differing[:10]))

    # ways to stop a process

    def killed(self, process: Process) -> str | None:
        """Kill a process in a phase that is drawn, or ask it to stop by SIGTERM."""
        if self.counts["SIGTERM"] < self.terms and self.random.random() < 0.1:
            return self.terminated(process)
        (aim,) = self.random.choices(PHASES, WEIGHTS)
        if not self.await_phase(process, aim):
            return None
        process.popen.send_signal(signal.SIGKILL)
        if process.wait() == 0:
            return None
        self.counts["SIGKILL"] += 1
        self.counts[self.phase_of(process)] += 1
        self.damage(process.folder)
        return "SIGKILL"

    def await_phase(self, process: Process, aim: str) -> bool:
        """Wait until a process is in a phase; return whether it still runs."""
        chance = self.random.random()
        if aim == START_UP:
            return process.wait_for(lambda: False, chance * self.start_up) or not process.has_ended
        begin = monotonic()
        if not process.wait_for(process.has_started):
            return False
        self.start_up = 0.8 * self.start_up + 0.2 * (monotonic() - begin)
        if aim == AT_END:
            return process.wait_for(lambda: self.is_at_end(process.folder))
        process.wait_for(lambda: False, chance * 1.2)
        if aim == IN_CHECKPOINT:
            process.wait_for(process.is_saving)
            process.wait_for(lambda: False, self.random.choice((0.0, 0.001, 0.003, 0.006)))
        if aim == IN_WRITING:
            process.wait_for(process.is_writing_others)
        return not process.has_ended

    def is_at_end(self, folder: Path) -> bool:
        """Return whether the history of a run has come to its end."""
        last = _last_time(folder)
        return last is not None and last >= _last_time(self.reference)

    def phase_of(self, process: Process) -> str:
        """Return the phase in which a process was killed, by what it has left."""
        if not process.has_started():
            return START_UP
        if process.is_saving():
            return IN_CHECKPOINT
        if self.is_at_end(process.folder):
            return AT_END
        return IN_WRITING if process.is_writing_others() else STEPPING

    def damage(self, folder: Path) -> None:
        """Change bytes of the last checkpoint after some kills, or cut it off."""
        last = folder / CHECKPOINT
        if not (last.exists() and (folder / "checkpoint_before.h5").exists()):
            return
        if self.random.random() > self.damaged_share:
            return
        data = bytearray(last.read_bytes())
        if self.random.random() < 0.3:
            data = data[: self.random.randrange(len(data))]
        else:
            for _ in range(64):
                data[self.random.randrange(len(data))] ^= self.random.randrange(1, 256)
        last.write_bytes(data)
        self.counts["damaged checkpoints"] += 1
        self.has_damaged = True

    def terminated(self, process: Process) -> str | None:
        """Ask a process to stop, some twice."""
        aim = START_UP if self.random.random() < 0.2 else STEPPING
        if not self.await_phase(process, aim):
            return None
        process.popen.send_signal(signal.SIGTERM)
        way = "SIGTERM"
        if self.random.random() < 0.3:
            sleep(self.random.random() * 0.02)
            process.popen.send_signal(signal.SIGTERM)
            way = "SIGTERM twice"
        if process.wait() == 0:
            return None
        self.counts["SIGTERM"] += 1
        return way

    def filled(self, process: Process) -> str | None:
        """Fill the file system of a folder, and make space again when the process has ended."""
        filler = process.folder / "filler"
        if self.counts["full"] >= self.most_full or not self.await_phase(process, STEPPING):
            return None
        fill(filler, left=self.random.randrange(0, 100_000))
        code = process.wait()
        filler.unlink()
        if code == 0:
            return None
        if "space" not in process.text().lower():
            raise LostError(f"says nothing of the disk: {process.text()[-2000:]}")
        self.counts["full"] += 1
        return "full"

    def removed(self, process: Process) -> str | None:
        """Remove the folder of a process, or move it away."""
        if self.counts["removed"] >= self.most_removed:
            return None
        if not self.await_phase(process, STEPPING):
            return None
        away = self.work / "away"
        if self.random.random() < 0.5:
            process.folder.rename(away)
        else:
            remove(process.folder)
        code = process.wait()
        shutil.rmtree(away, ignore_errors=True)
        if code == 0:
            raise LostError("came to its end although its folder was removed")
        if "removed" not in process.text() and "moved" not in process.text():
            raise LostError(f"says nothing of the folder: {process.text()[-2000:]}")
        if process.folder.exists():
            left = sorted(str(f) for f in process.folder.rglob("*"))
            raise LostError(f"made its folder anew: {left}; {process.text()[-500:]}")
        self.counts["removed"] += 1
        return "removed"

    # all of them

    def torture(self, kills: int, terms: int, full: int, removed: int) -> None:
        """Stop runs until each way has had its number."""
        self.terms, self.most_full, self.most_removed = terms, full, removed
        self.kill_all(kills)
        if full:
            self.fill_all(full)
        lives = 0
        while removed and self.counts["removed"] < removed and lives < removed:
            self.live(self.work / "removed", self.removed)
            lives += 1

    def kill_all(self, kills: int) -> None:
        """Kill runs until there were as many kills as wanted, and let the last come to its end."""

        def stop(process: Process) -> str | None:
            if self.counts["SIGKILL"] < kills:
                return self.killed(process)
            return self.terminated(process) if self.counts["SIGTERM"] < self.terms else None

        lives = 0
        while self.counts["SIGKILL"] < kills or self.counts["SIGTERM"] < self.terms:
            self.live(self.work / f"run{lives}", stop)
            lives += 1
            print(self.name, dict(self.counts), flush=True)

    def fill_all(self, full: int) -> None:
        """Fill the disk under runs."""
        with small_file_system(self.work / "small", 3 * self.size + 4_000_000) as place:
            lives = 0
            while self.counts["full"] < full and lives < full:
                way = self.filled if place is not None else self.limited
                self.live((place or self.work / "limited") / "run", way)
                lives += 1

    def limited(self, process: Process) -> str | None:
        """Run with a limit on the size of files, where no file system can be mounted."""
        if self.counts["full"] >= self.most_full:
            return None
        limit = self.random.randrange(2_000, 60_000)
        resource.prlimit(process.popen.pid, resource.RLIMIT_FSIZE, (limit, limit))
        if process.wait() == 0:
            return None
        self.counts["full"] += 1
        return "full"


def _last_time(folder: Path) -> float | None:
    """Return the last time in the history of a run, s."""
    with contextlib.suppress(OSError, ValueError), (folder / "history.csv").open("rb") as file:
        file.seek(0, os.SEEK_END)
        file.seek(max(0, file.tell() - 4096))
        return float(file.read().splitlines()[-1].split(b",")[0])
    return None


ROWS = (
    "SIGKILL",
    *PHASES,
    "SIGTERM",
    "full",
    "removed",
    "damaged checkpoints",
    "runs compared",
    "files compared",
    "files differing",
    "lost",
)


def table(counts: dict[str, Counter[str]]) -> str:
    """Return the counts of all cases as lines."""
    total = sum(counts.values(), Counter[str]())
    columns = {**counts, "all": total}
    lines = ["".join([f"{'':30}", *(f"{name:>10}" for name in columns)])]
    for row in ROWS:
        indent = "  " if row in PHASES else ""
        lines.append("".join([f"{indent + row:30}", *(f"{c[row]:10}" for c in columns.values())]))
    return "\n".join(lines)


@click.command()
@click.option("--quick", is_flag=True, help="A reduced form, under four minutes.")
@click.option("--seed", default=1, show_default=True)
@click.option("--kills", default=510, show_default=True)
@click.option("--terms", default=51, show_default=True)
@click.option("--full", default=21, show_default=True)
@click.option("--removed", default=12, show_default=True)
@click.option("--case", "names", multiple=True, type=click.Choice(list(CHANGES)))
@click.option("--folder", type=click.Path(path_type=Path), help="For the runs; a new one.")
def main(
    quick: bool,
    seed: int,
    kills: int,
    terms: int,
    full: int,
    removed: int,
    names: tuple[str, ...],
    folder: Path | None,
) -> None:
    """Stop runs in every way and compare their files with those of runs without interruption."""
    if quick:
        kills, terms, full, removed = QUICK.values()
    names = names or tuple(CHANGES)
    with tempfile.TemporaryDirectory(prefix="torture-") as spare:
        work = folder or Path(spare)
        counts, failures = {}, []
        begin = monotonic()
        for k, name in enumerate(names):
            part = [n // len(names) + (k < n % len(names)) for n in (kills, terms, full, removed)]
            tortured = Torture(name, work / name, random.Random(f"{seed} {name}"))
            tortured.damaged_share = 0.25 if quick else 0.1
            tortured.torture(*part)
            counts[name] = tortured.counts
            failures += tortured.failures
    print(table(counts))
    print(f"seed {seed}, {monotonic() - begin:.0f} s of wall time")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
