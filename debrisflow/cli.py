"""The command line.  Each command imports what it needs itself, which keeps help fast."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import Any

import click

from debrisflow import __version__
from debrisflow.commands import cases, results, runs, studies, validation
from debrisflow.commands.console import print_error
from debrisflow.errors import DebrisflowError, Interrupted

INTERRUPTED = 130  # the exit code of a shell
AS_JSON = "debrisflow.as_json"
GOES_ON = "a run that has begun goes on with: debrisflow resume RUN"


class Commands(click.Group):
    """Commands that print errors in plain words and return an exit code for each class."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; an error meant for the user becomes its message and exit code.

        With ``--json`` it is printed as an object too, as is any other error.
        """
        tell = print_error if ctx.meta[AS_JSON] else _say_nothing
        try:
            with _sigterm_as_interrupt():
                return super().invoke(ctx)
        except DebrisflowError as error:
            click.echo(error, err=True)
            tell(error, error.exit_code, str(error))
            ctx.exit(error.exit_code)
        except MemoryError as error:
            detail = f" ({error})" if str(error) else ""
            message = (
                f"the memory of this machine is used up{detail}; debrisflow check says what a case "
                "needs"
            )
            click.echo(message, err=True)
            tell(error, DebrisflowError.exit_code, message)
            ctx.exit(DebrisflowError.exit_code)
        except KeyboardInterrupt as stop:
            goes_on = ctx.invoked_subcommand in ("run", "resume")
            message = "interrupted" + (f"; {GOES_ON}" if goes_on else "")
            code = stop.exit_code if isinstance(stop, Interrupted) else INTERRUPTED
            click.echo(message, err=True)
            tell(stop, code, message)
            ctx.exit(code)
        except click.ClickException as error:
            tell(error, error.exit_code, error.format_message())
            raise
        except click.exceptions.Exit:
            raise
        except Exception as error:
            tell(error, 1, f"a fault of the program: {error}")
            raise

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Note whether the answer is to be JSON, since the options themselves may be wrong."""
        ctx.meta[AS_JSON] = "--json" in args
        return super().parse_args(ctx, args)


def _say_nothing(*_: object) -> None:
    """Print no error a second time."""


@contextmanager
def _sigterm_as_interrupt() -> Iterator[None]:
    """Let SIGTERM, which batch systems send, end a command as Ctrl-C does."""

    def interrupt(number: int, _: object) -> None:
        raise Interrupted(number)

    if current_thread() is not main_thread():
        yield
        return
    former = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, former)


@click.group(cls=Commands)
@click.version_option(__version__, prog_name="debrisflow")
def main() -> None:
    """Particle simulation (MPS) of debris flows from TOML case files."""


for command in (
    runs.check,
    runs.run,
    runs.resume,
    runs.status,
    cases.init,
    cases.schema,
    cases.info,
    results.postprocess,
    results.maps,
    results.report,
    results.compare,
    results.render,
    results.hazard,
    results.score,
    studies.sweep,
    validation.validate,
):
    main.add_command(command)
