"""An endless saturated bed on a slope: the slope at which it slides, how deep a flow moves it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import endless_channel
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact, points
from debrisflow.validation.marching import advance
from debrisflow.validation.row import Row, at_least, at_most, near

Floats = NDArray[np.float64]
ROCK, WATER, GRAVITY = 2650.0, 1000.0, 9.81
SETTLING, REST = 1.0, 2.0  # s
MOVING = 0.05  # m/s
ANGLES = 30.0, 35.0  # degrees, of friction
BED = 0.1  # m, depth of the bed of which the limit slope is measured
SLOPE, DEPTH = 15.0, 0.04  # degrees and m, of the water that flows over a bed
YIELDING = 35.0, 40.0  # degrees, of friction of the beds under it
TIME = 2.0  # s, for which it flows


class Rest(NamedTuple):
    """How far the particles of a bed moved in 2 s, in spacings."""

    mean: float
    greatest: float


def limit_slope(friction_angle: float, c: float = 0.55) -> float:
    """Return the slope at which an endless bed saturated to its surface slides, degrees.

    ``tan theta = C (rho_s - rho_l) tan phi / (C rho_s + (1 - C) rho_l)``.
    """
    buoyant = c * (ROCK - WATER)
    return float(np.degrees(np.arctan(buoyant * _tan(friction_angle) / (buoyant + WATER))))


def slope_of_motion(slope: float, moved: float) -> float:
    """Return the limit slope by the way that a bed slid from :data:`SETTLING` on, degrees.

    Drive and friction both grow with the depth under the surface, so that above the limit slope
    the bed slides as a block over its floor, by ``a = g cos(slope) (tan(slope) - tan(limit))``
    from the start on.

    Parameters
    ----------
    slope : float, degrees
    moved : float, m
        In :data:`REST`.
    """
    acceleration = 2.0 * moved / ((SETTLING + REST) ** 2 - SETTLING**2)
    limit = _tan(slope) - acceleration / (GRAVITY * np.cos(np.radians(slope)))
    return float(np.degrees(np.arctan(limit)))


def yield_depth(slope: float, friction_angle: float, depth: float, c: float = 0.55) -> float:
    """Return how deep a bed yields under water, m (Takahashi 1978).

    ``tan theta = C (rho_s - rho_l) tan phi / [C (rho_s - rho_l) + rho_l (1 + h0 / a)]``.
    """
    buoyant = c * (ROCK / WATER - 1.0)
    return depth / (buoyant * (_tan(friction_angle) / _tan(slope) - 1.0) - 1.0)


def _tan(degrees: float) -> float:
    return float(np.tan(np.radians(degrees)))


def start(
    slope: float,
    friction_angle: float,
    spacing: float,
    rows: int,
    water_rows: int = 0,
    scheme: type[SemiImplicit] = SemiImplicit,
) -> tuple[SemiImplicit, State]:
    """Return scheme and state of a bed, with water over it, that repeats every 20 spacings."""
    top = rows * spacing
    layers = [{"y": [0.0, top], "material": "two-phase", "sediment_share": 0.55}]
    if water_rows:
        layers.append({"y": [top, top + water_rows * spacing], "material": "water"})
    case = endless_channel(
        spacing,
        slope,
        layers,
        drag={"law": "gidaspow"},
        rheology={"type": "coulomb", "friction_angle": friction_angle, "mixing_length": 0.006},
    )
    return scheme(case), initial_state(case)


def rest(
    slope: float,
    friction_angle: float,
    spacing: float,
    rows: int = 10,
    scheme: type[SemiImplicit] = SemiImplicit,
) -> Rest:
    """Return how far the particles of a bed move in 2 s once it has settled for a second."""
    solver, state = start(slope, friction_angle, spacing, rows, scheme=scheme)
    path = np.zeros((state.particles.fluid_count, 2))
    advance(solver, state, until=SETTLING)
    period = solver.domain.period[0]
    while state.time < SETTLING + REST:
        # in pieces in which nothing passes half a period, so that a way around it is counted
        before = _by_id(state)
        advance(solver, state, until=state.time + 0.01)
        step = _by_id(state) - before
        step[:, 0] -= period * np.rint(step[:, 0] / period)
        path += step
    moved = np.linalg.norm(path, axis=1) / spacing
    return Rest(float(moved.mean()), float(moved.max()))


def speeds(
    slope: float, friction_angle: float, spacing: float, rows: int, water_rows: int, time: float
) -> Floats:
    """Return the mean speeds of the grains in the rows of a bed, from its floor up, m/s."""
    scheme, state = start(slope, friction_angle, spacing, rows, water_rows)
    advance(scheme, state, until=time)
    p = state.particles
    is_rock = p.sediment_fraction[p.fluid] > 0
    row = (p.position[p.fluid, 1][is_rock] / spacing).astype(int)
    count = np.bincount(row, minlength=rows)[:rows]
    total = np.bincount(row, p.velocity[p.fluid, 0][is_rock], minlength=rows)[:rows]
    return np.divide(total, count, out=np.zeros(rows), where=count > 0)


def moving_depth(speed: Floats, spacing: float) -> float:
    """Return the depth under the surface of the bed at which the grains move at 5 cm/s, m.

    0 if none does; linear between the middles of the rows.
    """
    if speed.max() < MOVING:
        return 0.0
    heights = np.arange(speed.size) + 0.5
    height = float(np.interp(MOVING, np.maximum.accumulate(speed), heights))
    return spacing * (speed.size - height)


def _by_id(state: State) -> Floats:
    p = state.particles
    return p.position[p.fluid, :2][np.argsort(p.id[p.fluid])].copy()


def measure_slope(level: Level) -> Measured:
    """Return whether beds lie below their limit slopes, and how they slide above them."""
    spacing = BED / level.across
    rows: list[Row] = []
    off, dots = [], []
    for angle in ANGLES:
        limit = limit_slope(angle)
        below = rest(limit - 1.0, angle, spacing, round(level.across))
        above = rest(limit + 1.0, angle, spacing, round(level.across))
        found = slope_of_motion(limit + 1.0, above.mean * spacing)
        off.append(abs(found / limit - 1.0))
        dots += [(-1.0, below.mean * spacing), (1.0, above.mean * spacing)]
        miss = COARSE_SLOPE if spacing > 0.01 else ""
        rows += _slope_rows(f"{angle:g}°", limit, found, below, above, miss)
    x = np.linspace(-1.0, 1.0, 21)
    way = 0.5 * GRAVITY * ((SETTLING + REST) ** 2 - SETTLING**2) * np.maximum(np.radians(x), 0.0)
    curves = (exact(x, way, "block on its floor"), points(*np.array(dots).T))
    axes = "slope over the limit slope (degrees)", "mean displacement in 2 s (m)"
    return Measured(tuple(rows), max(off), (Panel("sliding", *axes, curves),))


def _slope_rows(
    angle: str, limit: float, found: float, below: Rest, above: Rest, miss: str
) -> list[Row]:
    return [
        at_most(
            f"friction {angle}, 1° below the limit slope: mean displacement in 2 s",
            below.mean,
            0.1,
            "at rest: less than a tenth of a spacing",
            "d0",
        ),
        at_most(
            f"friction {angle}, the same: the greatest displacement",
            below.greatest,
            1.0,
            "no grain leaves its place",
            "d0",
        ),
        at_least(
            f"friction {angle}, 1° above the limit slope: mean displacement in 2 s",
            above.mean,
            10.0,
            "in motion: a hundred times what is rest",
            "d0",
        ),
        near(
            f"friction {angle}: limit slope by the way that the bed slides 1° above it",
            found,
            limit,
            "chosen: half of the step in slope",
            margin=0.5,
            unit="°",
            miss=miss,
            worst=limit + 0.75,
            is_certain=not miss,  # three seedings miss it by 0.04 to 0.2 degrees
        ),
    ]


def measure_yield(level: Level) -> Measured:
    """Return how deep beds yield under water."""
    flows = [(DEPTH, round(level.across), angle) for angle in YIELDING]
    if level.across == MIDDLE:
        flows += [(0.5 * DEPTH, 6, angle) for angle in YIELDING]
    rows, panels, errors = [], [], []
    for depth, water_rows, angle in flows:
        expected, spacing = yield_depth(SLOPE, angle, depth), depth / water_rows
        bed_rows = int(1.5 * expected / spacing) + 3
        speed = speeds(SLOPE, angle, spacing, bed_rows, water_rows, TIME)
        found = moving_depth(speed, spacing)
        title = f"friction {angle:g}°, {1e3 * depth:.0f} mm of water"
        rows.append(
            near(
                f"{title} in {water_rows} rows: depth down to which the bed moves",
                found,
                expected,
                "chosen: one to three spacings where the flow has four rows, no less than what "
                "the surface of the bed and the threshold of 5 cm/s blur",
                share=0.3,
                unit="m",
                miss=COARSE_DEPTH if expected < FEWEST * spacing else "",
                worst=0.07,
            )
        )
        if depth == DEPTH:
            errors.append(abs(found / expected - 1.0))
            down = spacing * (bed_rows - np.arange(bed_rows) - 0.5)
            edge = exact([0.0, speed.max()], [expected, expected], "Takahashi's depth")
            axes = "mean speed of the grains (m/s)", "depth in the bed (m)"
            below = np.arange(bed_rows) <= speed.argmax()  # no grains are left above
            curve = computed(speed[below], down[below])
            panels.append(Panel(title, *axes, (edge, curve)))
    if level.across == MIDDLE:
        dry = moving_depth(speeds(SLOPE, 35.0, 0.005, 16, 0, 1.0), 0.005)
        why = "15° is below the limit slope of 18.4°"
        rows.append(at_most("friction 35°, no water on the bed: the same", dry, 0.0, why, "m"))
    return Measured(tuple(rows), float(np.mean(errors)), tuple(panels))


COARSE_SLOPE = (
    "the floor holds the lowest row, a fifth of a bed of five, which rubs on the others as they "
    "slide; with ten rows it is within"
)
COARSE_DEPTH = (
    "the depth is four spacings, of which the surface of the bed takes two; with half the spacing "
    "it is within"
)
FEWEST = 5  # spacings of a yield depth that is resolved
MIDDLE = 8
"""Rows of water of the level that computes the other depth of water too."""
COMPARISONS = (
    Comparison(
        name="bed_slope",
        title="Slope at which an endless saturated bed slides",
        group=Group.BEDS,
        compared=(
            "Displacements in two seconds, after one in which the bed settles, 1° below and above "
            "the limit slope; and the limit slope that follows from the acceleration above it."
        ),
        reference=(
            "closed form: tan θ = C (ρ_s - ρ) tan φ / (C ρ_s + (1 - C) ρ): infinite slope, "
            "saturated, flow along it"
        ),
        parameters=(
            "two dimensions, bed 0.1 m deep that repeats every 20 spacings, C = 0.55, friction of "
            "30 and 35° (limit slopes of 15.4 and 18.4°), drag of Gidaspow"
        ),
        levels=(
            Level(5, "5 rows", 10, is_quick=True),
            Level(10, "10 rows", 14),
            Level(20, "20 rows", 37),
        ),
        measure=measure_slope,
        error="limit slope by the acceleration / closed form - 1, the greater of two",
    ),
    Comparison(
        name="bed_yield",
        title="Depth to which a bed yields under a flow",
        group=Group.BEDS,
        compared=(
            "Depth below the surface of a saturated bed down to which its grains move faster than "
            "5 cm/s, two seconds after water begins to flow over it on a slope of 15°."
        ),
        reference=(
            "a = h0 / [C (ρ_s/ρ - 1) (tan φ / tan θ - 1) - 1], Takahashi 1978, J. Hydraul. Div. "
            "ASCE 104, 1153"
        ),
        parameters=(
            "two dimensions, water 40 mm deep, C = 0.55, friction of 35 and 40°, repeats every 20 "
            "spacings, drag of Gidaspow, mixing length 6 mm"
        ),
        levels=(
            Level(4, "4 rows", 10, is_quick=True),
            Level(MIDDLE, "8 rows", 45),
            Level(16, "16 rows", 300),
        ),
        measure=measure_yield,
        error="mean of two distances of the depth from Takahashi's / that depth",
        discussion=(
            "The level of 8 rows computes 20 mm of water in 6 rows too, and a bed without water, "
            "of which nothing may yield."
        ),
    ),
)
