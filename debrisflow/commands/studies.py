"""Commands on many runs: ``sweep``, ``sweep status``."""

from __future__ import annotations

from collections import Counter
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from debrisflow.commands.console import RESULT, print_files, print_json
from debrisflow.commands.options import PATH, json_option
from debrisflow.errors import OutputError, shown

if TYPE_CHECKING:
    from debrisflow.study.member import Member
    from debrisflow.study.outcome import Outcome
    from debrisflow.study.sweep import Sweep


class WithDefault(click.Group):
    """Commands of which one is meant where none is named."""

    default = "run"

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the name of the default before arguments that begin with no other."""
        if args and args[0] not in self.commands and args[0] != "--help":
            args = [self.default, *args]
        return super().parse_args(ctx, args)


@click.group(cls=WithDefault)
def sweep() -> None:
    """Compute many runs of one case: debrisflow sweep STUDY.toml.

    What was computed before is not computed again, so that a sweep that was stopped goes on with
    the same command.
    """


@sweep.command()
@click.argument("study", metavar="STUDY", type=PATH)
@click.option("-o", "--output", type=PATH, help="Folder of the results; runs/NAME if left out.")
@click.option(
    "--store", type=PATH, help="Folder of the runs, to share them; members/ in that of the results."
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Members computed at a time; as many as cores and memory allow if left out.",
)
@click.option(
    "--threads", type=click.IntRange(min=1), default=1, show_default=True, help="Of each member."
)
@click.option(
    "--scheduler", metavar="tcp://HOST:PORT", help="Use the workers of a running dask scheduler."
)
@click.option("--dry-run", is_flag=True, help="Only tell how many members, hours and bytes.")
@click.option("--quiet", is_flag=True, help="Print nothing but warnings and errors.")
@json_option
def run(
    study: Path,
    output: Path | None,
    store: Path | None,
    workers: int | None,
    threads: int,
    scheduler: str | None,
    dry_run: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute the runs that STUDY states, and what it wants of them (the default)."""
    from debrisflow.study.sweep import Sweep

    if scheduler and workers:
        raise click.UsageError("--scheduler has workers of its own; leave out --workers")
    asked = Sweep.from_file(study, output, store)
    if dry_run:
        _tell_plan(asked, asked.room(workers, threads, scheduler), as_json)
        return

    from debrisflow.study.analysis import analyze
    from debrisflow.study.names import FINDINGS
    from debrisflow.study.outcome import STOPPED
    from debrisflow.study.progress import Bar

    bar = nullcontext(_print_member) if as_json else Bar(len(asked.members), quiet)
    with asked.workers(workers, threads, scheduler) as client, asked.open(), bar as told:
        found = analyze(asked, asked.results(client, threads, told), client, threads, told)
    results, written = found.results, found.files
    counts = Counter(outcome.state for outcome in results.outcomes)
    for message in found.warnings:
        click.echo(f"warning: {shown(message)}", err=True)
    if as_json:
        result = {"event": RESULT, "folder": str(asked.folder), "warnings": found.warnings}
        print_json(result | {"files": [str(file) for file in written]} | counts)
    elif not quiet:
        print_files(written)
        for file in written:
            if file.name == FINDINGS:
                click.echo(shown(file.read_text(encoding="utf-8").rstrip()))
        parts = ", ".join(f"{count} {state}" for state, count in counts.items())
        click.echo(f"{len(results.members)} members: {parts}; results in {asked.folder}")
    errors = found.errors
    if counts[STOPPED]:
        stopped = OutputError(
            f"{counts[STOPPED]} members could not be computed; once the cause is removed, the same "
            "command goes on with them"
        )
        errors = [stopped, *errors]
    if errors:
        raise type(errors[0])("\n".join(map(str, errors)))


def _tell_plan(asked: Sweep, workers: int, as_json: bool) -> None:
    """Print how many members there are, and what they need."""
    from debrisflow.study.plan import plan_figures, plan_lines

    found = plan_figures(asked, workers)
    if as_json:
        print_json({"event": RESULT} | found)
        return
    for line in plan_lines(found):
        click.echo(line)


def _print_member(member: Member, outcome: Outcome) -> None:
    """Print a member that is over as a line of JSON."""
    known = {"number": member.number, "folder": str(member.folder), "values": member.values}
    print_json({"event": "member"} | known | {"state": outcome.state, "message": outcome.message})


@sweep.command()
@click.argument("folder", metavar="SWEEP", type=PATH)
@json_option
def status(folder: Path, as_json: bool) -> None:
    """Tell where the sweep in the folder SWEEP is."""
    from debrisflow.study.status import status_lines, sweep_status

    found = sweep_status(folder)
    if as_json:
        print_json({"event": RESULT} | found)
        return
    for line in status_lines(found):
        click.echo(line)
