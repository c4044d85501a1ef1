"""Progress bars: one that is redrawn on a terminal, lines now and then in a file."""

from __future__ import annotations

import sys
from typing import Any, TextIO

from tqdm import tqdm

PAUSE, PAUSE_IN_FILE = 0.5, 30.0  # s between two drawings


class Lines:
    """A stream in which each drawing of a bar is a line, as a log of a batch system has them.

    Parameters
    ----------
    stream : TextIO

    Examples
    --------
    >>> lines = Lines(sys.stdout)
    >>> for text in (chr(13) + "50% | t = 0.5 s   ", chr(10)):
    ...     lines.write(text)
    50% | t = 0.5 s
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> None:
        """Write what a bar shows, without its carriage return, as a line."""
        shown = text.replace("\r", "").rstrip()
        if shown:
            self._stream.write(shown + "\n")

    def flush(self) -> None:
        """Flush the stream."""
        self._stream.flush()


def is_terminal() -> bool:
    """Return whether bars are drawn on a terminal."""
    return sys.stderr.isatty()


def pause() -> float:
    """Return the shortest time between two drawings of a bar, s."""
    return PAUSE if is_terminal() else PAUSE_IN_FILE


def bar(*arguments: Any, **options: Any) -> tqdm[Any]:
    """Return a bar of tqdm on the standard error, as fits a terminal or a file."""
    stream = sys.stderr if is_terminal() else Lines(sys.stderr)
    return tqdm(*arguments, file=stream, mininterval=pause(), **options)
