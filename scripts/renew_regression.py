"""Renew the curves of tests/slow/regression, once it is understood why an answer has moved.

python scripts/renew_regression.py --reason "..." [NAME ...]
"""

from __future__ import annotations

import sys
from datetime import date
from pathlib import Path
from tempfile import TemporaryDirectory

import click

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.slow.regression.small_cases import COLUMNS, CURVES, SMALL_CASES, curve


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(sorted(SMALL_CASES)))
@click.option("--reason", required=True, help="Why the answer has moved; kept in the file.")
def main(names: tuple[str, ...], reason: str) -> None:
    """Renew the curves of NAMES, or of all small cases."""
    for name in names or SMALL_CASES:
        with TemporaryDirectory() as folder:
            rows = curve(name, Path(folder) / name)
        lines = [f"# {date.today()}: {reason}", ",".join(COLUMNS)]
        lines += [",".join(f"{value:.9g}" for value in row) for row in rows]
        (CURVES / f"{name}.csv").write_text("\n".join(lines) + "\n")
        click.echo(f"renewed {CURVES / name}.csv")


if __name__ == "__main__":
    main()
