"""Commands on case files and the installation: ``init``, ``schema``, ``info``."""

from __future__ import annotations

from pathlib import Path

import click

from debrisflow.commands.console import RESULT, print_json
from debrisflow.commands.options import PATH, json_option


class WithTemplates(click.Command):
    """A command whose help lists the shipped cases."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the names of the templates and their titles."""
        from debrisflow.case.templates import titles

        with formatter.section("Templates"):
            formatter.write_dl(list(titles().items()))


@click.command(cls=WithTemplates)
@click.argument("file", type=PATH)
@click.option(
    "--template", default="flume2d", show_default=True, help="Shipped case to start from."
)
def init(file: Path, template: str) -> None:
    """Write a commented case FILE to start from."""
    from debrisflow.case.templates import start_case

    for path in start_case(file, template):
        click.echo(f"wrote {path}")


@click.command()
def schema() -> None:
    """Print the JSON schema of case files, which editors use for completion."""
    from debrisflow.case import case_schema

    click.echo(case_schema(), nl=False)


@click.command()
@click.option(
    "--compile",
    "with_kernels",
    is_flag=True,
    help="Also compile all kernels into the cache folder, which takes minutes.",
)
@json_option
def info(with_kernels: bool, as_json: bool) -> None:
    """Print versions, cores, threading layer and cache folder."""
    from debrisflow.about import HOW_TO_SHARE, about

    if as_json and with_kernels:
        raise click.UsageError("--compile has no answer as JSON; give one of them")
    if as_json:
        print_json({"event": RESULT} | about())
        return
    for name, value in about().items():
        click.echo(f"{name:<16} {value}")
    if with_kernels:
        from debrisflow.run.preparation import compile_kernels, short_runs

        for name, (path, changes) in short_runs().items():
            click.echo(f"compiling for {name}: ", nl=False)
            click.echo(f"{compile_kernels(path, changes):.1f} s")
        click.echo(HOW_TO_SHARE)
