"""Small cases whose scalar curves are kept, and how a curve is computed."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.run.names import HISTORY
from debrisflow.run.simulation import simulate

ROOT = Path(__file__).parents[3]
CURVES = Path(__file__).parent / "curves"
COLUMNS = ("time", "front_all", "kinetic_energy", "potential_energy", "mass_in_liquid")
SMALL_CASES = {
    "dam_break2d": (
        "particles.spacing=0.003571875",
        "time.end=0.2",
        "output.history_interval=0.01",
        "output.interval=0.2",
    ),
    "dam_break3d": (
        "particles.spacing=0.2",
        "geometry.height=2.4",
        "time.end=0.8",
        "output.history_interval=0.05",
        "output.interval=0.8",
    ),
    "column_collapse2d": (
        "time.end=0.4",
        "output.history_interval=0.02",
        "output.interval=0.4",
    ),
    "bed_erosion2d": (
        "time.settling=0.2",
        "time.end=0.4",
        "output.history_interval=0.05",
        "output.interval=0.4",
    ),
}


def curve(name: str, folder: Path) -> NDArray[np.float64]:
    """Run a small case in a folder and return its history, one row a time, by ``COLUMNS``."""
    case = load_case(ROOT / "cases" / f"{name}.toml", SMALL_CASES[name])
    simulate(case, folder, threads=1)
    return read(folder / HISTORY)


def read(path: Path) -> NDArray[np.float64]:
    """Return a table of curves by ``COLUMNS``; lines that begin with # are left out."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array([[float(row[c]) for c in COLUMNS] for row in csv.DictReader(lines)])
