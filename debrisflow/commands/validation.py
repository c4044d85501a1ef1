"""The command ``validate``: experiments and closed forms, computed here and compared."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from debrisflow.commands.console import RESULT, print_files, print_json
from debrisflow.commands.options import PATH, json_option
from debrisflow.errors import CaseError

if TYPE_CHECKING:
    from debrisflow.validation.comparison import Comparison


@click.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--quick", "is_quick", is_flag=True, help="Only what takes ten minutes in all.")
@click.option("--list", "is_list", is_flag=True, help="Say what there is, and how long it takes.")
@click.option(
    "-o",
    "--output",
    type=PATH,
    default=Path("validation"),
    show_default=True,
    help="Folder of the results; what is there of other comparisons stays.",
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Levels computed at the same time, one thread each; as many as cores if left out.",
)
@json_option
def validate(
    names: tuple[str, ...],
    is_quick: bool,
    is_list: bool,
    output: Path,
    workers: int | None,
    as_json: bool,
) -> None:
    """Compute published experiments and closed forms on this machine, and compare.

    NAMEs are those of comparisons or groups of them, as --list shows; all if left out.  A folder
    is written with a table, a report in HTML and a page in Markdown.  The exit code is 5 if a row
    is outside its limit unexpectedly.
    """
    from debrisflow.validation.selection import chosen

    comparisons = chosen(names)
    if is_list:
        _print_list(comparisons, as_json)
        return

    from debrisflow._jit import cores
    from debrisflow.validation.publication import Validation
    from debrisflow.validation.result import count, plain
    from debrisflow.validation.runner import compute, plan, tasks_of
    from debrisflow.validation.table import level_lines, summary

    tasks = tasks_of(comparisons, is_quick)
    if not tasks:
        raise CaseError(f"not in the quick set: {', '.join(names)}; leave out --quick")
    run = Validation.begin(output, comparisons)
    workers = workers or cores()
    if not as_json:
        click.echo(f"{plan(tasks, workers)}\n")
    for task, found in compute(tasks, workers):
        comparison = run.add(task.name, found)
        if as_json:
            print_json({"event": "level", "name": task.name} | plain(found._replace(panels=())))
        else:
            click.echo("\n".join(level_lines(comparison, found)) + "\n")
    files = run.write()
    if as_json:
        listed = {"folder": str(output), "files": [str(file) for file in files]}
        print_json({"event": RESULT} | listed | count(run.computed)._asdict())
    else:
        print_files(files)
        click.echo(summary(run.computed))
    run.refuse_unexplained()


def _print_list(comparisons: list[Comparison], as_json: bool) -> None:
    """Print names, titles and how long they take, by groups."""
    from debrisflow.validation.selection import listed_lines, listed_values

    if as_json:
        print_json({"event": RESULT, "comparisons": listed_values(comparisons)})
        return
    for line in listed_lines(comparisons):
        click.echo(line)
