"""Feed the loaders of cases with files that nobody vouches for, and count what goes wrong.

python scripts/fuzz.py [--runs N] [--seconds S] [--random] [--quick] [--coverage] [TARGET ...]

With atheris (the extra ``fuzz``) coverage guides the mutations; without it, or with ``--random``,
they are drawn at random from the samples.  Every input must end as an error that is meant for the
user, or as a case that ``debrisflow check`` accepts: a traceback, a hang or a death counts as
found, is kept in the folder of ``--keep`` and makes the exit code 1.
"""

from __future__ import annotations

import faulthandler
import json
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NoReturn

import click

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

HANG = 10.0  # s, in which an input must be done with
DEAD = 3.0 * HANG  # s, after which a hang within a library ends the process
MOST_MEMORY = 8 << 30  # bytes of addresses, beyond which an allocation fails
QUICK = 250  # inputs a target
IN_MEMORY = "/dev/shm"  # where there is one: the inputs wear no disk
LATE = 60.0  # s, by which a process may end after its time
STARTS = 20  # of the process of a target, which a crash ends
INSTRUMENTED = (
    "debrisflow.case",
    "debrisflow.files",
    "debrisflow.results.hazard_classes",
    "debrisflow.results.references",
    "debrisflow.run.tables",
    "meshio.stl",
    "meshio.obj",
    "meshio.ply",
    "tomllib",
)
LOADERS = [
    str(ROOT / "debrisflow" / part)
    for part in ("case/*", "results/references.py", "results/hazard_classes.py")
]


class HangError(BaseException):
    """An input takes too long; no reader may take this for an error of its own."""


class Tally:
    """What the inputs of a target led to, written to a file as it goes.

    Parameters
    ----------
    name : str
        Of the target.
    folder : Path
        Where the loader finds its files.
    kept : Path
        Folder of the inputs that went wrong.
    runs : int
    seconds : float
        Ends of the fuzzing, whichever is first.
    file : Path
        Of the figures.
    """

    def __init__(
        self, name: str, folder: Path, kept: Path, runs: int, seconds: float, file: Path
    ) -> None:
        from debrisflow.errors import DebrisflowError
        from tests.untrusted.targets import targets

        self.target, self.name, self.kept, self.file = targets()[name], name, kept, file
        self.input, self.expected = folder / self.target.file, DebrisflowError
        self.runs, self.end = runs, time.monotonic() + seconds
        self.base = _memory()
        self.found: dict[str, Any] = {"inputs": 0, "accepted": 0, "tracebacks": {}, "hangs": 0}
        signal.signal(signal.SIGALRM, self._hangs)

    def try_one(self, data: bytes) -> None:
        """Give an input to the loader and count what comes of it."""
        self.input.write_bytes(data)
        faulthandler.dump_traceback_later(DEAD, exit=True)
        signal.setitimer(signal.ITIMER_REAL, HANG)
        try:
            self.target.meet(self.input)
            self.found["accepted"] += 1
        except self.expected:
            pass
        except HangError as error:
            self.found["hangs"] += 1
            self._keep(data, error)
        except Exception as error:
            self._keep(data, error)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            faulthandler.cancel_dump_traceback_later()
        self.found["inputs"] += 1
        if self.is_over or self.found["inputs"] % 500 == 0:
            self.write()

    @property
    def is_over(self) -> bool:
        """Tell whether there were enough inputs."""
        return self.found["inputs"] >= self.runs or time.monotonic() >= self.end

    def write(self) -> None:
        """Write the figures; memory in bytes, beyond that of the imports."""
        self.found["memory"] = _memory() - self.base
        self.file.write_text(json.dumps(self.found))

    def _hangs(self, *_: object) -> NoReturn:
        raise HangError

    def _keep(self, data: bytes, error: BaseException) -> None:
        """Count an error by its type and place; keep the first input of each."""
        place = traceback.extract_tb(error.__traceback__)[-1]
        own = [f for f in traceback.extract_tb(error.__traceback__) if "debrisflow" in f.filename]
        ours = own[-1] if own else place
        key = f"{type(error).__name__} at {Path(ours.filename).name}:{ours.lineno} ({place.name})"
        known = self.found["tracebacks"]
        known[key] = known.get(key, 0) + 1
        if known[key] == 1:
            self.kept.mkdir(parents=True, exist_ok=True)
            stem = f"{self.name}-{type(error).__name__}-{Path(ours.filename).stem}-{ours.lineno}"
            (self.kept / f"{stem}{self.input.suffix}").write_bytes(data)
            text = "".join(traceback.format_exception(error))
            (self.kept / f"{stem}.traceback").write_text(text[-6000:])


