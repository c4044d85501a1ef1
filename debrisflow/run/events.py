"""What a run says of itself while it goes on, and who is told.

Events are dicts, the lines of ``debrisflow run --json``.  The key ``event`` is one of

- ``start``, ``progress``, ``checkpoint``: where the run is, by the names in ``FIELDS``;
- ``warning``: a ``message``.

Who is told is a function of an event.  The bar, the lines of JSON and ``status.json`` are such.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

Event = dict[str, Any]
Listener = Callable[[Event], None]

START, PROGRESS, CHECKPOINT, WARNING = "start", "progress", "checkpoint", "warning"
STARTING, COMPILING, RUNNING, STOPPING = "starting", "compiling", "running", "stopping"
ENDED, INTERRUPTED, FAILED = "ended", "interrupted", "failed"
LIVE = (STARTING, COMPILING, RUNNING, STOPPING)
OVER = (ENDED, INTERRUPTED, FAILED)
END_OF_TIME, EMPTY, AT_REST = "end of the simulated time", "no fluid is left", "at rest"
END_REASONS = (END_OF_TIME, EMPTY, AT_REST)


class Field(NamedTuple):
    """A figure of a run that goes on.

    Attributes
    ----------
    name : str
    type : type
        Of its value: ``str``, ``int``, ``float``, or ``dict`` for numbers by the names in
        ``LEDGER``.  Any may be None where it is not known.
    unit, meaning : str
    """

    name: str
    type: type
    unit: str
    meaning: str


LEDGER = ("initial", "entered", "released", "inside", "left", "lost", "difference")
FIELDS = (
    Field("state", str, "", f"one of {', '.join(LIVE + OVER)}"),
    Field("reason", str, "", "why the run is over; empty while it goes on"),
    Field("title", str, "", "of the case"),
    Field("dimension", int, "", "2 or 3"),
    Field("version", str, "", "of debrisflow"),
    Field("host", str, "", "name of the machine"),
    Field("process", int, "", "id of the process on it"),
    Field("threads", int, "", "in use now"),
    Field("begin", float, "s", "simulated time at which the run begins: 0, or minus the settling"),
    Field("time", float, "s", "simulated time reached"),
    Field("end", float, "s", "simulated time at which the run ends"),
    Field("step", int, "", "steps since the beginning of the run"),
    Field("dt", float, "s", "length of the last step"),
    Field("particles", int, "", "fluid particles"),
    Field("rate", float, "1/s", "fluid particles times steps in a second of wall time"),
    Field("speed", float, "", "simulated time in a second of wall time, s/s"),
    Field("seconds_left", float, "s", "wall time still needed, as estimated"),
    Field("ends_at", str, "UTC", "estimated end, ISO 8601"),
    Field("wall_seconds", float, "s", "wall time of this process, without compiling"),
    Field("compile_seconds", float, "s", "wall time in which kernels were compiled"),
    Field("checkpoint_time", float, "s", "simulated time of this process's last checkpoint"),
    Field("checkpoint_at", str, "UTC", "when it was written, ISO 8601"),
    Field(
        "ledger_particles",
        dict,
        "",
        "particles by way: initial + entered + released = inside + left + lost; difference is that "
        "of the sides since this process began",
    ),
    Field("ledger_mass", dict, "kg", "their mass; in two dimensions kg per meter of width"),
    Field("updated", str, "UTC", "time of writing, ISO 8601"),
)


def plain(value: Any) -> Any:
    """Return a value as strict JSON has it: numbers of Python, and None for one that is not finite.

    Examples
    --------
    >>> plain({"a": float("nan"), "b": (1, 2.0), "c": "d"})
    {'a': None, 'b': [1, 2.0], 'c': 'd'}
    """
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if hasattr(value, "tolist"):  # of numpy
        return plain(value.tolist())
    if isinstance(value, float) and not isfinite(value):
        return None
    return value
