"""The command line.  Each command imports what it needs itself, which keeps help fast."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any

import click

from debrisflow import __version__
from debrisflow.errors import DebrisflowError, Interrupted
from debrisflow.particles.arrays import COLORED

INTERRUPTED = 130  # the exit code of a shell
MOST_BOUNCED = 0.001  # share of the particles in a step, above which a note is printed
_PATH = click.Path(path_type=Path)


class Commands(click.Group):
    """Commands that print errors in plain words and return an exit code for each class."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; an error meant for the user becomes its message and exit code."""
        try:
            with _sigterm_as_interrupt():
                return super().invoke(ctx)
        except DebrisflowError as error:
            click.echo(error, err=True)
            ctx.exit(error.exit_code)
        except MemoryError as error:
            detail = f" ({error})" if str(error) else ""
            click.echo(
                f"the memory of this machine is used up{detail}; debrisflow check says what a case "
                "needs",
                err=True,
            )
            ctx.exit(DebrisflowError.exit_code)
        except KeyboardInterrupt as stop:
            goes_on = ctx.invoked_subcommand in ("run", "resume")
            how = "; the run goes on with: debrisflow resume RUN" if goes_on else ""
            click.echo(f"interrupted{how}", err=True)
            ctx.exit(stop.exit_code if isinstance(stop, Interrupted) else INTERRUPTED)


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
    help="Threads to use; by default as many as the case can keep busy.",
)
_stations = click.option(
    "--stations",
    type=numbers_type(),
    default=(),
    help="x of profiles and hydrographs, m: X,X,...; every eighth of the length if left out.",
)
_window = click.option(
    "--window",
    type=numbers_type(2, are_intervals=True),
    help="Times over which profiles and probes are averaged, s: T0,T1; the last fifth if left out.",
)


