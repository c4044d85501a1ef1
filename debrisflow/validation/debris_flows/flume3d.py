"""Debris flow from a movable bed in a narrow flume in three dimensions: case B2 of the study."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.run.measures import FRONT_SHARE, particle_volume
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.debris_flows.flume import discharge_of
from debrisflow.validation.debris_flows.short_flume import EQUILIBRIUM, takahashi
from debrisflow.validation.debris_flows.sources import STUDY, TAKAHASHI
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import states
from debrisflow.validation.row import at_most, conserved, near, none_of, stated

Floats = NDArray[np.float64]
BED = 0.03
"""Thickness of the bed, m."""
SAMPLE = 0.02
"""Time between two rows of the record, s."""
DRY_UNTIL = 0.8
"""Until when hardly any water has come to the bed, s."""
APART = (
    "particles of the bed keep their pore water and those of the inflow have no grains, so that "
    "the water shears the surface of the bed and does not mix into it"
)


class Flume(NamedTuple):
    """What the flume did.

    Attributes
    ----------
    time, front : (n,) float64 array, s, m
        x behind which 99.5 % of the supplied water in the flume is.
    sediment, volume : (n,) float64 array, m3
        What has left over the end: sediment, and all.
    moved : float
        Mean displacement of the bed before the water comes, in spacings.
    entered : float
        What has come in over the discharge.
    missing : int
        Particles that have come in or were there, and neither have left nor are there.
    through_wall : int
    """

    time: Floats
    front: Floats
    sediment: Floats
    volume: Floats
    moved: float
    entered: float
    missing: int
    through_wall: int

    @property
    def share(self) -> float:
        """Return the share of sediment in what has left."""
        return float(self.sediment[-1] / self.volume[-1]) if self.volume[-1] > 0.0 else np.nan


def run(spacing: float) -> Flume:
    """Run the shipped case."""
    case = load_case(CASES / "flume3d.toml", (f"particles.spacing={spacing!r}",))
    d0, volume = case.particles.spacing, particle_volume(case)
    time: list[float] = []
    front, sediment, left = [], [], []
    bed, start, moved = 0, np.empty(0), np.nan
    for state in states(case, SAMPLE):
        p = state.particles
        x, fraction = p.position[p.fluid], p.sediment_fraction[p.fluid]
        inside, water = float(fraction.sum()), x[fraction == 0.0, 0]
        if not time:
            # the bed keeps the order of its ids, the first that there are
            bed, carried = p.fluid_count, inside
            start = x[np.argsort(p.id[p.fluid])].copy()
        if np.isnan(moved) and state.time >= DRY_UNTIL:
            number = p.id[p.fluid]
            kept = number < bed
            step = x[kept] - start[number[kept]]
            moved = float(np.linalg.norm(step, axis=1).mean() / d0)
        time.append(state.time)
        front.append(float(np.quantile(water, FRONT_SHARE)) if water.size else 0.0)
        sediment.append((carried - inside) * volume)
        left.append(int(state.left.sum()) * volume)
    entered = int(state.entered.sum())
    return Flume(
        np.array(time),
        np.array(front),
        np.array(sediment),
        np.array(left),
        moved,
        entered * volume / (discharge_of(case) * state.time),
        bed + entered - int(state.left.sum()) - p.fluid_count,
        int(state.through_wall.sum()),
    )


def measure(level: Level) -> Measured:
    """Return what the flume did at a level."""
    found = run(BED / level.across)
    expected = takahashi(15.0, 35.0)
    rows = (
        at_most(
            "bed before the water: mean displacement in 0.8 s",
            found.moved,
            0.1,
            "a particle of a bed at rest stays in its place; chosen: far less than a spacing",
            "d0",
        ),
        conserved(
            "inflow less its discharge / discharge",
            abs(found.entered - 1.0),
            0.01,
            "whole rows of particles come in",
            "%",
        ),
        near(
            "sediment in what left by 6 s",
            found.share,
            expected,
            EQUILIBRIUM,
            share=0.25,
            miss=APART,
            worst=0.15,
        ),
        none_of("particles missing from the balance", found.missing),
        none_of("particles through a wall", found.through_wall),
        *(
            stated(
                f"front of the water at {at} s", float(np.interp(at, found.time, found.front)), "m"
            )
            for at in (1.03, 2.03)
        ),
        stated("sediment that left by 6 s", 1e6 * float(found.sediment[-1]), "cm³"),
    )
    return Measured(rows, abs(found.share / expected - 1.0), _panels(found))


def _panels(found: Flume) -> tuple[Panel, ...]:
    began = found.volume > 0.0
    share = found.sediment[began] / found.volume[began]
    return (
        Panel(
            "front of the water",
            "t (s)",
            "x (m)",
            (computed(found.time, np.maximum.accumulate(found.front)),),
        ),
        Panel(
            "sediment in what has left",
            "t (s)",
            "volume share",
            (
                exact(found.time[[0, -1]], np.full(2, takahashi(15.0, 35.0)), "Takahashi"),
                computed(found.time[began], share),
            ),
        ),
    )


COMPARISONS = (
    Comparison(
        name="flume3d",
        title="Debris flow from a movable bed in a narrow flume (B2)",
        group=Group.DEBRIS_FLOWS,
        compared=(
            "Rest of the bed, its balance, and the sediment in what leaves the flume against the "
            "equilibrium concentration. The study's results of this case are lost, so that nothing "
            "is held to a figure of it; the experiment is that of A3, `bed_erosion2d`."
        ),
        reference=(f"{STUDY}, case B2; equilibrium concentration: {TAKAHASHI}"),
        parameters=(
            "`cases/flume3d.toml`: slope of 15°, width of 70 mm, bed of 30 mm with C = 0.5, "
            "friction angle of 35°, supply of 10 L/min"
        ),
        levels=(
            Level(3, "10 mm", 29, is_quick=True),
            Level(4, "7.5 mm", 100),
            Level(6, "5 mm", 500),
        ),
        measure=measure,
        error="sediment in what left, relative to Takahashi's concentration",
        discussion=(
            "The front is about half as fast as that of `bed_erosion2d`, which is the same "
            "experiment: a bed that keeps its pore water is not taken up by the flow. At 10 and "
            "7.5 mm the supply is one spacing deep."
        ),
    ),
)
