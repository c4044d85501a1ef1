"""A landslide on real terrain: run-out at the S-1000 road near Mount St. Helens, December 2021.

The shipped case, against the surveyed change of the ground.  Nothing is eroded.

References
----------
Keck, Istanbulluoglu, Campforts, Tucker & Horner-Devine 2024, A landslide runout model for sediment
transport, landscape evolution, and hazard assessment applications, Earth Surface Dynamics 12.
"""

from __future__ import annotations

from collections.abc import Mapping
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
from debrisflow.run.names import LEDGER
from debrisflow.run.simulation import simulate
from debrisflow.run.tables import Table, read_table
from debrisflow.space.ground import ground_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact, measured
from debrisflow.validation.files import CASES
from debrisflow.validation.row import Row, at_least, at_most, near, none_of, stated

Floats = NDArray[np.float64]
OBSERVED = CASES / "data" / "mt_st_helens2021_change.asc"
VOLUME = 22_481.0
"""That was released, m3."""
BLIND = (
    "walls.floor.friction.coefficient=0.155",
    "walls.floor.friction.turbulence=200",
)
"""Coefficients of Voellmy's law that DebrisFrame has for debris flows by default."""
DEPTH = 4.0
"""Of the flow, m, by which rows of particles are counted."""
BIN = 50.0
"""Of the distance from the release in figures, m."""
LIMIT = 400.0
"""When a run ends that does not come to rest, s."""
SPREAD = (
    "it spreads beside the gully, half of it by less than 1 m deep, and on the slope under the "
    "scar, where it leaves nothing to be surveyed. Tried: sliding friction of 0.15 to 0.25, ξ of "
    "50 to 500 m/s², pore pressure that decays, internal friction: 0.38 to 0.48"
)
STREAMS = (
    "on slopes steeper than its sliding friction, which most of the gully is, a flow by Voellmy's "
    "law thins and never stops; what is slower than 5 cm/s counts as deposit"
)
ONE_ROW = "a single row stops half-way in the gully, whose slope is near the sliding friction"
BY_ROWS = "10 m cells on a path of 770 m, and the run-out of other codes on mapped events"


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
        simulate(
            load_case(CASES / "mt_st_helens2021.toml", changes), path, threads=1, on_event=_no_bar
        )
        return runout_of(path)


def _no_bar(_: Mapping[str, Any]) -> None:
    """Show nothing of a run."""


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


def measure(level: Level) -> Measured:
    """Return the landslide with the fitted friction at a level."""
    found = run(of_spacing(DEPTH / level.across))
    score, coarse = found.score, ONE_ROW if level.across < 2.0 else ""
    rows = (
        *_distance_rows(found, coarse),
        at_least(
            "critical success index of the extent (fitted)",
            score["csi"],
            0.5,
            "what depth-averaged codes reach after calibration",
            miss=SPREAD,
        ),
        near(
            "volume at the end deeper than 0.3 m",
            found.thick,
            score["deposit_volume_observed"],
            "surveys of 0.3 m, and erosion that is not computed",
            share=0.2,
            unit="m³",
        ),
        at_least(
            "… of it at rest, less what rose, over what rose",
            0.01 * score["deposit_volume_error"],
            -0.2,
            "surveys of 0.3 m, and erosion that is not computed",
            "%",
            miss=STREAMS,
        ),
        at_most(
            "kinetic energy under 1 % of its greatest after",
            float(found.summary["time"]),
            LIMIT,
            "landslides of this size stop within minutes",
            "s",
        ),
        *_integrity_rows(found),
    )
    return Measured(rows, abs(0.01 * score["reach_error"]), _panels(found))


def measure_blind(level: Level) -> Measured:
    """Return the landslide with the default friction of another code at a level."""
    found = run((*of_spacing(DEPTH / level.across), *BLIND))
    score = found.score
    rows = (
        *_distance_rows(found, ""),
        stated("critical success index of the extent", score["csi"]),
        stated(
            "observed cells that are reached",
            score["hits"] / (score["hits"] + score["misses"]),
            "%",
        ),
        stated("cells that are reached and not observed", score["false_alarms"]),
        none_of("particles off the balance or under the ground", not found.is_balanced),
    )
    return Measured(rows, abs(0.01 * score["reach_error"]), _panels(found))


