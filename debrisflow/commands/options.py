"""Arguments and options that several commands have."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from debrisflow.commands.console import LEVELS

PATH = click.Path(path_type=Path)


def numbers_type(
    count: int | None = None, are_intervals: bool = False
) -> Callable[[Any], tuple[float, ...]]:
    """Return the type of an option that consists of numbers separated by commas.

    Parameters
    ----------
    count : int, optional
        How many there must be.
    are_intervals : bool
        Whether each two are the ends of an interval.
    """

    def numbers(value: Any) -> tuple[float, ...]:
        if isinstance(value, tuple):
            return value
        try:
            found = tuple(float(part) for part in value.split(","))
        except ValueError:
            found = (math.nan,)
        if not all(map(math.isfinite, found)):
            raise click.BadParameter(f"{value} is not a list of numbers with commas between them")
        if count is not None and len(found) != count:
            raise click.BadParameter(f"{value} has {len(found)} numbers where {count} are needed")
        ends = zip(found[::2], found[1::2], strict=True) if are_intervals else ()
        if not all(a < b for a, b in ends):
            raise click.BadParameter(f"{value}: an interval must end after it starts")
        return found

    return numbers


case_argument = click.argument("case", metavar="CASE", type=PATH)


run_argument = click.argument("folder", metavar="RUN", type=PATH)


overrides_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    help="Change a value of the case, as in --set time.end=2; may be repeated.",
)


threads_option = click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Threads to use; by default as many as the case can keep busy.",
)


stations_option = click.option(
    "--stations",
    type=numbers_type(),
    default=(),
    help="x of profiles and hydrographs, m: X,X,...; every eighth of the length if left out.",
)


window_option = click.option(
    "--window",
    type=numbers_type(2, are_intervals=True),
    help="Times over which profiles and probes are averaged, s: T0,T1; the last fifth if left out.",
)


def finite(_: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Refuse what is no number or without end."""
    if value is not None and not math.isfinite(value):
        raise click.BadParameter(f"{value} is no finite number", param=parameter)
    return value


smooth_option = click.option(
    "--smooth",
    type=click.FloatRange(min=0.0),
    callback=finite,
    help="Time over which samples of probes are averaged, s; ten of their intervals if left out.",
)


references_option = click.option(
    "--reference",
    "references",
    type=PATH,
    multiple=True,
    help="CSV file of curves to compare with; may be repeated.",
)


language_option = click.option(
    "--language",
    type=click.Choice(["en", "ja"]),
    default="en",
    show_default=True,
    help="Language of headings and labels.",
)


json_option = click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")


def shown_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options on what is shown of a run that goes on."""
    for option in (
        click.option(
            "--log-level",
            type=click.Choice(LEVELS),
            default="info",
            show_default=True,
            help="Level from which on messages are kept in run.log.",
        ),
        click.option("--quiet", is_flag=True, help="Print nothing but warnings and errors."),
        click.option(
            "--json", "as_json", is_flag=True, help="Print progress and result as lines of JSON."
        ),
    ):
        command = option(command)
    return command
