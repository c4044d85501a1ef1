"""The landslide near Mount St. Helens of the shipped case, run and compared with its survey."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.case.rasters import read_raster
from debrisflow.results import open_run
from debrisflow.results.flow_path import centers
from debrisflow.results.layers import read_layer
from debrisflow.results.score import compare_with_observed, on_grid
from debrisflow.run.events import AT_REST
from debrisflow.run.names import LEDGER
from debrisflow.run.tables import Table, read_table
from debrisflow.space.ground import ground_of
from debrisflow.validation.files import CASES
from debrisflow.validation.probed import simulated

Floats = NDArray[np.float64]
OBSERVED = CASES / "data" / "mt_st_helens2021_change.asc"
BIN = 50.0
"""Of the distance from the release in figures, m."""


class Profile(NamedTuple):
    """What lies at distances from the middle of the release, in bins of 50 m.

    Attributes
    ----------
    distance : (n,) float64 array, m
        Middles of the bins, in a straight line.
    cells, observed_cells : (n,) float64 array
        That the flow reached, and whose ground has changed.
    volume, observed_volume : (n,) float64 array, m3
        At the end, and by which the ground rose, where it is more than the threshold of the score.
    """

    distance: Floats
    cells: Floats
    observed_cells: Floats
    volume: Floats
    observed_volume: Floats


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
    profile : Profile
    """

    score: dict[str, float]
    thick: float
    ledger: Table
    history: Table
    nearest: float
    summary: dict[str, Any]
    profile: Profile

    @property
    def rest(self) -> float:
        """When it came to rest, s; nan if it did not before the end of the run."""
        is_at_rest = self.summary["end_reason"] == AT_REST
        return float(self.summary["time"]) if is_at_rest else np.nan

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
        simulated(load_case(CASES / "mt_st_helens2021.toml", changes), path)
        return runout_of(path)


def runout_of(folder: Path) -> Runout:
    """Return what the landslide in the folder of a run did."""
    found = compare_with_observed(folder, OBSERVED)
    score = {row.measure: row.value for row in found.rows}
    last = read_layer(folder, "final_depth")
    least, area = score["threshold"], last.grid.cell**2
    thick = np.nan_to_num(last.values)
    thick[thick <= least] = 0.0
    risen = np.nan_to_num(on_grid(read_raster(OBSERVED), last.grid))
    risen[risen <= least] = 0.0
    east, north = np.meshgrid(*centers(last.grid))
    start = found.path.coords[0]
    number = (np.hypot(east - start[0], north - start[1]) / BIN).astype(int).ravel()
    distance = np.arange(0.5, number.max() + 1, dtype=np.float64) * BIN
    sums: list[Floats] = [
        np.asarray(np.bincount(number, values.ravel()), dtype=np.float64)
        for values in (found.simulated, found.observed, area * thick, area * risen)
    ]
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
        thick=float(thick.sum() * area),
        ledger=read_table(folder / LEDGER),
        history=results.history,
        nearest=nearest,
        summary=results.summary,
        profile=Profile(distance, *sums),
    )
