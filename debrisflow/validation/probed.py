"""Run a case as a user does and read what its probes wrote."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.run.simulation import simulate

Table = NDArray[np.void]
"""Rows by the names of their columns."""


def series(path: Path) -> Table:
    """Return the rows of a probe file by the names of their columns."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    table: Table = np.genfromtxt(lines, delimiter=",", names=True)
    return table


def probed(case: ResolvedCase) -> tuple[dict[str, Any], dict[str, Table]]:
    """Run a case and return its summary and the samples of its probes."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run"
        summary = simulated(case, path)
        return summary, {one.stem: series(one) for one in (path / "probes").glob("*.csv")}


def simulated(case: ResolvedCase, folder: Path) -> dict[str, Any]:
    """Run a case into a folder on one thread, without a bar, and return its summary."""
    return simulate(case, folder, threads=1, on_event=_no_bar)


def _no_bar(_: Mapping[str, Any]) -> None:
    """Show nothing of a run."""