def _distance_rows(found: Runout, miss: str) -> tuple[Row, ...]:
    score = found.score
    return (
        near(
            "run-out along the path",
            score["runout_simulated"],
            score["runout_observed"],
            BY_ROWS,
            share=0.1,
            unit="m",
            miss=miss,
        ),
        near(
            "… in a straight line",
            score["reach_simulated"],
            score["reach_observed"],
            BY_ROWS,
            share=0.1,
            unit="m",
            miss=miss,
        ),
    )


def _integrity_rows(found: Runout) -> tuple[Row, ...]:
    return (
        near(
            "volume released",
            float(found.ledger["volume_released"][-1]),
            VOLUME,
            "particles of 8 m³ fill a raster of depths",
            share=0.01,
            unit="m³",
        ),
        at_least(
            "greatest speed",
            float(found.history["maximal_speed"].max()),
            5.0,
            "of a landslide that fell by 300 m",
            "m/s",
        ),
        none_of(
            "released other than moving + at rest + left, or under the ground",
            not found.is_balanced,
        ),
        at_least(
            "least height of a particle over the ground",
            found.nearest,
            0.0,
            "nothing is under the ground",
            "d0",
        ),
    )


def _panels(found: Runout) -> tuple[Panel, ...]:
    here = found.profile
    near_enough = here.distance < 1.5 * found.score["reach_observed"]
    at, place = here.distance[near_enough], "distance from the release (m)"
    time, front = found.history["time"], found.history["front_all"]
    known = np.isfinite(front)
    observed = np.full(2, found.score["reach_observed"])
    return (
        Panel(
            "front",
            "t (s)",
            place,
            (
                exact([0.0, LIMIT], observed, "observed end"),
                computed(time[known], front[known]),
            ),
        ),
        Panel(
            "extent",
            place,
            "cells of 10 m by 10 m in 50 m",
            (
                measured(at, here.observed_cells[near_enough], "ground changed"),
                computed(at, here.cells[near_enough]),
            ),
        ),
        Panel(
            "deposit",
            place,
            "volume in 50 m (m³)",
            (
                measured(at, here.observed_volume[near_enough], "ground rose"),
                computed(at, here.volume[near_enough]),
            ),
        ),
    )


_KECK = (
    "Keck, Istanbulluoglu, Campforts, Tucker & Horner-Devine 2024, Earth Surface Dynamics 12; "
    "terrain, release and surveyed change of the ground with landlab, MIT License"
)
_COMPARED = (
    "Where a landslide of 22,481 m³ comes to rest, and the cells that it has reached by more than "
    "0.3 m, against those whose ground has changed by more than 0.3 m; "
)
COMPARISONS = (
    Comparison(
        name="st_helens",
        title="Landslide near Mount St. Helens, December 2021, fitted",
        group=Group.FIELD,
        compared=_COMPARED + "volume and rest of the deposit.",
        reference=_KECK,
        parameters="`cases/mt_st_helens2021.toml`: Voellmy's law with μ = 0.2, ξ = 100 m/s², no "
        "erosion, no strength inside",
        calibrated="μ and ξ, on run-out and extent, at 2 m",
        levels=(
            Level(1, "4 m", 3),
            Level(2, "2 m", 40, is_quick=True),
            Level(DEPTH / 1.4, "1.4 m", 180),
            Level(4, "1 m", 680),
        ),
        measure=measure,
        error="reach in a straight line, relative to the observed one",
        discussion=(
            "Half of the false alarms are around the scar and on the slope below it; the others "
            "are beside the gully, which is one or two cells wide. Too much is left in the steep "
            "part of the gully. Nothing is eroded, whereas 5,000 m³ of ground were. The mass is "
            "faster the finer it is, since nothing but the lowest row feels the ground; two rows "
            "are the coarsest that hold."
        ),
    ),
    Comparison(
        name="st_helens_blind",
        title="Landslide near Mount St. Helens, December 2021, blind",
        group=Group.FIELD,
        compared=_COMPARED + "with default coefficients.",
        reference=_KECK,
        parameters="`cases/mt_st_helens2021.toml` with μ = 0.155, ξ = 200 m/s², DebrisFrame's "
        "default for debris flows",
        levels=(Level(1, "4 m", 3), Level(2, "2 m", 50), Level(DEPTH / 1.4, "1.4 m", 200)),
        measure=measure_blind,
        error="reach in a straight line, relative to the observed one",
        discussion="What a user gets who knows nothing of the event but its release.",
    ),
)