def _finite(_: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Refuse what is no number or without end."""
    if value is not None and not math.isfinite(value):
        raise click.BadParameter(f"{value} is no finite number", param=parameter)
    return value


_smooth = click.option(
    "--smooth",
    type=click.FloatRange(min=0.0),
    callback=_finite,
    help="Time over which samples of probes are averaged, s; ten of their intervals if left out.",
)
_references = click.option(
    "--reference",
    "references",
    type=_PATH,
    multiple=True,
    help="CSV file of curves to compare with; may be repeated.",
)

_language = click.option(
    "--language",
    type=click.Choice(["en", "ja"]),
    default="en",
    show_default=True,
    help="Language of headings and labels.",
)


@click.group(cls=Commands)
@click.version_option(__version__, prog_name="debrisflow")
def main() -> None:
    """Particle simulation (MPS) of debris flows from TOML case files."""


@main.command()
@_case
@_overrides
@click.option(
    "--measure",
    is_flag=True,
    help="Measure the wall time by two seconds of steps, after kernels are compiled.",
)
@click.option(
    "--plot",
    "picture",
    metavar="FILE.png",
    type=_PATH,
    help="Draw terrain, releases, zones, obstacles and probes of a case on a terrain.",
)
def check(case: Path, overrides: tuple[str, ...], measure: bool, picture: Path | None) -> None:
    """Validate CASE and print a forecast of its run."""
    from debrisflow.case import load_case
    from debrisflow.run.forecast import forecast
    from debrisflow.run.pace import last_pace

    checked = load_case(case, overrides)
    click.echo(f"{case}: {checked.title}")
    pace = last_pace(checked)
    if measure:
        from debrisflow.run.trial import measured_pace

        pace = measured_pace(checked)
    click.echo(forecast(checked, pace))
    if picture is not None:
        from debrisflow.results.maps.plan import draw_case

        _print_files([draw_case(checked, picture)])


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

    checked = load_case(case, overrides)  # before the import of the solver, which takes a second

    from debrisflow.run.loop import simulate

    folder = output or Path("runs") / case.stem
    _print_summary(simulate(checked, folder, threads=threads, overwrite=overwrite), folder)


@main.command()
@_results
@_threads
@click.option("--until", type=float, callback=_finite, help="A later end of the simulated time, s.")
@click.option(
    "--accept-changes",
    is_flag=True,
    help="Go on although the case, its files or the program have changed since.",
)
def resume(folder: Path, threads: int | None, until: float | None, accept_changes: bool) -> None:
    """Continue the run in the folder RUN from its last checkpoint.

    Without a checkpoint it begins anew.
    """
    from debrisflow.run.loop import resume

    summary = resume(folder, threads, until, accept_changes)
    if summary is None:
        click.echo(f"{folder} has come to its end; nothing is changed")
    else:
        _print_summary(summary, folder)


def _print_summary(summary: dict[str, Any], folder: Path) -> None:
    lost = sum(summary["through_wall"].values())
    compiled = summary["compile_seconds"]
    once = f" and {compiled:.0f} s of compiling kernels, once" if compiled >= 1.0 else ""
    click.echo(
        f"{summary['end_reason']}: t = {summary['time']:g} s after {summary['steps']} steps, "
        f"{summary['wall_seconds']:.0f} s of wall time{once}; results in {folder}"
    )
    if lost:
        click.echo(f"warning: {lost} particles went through a wall", err=True)
    bounced = summary.get("bounced_share", 0.0)
    if bounced > MOST_BOUNCED:
        click.echo(
            f"note: {100.0 * bounced:.2g} % of the fluid particles bounced off a wall in a step, "
            "on the mean; their impulse is in the forces on walls, but in no pressure",
            err=True,
        )


class WithTemplates(click.Command):
    """A command whose help lists the shipped cases."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the names of the templates and their titles."""
        from debrisflow.case.templates import titles

        with formatter.section("Templates"):
            formatter.write_dl(list(titles().items()))


@main.command(cls=WithTemplates)
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
@_stations
@_window
@click.option("--times", type=numbers_type(), default=(), help="Times of the deposit, s: T,T,...")
@_smooth
@_references
@click.option("--surface", is_flag=True, help="Write the free surface of each frame for ParaView.")
def postprocess(
    folder: Path,
    stations: tuple[float, ...],
    window: tuple[float, float] | None,
    times: tuple[float, ...],
    smooth: float | None,
    references: tuple[Path, ...],
    surface: bool,
) -> None:
    """Derive tables and plots from the results in the folder RUN, finished or running."""
    from debrisflow.results import open_run
    from debrisflow.results.postprocess import postprocess
    from debrisflow.results.references import read_reference
    from debrisflow.results.survey import survey_of

    given = [read_reference(path) for path in references]
    run = open_run(folder)
    if surface:
        run.walls()  # an error on a terrain, whose surface cannot be drawn
    found = survey_of(run, stations, window, times, smooth)
    written, messages = postprocess(found, given)
    if surface:
        from debrisflow.results.surface_files import write_surfaces

        written.append(write_surfaces(found.run))
    _print_files(written)
    for line in messages:
        click.echo(line)


@main.command()
@_results
@_language
@click.option(
    "--layers",
    metavar="NAME,NAME,...",
    default="",
    help="Layers to draw; all that the run wrote if left out.",
)
@click.option(
    "--dpi", type=click.IntRange(50, 600), default=200, show_default=True, help="Dots per inch."
)
def maps(folder: Path, language: str, layers: str, dpi: int) -> None:
    """Draw maps of the layers of the run in the folder RUN, over its terrain."""
    from debrisflow.results import open_run
    from debrisflow.results.maps import draw_maps
    from debrisflow.results.words import Words

    chosen = [name.strip() for name in layers.split(",") if name.strip()]
    written, messages = draw_maps(open_run(folder), Words(language), chosen, dpi)
    _print_files(written)
    for line in messages:
        click.echo(f"note: {line}", err=True)


@main.command()
@_results
@_stations
@_window
@_smooth
@_references
@_language
def report(
    folder: Path,
    stations: tuple[float, ...],
    window: tuple[float, float] | None,
    smooth: float | None,
    references: tuple[Path, ...],
    language: str,
) -> None:
    """Write a report on the run in the folder RUN: one self-contained HTML file.

    That of a run on a terrain has a map of its layers, which needs no network.
    """
    from debrisflow.results import open_run
    from debrisflow.results.references import read_reference
    from debrisflow.results.report import report
    from debrisflow.results.survey import survey_of
    from debrisflow.results.terrain_report import terrain_report
    from debrisflow.results.terrain_survey import TerrainSurvey

    given = [read_reference(path) for path in references]
    found = survey_of(open_run(folder), stations, window, smoothing=smooth)
    if isinstance(found, TerrainSurvey):
        _print_files([terrain_report(found, given, language)])
        return
    _print_files([report(found, given, language)])


@main.command()
@click.argument("folders", metavar="RUN RUN...", type=_PATH, nargs=-1, required=True)
@_stations
@_window
@_smooth
@_references
@click.option(
    "-o",
    "--output",
    type=_PATH,
    default=Path("comparison"),
    show_default=True,
    help="Folder of the tables and plots.",
)
def compare(
    folders: tuple[Path, ...],
    stations: tuple[float, ...],
    window: tuple[float, float] | None,
    smooth: float | None,
    references: tuple[Path, ...],
    output: Path,
) -> None:
    """Compare runs: parameters that differ, figures, and the same curves in one plot."""
    from debrisflow.results import open_run
    from debrisflow.results.compare import compare, table_lines
    from debrisflow.results.references import read_reference
    from debrisflow.results.survey import survey_of

    if len(folders) < 2:
        raise click.UsageError("two runs or more are needed to compare")
    given = [read_reference(path) for path in references]
    found = [survey_of(open_run(f), stations, window, smoothing=smooth) for f in folders]
    together, written = compare(found, output, given)
    for line in table_lines(together):
        click.echo(line)
    _print_files(written)


def _print_files(files: Sequence[Path]) -> None:
    for file in files:
        click.echo(f"wrote {file}")


@main.command()
@_results
@click.option(
    "--by",
    type=click.Choice(list(COLORED)),
    help="Quantity shown by the colors; by default the kind if there are several, else the speed.",
)
@click.option(
    "--times",
    type=numbers_type(),
    help="Times of the panels, s; six evenly spread ones if left out.",
)
@click.option(
    "--view",
    type=numbers_type(4, are_intervals=True),
    help="Part of a run in two dimensions, m: X0,X1,Y0,Y1; all if left out.",
)
def render(
    folder: Path,
    by: str | None,
    times: tuple[float, ...] | None,
    view: tuple[float, ...] | None,
) -> None:
    """Draw pictures and an animation of the particles of the run in the folder RUN."""
    from debrisflow.results.pictures import render

    _print_files(render(folder, by, times, view))


@main.command()
@_results
@click.option(
    "--classes",
    metavar="NAME|FILE",
    required=True,
    help="Table of thresholds: japan, swiss, or a TOML file.",
)
def hazard(folder: Path, classes: str) -> None:
    """Map hazard classes of the run in the folder RUN, on a terrain, by a table of thresholds."""
    from debrisflow.results.hazard import area_lines, hazard_map, write_hazard
    from debrisflow.results.hazard_classes import read_classes

    found = hazard_map(folder, read_classes(classes))
    for line in area_lines(found):
        click.echo(line)
    _print_files(write_hazard(folder, found))


@main.command()
@_results
@click.option(
    "--observed",
    type=_PATH,
    required=True,
    help="Polygons of the reached area (.gpkg, .geojson, .shp), or a raster of the change of "
    "elevation (.tif, .asc).",
)
@click.option(
    "--threshold",
    type=click.FloatRange(min=0.0),
    callback=_finite,
    help="Depth, and change of elevation, from which a cell counts, m; if left out 0.3 for a "
    "raster, and output.layer_depth of the run for polygons.",
)
def score(folder: Path, observed: Path, threshold: float | None) -> None:
    """Compare the run in the folder RUN, on a terrain, with an observed extent or deposit."""
    from debrisflow.results.score import compare_with_observed, score_lines
    from debrisflow.results.score_map import write_score

    found = compare_with_observed(folder, observed, threshold)
    for line in score_lines(found):
        click.echo(line)
    _print_files(write_score(folder, observed, found))


@main.command()
def schema() -> None:
    """Print the JSON schema of case files, which editors use for completion."""
    from debrisflow.case import case_schema

    click.echo(case_schema(), nl=False)


@main.command()
@click.option(
    "--compile",
    "with_kernels",
    is_flag=True,
    help="Also compile all kernels into the cache folder, which takes minutes.",
)
def info(with_kernels: bool) -> None:
    """Print versions, cores, threading layer and cache folder."""
    from debrisflow.about import HOW_TO_SHARE, about

    for name, value in about().items():
        click.echo(f"{name:<16} {value}")
    if with_kernels:
        from debrisflow.run.preparation import compile_kernels, short_runs

        for name, (path, changes) in short_runs().items():
            click.echo(f"compiling for {name}: ", nl=False)
            click.echo(f"{compile_kernels(path, changes):.1f} s")
        click.echo(HOW_TO_SHARE)
