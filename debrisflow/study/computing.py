"""The computation of one member, as a worker does it."""

from __future__ import annotations

from pathlib import Path
from threading import Lock
from time import perf_counter, sleep

from debrisflow.case import ResolvedCase
from debrisflow.errors import CaseError, DebrisflowError, DivergedError
from debrisflow.run.events import Event
from debrisflow.run.lock import is_locked
from debrisflow.run.names import CASE
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


def compute(case: ResolvedCase, folder: Path, threads: int, program: str) -> Outcome:
    """Compute a member, or go on with it, and return what became of it.

    What was computed before is not computed again; a member that another process computes is
    waited for.

    Parameters
    ----------
    case : ResolvedCase
    folder : Path
        Of its run.
    threads : int
    program : str
        By which the results are to be computed.
    """
    from debrisflow.run import loop

    if loop.program() != program:
        message = (
            f"its worker has {loop.program()}, not {program}; install the same on all machines"
        )
        return Outcome(STOPPED, message, {}, 0.0)
    with _ONE_AT_A_TIME:
        while is_locked(folder):
            sleep(PAUSE)
        known = read_outcome(folder)
        if known is not None:
            return known
        began = perf_counter()
        try:
            _run(case, folder, threads)
            outcome = Outcome(FINISHED, "", _answers(folder), perf_counter() - began)
        except (CaseError, DivergedError) as error:
            outcome = Outcome(FAILED, str(error), {}, perf_counter() - began)
        except DebrisflowError as error:
            return Outcome(STOPPED, str(error), {}, perf_counter() - began)
        except MemoryError:
            return Outcome(STOPPED, "the memory of its worker is used up", {}, 0.0)
        except Exception as error:  # whatever is wrong with one member, the others go on
            message = f"a fault of the program: {type(error).__name__}: {error}"
            return Outcome(STOPPED, message, {}, perf_counter() - began)
        write_outcome(folder, outcome)
        return outcome


def _run(case: ResolvedCase, folder: Path, threads: int) -> None:
    from debrisflow.run.simulation import resume, simulate

    if (folder / CASE).exists():
        resume(folder, threads, on_event=_silent)
    else:
        folder.parent.mkdir(parents=True, exist_ok=True)
        simulate(case, folder, threads, on_event=_silent)


def _silent(event: Event) -> None:
    """Show no event: warnings are in the log of the run."""


def _answers(folder: Path) -> dict[str, Figure]:
    """Return the figures of a finished run."""
    from debrisflow.results import open_run
    from debrisflow.results.answers import answers
    from debrisflow.results.survey import survey_of

    return {
        row.quantity: Figure(row.value, row.unit) for row in answers(survey_of(open_run(folder)))
    }
