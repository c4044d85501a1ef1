"""Feed the readers of run folders with files that nobody vouches for, and count what goes wrong.

python scripts/fuzz_readers.py [--runs N] [--seed S] [--only KIND] [--keep FOLDER] RUN ...

Each input is one of the RUN folders with one of its files changed.  It must end as an error that is
meant for the user, or as a report: a traceback, more than ten seconds, more memory than a bound or
the death of the process counts as found, and makes the exit code 1.  An input follows from seed and
number, so that ``--first NUMBER --runs 1`` repeats it.  Ctrl-C ends it with its counts.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import sys
import time
import traceback
import warnings
from collections import Counter, defaultdict
from contextlib import suppress
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import NoReturn

import click

sys.path.insert(0, str(Path(__file__).parents[1]))

from debrisflow.errors import DebrisflowError
from tests.hostile.mutations import mutated
from tests.hostile.reading import files_read, kind_of, read_all, read_checkpoint

HANG = 10.0  # s of processor time, since the machine may be busy
WAITING = 60  # s that it may take at all
MEMORY = 3 << 30  # bytes of addresses beyond those at the start
IN_MEMORY = Path("/dev/shm")
BATCH = 100  # inputs of a process, whose death loses no more
DRAWN = 0.01  # share of the inputs whose plots are drawn too
OUTCOMES = ("answered", "refused", "traceback", "hang", "death")


class HangError(BaseException):
    """An input takes too long."""


def _hang(*_: object) -> NoReturn:
    raise HangError


def outcome(folder: Path, file: Path, draws: bool) -> tuple[str, str]:
    """Return how the readers take a folder in which a file is changed, and the traceback."""
    signal.setitimer(signal.ITIMER_PROF, HANG)
    signal.alarm(WAITING)
    try:
        if file.suffix == ".h5":
            read_checkpoint(folder)
        else:
            read_all(folder, draws)
        return "answered", ""
    except DebrisflowError as error:
        return ("refused", "") if str(error) and error.exit_code in (2, 3) else ("traceback", "1")
    except HangError:
        return "hang", traceback.format_exc()
    except Exception:  # whatever comes is what a user would have seen as a traceback
        return "traceback", traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.alarm(0)


def work(folders: list[Path], seed: int, numbers: range, place: Path, only: str, told: int) -> None:
    """Feed the readers with inputs, and tell each outcome as a line; ends the process."""
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGALRM, _hang)
    signal.signal(signal.SIGPROF, _hang)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    with os.fdopen(told, "w") as lines:
        for number in numbers:
            random = Random(f"{seed} {number}")
            folder = random.choice(folders)
            files = [f for f in files_read(folder) if only in kind_of(f)]
            if not files:
                continue
            kind = random.choice(sorted({kind_of(file) for file in files}))
            file = random.choice([file for file in files if kind_of(file) == kind])
            others = [one.read_bytes() for one in files_read(folder)]
            copy = place / "run"
            shutil.rmtree(copy, ignore_errors=True)
            shutil.copytree(folder, copy)
            target = copy / file.relative_to(folder)
            target.write_bytes(mutated(file.read_bytes(), random, others))
            print("begun", number, kind, file=lines, flush=True)
            found, trace = outcome(copy, target, random.random() < DRAWN)
            print(found, number, kind, json.dumps(trace), file=lines, flush=True)
    os._exit(0)


@click.command()
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.option("--runs", default=2000, show_default=True, help="Inputs.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=1, show_default=True)
@click.option("--only", default="", help="Only kinds of files with this in their names.")
@click.option("--keep", type=click.Path(path_type=Path), help="Folder of tracebacks.")
def main(
    folders: tuple[Path, ...], runs: int, first: int, seed: int, only: str, keep: Path | None
) -> None:
    """Count outcomes by kind of file, and fail if there is any but an answer or a refusal."""
    counts: defaultdict[str, Counter[str]] = defaultdict(Counter)
    traces: Counter[str] = Counter()
    start, number, end = time.monotonic(), first, first + runs
    in_memory = IN_MEMORY if IN_MEMORY.is_dir() else None
    with suppress(KeyboardInterrupt), TemporaryDirectory(dir=in_memory) as place:
        while number < end:
            numbers = range(number, min(number + BATCH, end))
            number = _batch(list(folders), seed, numbers, Path(place), only, counts, traces)
            done = sum(sum(known.values()) for known in counts.values())
            wrong = sum(sum(known[k] for k in OUTCOMES[2:]) for known in counts.values())
            print(f"\r{done} inputs, {wrong} wrong", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    _print_counts(counts, time.monotonic() - start)
    found = {trace.split("\0")[0]: count for trace, count in traces.most_common()}
    for trace, count in found.items():
        print(f"\n{count} times, for example number {trace}")
    if keep is not None and traces:
        keep.mkdir(parents=True, exist_ok=True)
        (keep / f"tracebacks_{seed}.txt").write_text("\n".join(found), encoding="utf-8")
    sys.exit(1 if traces else 0)


def _batch(
    folders: list[Path],
    seed: int,
    numbers: range,
    place: Path,
    only: str,
    counts: defaultdict[str, Counter[str]],
    traces: Counter[str],
) -> int:
    """Feed inputs in a process of their own, count, and return the number to go on from."""
    reading, told = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            work(folders, seed, numbers, place, only, told)
        finally:
            os._exit(1)
    os.close(told)
    begun: tuple[int, str] | None = None
    with os.fdopen(reading) as lines:
        for line in lines:
            found, at, kind, *rest = line.rstrip("\n").split(" ", 3)
            if found == "begun":
                begun = int(at), kind
                continue
            begun = None
            counts[kind][found] += 1
            if rest[0] != '""':
                _remember(traces, at, kind, json.loads(rest[0]))
    status = os.waitpid(child, 0)[1]
    if begun is None:
        return numbers.stop
    counts[begun[1]]["death"] += 1
    traces[f"{begun[0]} ({begun[1]}): the process died, status {status}"] += 1
    return begun[0] + 1


def _remember(traces: Counter[str], number: str, kind: str, trace: str) -> None:
    """Count a traceback with those that end at the same place."""
    places = [line for line in trace.splitlines() if line.startswith("  File")]
    key = "".join(places[-2:]) + trace.splitlines()[-1].split(":")[0]
    for known in traces:
        if known.split("\0")[-1] == key:
            traces[known] += 1
            return
    traces[f"{number} ({kind}):\n{trace}\0{key}"] += 1


def _print_counts(counts: defaultdict[str, Counter[str]], seconds: float) -> None:
    print(f"{'file':<20}  inputs  " + "  ".join(f"{name:>9}" for name in OUTCOMES))
    total: Counter[str] = Counter()
    for kind, known in sorted(counts.items()):
        total.update(known)
        print(f"{kind:<20}  {sum(known.values()):6d}  " + _columns(known))
    print(f"{'all':<20}  {sum(total.values()):6d}  " + _columns(total) + f"  in {seconds:.0f} s")


def _columns(known: Counter[str]) -> str:
    return "  ".join(f"{known[name]:9d}" for name in OUTCOMES)


if __name__ == "__main__":
    main()
