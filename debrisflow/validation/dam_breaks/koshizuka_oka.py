"""The dam break of Koshizuka & Oka (1996), the column that particle codes began with."""

from __future__ import annotations

from functools import partial

import numpy as np

from debrisflow.case import load_case
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.dam_breaks.fronts import (
    EXPERIMENTS,
    LATE,
    SPEEDS,
    Experiment,
    budget_rows,
    flat,
    front_rows,
    panels,
    speed_row,
)

CASE = EXPERIMENTS / "koshizuka_oka.toml"
WIDTH, WALL = 0.146, 4.0  # m, Z
_unfitted = partial(Experiment, WIDTH, 2, CASE.with_suffix(".csv"), None)


def experiment() -> Experiment:
    """Return the column, with the late speed of its front fitted to the readings."""
    t, z = _unfitted(np.nan).fronts()
    return _unfitted(float(np.polyfit(t[t > LATE], z[t > LATE], 1)[0]), WALL)


def measure(level: Level) -> Measured:
    """Return what the shipped case gave at a spacing."""
    spacing = 0.001 * round(WIDTH / level.across / 0.001)
    found = flat(load_case(CASE, [f"particles.spacing={spacing!r}"]), experiment())
    apart = "scatter of experiments: the same column of Martin & Moyce differs from this one by 8 %"
    rows = [
        # 10 % of the clock and 8 % between the experiments, which are independent
        *front_rows(found, 0.13, 0.08, apart, _AHEAD, farthest=0.5),
        speed_row(found, 0.08, SPEEDS, _FASTER),
        *budget_rows(found),
    ]
    return Measured(tuple(rows), found.best_shift(0.5)[1], panels(found))


_AHEAD = (
    "the run has no gate and leads by 0.23 to 0.28 in T; the limit was set for 10 % from the clock "
    "and 8 % between the experiments, and the clock costs 12 %, as with the column of Martin & "
    "Moyce. After the shift the front is within 5 %"
)
_FASTER = (
    "five readings decide the speed of this experiment, and that of Martin & Moyce with the same "
    "column is 1.32, 22 % more; the run lies between the two. The limit was set from the places of "
    "the fronts, in which the two differ by 8 %"
)
COMPARISONS = (
    Comparison(
        name="koshizuka_oka",
        title="Column of Koshizuka & Oka",
        group=Group.DAM_BREAKS,
        compared=(
            "Front on the dry floor against their experiment (not their computation), unshifted "
            "and after the best shift in time of at most 0.5 in T."
        ),
        reference="Koshizuka & Oka 1996, doi:10.13182/NSE96-A24205",
        parameters=(
            "experiments/koshizuka_oka.toml: column of 0.146 m by 0.292 m, roughness of the floor "
            "0.03 mm (chosen), no gate"
        ),
        levels=(
            Level(WIDTH / 0.008, "d0 = 8 mm", 1, is_quick=True),
            Level(WIDTH / 0.005, "d0 = 5 mm", 3),
            Level(WIDTH / 0.003, "d0 = 3 mm", 12),
        ),
        measure=measure,
        error="rms of the front after the best shift / Z",
        discussion=(
            "Nine readings of a front; the experiment of Martin & Moyce with the same column is up "
            "to 8 % ahead of it, so that no limit under 8 % has a ground in measurements."
        ),
    ),
)
