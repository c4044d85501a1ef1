"""Commands that compute, and tell how a run goes: ``check``, ``run``, ``resume``, ``status``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from debrisflow.commands.console import RESULT, listener, logging_from, print_files, print_json
from debrisflow.commands.options import (
    PATH,
    case_argument,
    finite,
    json_option,
    overrides_option,
    run_argument,
    shown_options,
    threads_option,
)

MOST_BOUNCED = 0.001  # share of the particles in a step, above which a note is printed


@click.command()
@case_argument
@overrides_option
@click.option(
    "--measure",
    is_flag=True,
    help="Measure the wall time by two seconds of steps, after kernels are compiled.",
)
@click.option(
    "--plot",
    "picture",
    metavar="FILE.png",
    type=PATH,
    help="Draw terrain, releases, zones, obstacles and probes of a case on a terrain.",
)
@json_option
def check(
    case: Path, overrides: tuple[str, ...], measure: bool, picture: Path | None, as_json: bool
) -> None:
    """Validate CASE and print a forecast of its run."""
    from debrisflow.case import load_case
    from debrisflow.run.forecast import figures, forecast
    from debrisflow.run.pace import last_pace

    checked = load_case(case, overrides)
    if not as_json:
        click.echo(f"{case}: {checked.title}")
    pace = last_pace(checked)
    if measure:
        from debrisflow.run.trial import measured_pace

        pace = measured_pace(checked)
    found = forecast(checked, pace)
    if not as_json:
        click.echo(found)
    if picture is not None:
        from debrisflow.results.maps.plan import draw_case

        drawn = draw_case(checked, picture)
        if not as_json:
            print_files([drawn])
    if as_json:
        print_json({"event": RESULT, "title": checked.title} | figures(found))


@click.command()
@case_argument
@overrides_option
@threads_option
@click.option("-o", "--output", type=PATH, help="Folder of the results; runs/NAME if left out.")
@click.option("--overwrite", is_flag=True, help="Replace the results that the folder holds.")
@shown_options
def run(
    case: Path,
    overrides: tuple[str, ...],
    threads: int | None,
    output: Path | None,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
    log_level: str,
) -> None:
    """Compute CASE and write its results into a folder."""
    from debrisflow.case import load_case

    told = listener(as_json, quiet)

    checked = load_case(case, overrides)  # before the import of the solver, which takes a second

    from debrisflow.run.simulation import simulate

    folder = output or Path("runs") / case.stem
    with logging_from(log_level):
        summary = simulate(checked, folder, threads, overwrite, on_event=told)
    if as_json:
        _print_result(summary, folder)
    elif not quiet:
        _print_summary(summary, folder)


@click.command()
@run_argument
@threads_option
@click.option("--until", type=float, callback=finite, help="A later end of the simulated time, s.")
@click.option(
    "--accept-changes",
    is_flag=True,
    help="Go on although the case, its files or the program have changed since.",
)
@shown_options
def resume(
    folder: Path,
    threads: int | None,
    until: float | None,
    accept_changes: bool,
    as_json: bool,
    quiet: bool,
    log_level: str,
) -> None:
    """Continue the run in the folder RUN from its last checkpoint.

    Without a checkpoint it begins anew.
    """
    told = listener(as_json, quiet)

    from debrisflow.run.folder import read_summary
    from debrisflow.run.simulation import resume

    with logging_from(log_level):
        summary = resume(folder, threads, until, accept_changes, on_event=told)
    if as_json:
        _print_result(summary or read_summary(folder), folder)
    elif quiet:
        return
    elif summary is None:
        click.echo(f"{folder} has come to its end; nothing is changed")
    else:
        _print_summary(summary, folder)


@click.command()
@run_argument
@json_option
def status(folder: Path, as_json: bool) -> None:
    """Tell where the run in the folder RUN is, and how it goes on."""
    from debrisflow.run.folder_status import status_of
    from debrisflow.run.status_lines import status_lines

    found = status_of(folder)
    if as_json:
        print_json({"event": RESULT} | found)
        return
    for line in status_lines(found):
        click.echo(line)


def _print_result(summary: dict[str, Any], folder: Path) -> None:
    print_json({"event": RESULT, "folder": str(folder)} | summary)


def _print_summary(summary: dict[str, Any], folder: Path) -> None:
    compiled = summary["compile_seconds"]
    once = f" and {compiled:.0f} s of compiling kernels, once" if compiled >= 1.0 else ""
    click.echo(
        f"{summary['end_reason']}: t = {summary['time']:g} s after {summary['steps']} steps, "
        f"{summary['wall_seconds']:.0f} s of wall time{once}; results in {folder}"
    )
    bounced = summary.get("bounced_share", 0.0)
    if bounced > MOST_BOUNCED:
        click.echo(
            f"note: {100.0 * bounced:.2g} % of the fluid particles bounced off a wall in a step, "
            "on the mean; their impulse is in the forces on walls, but in no pressure",
            err=True,
        )
