"""A debris flow that comes to rest where its flume bends to a milder slope."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.particles.start import initial_state
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.space.floor import height_over_floor, runout_bend
from debrisflow.validation.beds.endless_bed import limit_slope
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.debris_flows.flume import DEPOSITED, Frame, channel_of, frame_of
from debrisflow.validation.debris_flows.sources import TAKAHASHI
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import advance
from debrisflow.validation.row import Row, at_least, at_most, between, none_of

Floats = NDArray[np.float64]
LENGTH = 0.3
"""Behind the bend, of what is measured of the deposit, m."""
BED = 0.05
"""Thickness of the bed, m."""
FRICTION = 35.0
"""Friction angle, degrees."""
WATCHED = 2.0
"""Time at the end in which the deposit shall not move, s."""
SEEDS = "10 mm, seedings 2 to 4"
OTHER_SEEDS = 2, 3, 4


class Deposit(NamedTuple):
    """A deposit in the last two seconds of a run.

    Attributes
    ----------
    moved : (n,) float64 array
        How far its grains moved, in spacings; grains in a film of water do not belong to it.
    on_runout : float
        Share of the sediment on the run-out.
    along, heights : (n,) float64 array, m
        Distances behind the bend and depths there.
    slope : float
        By which the surface of the first 0.3 m of it falls below the horizontal, degrees.
    through_wall : int
    """

    moved: Floats
    on_runout: float
    along: Floats
    heights: Floats
    slope: float
    through_wall: int

    @property
    def depth(self) -> float:
        """The depth just behind the bend, m."""
        return float(self.heights[:3].mean())


def run(spacing: float = 0.01, seed: int = 1) -> Deposit:
    """Run the shipped case to its end and return its deposit."""
    changes = (f"particles.spacing={spacing!r}", f"particles.seed={seed}")
    case = load_case(CASES / "flume_deposit2d.toml", changes)
    scheme, state = SemiImplicit(case), initial_state(case)
    advance(scheme, state, until=case.time.end - WATCHED)
    before = frame_of(state)
    advance(scheme, state, until=case.time.end)
    after = frame_of(state)
    shape, d0 = channel_of(case), case.particles.spacing
    assert shape.runout_start is not None
    x, y = after.position[after.fraction > 0.0].T
    height = height_over_floor(case, x, y, x)
    number = np.floor((x - shape.runout_start) / (2.0 * d0)).astype(int)
    places = np.arange(round(LENGTH / (2.0 * d0)))
    # over the floor, so that a place without sediment has the depth 0 and not that of x = 0
    tops = np.array([height[number == k].max(initial=-0.5 * d0) for k in places]) + 0.5 * d0
    along = (places + 0.5) * 2.0 * d0 / np.cos(runout_bend(case))
    thinning = float(np.degrees(np.arctan(-np.polyfit(along, tops, 1)[0])))
    return Deposit(
        _moved(before, after) / d0,
        float(np.mean(x > shape.runout_start)),
        along,
        tops,
        shape.runout_slope + thinning,
        int(state.through_wall.sum()),
    )


def _moved(before: Frame, after: Frame) -> Floats:
    """Return how far deposited grains moved, m."""
    _, one, other = np.intersect1d(before.id, after.id, return_indices=True)
    deposited = (after.fraction[other] > 0.0) & (before.concentration[one] >= DEPOSITED)
    step = after.position[other] - before.position[one]
    lengths: Floats = np.linalg.norm(step, axis=1)[deposited]
    return lengths


def measure(level: Level) -> Measured:
    """Return the deposits of a level."""
    seeds = OTHER_SEEDS if level.label == SEEDS else (1,)
    found = [run(BED / level.across, seed) for seed in seeds]
    rows = [row for seed, one in zip(seeds, found, strict=True) for row in _rows(one, seed)]
    return Measured(tuple(rows), panels=(_panel(found),))


def _rows(found: Deposit, seed: int) -> tuple[Row, ...]:
    steepest = limit_slope(FRICTION)
    of_seed = f", seeding {seed}" if seed > 1 else ""
    return (
        at_most(
            f"mean displacement in the last 2 s{of_seed}",
            float(found.moved.mean()),
            0.1,
            "a particle at rest stays in its place; chosen: far less than a spacing",
            "d0",
        ),
        at_least(
            f"sediment behind the bend{of_seed}",
            found.on_runout,
            0.1,
            "chosen: a tenth; a debris flow stops where its slope is milder than what carries it",
            "%",
        ),
        at_least(
            f"depth just behind the bend{of_seed}",
            found.depth,
            0.02,
            "chosen: two rows of 10 mm; what is deeper is no film of water",
            "m",
        ),
        between(
            f"slope of its surface{of_seed}",
            found.slope,
            4.0,
            steepest,
            "chosen: 1° more than the run-out has, since a deposit thins downstream; a saturated "
            "bed slides from its limit slope on",
            "°",
        ),
        none_of(f"particles through a wall{of_seed}", found.through_wall),
    )


def _panel(found: list[Deposit]) -> Panel:
    along = found[0].along
    steepest = np.tan(np.radians(limit_slope(FRICTION) - 3.0)) * along
    start = float(np.mean([one.depth for one in found]))
    limit = np.maximum(start - steepest, 0.0)
    return Panel(
        "deposit at rest",
        "distance behind the bend (m)",
        "depth (m)",
        (
            exact(along, limit, "limit slope"),
            *(points(one.along, one.heights) for one in found),
        ),
    )


COMPARISONS = (
    Comparison(
        name="flume_deposit2d",
        title="Deposit behind a bend of a flume",
        group=Group.DEBRIS_FLOWS,
        compared=(
            "Whether a debris flow is at rest ten seconds after its supply has ended, and the "
            "slope of its deposit against the limit slope of a saturated bed. No experiment: what "
            "must hold of any deposit."
        ),
        reference=(f"limit slope, tan θ = C (ρ_s - ρ) tan φ / [C (ρ_s - ρ) + ρ]: {TAKAHASHI}"),
        parameters=(
            "`cases/flume_deposit2d.toml`: flume that bends from 15° to 3°, bed of 50 mm, friction "
            "angle of 35°, supply of 100 cm²/s for 4 s"
        ),
        levels=(
            Level(5, "10 mm", 58, is_quick=True),
            Level(5, SEEDS, 180),
            Level(7, "7 mm", 150),
        ),
        measure=measure,
        discussion=(
            "Two spacings only, and the limit slope is a bound and no value, so that there is no "
            "error to have an order. Digits of the processor choose among deposits, as other "
            "seedings do. Single grains in the film of water over the run-out make up the mean "
            "displacement."
        ),
    ),
)
