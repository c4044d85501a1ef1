"""The dam break of Martin & Moyce (1952), a column a wide: front, residual height and energy.

In two dimensions the column is 2 a high, n^2 = 2.  The front is the place ahead of which the layer
is thinner than a/32 on average over a/16: half a particle layer at the coarsest of the three
spacings, so that all are measured by one length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case, tables
from debrisflow.particles.state import State
from debrisflow.validation.files import CASES, REFERENCES
from debrisflow.validation.marching import energy, states

Floats = NDArray[np.float64]
WIDTH = 0.05715
GRAVITY = 9.81
SMOOTH = ("walls.floor.slip=free-slip", "walls.floor.roughness=0.0")


def reference_table(name: str) -> Floats:
    """Return a reference table, one row a point."""
    return np.loadtxt(REFERENCES / name, delimiter=",", skiprows=3)


def shipped_case(across: int, end: float, overrides: tuple[str, ...] = ()) -> tables.Case:
    """Return cases/dam_break2d.toml with another number of particles across the column."""
    changes = [f"particles.spacing={WIDTH / across!r}", f"time.end={end!r}", *overrides]
    return load_case(CASES / "dam_break2d.toml", changes)


def front(x: Floats, spacing: float, stretch: float, area: float) -> float:
    """Return the foremost x behind which a stretch holds a layer of half its length or more, m.

    A particle of ``x`` has the given area, m2, in the plane of the flow.
    """
    enough = max(1, int(np.ceil(0.5 * stretch**2 / area)))
    foremost = np.sort(x)[::-1]
    dense = foremost[: x.size - enough + 1] - foremost[enough - 1 :] <= stretch
    return float(foremost[np.argmax(dense)] + 0.5 * spacing)


class Experiment(NamedTuple):
    """A column of Martin & Moyce: its height over a, n^2; dZ/dT from T = 1.4 on; the tables."""

    ratio: int
    slope: float
    front: str = "martin_moyce_1952_front.csv"
    height: str = "martin_moyce_1952_height.csv"


HIGH = Experiment(2, 1.32)
SQUARE = Experiment(
    1, 1.40, "martin_moyce_1952_front_square.csv", "martin_moyce_1952_height_square.csv"
)


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
    experiment: Experiment = HIGH
    last_column: Floats | None = None

    @property
    def scaled_time(self) -> Floats:
        """T of the experiment."""
        return self.time * np.sqrt(self.experiment.ratio * GRAVITY / WIDTH)

    def by_last_column(self) -> DamBreak:
        """Return the run with its other front."""
        return replace(self, front=self.last_column)

    def front_error(self, shift: float = 0.0) -> float:
        """Return the rms of (Z - Z_exp)/Z_exp for 0.84 <= T <= 3.33; Z leads by ``shift`` in T."""
        table = reference_table(self.experiment.front)
        t, z = table[(table[:, 0] >= 0.84) & (table[:, 0] <= 3.33)].T
        ours = np.interp(t - shift, self.scaled_time, self.front / WIDTH)
        return float(np.sqrt(np.mean(((ours - z) / z) ** 2)))

    def best_shift(self, most: float = 0.2) -> tuple[float, float]:
        """Return the shift of at most ``most`` with the least front error, and that error."""
        shifts = np.linspace(-most, most, 81)
        errors = [self.front_error(shift) for shift in shifts]
        best = int(np.argmin(errors))
        return float(shifts[best]), errors[best]

    def slope(self) -> float:
        """Return dZ/dT for 1.4 < T < 3.33."""
        inside = (self.scaled_time > 1.4) & (self.scaled_time < 3.33)
        return float(np.polyfit(self.scaled_time[inside], self.front[inside] / WIDTH, 1)[0])

    def places(self) -> Floats:
        """Return Z at T = 1, 2 and 3."""
        return np.interp([1.0, 2.0, 3.0], self.scaled_time, self.front / WIDTH)

    def height_error(self) -> float:
        """Return the greatest difference of the residual height for tau <= 2.45, in H0."""
        table = reference_table(self.experiment.height)
        tau, h = table[table[:, 0] <= 2.45].T
        start = self.experiment.ratio * WIDTH
        ours = np.interp(tau, self.time * np.sqrt(GRAVITY / WIDTH), self.height / start)
        return float(np.abs(ours - h).max())


def column_height(position: Floats, up: int, spacing: float) -> float:
    """Return the height of what is left of the column, in the fifth at the wall, m."""
    beside = position[:, 0] < 0.2 * WIDTH
    return float(position[beside, up].max()) + 0.5 * spacing


def run(across: int, end: float = 0.19, overrides: tuple[str, ...] = ()) -> DamBreak:
    """Run the shipped case at a spacing of a / across and return its series."""
    case = shipped_case(across, end, overrides)
    spacing = case.particles.spacing
    series = []
    for state in states(case):
        position = state.particles.position[state.particles.fluid]
        reach = front(position[:, 0], spacing, WIDTH / 16, spacing**2)
        height = column_height(position, 1, spacing)
        series.append((state.time, reach, height, energy(case, state)))
    time, x, y, total = np.array(series).T
    return DamBreak(time, x, y, total / total[0], state)


def lost_before_impact(across: int) -> float:
    """Return the share of its energy that the dam break over a smooth floor loses until Z = 4."""
    found = run(across, overrides=SMOOTH)
    there = int(np.argmax(found.front >= 4.0 * WIDTH))
    return float(1.0 - found.energy[there] / found.energy[0])
