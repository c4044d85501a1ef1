"""What the folder of a run tells about it, without the solver: who runs there, how far it is."""

from __future__ import annotations

import json
import os
import shlex
import socket
import sys
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from debrisflow.errors import OutputError
from debrisflow.files import opened
from debrisflow.run.events import (
    END_REASONS,
    ENDED,
    FAILED,
    FIELDS,
    INTERRUPTED,
    LIVE,
    RUNNING,
    STARTING,
    Field,
)
from debrisflow.run.lock import is_locked
from debrisflow.run.names import CASE, CHECKPOINT, HISTORY, LOG, SUMMARY
from debrisflow.run.status import GREATEST_SIZE, fits, moment, read_status

KILLED, NOT_STARTED, UNKNOWN = "killed", "not started", "unknown"
SILENT = 600.0  # s without a word from another machine, after which its run may be dead
Status = dict[str, Any]
MORE_FIELDS = (
    Field("folder", str, "", "of the run, as it was given"),
    Field("held", bool, "", "whether a process holds the folder now; null where that is unknown"),
    Field("next", str, "", "command by which the run goes on; null where there is none"),
)
"""What is known from outside, besides ``FIELDS``; the state may also be one of ``SEEN``."""
SEEN = {
    KILLED: "no process holds the folder, and none said that the run is over",
    NOT_STARTED: "the folder holds no results",
    UNKNOWN: f"another machine runs it, silent for more than {SILENT / 60.0:.0f} min",
}


def status_of(folder: Path) -> Status:
    """Return what is known of the run in a folder, by the names in ``FIELDS`` and ``MORE_FIELDS``.

    Raises
    ------
    OutputError
        If there is no such folder, or a file in it cannot be read or is damaged.
    """
    if not folder.is_dir():
        raise OutputError(f"{folder} is no folder")
    held = is_locked(folder)
    status = read_status(folder) or _from_results(folder)
    status["state"] = _state(status, held)
    goes_on = status["state"] in (KILLED, INTERRUPTED, FAILED)
    command = f"debrisflow resume {shlex.quote(str(folder))}" if goes_on else None
    return status | {"folder": str(folder), "held": held, "next": command}


def _state(status: Status, held: bool | None) -> str:
    """Return the state that a run is in, whatever it said last."""
    state = str(status["state"])
    if held:
        return state if state in LIVE else STARTING  # it has not yet written of itself
    if state not in LIVE:
        return state
    if status["host"] not in (None, socket.gethostname()):
        # a lock need not be seen on other machines
        silent = (datetime.now(UTC) - moment(status["updated"])).total_seconds()
        return state if silent < SILENT else UNKNOWN
    if held is None and status["process"] is not None:
        return state if _lives(status["process"]) else KILLED
    return KILLED


def _lives(process: int) -> bool:
    """Return whether there is such a process here; it is assumed where asking would end it."""
    if process <= 0 or os.name == "nt":
        return process > 0
    try:
        os.kill(process, 0)  # sends nothing
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # it belongs to somebody else
        return True
    return True


def _from_results(folder: Path) -> Status:
    """Return what the results of a run tell that left no ``status.json``."""
    status: Status = dict.fromkeys(field.name for field in FIELDS)
    summary = _summary(folder)
    reason = summary.get("end_reason")
    if reason is not None:
        known = {INTERRUPTED: INTERRUPTED} | dict.fromkeys(END_REASONS, ENDED)
        status |= {"state": known.get(reason, FAILED), "reason": str(reason)}
        status |= {name: summary.get(name) for name in ("title", "time", "threads")}
        status |= {"step": summary.get("steps"), "updated": _written(folder / SUMMARY)}
    else:
        row = _last_row(folder / HISTORY)
        status |= {"state": RUNNING if row else NOT_STARTED, "reason": ""} | row
        status["updated"] = _written(folder / HISTORY) or _written(folder / LOG)
    case = _case(folder)
    status["title"] = case.get("title")
    time = case.get("time")
    status["end"] = time.get("end") if isinstance(time, dict) else None
    status["checkpoint_at"] = _written(folder / CHECKPOINT)
    return {f.name: status[f.name] if fits(status[f.name], f) else None for f in FIELDS}


def _summary(folder: Path) -> dict[str, Any]:
    try:
        found = json.loads(_text(folder / SUMMARY) or "{}")
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{folder / SUMMARY} is damaged: {error}") from error
    return found if isinstance(found, dict) else {}


def _case(folder: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(_text(folder / CASE))
    except (ValueError, RecursionError):
        return {}  # its faults are for those who want to run it


def _last_row(path: Path) -> dict[str, Any]:
    """Return time and step of the last whole row of a history; nothing without one."""
    whole = _text(path, from_end=True).rpartition("\n")[0]
    time, _, rest = whole[whole.rfind("\n") + 1 :].partition(",")
    try:
        return {"time": float(time), "step": int(rest.partition(",")[0])}
    except ValueError:
        return {}


def _text(path: Path, from_end: bool = False) -> str:
    """Return the text of a file, or what is at its end; empty if it is not there."""
    try:
        with opened(path, sys.maxsize) as file:
            if from_end:
                file.seek(max(0, os.fstat(file.fileno()).st_size - GREATEST_SIZE))
            return file.read(GREATEST_SIZE).decode("utf-8", errors="replace")
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise OutputError(f"{path} cannot be read: {error.strerror}") from error


def _written(path: Path) -> str | None:
    try:
        seconds = path.stat().st_mtime
    except OSError:
        return None
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
