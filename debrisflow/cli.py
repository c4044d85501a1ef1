"""The command line; what a command needs is imported inside it, so that help is instant."""

from __future__ import annotations

from math import inf, isfinite, isnan
from pathlib import Path
from typing import Any

import click

from debrisflow import __version__
from debrisflow.errors import DebrisflowError

INTERRUPTED = 130  # as a shell has it
_PATH = click.Path(path_type=Path)


class Commands(click.Group):
    """Commands whose errors are told in plain words, with an exit code a class."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; an error meant for the user becomes its message and exit code."""
        try:
            return super().invoke(ctx)
        except DebrisflowError as error:
            click.echo(error, err=True)
            ctx.exit(error.exit_code)
        except KeyboardInterrupt:
            click.echo("interrupted; a run goes on with: debrisflow resume RUN", err=True)
            ctx.exit(INTERRUPTED)


_case = click.argument("case", metavar="CASE", type=_PATH)
_results = click.argument("folder", metavar="RUN", type=_PATH)
_overrides = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    help="Change a value of the case, as in --set time.end=2; may be repeated.",
)
_threads = click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Threads to use; if left out, as many as the case keeps busy.",
)


@click.group(cls=Commands)
@click.version_option(__version__, prog_name="debrisflow")
def main() -> None:
    """Particle simulation (MPS) of debris flows from TOML case files."""


@main.command()
@_case
@_overrides
def check(case: Path, overrides: tuple[str, ...]) -> None:
    """Validate CASE and print what it will run."""
    from debrisflow.case import load_case
    from debrisflow.forecast import forecast

    checked = load_case(case, overrides)
    click.echo(f"{case}: {checked.title}")
    click.echo(forecast(checked))


@main.command()
@_case
@_overrides
@_threads
@click.option("-o", "--output", type=_PATH, help="Folder of the results; runs/NAME if left out.")
@click.option("--overwrite", is_flag=True, help="Replace the results that the folder holds.")
def run(
    case: Path,
    overrides: tuple[str, ...],
    threads: int | None,
    output: Path | None,
    overwrite: bool,
) -> None:
    """Compute CASE and write its results into a folder."""
    from debrisflow.case import load_case

    checked = load_case(case, overrides)  # before the solver is imported, which takes a second

    from debrisflow.simulation import simulate

    folder = output or Path("runs") / case.stem
    _tell(simulate(checked, folder, threads=threads, overwrite=overwrite), folder)


@main.command()
@_results
@_threads
def resume(folder: Path, threads: int | None) -> None:
    """Continue the run in the folder RUN from its last checkpoint."""
    from debrisflow.simulation import resume

    _tell(resume(folder, threads=threads), folder)


def _tell(summary: dict[str, Any], folder: Path) -> None:
    lost = sum(summary["through_wall"].values())
    click.echo(
        f"{summary['end_reason']}: t = {summary['time']:g} s after {summary['steps']} steps, "
        f"{summary['wall_seconds']:.0f} s of wall time; results in {folder}"
    )
    if lost:
        click.echo(f"warning: {lost} particles went through a wall", err=True)


@main.command()
@click.argument("file", type=_PATH)
@click.option(
    "--template", default="flume2d", show_default=True, help="Shipped case to start from."
)
def init(file: Path, template: str) -> None:
    """Write a commented case FILE to start from."""
    from debrisflow.case.templates import start_case

    for path in start_case(file, template):
        click.echo(f"wrote {path}")


@main.command()
@_results
def postprocess(folder: Path) -> None:
    """Derive front, profiles and deposit from the results in the folder RUN."""
    from debrisflow.postprocess import arrivals, postprocess

    for path in postprocess(folder):
        click.echo(f"wrote {path}")
    for name, time in arrivals(folder).items():
        told = "nothing has passed" if isnan(time) else f"first passed by t = {time:g} s"
        click.echo(f"section {name}: {told}")


def _numbers(ctx: click.Context, option: click.Parameter, text: str | None) -> list[float] | None:
    """Read numbers separated by commas."""
    if text is None:
        return None
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = [inf]
    if not all(map(isfinite, numbers)):
        raise click.BadParameter(f"{text!r} is no list of numbers, such as 0,2.5")
    return numbers


def _window(ctx: click.Context, option: click.Parameter, text: str | None) -> list[float] | None:
    """Read the ends of a window along x and y."""
    ends = _numbers(ctx, option, text)
    if ends is not None and len(ends) != 4:
        raise click.BadParameter(f"needs 4 numbers, got {len(ends)}")
    if ends is not None and not (ends[0] < ends[1] and ends[2] < ends[3]):
        raise click.BadParameter("must be X0 < X1 and Y0 < Y1")
    return ends


@main.command()
@_results
@click.option(
    "--by",
    type=click.Choice(["kind", "speed", "concentration", "pressure", "granular_temperature"]),
    help="What the colors say; if left out the kind where there are several, else the speed.",
)
@click.option(
    "--times",
    metavar="T,T,...",
    callback=_numbers,
    help="Times of the panels, s; six evenly spread ones if left out.",
)
@click.option(
    "--window",
    metavar="X0,X1,Y0,Y1",
    callback=_window,
    help="Part of a run in two dimensions, m; all if left out.",
)
def render(
    folder: Path, by: str | None, times: list[float] | None, window: list[float] | None
) -> None:
    """Draw pictures and an animation of the particles of the run in the folder RUN."""
    from debrisflow.results.render import render

    for path in render(folder, by, times, window):
        click.echo(f"wrote {path}")


@main.command()
def schema() -> None:
    """Print the JSON schema of a case file, from which editors complete."""
    from debrisflow.case import case_schema

    click.echo(case_schema(), nl=False)


@main.command()
def info() -> None:
    """Print versions, cores, threading layer and cache folder."""
    from debrisflow.about import about

    for name, value in about().items():
        click.echo(f"{name:<16} {value}")
