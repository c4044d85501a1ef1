"""``status.json``: where a run is, for whoever looks into its folder."""

from __future__ import annotations

import json
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import Any

from debrisflow.errors import OutputError
from debrisflow.files import text_of
from debrisflow.run.atomic import replaced
from debrisflow.run.events import FIELDS, LEDGER, LIVE, OVER, WARNING, Event, Field, plain
from debrisflow.run.names import STATUS

LEAST_PAUSE = 2.0  # s of wall time
SHARE = 1e-3  # of the wall time, spent writing at most
GREATEST_SIZE = 2**20  # bytes, of a file that is read
GREATEST = 1e300  # number, far beyond what any run has


class StatusFile:
    """Keeps ``status.json`` up to date with the events of a run.

    Parameters
    ----------
    folder : Path
        Of the run.

    Attributes
    ----------
    pause : float, s
        Wall time that is to pass before the next event.
    """

    def __init__(self, folder: Path) -> None:
        self._path, self.pause = folder / STATUS, LEAST_PAUSE

    def __call__(self, event: Event) -> None:
        """Write an event.  One that cannot be written ends no run: its results will, if at all."""
        if event["event"] == WARNING or not self._path.parent.is_dir():
            return
        before = perf_counter()
        status = {field.name: event[field.name] for field in FIELDS}
        with suppress(OutputError), replaced(self._path, is_flushed=False) as unfinished:
            unfinished.write_text(json.dumps(plain(status), indent=2) + "\n", encoding="utf-8")
        self.pause = max(LEAST_PAUSE, (perf_counter() - before) / SHARE)


def read_status(folder: Path) -> dict[str, Any] | None:
    """Return what ``status.json`` holds, by the names in ``FIELDS``.

    None without the file, or with an empty one.  What a file of another version lacks is None.

    Raises
    ------
    OutputError
        If it cannot be read or is damaged.
    """
    path = folder / STATUS
    if not path.is_file():
        return None
    try:
        text = text_of(path, GREATEST_SIZE)
        if not text:
            return None  # left by a loss of power
        status = json.loads(text)
    except OSError as error:
        raise OutputError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{path} is damaged: {error}") from error
    if not isinstance(status, dict) or status.get("state") not in LIVE + OVER:
        raise OutputError(f"{path} is damaged: it names no state")
    for field in FIELDS:
        if not fits(status.get(field.name), field):
            raise OutputError(f"{path} is damaged: {field.name} is {status[field.name]!r}")
    return {field.name: status.get(field.name) for field in FIELDS}


def fits(value: Any, field: Field) -> bool:
    """Return whether a value may be that of a field."""
    if value is None:
        return True
    if field.type is dict:
        return isinstance(value, dict) and all(
            name in value and (value[name] is None or _is_number(value[name])) for name in LEDGER
        )
    if field.type is float:
        return _is_number(value)
    if field.type is int:
        return _is_number(value) and isinstance(value, int)
    return isinstance(value, field.type)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < GREATEST


def moment(text: str | None) -> datetime:
    """Return a time written as ISO 8601; the beginning of the era if it is none.

    Examples
    --------
    >>> moment("2026-11-30T06:12:00+00:00").minute, moment("noon").year
    (12, 1970)
    """
    try:
        found = datetime.fromisoformat(text or "")
    except ValueError:
        return datetime.fromtimestamp(0.0, UTC)
    return found if found.tzinfo else found.replace(tzinfo=UTC)