def _memory() -> int:
    """Return the greatest memory of this process so far, bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def fuzz_at_random(tally: Tally, samples: list[bytes], seed: int) -> None:
    """Try the samples, and mutations of them and of what was made of them."""
    random, pool = Random(seed), list(samples)
    for data in samples:
        tally.try_one(data)
    while not tally.is_over:
        data = tally.target.mutate(random.choice(pool), random, tally.target.words)
        tally.try_one(data)
        if random.random() < 0.05 and len(data) < 20_000:  # mutations of mutations
            pool = [*pool[: len(samples)], *pool[len(samples) :][-100:], data]


def fuzz_by_coverage(tally: Tally, samples: list[bytes], seed: int, corpus: Path) -> NoReturn:
    """Let atheris choose the inputs; it starts from the samples and adds to the corpus."""
    import atheris

    corpus.mkdir(parents=True, exist_ok=True)
    for k, data in enumerate(samples):
        (corpus / f"sample{k}").write_bytes(data)

    def mutate(data: bytes, most: int, seed: int) -> bytes:
        random = Random(seed)
        if random.random() < 0.5:
            return atheris.Mutate(data, most)
        return tally.target.mutate(data, random, tally.target.words)[:most]

    def try_one(data: bytes) -> None:
        tally.try_one(data)
        if tally.is_over:
            os._exit(0)

    options = [f"-seed={seed}", "-timeout=0", "-rss_limit_mb=0", "-max_len=200000", "-verbosity=0"]
    atheris.Setup(["fuzz", *options, str(corpus)], try_one, custom_mutator=mutate)
    atheris.Fuzz()
    os._exit(0)


def one_target(name: str, options: dict[str, Any]) -> None:
    """Fuzz a target in this process, which a crash or a hang may end."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    measured = None
    if options["coverage"]:
        from coverage import Coverage

        measured = Coverage(
            options["coverage"], data_suffix=True, config_file=False, include=LOADERS
        )
        measured.start()
    elif options["guided"]:
        import atheris

        with atheris.instrument_imports(include=list(INSTRUMENTED)):
            import_module("tests.untrusted.targets")
    from tests.untrusted.targets import furnish

    with TemporaryDirectory(dir=IN_MEMORY if Path(IN_MEMORY).is_dir() else None) as folder:
        tally = Tally(
            name,
            Path(folder),
            Path(options["kept"]),
            options["runs"],
            options["seconds"],
            Path(options["figures"]),
        )
        samples, corpus = furnish(Path(folder))[name], Path(options["corpus"]) / name
        if options["guided"]:
            fuzz_by_coverage(tally, samples, options["seed"], corpus)
        stored = sorted(corpus.iterdir()) if corpus.is_dir() else []
        fuzz_at_random(tally, samples + [file.read_bytes() for file in stored], options["seed"])
        tally.write()
    if measured:
        measured.stop()
        measured.save()


def in_processes(name: str, options: dict[str, Any]) -> dict[str, Any]:
    """Fuzz a target in processes of its own; one that dies is counted and followed by another."""
    total: dict[str, Any] = {"inputs": 0, "accepted": 0, "tracebacks": {}, "hangs": 0, "memory": 0}
    total["deaths"] = 0
    end = time.monotonic() + options["seconds"]
    for start in range(STARTS):
        with TemporaryDirectory() as folder:
            own = options | {
                "figures": f"{folder}/figures.json",
                "runs": options["runs"] - total["inputs"],
                "seconds": end - time.monotonic(),
                "seed": options["seed"] + start,
            }
            command = [sys.executable, __file__, "--one", json.dumps(own), name]
            code, said = _ended(command, own["seconds"] + LATE)
            figures = Path(own["figures"])
            if figures.is_file():
                _add(total, json.loads(figures.read_text()))
        if code == 0:
            break
        total["deaths"] += 1
        key = f"process ended by {code}: {' '.join(said.split())[-300:]}"
        total["tracebacks"][key] = total["tracebacks"].get(key, 0) + 1
    return total


