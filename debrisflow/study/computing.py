"""The computation of one member, as a worker does it."""

from __future__ import annotations

import shutil
from pathlib import Path
from threading import Lock
from time import perf_counter, sleep

from debrisflow.case import ResolvedCase, dump_case
from debrisflow.errors import CaseError, DebrisflowError, DivergedError
from debrisflow.run.atomic import replaced
from debrisflow.run.events import Event
from debrisflow.run.lock import LockedError
from debrisflow.run.names import CASE
from debrisflow.study.member import address
from debrisflow.study.outcome import (
    FAILED,
    FINISHED,
    STOPPED,
    Figure,
    Outcome,
    read_outcome,
    write_outcome,
)

PAUSE = 1.0  # s, between two looks at a member that another process computes
_ONE_AT_A_TIME = Lock()  # the log of a run takes all messages of its process


def compute(
    case: ResolvedCase, folder: Path, digest: str, program: str, threads: int = 1
) -> Outcome:
    """Compute a member, or go on with it, and return what became of it.

    What was computed before is not computed again; a member that another process computes is
    waited for.

    Parameters
    ----------
    case : ResolvedCase
    folder : Path
        Of its run.
    digest : str
        Its address, which case, files and program must have here and now.
    program : str
        By which the results are to be computed.
    threads : int
    """
    from debrisflow.run import loop

    if loop.program() != program:
        return _stopped(
            f"its worker has {loop.program()}, not {program}; install the same on all machines"
        )
    with _ONE_AT_A_TIME:
        while True:
            try:
                return read_outcome(folder) or _computed(case, folder, digest, program, threads)
            except LockedError:
                sleep(PAUSE)
            except DebrisflowError as error:
                return _stopped(str(error))
            except MemoryError:
                return _stopped("the memory of its worker is used up")
            except Exception as error:  # whatever is wrong with one member, the others go on
                return _stopped(f"a fault of the program: {type(error).__name__}: {error}")


def _computed(case: ResolvedCase, folder: Path, digest: str, program: str, threads: int) -> Outcome:
    """Run a member and keep what became of it.

    Raises
    ------
    DebrisflowError
        If something else than the case or its flow is in the way.
    """
    began = perf_counter()
    _expect_same_files(case, digest, program)
    try:
        _run(case, folder, threads)
    except (CaseError, DivergedError) as error:
        _expect_same_files(case, digest, program)  # else it is not the case that is wrong
        outcome = Outcome(FAILED, str(error), {}, perf_counter() - began)
    else:
        if address(case, program) != digest:
            shutil.rmtree(folder)  # its results are not those of this address
            _expect_same_files(case, digest, program)
        outcome = Outcome(FINISHED, "", _answers(folder), perf_counter() - began)
    write_outcome(folder, outcome)
    return outcome


def _expect_same_files(case: ResolvedCase, digest: str, program: str) -> None:
    """Refuse a case whose files are not what they were when its address was made.

    Raises
    ------
    CaseError
    """
    if address(case, program) != digest:
        raise CaseError(
            "a file that its case names has changed since the sweep began; start the sweep again"
        )


def _run(case: ResolvedCase, folder: Path, threads: int) -> None:
    from debrisflow.run.simulation import resume, simulate

    if not (folder / CASE).exists():
        simulate(case, folder, threads, on_event=_silent)
        return
    # Another study may have begun it, with its own title and places of the same files.
    with replaced(folder / CASE) as unfinished:
        unfinished.write_text(dump_case(case), encoding="utf-8")
    resume(folder, threads, accept_changes=True, on_event=_silent)


def _silent(event: Event) -> None:
    """Show no event: warnings are in the log of the run."""


def _answers(folder: Path) -> dict[str, Figure]:
    """Return the figures of a finished run."""
    from debrisflow.results import open_run
    from debrisflow.results.answers import answers
    from debrisflow.results.survey import survey_of

    rows = answers(survey_of(open_run(folder)))
    return {row.quantity: Figure(row.value, row.unit) for row in rows}


def _stopped(message: str) -> Outcome:
    return Outcome(STOPPED, message, {}, 0.0)
