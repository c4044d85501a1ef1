"""The dam break of Martin & Moyce (1952) in two dimensions, a column a wide and 2 a high."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from debrisflow.case import ResolvedCase, load_case
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed
from debrisflow.validation.dam_breaks.fronts import (
    HIGH,
    SPEEDS,
    DamBreak,
    budget_rows,
    flat,
    front_rows,
    height_row,
    panels,
    speed_row,
)
from debrisflow.validation.dam_breaks.known import Known
from debrisflow.validation.files import CASES
from debrisflow.validation.row import Row, at_most

WIDTH = HIGH.width
SMOOTH = ("walls.floor.slip=free-slip", "walls.floor.roughness=0.0")
IMPACT = 0.19
"""s, when the front strikes the far wall."""
SPLASH = 2.0
"""s, until when the splash is followed for what it loses."""
TIMES = 0.05, 0.09, 0.13, 0.17
"""s, at which fronts of several spacings are compared."""
STRUCK = 4.0
"""Z until which the energy is compared: two thirds of the way to the wall."""
SHIPPED = 32
"""Particles across the column in the shipped case."""


def shipped_case(across: int, end: float, overrides: tuple[str, ...] = ()) -> ResolvedCase:
    """Return cases/dam_break2d.toml with another number of particles across the column."""
    changes = [f"particles.spacing={WIDTH / across!r}", f"time.end={end!r}", *overrides]
    return load_case(CASES / "dam_break2d.toml", changes)


def run(across: int, end: float = IMPACT, overrides: tuple[str, ...] = ()) -> DamBreak:
    """Run the shipped case at a spacing of a / across and return its series."""
    return flat(shipped_case(across, end, overrides), HIGH)


def apart(coarse: DamBreak, fine: DamBreak) -> float:
    """Return the mean distance of the fronts of two runs, m."""
    fronts = [np.interp(TIMES, found.time, found.front) for found in (coarse, fine)]
    return float(np.abs(fronts[1] - fronts[0]).mean())


def lost_before_impact(found: DamBreak) -> float:
    """Return the share of its energy that a dam break loses until Z = 4."""
    there = int(np.argmax(found.scaled_front >= STRUCK))
    return float(1.0 - found.energy[there] / found.energy[0])


def measure(level: Level) -> Measured:
    """Return what the column over a rough floor gave."""
    across = round(level.across)
    found = run(across, SPLASH if across == SHIPPED else IMPACT)
    rows = [
        *front_rows(found, 0.10, 0.04, farthest=0.2, **_AHEAD.at(level.label)),
        speed_row(found, 0.08, SPEEDS),
        height_row(found),
        *budget_rows(found),
    ]
    if across > SHIPPED:
        runs = [run(across // 4), run(across // 2), found]
        rows.append(_nearer(across, runs, 1.0, **_ROUGH.at(level.label)))
    return Measured(tuple(rows), found.best_shift()[1], panels(found))


def measure_smooth(level: Level) -> Measured:
    """Return what the column over a smooth floor gave, beside half as many particles across."""
    across = round(level.across)
    coarse, found = (run(n, overrides=SMOOTH) for n in (across // 2, across))
    lost, before = lost_before_impact(found), lost_before_impact(coarse)
    rows = [
        at_most(
            "energy lost until Z = 4 / that with half as many across",
            lost / before,
            0.7,
            "chosen: it is lost to the spacing, and first order would halve it",
        ),
        *budget_rows(found),
    ]
    if across >= SHIPPED:
        most = "chosen: 4 %, as the front; without friction or impact only the scheme loses any"
        rows.insert(
            0, at_most("energy lost until Z = 4 / that of the start", lost, 0.04, most, "%")
        )
    if across > SHIPPED:
        runs = [run(across // 4, overrides=SMOOTH), coarse, found]
        rows.insert(0, _nearer(across, runs, 0.5))
    time = Panel(
        "energy of the fluid",
        "t (s)",
        "energy / that of the start",
        (computed(found.time, found.energy),),
    )
    return Measured(tuple(rows), apart(coarse, found) / WIDTH, (*panels(found), time))


def _nearer(across: int, runs: Sequence[DamBreak], most: float, **known: Any) -> Row:
    """Return the row of whether fronts come nearer as the spacing is halved twice."""
    coarse, middle, fine = runs
    return at_most(
        f"distance of the fronts at {across // 2} and {across} across / at {across // 4} and "
        f"{across // 2}",
        apart(middle, fine) / apart(coarse, middle),
        most,
        "convergence: first order halves the distance"
        if most < 1.0
        else "convergence of any order",
        **known,
    )


_AHEAD = Known(
    "the run has no gate and leads by 0.2 in T; shifted by it, the front is within its limit",
    {"a/32": 0.117, "a/64": 0.128},
)
_ROUGH = Known(
    "the law of the wall slows the lowest row alone, which is thinner with each spacing, and "
    "without a model of turbulence little passes on to the rows above; over a smooth floor the "
    "fronts do converge (dam_break_smooth_floor)",
    {"a/64": 1.2},
)
_LEVELS = (
    Level(16, "a/16", 1, is_quick=True),
    Level(32, "a/32", 27, is_quick=True),
    Level(64, "a/64", 25),
)
COMPARISONS = (
    Comparison(
        name="martin_moyce",
        title="Column of Martin & Moyce, n² = 2, two dimensions",
        group=Group.DAM_BREAKS,
        compared=(
            "Front on the dry floor and height at the wall against Tables 2 and 6, unshifted and "
            "after the best shift in time of at most 0.2 in T; the splash to 2 s at a/32."
        ),
        reference="Martin & Moyce 1952, doi:10.1098/rsta.1952.0006",
        parameters=(
            "dam_break2d.toml: a = 57.15 mm, roughness of the floor 0.3 mm (chosen; the experiment "
            "does not state one), no gate"
        ),
        levels=_LEVELS,
        measure=measure,
        error="rms of the front after the best shift / Z",
        discussion=(
            "The front is where the layer is half of a/16 thick. The run at a/32 goes on to 2 s, "
            "which is most of its time. The error after the shift does not fall with the spacing."
        ),
    ),
    Comparison(
        name="dam_break_smooth_floor",
        title="The same column over a floor without friction: convergence",
        group=Group.DAM_BREAKS,
        compared=(
            "Fronts at 0.05, 0.09, 0.13 and 0.17 s against those at twice the spacing, and the "
            "energy lost before the impact, of which inviscid flow loses none."
        ),
        reference="closed form: energy is conserved; the finer of two runs",
        parameters="dam_break2d.toml with a floor that slips freely, and no roughness",
        levels=(
            Level(16, "a/16", 1),
            Level(32, "a/32", 5, is_quick=True),
            Level(64, "a/64", 25, is_quick=True),
        ),
        measure=measure_smooth,
        error="mean distance of the fronts from those at twice the spacing / a",
    ),
)
