"""A landslide on real terrain: run-out at the S-1000 road near Mount St. Helens, December 2021.

The shipped case, against the surveyed change of the ground.  Nothing is eroded.

References
----------
Keck, Istanbulluoglu, Campforts, Tucker & Horner-Devine 2024, A landslide runout model for sediment
transport, landscape evolution, and hazard assessment applications, Earth Surface Dynamics 12.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from debrisflow.case import load_case
from debrisflow.results import open_run
from debrisflow.results.layers import read_layer
from debrisflow.results.score import compare_with_observed
from debrisflow.run.names import LEDGER
from debrisflow.run.simulation import simulate
from debrisflow.run.tables import Table, read_table
from debrisflow.space.ground import ground_of
from debrisflow.validation.files import CASES

OBSERVED = CASES / "data" / "mt_st_helens2021_change.asc"
VOLUME = 22_481.0  # m3, released
BLIND = (
    "walls.floor.friction.coefficient=0.155",
    "walls.floor.friction.turbulence=200",
)
"""Coefficients of Voellmy's law that DebrisFrame has for debris flows by default."""
SPACINGS = 4.0, 2.0, 1.4, 1.0  # m
DEPTH = 4.0  # m, of the flow, by which rows of particles are counted


class Runout(NamedTuple):
    """What a landslide did until it came to rest.

    Attributes
    ----------
    score : dict of float
        By the names of :func:`debrisflow.results.score.compare_with_observed`.
    thick : float, m3
        Volume at the end where it is deeper than the threshold of the score, moving or not.
    ledger, history : tables
    nearest : float
        Least distance of a particle to the ground in a frame, in spacings.
    summary : dict
        Of the run.
    """

    score: dict[str, float]
    thick: float
    ledger: Table
    history: Table
    nearest: float
    summary: dict[str, Any]

    @property
    def is_balanced(self) -> bool:
        """Whether released = moving + at rest + left, to the particle, in every row."""
        row = self.ledger
        there = row["moving"] + row["at_rest"] + row["left"]
        return bool(np.all(row["released"] == there) and not row["through_ground"].any())


def of_spacing(spacing: float) -> tuple[str, ...]:
    """Return the changes of the case for a spacing, m, on the same smooth ground."""
    return f"particles.spacing={spacing}", "geometry.cell=10.0"


def run(changes: tuple[str, ...] = ()) -> Runout:
    """Run the shipped case with changes, as ``--set`` takes them, and compare it."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run"
        simulate(load_case(CASES / "mt_st_helens2021.toml", changes), path, threads=1)
        return runout_of(path)


def runout_of(folder: Path) -> Runout:
    """Return what the landslide in the folder of a run did."""
    found = compare_with_observed(folder, OBSERVED)
    score = {row.measure: row.value for row in found.rows}
    last = read_layer(folder, "final_depth")
    thick = np.nan_to_num(last.values)
    results = open_run(folder)
    ground, spacing = ground_of(results.case).surface, results.case.particles.spacing
    nearest = np.inf
    for frame in results.frames():
        x, y, z = frame.position.T
        level, along, across = ground.level_and_slope(x, y)
        height = (z - level) / np.sqrt(1.0 + along**2 + across**2)
        nearest = min(nearest, float(height.min() / spacing))
    return Runout(
        score=score,
        thick=float(thick[thick > score["threshold"]].sum() * last.grid.cell**2),
        ledger=read_table(folder / LEDGER),
        history=results.history,
        nearest=nearest,
        summary=results.summary,
    )
