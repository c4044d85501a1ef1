"""Gates that are drawn, in two dimensions: the discharge under one, and a front behind one.

The closed form of the discharge under a gate drawn a above a floor is
``C_c a sqrt(2 g (H - C_c a))``, with the contraction of a free jet, ``C_c = pi / (pi + 2)``, and
the depth H before the gate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.dam_breaks.known import Known
from debrisflow.validation.dam_breaks.moving_walls import GRAVITY, plate, smooth_tank
from debrisflow.validation.marching import states
from debrisflow.validation.row import near, stated

Floats = NDArray[np.float64]
CONTRACTION = np.pi / (np.pi + 2.0)
LENGTH, DEPTH, OPENING = 1.2, 0.4, 0.08  # m
RISE, END = 1.0, 2.0  # s
INTERVAL = 0.1  # s, over which a discharge is averaged for the figure


def front_after(speed: float | None, spacing: float = 0.01) -> float:
    """Return the front of a column 20 cm high, 0.25 s after a gate is drawn at a speed, m/s, in m.

    The fourth particle from ahead; None for no gate.
    """
    gate = [] if speed is None else [plate(0.2, spacing, 0.4, velocity=(0.0, speed))]
    case = smooth_tank(spacing, 1.0, 0.5, (0.0, 0.2), 0.25, depth=0.2, obstacle=gate)
    for state in states(case, case.time.end):
        last = state
    return float(np.sort(last.particles.position[last.particles.fluid, 0])[-4])


class Sluice(NamedTuple):
    """What ran under a gate.

    Attributes
    ----------
    drawn : float
        Volume that passed while the gate rose from half its opening on, over that of the orifice.
    open : float
        The same while it stood open.
    time, rate : (n,) float64 array
        Discharge over time, s, m2/s.
    """

    drawn: float
    open: float
    time: Floats
    rate: Floats


def sluice(rows: int) -> Sluice:
    """Return what passes a gate that is drawn to an opening of a number of rows within a second."""
    spacing = OPENING / rows
    gate = plate(LENGTH, 0.02, 0.5, time=(0.0, RISE, END), y=(0.0, OPENING, OPENING))
    case = smooth_tank(spacing, LENGTH + 3.2, 0.6, (0.0, LENGTH), END, depth=DEPTH, obstacle=[gate])
    found = [
        (state.time, np.count_nonzero(state.particles.position[state.particles.fluid, 0] < LENGTH))
        for state in states(case, 0.02)
    ]
    time, count = np.array(found).T
    volume = count * spacing**2
    rate = discharge(jet(time), volume / LENGTH)
    ratio = {}
    for name, start, stop in (("drawn", 0.5 * RISE, RISE), ("open", RISE, END)):
        within = (time >= start) & (time <= stop)
        passed = volume[within][0] - volume[within][-1]
        ratio[name] = float(passed / np.trapezoid(rate[within], time[within]))
    edges = np.arange(0.0, END + 0.5 * INTERVAL, INTERVAL)
    flux = -np.diff(np.interp(edges, time, volume)) / INTERVAL
    return Sluice(**ratio, time=0.5 * (edges[1:] + edges[:-1]), rate=flux)


def jet(time: Floats) -> Floats:
    """Return the thickness of the contracted jet under the gate, m."""
    opening = PchipInterpolator((0.0, RISE, END), (0.0, OPENING, OPENING))(time)
    thickness: Floats = CONTRACTION * opening
    return thickness


def discharge(thickness: Floats, depth: Floats | float) -> Floats:
    """Return the discharge of an orifice, m2/s, by the thickness of its jet and the depth, m."""
    rate: Floats = thickness * np.sqrt(2.0 * GRAVITY * np.maximum(depth - thickness, 0.0))
    return rate


def emptying() -> tuple[Floats, Floats]:
    """Return the discharge of the orifice over time from water that it empties, s, m2/s."""
    time = np.linspace(0.0, END, 401)
    thickness, rate, depth = jet(time), np.zeros(time.size), DEPTH
    for k in range(time.size):
        rate[k : k + 1] = discharge(thickness[k : k + 1], depth)
        depth -= rate[k] * time[1] / LENGTH
    return time, rate


def measure(level: Level) -> Measured:
    """Return the discharge under a gate."""
    found = sluice(round(level.across))
    reason = "chosen: less than a row of the opening of eight"
    rows = (
        near(
            "volume under the open gate / that of an orifice",
            found.open,
            1.0,
            reason,
            share=0.10,
            **_THICK.at(level.label),
        ),
        stated("the same while it is drawn", found.drawn),
    )
    curves = exact(*emptying(), "orifice"), computed(found.time, found.rate)
    panel = Panel("discharge", "t (s)", "discharge (m²/s)", curves)
    return Measured(rows, abs(found.open - 1.0), (panel,))


_THICK = Known(
    "the jet under the gate is five rows thick at eight rows over the opening, and half at four. "
    "At eight rows two computations that differ in rounding alone gave 0.86 and 0.92",
    {"4 rows": 0.865, "8 rows": 0.84},
    uncertain=("8 rows",),
)
COMPARISONS = (
    Comparison(
        name="gate",
        group=Group.DAM_BREAKS,
        title="Discharge under a gate that is drawn",
        compared="Volume that passes in a second while the gate stands open, 8 cm above the floor.",
        reference="orifice with the contraction π/(π + 2) of a free jet (Kirchhoff); Rouse 1946",
        parameters="two dimensions, 0.4 m of water, smooth walls; the gate is drawn for a second",
        levels=(
            Level(4, "4 rows", 5),
            Level(8, "8 rows", 30, is_quick=True),
            Level(12, "12 rows", 90),
        ),
        measure=measure,
        error="error of the volume under the open gate",
    ),
)
