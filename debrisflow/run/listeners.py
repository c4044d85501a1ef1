"""Those who are told of a run while it goes on."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from time import perf_counter
from types import TracebackType
from typing import Self

from debrisflow.errors import shown
from debrisflow.run.events import WARNING, Event, Listener

LOG = logging.getLogger("debrisflow")
PAUSE = 1.0  # s of wall time, before a listener that names none is told of progress again


class Listeners(logging.Handler):
    """Tells events, and while it is open what the package logs as a warning.

    Progress is told as often as a listener's attribute ``pause`` allows, s of wall time; all else
    at once.

    Parameters
    ----------
    listeners : sequence of Listener
        One that raises an OSError, such as for a pipe that nobody reads, is told no more.
    """

    def __init__(self, listeners: Sequence[Listener]) -> None:
        super().__init__(logging.WARNING)
        self._due = dict.fromkeys(listeners, 0.0)

    def tell(self, event: Callable[[], Event], at_once: bool = True) -> None:
        """Tell what a function returns, which is called only if it is time for a listener."""
        now = perf_counter()
        due = [each for each, when in self._due.items() if at_once or now >= when]
        if not due:
            return
        told = event()
        for listener in due:
            self._due[listener] = now + getattr(listener, "pause", PAUSE)
            try:
                listener(told)
            except OSError as error:
                del self._due[listener]  # first: it is not told of the warning
                LOG.warning("progress is shown no more: %s", error)

    def emit(self, record: logging.LogRecord) -> None:
        """Tell a warning."""
        self.tell(lambda: {"event": WARNING, "message": shown(record.getMessage())})

    def __enter__(self) -> Self:
        """Return the object itself."""
        LOG.addHandler(self)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Tell of warnings no more."""
        LOG.removeHandler(self)
