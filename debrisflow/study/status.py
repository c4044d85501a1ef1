"""Where a sweep is: what each of its members is doing, from its folder alone."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, ValidationError

from debrisflow.errors import OutputError, shown
from debrisflow.run.duration import duration
from debrisflow.run.events import LIVE
from debrisflow.run.folder_status import status_of
from debrisflow.run.reading import text_of
from debrisflow.study.member import shown_values
from debrisflow.study.names import PLAN
from debrisflow.study.outcome import DAMAGED, FAILED, FINISHED, read_outcome

RUNNING, INTERRUPTED, WAITING = "running", "interrupted", "waiting"
STATES = (FINISHED, FAILED, DAMAGED, RUNNING, INTERRUPTED, WAITING)
SHOWN = (FAILED, DAMAGED, RUNNING, INTERRUPTED)
MOST_SHOWN = 20  # members, in lines


class _Entry(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)

    number: NonNegativeInt
    folder: str = Field(pattern=r"^[0-9a-f]{16}$")
    values: dict[str, float | str]


class _Plan(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")

    title: str
    store: str
    members: list[_Entry]


def sweep_status(folder: Path) -> dict[str, Any]:
    """Return where the sweep in a folder is.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    dict
        ``title``, ``folder``, ``members``: how many in all; ``finished``, ``failed``, ``damaged``,
        ``running``, ``interrupted``, ``waiting``: how many of them; ``seconds``: mean wall time of
        those that are over, and ``seconds_left``, None where there is none; ``shown``: those that
        failed, run or are damaged, dicts of ``number``, ``folder``, ``values``, ``state``,
        ``message``.

    Raises
    ------
    OutputError
        If the folder is none of a sweep, or its list of members is damaged.
    """
    plan = _plan_of(folder)
    counts: Counter[str] = Counter()
    seconds, shown_ones, done = [], [], 0.0
    seen: dict[str, tuple[str, str]] = {}
    for entry in plan.members:
        if entry.folder not in seen:
            state, message, share, took = _of_member(folder / plan.store / entry.folder)
            seen[entry.folder] = state, message
            done += share
            if took is not None:
                seconds.append(took)
        state, message = seen[entry.folder]
        counts[state] += 1
        if state in SHOWN:
            known = {"number": entry.number, "folder": entry.folder, "values": entry.values}
            shown_ones.append(known | {"state": state, "message": message})
    mean = sum(seconds) / len(seconds) if seconds else None
    found = {"title": plan.title, "folder": str(folder), "members": len(plan.members)}
    found |= {state: counts[state] for state in STATES}
    left = sum(counts[state] for state in (RUNNING, INTERRUPTED, WAITING)) - done
    at_once = counts[RUNNING]
    until = mean * left / at_once if mean and at_once else (0.0 if not left else None)
    return found | {"seconds": mean, "seconds_left": until, "shown": shown_ones}


def status_lines(status: dict[str, Any]) -> Iterator[str]:
    """Yield what :func:`sweep_status` returned as lines, members that failed or run at the end."""
    whole = status["members"]
    over = status[FINISHED] + status[FAILED]
    parts = [f"{status[state]} {state}" for state in STATES if status[state]]
    yield f"{shown(status['folder'])}: {over} of {whole} members are over; {', '.join(parts)}"
    if status["seconds"]:
        left = status["seconds_left"]
        rest = f", {duration(left)} left at the present pace" if left else ""
        yield f"a member takes {duration(status['seconds'])}{rest}"
    for one in status["shown"][:MOST_SHOWN]:
        message = " ".join(shown(one["message"]).split())
        values = shown(shown_values(one["values"]))
        head = f"  {one['state']:<12}{one['number']:>5}  {one['folder']}"
        yield f"{head}  {values}  {message}".rstrip()
    if len(status["shown"]) > MOST_SHOWN:
        yield f"  and {len(status['shown']) - MOST_SHOWN} more, see --json"


def _plan_of(folder: Path) -> _Plan:
    file = folder / PLAN
    if not file.is_file():
        raise OutputError(
            f"{folder} is no folder of a sweep: it holds no {PLAN}; start one with: "
            "debrisflow sweep STUDY.toml"
        )
    try:
        return _Plan.model_validate(json.loads(text_of(file)))
    except (ValidationError, ValueError, RecursionError) as error:
        raise OutputError(f"{file} is damaged; start the sweep again, which writes it") from error


def _of_member(run: Path) -> tuple[str, str, float, float | None]:
    """Return the state of a member, a message, the share of a run that is done, and its seconds."""
    try:
        outcome = read_outcome(run)
        if outcome is None:
            return *_unfinished(run), None
    except OutputError as error:
        return DAMAGED, str(error), 0.0, None
    return outcome.state, outcome.message, 0.0, outcome.seconds


def _unfinished(run: Path) -> tuple[str, str, float]:
    """Return the state of a run that is not over, a message, and the share of it that is done."""
    if not run.is_dir():
        return WAITING, "", 0.0
    status = status_of(run)
    time, end = status["time"], status["end"]
    share = min(max(time / end, 0.0), 1.0) if time and end else 0.0
    state = RUNNING if status["state"] in LIVE else INTERRUPTED
    return state, f"{100.0 * share:.0f} %", share
