"""Compute levels of comparisons, several at a time, one thread each."""

from __future__ import annotations

import multiprocessing
import platform
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from datetime import UTC, datetime
from time import process_time
from typing import NamedTuple

from debrisflow import __version__
from debrisflow.errors import DebrisflowError, OutputError
from debrisflow.run.duration import duration
from debrisflow.validation.comparison import Comparison, Measured
from debrisflow.validation.register import COMPARISONS
from debrisflow.validation.result import LevelResult, Origin, level_result


class Task(NamedTuple):
    """A level of a comparison, by their names, which another process knows too."""

    name: str
    label: str


def tasks_of(chosen: Sequence[Comparison], is_quick: bool) -> list[Task]:
    """Return the levels of comparisons that are to be computed, those that take longest first."""
    pairs = [
        (level.seconds, Task(one.name, level.label))
        for one in chosen
        for level in one.levels
        if level.is_quick or not is_quick
    ]
    return [task for _, task in sorted(pairs, key=lambda pair: -pair[0])]


def plan(tasks: Sequence[Task], workers: int) -> str:
    """Return how many levels are to be computed, and how long it takes, in words."""
    seconds = [COMPARISONS[task.name].level(task.label).seconds for task in tasks]
    workers = min(workers, len(tasks))
    expected = max(sum(seconds) / max(workers, 1), *seconds, 0.0)
    return (
        f"levels to compute: {len(tasks)}, of {len({task.name for task in tasks})} comparisons, "
        f"{workers} at a time; about {duration(expected)}, without the compilation of the kernels"
    )


def origin() -> Origin:
    """Return when and by what a level is computed now."""
    from debrisflow._jit import KERNELS, PROCESSOR

    today = datetime.now(UTC).strftime("%Y-%m-%d")
    return Origin(today, __version__, PROCESSOR, platform.python_version(), KERNELS)


def computed(task: Task) -> LevelResult:
    """Compute a level on one thread and return what it gave.

    Whatever goes wrong is told in the result, so that the others go on.
    """
    from debrisflow._jit import set_threads

    set_threads(1)
    comparison = COMPARISONS[task.name]
    level = comparison.level(task.label)
    start, found, failure = process_time(), Measured(()), ""
    try:
        found = comparison.measure(level)
    except DebrisflowError as error:
        failure = str(error)
    except Exception as error:
        failure = f"a fault of the program: {type(error).__name__}: {error}"
    return level_result(level, found, origin(), process_time() - start, failure)


def compute(tasks: Sequence[Task], workers: int) -> Iterator[tuple[Task, LevelResult]]:
    """Yield what tasks gave as they end.

    Parameters
    ----------
    tasks : sequence of Task
    workers : int
        Processes; with one, or one task, all is computed in this one.

    Raises
    ------
    OutputError
        If a process was killed, as happens when memory is used up.
    """
    workers = min(workers, len(tasks))
    if workers <= 1:
        for task in tasks:
            yield task, computed(task)
        return
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, context, _leave_signals)
    running = {pool.submit(computed, task): task for task in tasks}
    try:
        for done in as_completed(running):
            yield running[done], done.result()
    except BrokenProcessPool as error:
        raise OutputError(
            "a process that computed was killed, perhaps because memory was used up; compute "
            "fewer at a time with --workers"
        ) from error
    finally:
        if not all(future.done() for future in running):
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_signals() -> None:
    """Let Ctrl-C reach the first process only, which ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
