"""Front, residual height and energy of a collapsing column, beside those that were measured.

Columns of Martin & Moyce (1952) and of Koshizuka & Oka (1996), a wide and n^2 a high: the front Z a
at T = n t sqrt(g / a), and the height H n^2 a at tau = t sqrt(g / a).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.results.references import read_reference
from debrisflow.validation.curves import Curve, Panel, computed, measured
from debrisflow.validation.files import CASES, REFERENCES
from debrisflow.validation.marching import energy, states
from debrisflow.validation.row import Row, at_most, energy_gained, near, none_of, stated

Floats = NDArray[np.float64]
GRAVITY = 9.81
WINDOW = 0.84, 3.33
"""T within which fronts are compared: from where the front has moved by a quarter of a."""
LATE = 1.4
"""T from which on the front moves steadily."""
BEFORE_WALL = 0.1
"""In Z, where the front is no longer free."""
DRAWN = 1.2
"""Of the time of the last reading, until when runs are drawn."""
LAST_HEIGHT = 2.45
"""tau until which heights are compared."""
ROUNDING = 1e-3
"""Of T and tau, which the shipped tables hold in seconds."""
EXPERIMENTS = CASES / "experiments"

CLOCK = "chosen: 10 % of Z, by which 0.2 in T is felt; T = 0 of the experiment is not the release"
AGREED = (
    "chosen: half of the 8 % by which the fronts of two experiments with n² = 2 differ in place "
    "(Martin & Moyce; Koshizuka & Oka)"
)
SPEEDS = (
    "chosen: 8 %, as two experiments with n² = 2 differ in the place of the front; in its speed "
    "they differ by 22 %, 1.08 and 1.32"
)


class Experiment(NamedTuple):
    """A column.

    Attributes
    ----------
    width, ratio : float, int
        a, m, and the height over it, n^2.
    front, height : Path or None
        Tables.
    slope : float
        dZ/dT from T = 1.4 on.
    wall : float
        Z of the far wall.
    """

    width: float
    ratio: int
    front: Path
    height: Path | None
    slope: float
    wall: float = np.inf

    def scaled_time(self, time: Floats) -> Floats:
        """Return T of times, s."""
        scaled: Floats = time * np.sqrt(self.ratio * GRAVITY / self.width)
        return scaled

    def fronts(self) -> tuple[Floats, Floats]:
        """Return T and Z, as measured."""
        return self._read(self.front, "outer_front_all", self.ratio, self.width)

    def heights(self) -> tuple[Floats, Floats]:
        """Return tau and H, as measured."""
        assert self.height is not None
        whole = self.ratio * self.width
        return self._read(self.height, "column.filled_height", 1, whole)

    def _read(self, path: Path, name: str, ratio: int, length: float) -> tuple[Floats, Floats]:
        if path.parent == REFERENCES:  # in the units of the paper
            scaled, lengths = np.loadtxt(path, delimiter=",", skiprows=3).T
            return scaled, lengths
        table = read_reference(path).table
        known = np.isfinite(table[name])
        time = table["time"][known] * np.sqrt(ratio * GRAVITY / self.width)
        return time, table[name][known] / length


_MARTIN = EXPERIMENTS / "martin_moyce.csv"
HIGH = Experiment(0.05715, 2, _MARTIN, _MARTIN, 1.32)
SQUARE = Experiment(
    0.05715,
    1,
    REFERENCES / "martin_moyce_1952_front_square.csv",
    REFERENCES / "martin_moyce_1952_height_square.csv",
    1.40,
)


def front(x: Floats, spacing: float, stretch: float, area: float) -> float:
    """Return the foremost x behind which a stretch holds a layer of half its length or more, m.

    A particle of ``x`` has the given area, m2, in the plane of the flow.
    """
    enough = max(1, int(np.ceil(0.5 * stretch**2 / area)))
    foremost = np.sort(x)[::-1]
    dense = foremost[: x.size - enough + 1] - foremost[enough - 1 :] <= stretch
    return float(foremost[np.argmax(dense)] + 0.5 * spacing)


def column_height(position: Floats, up: int, spacing: float, width: float) -> float:
    """Return the height of what is left of the column, in the fifth at the wall, m."""
    beside = position[:, 0] < 0.2 * width
    return float(position[beside, up].max()) + 0.5 * spacing


@dataclass
class DamBreak:
    """Series of a run: time (s), front (m), height of the column (m), energy (share of start).

    ``last_column`` is another front, m: the first column a spacing wide that is not half a
    particle deep; only in three dimensions.
    """

    time: Floats
    front: Floats
    height: Floats
    energy: Floats
    state: State
    experiment: Experiment
    last_column: Floats | None = None

    @property
    def scaled_time(self) -> Floats:
        """T of the experiment."""
        return self.experiment.scaled_time(self.time)

    @property
    def scaled_front(self) -> Floats:
        """Z of the experiment."""
        return self.front / self.experiment.width

    @property
    def scaled_height(self) -> Floats:
        """H of the experiment."""
        return self.height / (self.experiment.ratio * self.experiment.width)

    def by_last_column(self) -> DamBreak:
        """Return the run with its other front."""
        assert self.last_column is not None
        return replace(self, front=self.last_column)

    def front_error(self, shift: float = 0.0) -> float:
        """Return the rms of (Z - Z_exp)/Z_exp within the window; Z leads by ``shift`` in T."""
        t, z = self.experiment.fronts()
        inside = (t > WINDOW[0] - ROUNDING) & (t < WINDOW[1] + ROUNDING)
        ours = np.interp(t[inside] - shift, self.scaled_time, self.scaled_front)
        return float(np.sqrt(np.mean((ours / z[inside] - 1.0) ** 2)))

    def best_shift(self, most: float = 0.2) -> tuple[float, float]:
        """Return the shift of at most ``most`` with the least front error, and that error."""
        shifts = np.linspace(-most, most, 81)
        errors = [self.front_error(shift) for shift in shifts]
        best = int(np.argmin(errors))
        return float(shifts[best]), errors[best]

    def slope(self) -> float:
        """Return dZ/dT from T = 1.4 to 3.33, the last reading or shortly before the far wall."""
        last = min(WINDOW[1], self.experiment.fronts()[0].max() + ROUNDING)
        inside = (self.scaled_time > LATE) & (self.scaled_time < last)
        inside &= self.scaled_front < self.experiment.wall - BEFORE_WALL
        return float(np.polyfit(self.scaled_time[inside], self.scaled_front[inside], 1)[0])

    def height_error(self) -> float:
        """Return the greatest difference of the residual height for tau <= 2.45, in H0."""
        tau, h = self.experiment.heights()
        early = tau < LAST_HEIGHT + ROUNDING
        scaled = self.time * np.sqrt(GRAVITY / self.experiment.width)
        return float(np.abs(np.interp(tau[early], scaled, self.scaled_height) - h[early]).max())


def flat(case: ResolvedCase, experiment: Experiment) -> DamBreak:
    """Run a column in two dimensions and return its series.

    The front is the place ahead of which the layer is thinner than a/32 on average over a/16: half
    a particle layer at sixteen particles across, so that all spacings are measured by one length.
    """
    spacing, width = case.particles.spacing, experiment.width
    series = []
    for state in states(case):
        position = state.particles.position[state.particles.fluid]
        reach = front(position[:, 0], spacing, width / 16, spacing**2)
        height = column_height(position, 1, spacing, width)
        series.append((state.time, reach, height, energy(case, state)))
    time, x, y, total = np.array(series).T
    return DamBreak(time, x, y, total / total[0], state, experiment)


def front_rows(
    found: DamBreak,
    most: float,
    shifted: float,
    farthest: float,
    reasons: tuple[str, str] = (CLOCK, AGREED),
    **known: Any,
) -> Iterable[Row]:
    """Yield the rows of a front: as it is, and after the best shift.

    Parameters
    ----------
    found : DamBreak
    most, shifted : float
        Greatest rms without a shift and with one.
    farthest : float
        Greatest shift that is tried, in T.
    reasons : tuple of str
        Of the two limits.
    known
        ``miss``, ``worst`` and ``is_certain`` of the first.
    """
    shift, error = found.best_shift(farthest)
    unshifted = "rms of the front, not shifted in time"
    yield at_most(unshifted, found.front_error(), most, reasons[0], "%", **known)
    yield at_most("rms of the front, after the best shift", error, shifted, reasons[1], "%")
    yield stated("the best shift in T (positive: the run leads)", shift)


def speed_row(found: DamBreak, share: float, reason: str, **known: Any) -> Row:
    """Return the row of the speed of the front, which needs no clock."""
    return near(
        "speed of the front, dZ/dT from T = 1.4 on",
        found.slope(),
        found.experiment.slope,
        reason,
        share=share,
        **known,
    )


def height_row(found: DamBreak) -> Row:
    """Return the row of the height of the column at the wall."""
    reason = "resolution of the experiment: read as the water passed marks 0.056 apart"
    return at_most(
        "height of the column, greatest difference / its height at the start",
        found.height_error(),
        0.05,
        reason,
        "%",
    )


def budget_rows(found: DamBreak) -> Iterable[Row]:
    """Yield the rows of energy and particles."""
    yield energy_gained(float(found.energy.max()))
    lost = found.state.through_wall.sum()
    yield none_of("particles through a wall", lost)


def panels(found: DamBreak) -> tuple[Panel, ...]:
    """Return the front over time, and the height where it was measured."""
    experiment = found.experiment
    t, tau = found.scaled_time, found.time * np.sqrt(GRAVITY / experiment.width)
    read = experiment.fronts()
    curves = measured(*read), _drawn(t, found.scaled_front, read[0])
    ahead = Panel("front", "T = n t √(g/a)", "Z = x / a", curves)
    if experiment.height is None:
        return (ahead,)
    read = experiment.heights()
    curves = measured(*read), _drawn(tau, found.scaled_height, read[0])
    return (ahead, Panel("height at the wall", "τ = t √(g/a)", "H / H(0)", curves))


def _drawn(time: Floats, values: Floats, readings: Floats) -> Curve:
    early = time <= DRAWN * readings.max()
    return computed(time[early], values[early])
