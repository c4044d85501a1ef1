"""Ctrl-C and SIGTERM: the first asks a run to stop where it can be resumed, the next stops it."""

from __future__ import annotations

import signal
from threading import current_thread, main_thread
from types import FrameType, TracebackType
from typing import Any, Self

from debrisflow.errors import Interrupted

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """Takes the signals that end a program while it is open, in the main thread.

    The second one raises no error from within a library if it can be helped, where it might be
    lost: SIGTERM ends the process there and then.  Files are replaced as wholes, so that none is
    damaged.

    Attributes
    ----------
    received : int or None
        The number of the first signal that came.

    Raises
    ------
    Interrupted
        At a second Ctrl-C, wherever the run is then.
    """

    def __init__(self) -> None:
        self.received: int | None = None
        self._former: dict[signal.Signals, Any] = {}

    def _take(self, number: int, frame: FrameType | None) -> None:
        if self.received is None:
            self.received = number
        elif number == signal.SIGTERM:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        else:
            raise Interrupted(number)

    def __enter__(self) -> Self:
        """Return the object itself."""
        if current_thread() is main_thread():
            self._former = {number: signal.signal(number, self._take) for number in SIGNALS}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the signals back."""
        for number, former in self._former.items():
            signal.signal(number, former)
