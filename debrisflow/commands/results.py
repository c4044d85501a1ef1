"""Commands that read the results of runs: tables, pictures, maps, reports and comparisons."""

from __future__ import annotations

from pathlib import Path

import click

from debrisflow.commands.console import print_files
from debrisflow.commands.options import (
    PATH,
    finite,
    language_option,
    numbers_type,
    references_option,
    run_argument,
    smooth_option,
    stations_option,
    window_option,
)
from debrisflow.particles.arrays import COLORED


@click.command()
@run_argument
@stations_option
@window_option
@click.option("--times", type=numbers_type(), default=(), help="Times of the deposit, s: T,T,...")
@smooth_option
@references_option
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
    print_files(written)
    for line in messages:
        click.echo(line)


@click.command()
@run_argument
@language_option
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
    print_files(written)
    for line in messages:
        click.echo(f"note: {line}", err=True)


@click.command()
@run_argument
@stations_option
@window_option
@smooth_option
@references_option
@language_option
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
        print_files([terrain_report(found, given, language)])
        return
    print_files([report(found, given, language)])


@click.command()
@click.argument("folders", metavar="RUN RUN...", type=PATH, nargs=-1, required=True)
@stations_option
@window_option
@smooth_option
@references_option
@click.option(
    "-o",
    "--output",
    type=PATH,
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
    print_files(written)


@click.command()
@run_argument
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

    print_files(render(folder, by, times, view))


@click.command()
@run_argument
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
    print_files(write_hazard(folder, found))


@click.command()
@run_argument
@click.option(
    "--observed",
    type=PATH,
    required=True,
    help="Polygons of the reached area (.gpkg, .geojson, .shp), or a raster of the change of "
    "elevation (.tif, .asc).",
)
@click.option(
    "--threshold",
    type=click.FloatRange(min=0.0),
    callback=finite,
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
    print_files(write_score(folder, observed, found))
