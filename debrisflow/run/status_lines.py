"""The lines of ``debrisflow status`` for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from typing import Any

from debrisflow.errors import shown
from debrisflow.run.duration import duration
from debrisflow.run.events import FAILED, LEDGER, LIVE, OVER
from debrisflow.run.folder_status import KILLED, UNKNOWN
from debrisflow.run.status import moment

PER_WIDTH = {2: " kg per meter of width", 3: " kg"}


def status_lines(status: Mapping[str, Any]) -> Iterator[str]:
    """Yield what :func:`debrisflow.run.folder_status.status_of` returned, without what is unknown.

    What might be read as a command by a terminal is written out: the file may be from anybody.
    """
    for line in _lines(status):
        yield " ".join(shown(line).splitlines())


def _lines(status: Mapping[str, Any]) -> Iterator[str]:
    yield _headline(status)
    for name, values in (
        ("reason", _reason(status)),
        ("time", _simulated(status)),
        ("speed", _speed(status)),
        ("left", _left(status)),
        ("checkpoint", _checkpoint(status)),
        ("particles", _ledger(status["ledger_particles"], "")),
        ("mass", _ledger(status["ledger_mass"], PER_WIDTH.get(status["dimension"], ""))),
    ):
        if values:
            yield f"{name:<12}{values}"
    if status["next"]:
        once = ", once the cause is removed" if status["state"] == FAILED else ""
        yield f"{'go on with':<12}{status['next']}{once}"


def _headline(status: Mapping[str, Any]) -> str:
    state, updated = status["state"], status["updated"]
    where = f" on {status['host']}, process {status['process']}" if status["host"] else ""
    if state in LIVE:
        threads = f", threads: {status['threads']}" if status["threads"] else ""
        since = f", as of {_ago(updated)} ago" if updated else ""
        return f"{status['folder']}: {state}{where}{threads}{since}"
    if state == KILLED:
        return f"{status['folder']}: killed{where}, after {_local(updated)}"
    if state == UNKNOWN:
        return f"{status['folder']}: running{where}, or killed: silent since {_local(updated)}"
    return f"{status['folder']}: {state}" + (f", {_local(updated)}" if updated else "")


def _reason(status: Mapping[str, Any]) -> str:
    reason = status["reason"] or ""
    return "" if reason == status["state"] or status["state"] not in OVER else str(reason)


def _simulated(status: Mapping[str, Any]) -> str:
    if status["time"] is None:
        return ""
    end = f" of {status['end']:g}" if isinstance(status["end"], int | float) else ""
    step = "" if status["step"] is None else f", step {status['step']:,}"
    dt = f", dt = {status['dt']:.2g} s" if status["dt"] else ""
    return f"{status['time']:.6g}{end} s{step}{dt}"


def _speed(status: Mapping[str, Any]) -> str:
    if not status["rate"] or status["speed"] is None:
        return ""
    return (
        f"{status['speed']:.3g} s of the flow a second, {status['rate']:.2g} particle-steps/s; "
        f"{duration(status['wall_seconds'] or 0.0)} so far"
    )


def _left(status: Mapping[str, Any]) -> str:
    if status["seconds_left"] is None or status["state"] not in LIVE:
        return ""
    return f"{duration(status['seconds_left'])}, until {_local(status['ends_at'])}"


def _checkpoint(status: Mapping[str, Any]) -> str:
    if status["checkpoint_at"] is None:
        return ""
    time = status["checkpoint_time"]
    at = "" if time is None else f"t = {time:.6g} s, "
    return f"{at}{_ago(status['checkpoint_at'])} ago"


def _ledger(ledger: Mapping[str, float] | None, unit: str) -> str:
    if ledger is None:
        return ""
    values = (ledger[name] for name in LEDGER)
    initial, entered, released, inside, left, lost, _ = (
        "?" if value is None else f"{value:,.6g}" for value in values
    )
    return (
        f"{initial} initial + {entered} entered + {released} released = "
        f"{inside} inside + {left} left + {lost} lost{unit}"
    )


def _ago(text: str) -> str:
    return duration(max(0.0, (datetime.now(UTC) - moment(text)).total_seconds()))


def _local(text: str | None) -> str:
    return f"{moment(text).astimezone():%Y-%m-%d %H:%M:%S}"
