"""What ``run`` and ``resume`` print while a run goes on: a bar, lines of JSON, or warnings only."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from debrisflow.run.events import WARNING, Event, Listener, plain

PAUSE = 2.0  # s of wall time between two lines of progress
RESULT, ERROR = "result", "error"
LEVELS = ("debug", "info", "warning", "error")


def print_json(values: Mapping[str, Any]) -> None:
    """Print a line of JSON; it is flushed."""
    click.echo(json.dumps(plain(dict(values)), allow_nan=False))


def print_error(error: BaseException, exit_code: int, message: str) -> None:
    """Print an error as a line of JSON."""
    kind = type(error).__name__
    print_json({"event": ERROR, "exit_code": exit_code, "class": kind, "message": message})


class JsonLines:
    """Prints each event as a line of JSON, and warnings as text on the standard error too."""

    pause = PAUSE

    def __call__(self, event: Event) -> None:
        """Print an event."""
        print_json(event)
        print_warning(event)


def print_warning(event: Event) -> None:
    """Print an event on the standard error if it is a warning."""
    if event["event"] == WARNING:
        click.echo(f"warning: {event['message']}", err=True)


def listener(as_json: bool, is_quiet: bool) -> Listener | None:
    """Return who is told of the events of a run; None for the bar."""
    if as_json and is_quiet:
        raise click.UsageError("--json prints progress and --quiet none; give one of them")
    if as_json:
        return JsonLines()
    return print_warning if is_quiet else None


@contextmanager
def logging_from(level: str) -> Iterator[None]:
    """Let the package log what is at a level or above it."""
    log = logging.getLogger("debrisflow")
    before = log.level
    log.setLevel(level.upper())
    try:
        yield
    finally:
        log.setLevel(before)


def print_files(files: Sequence[Path]) -> None:
    """Say which files were written."""
    for file in files:
        click.echo(f"wrote {file}")
