"""Progress bars: one that is redrawn on a terminal, lines now and then in a file."""

from __future__ import annotations

import sys
from typing import Any, TextIO

from tqdm import tqdm

from debrisflow.run.events import COMPILING, LIVE, OVER, PROGRESS, STOPPING, WARNING, Event

BAR = "{percentage:3.0f}% |{bar:20}| {desc}"
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


class Bar:
    """Shows the events of a run as a bar, and warnings in lines above it."""

    def __init__(self) -> None:
        self._bar: tqdm[Any] | None = None

    @property
    def pause(self) -> float:
        """Wall time that is to pass before the next event, s."""
        return pause()

    def __call__(self, event: Event) -> None:
        """Show an event."""
        if event["event"] == WARNING:
            tqdm.write(f"warning: {event['message']}", file=sys.stderr)
            return
        done, whole, text = (
            event["time"] - event["begin"],
            event["end"] - event["begin"],
            text_of(event),
        )
        if self._bar is None:
            self._bar = bar(total=whole, initial=done, desc=text, bar_format=BAR)
        elif event["event"] == PROGRESS:
            self._bar.n = done
            is_over = event["state"] in OVER
            self._bar.set_description_str(text, refresh=not is_over)
            if is_over:
                self._bar.close()  # which draws it


def text_of(event: Event) -> str:
    """Return what a bar says of an event."""
    if event["state"] == COMPILING:
        so_far = f"{event['compile_seconds']:.0f} s so far"
        return f"compiling kernels, once, about a minute: {so_far}"
    if not event["rate"]:
        return str(event["state"]) if event["state"] in LIVE else ""
    left = event["seconds_left"]
    stopping = f"{STOPPING}: " if event["state"] == STOPPING else ""
    return (
        f"{stopping}t = {event['time']:.3f} s, dt = {event['dt']:.1e} s, "
        f"{event['particles']} particles, {event['rate']:.2g} particle-steps/s"
        + ("" if left is None else f", {tqdm.format_interval(left)} left")
    )