def _ended(command: list[str], seconds: float) -> tuple[int | str, str]:
    """Return the exit code of a process and what it said; one that does not end is killed."""
    try:
        made = subprocess.run(
            command, capture_output=True, text=True, errors="replace", timeout=seconds
        )
    except subprocess.TimeoutExpired:
        return "no end", f"within {seconds:.0f} s"
    return made.returncode, made.stderr


def _add(total: dict[str, Any], part: dict[str, Any]) -> None:
    for key in ("inputs", "accepted", "hangs"):
        total[key] += part[key]
    total["memory"] = max(total["memory"], part.get("memory", 0))
    for key, count in part["tracebacks"].items():
        total["tracebacks"][key] = total["tracebacks"].get(key, 0) + count


def print_coverage(data_file: str) -> None:
    """Print the share of the lines of the loaders that the inputs ran."""
    from coverage import Coverage

    measured = Coverage(data_file, config_file=False, include=LOADERS)
    measured.combine()
    measured.report()


@click.command()
@click.argument("names", metavar="[TARGET ...]", nargs=-1)
@click.option("--runs", default=10_000, show_default=True, help="Inputs a target at most.")
@click.option("--seconds", default=600.0, show_default=True, help="Time a target at most.")
@click.option("--seed", default=1, show_default=True, help="Of the random numbers.")
@click.option("--random", "at_random", is_flag=True, help="Without atheris, though it is there.")
@click.option("--quick", is_flag=True, help=f"{QUICK} random inputs a target, the same each time.")
@click.option("--coverage", "covers", is_flag=True, help="Also print the coverage of the loaders.")
@click.option("--corpus", default="fuzz_corpus", show_default=True, help="Folder of atheris.")
@click.option("--keep", default="fuzz_found", show_default=True, help="Folder of what goes wrong.")
@click.option("--one", hidden=True, help="Options of a target, for a process of its own.")
def main(
    names: tuple[str, ...],
    runs: int,
    seconds: float,
    seed: int,
    at_random: bool,
    quick: bool,
    covers: bool,
    corpus: str,
    keep: str,
    one: str | None,
) -> None:
    """Fuzz all loaders, or each TARGET."""
    if one is not None:
        one_target(names[0], json.loads(one))
        return
    from tests.untrusted.targets import targets

    known = targets()
    if unknown := [name for name in names if name not in known]:
        raise click.UsageError(f"no target {unknown[0]}; there are {', '.join(known)}")
    guided = not (at_random or quick or covers) and find_spec("atheris") is not None
    with TemporaryDirectory() as folder:
        options = {
            "runs": QUICK if quick else runs,
            "seconds": seconds,
            "seed": seed,
            "guided": guided,
            "coverage": f"{folder}/coverage" if covers else "",
            "corpus": str(Path(corpus).absolute()),
            "kept": str(Path(keep).absolute()),
        }
        click.echo(f"mutations {'guided by coverage' if guided else 'at random'}")
        failed = inputs = 0
        for name in names or known:
            found = in_processes(name, options)
            failed += _told(name, found)
            inputs += found["inputs"]
        click.echo(f"in total    {inputs:>7,} inputs, {failed} of them tracebacks or hangs")
        if covers:
            print_coverage(options["coverage"])
    raise SystemExit(1 if failed else 0)


def _told(name: str, found: dict[str, Any]) -> int:
    """Print a line on a target, and each fault; return the number of its faults."""
    faults = sum(found["tracebacks"].values())
    click.echo(
        f"{name:<11} {found['inputs']:>7,} inputs, {found['accepted']:>7,} accepted, "
        f"{faults - found['hangs']} tracebacks, {found['hangs']} hangs, "
        f"{found['memory'] / 1e6:,.0f} MB"
    )
    for key, count in found["tracebacks"].items():
        click.echo(f"    {count} x {key}")
    return faults


if __name__ == "__main__":
    main()
