"""The dam break of Martin & Moyce (1952), n^2 = 2: front, residual height and energy.

The front is the place ahead of which the layer is thinner than a/32 on average over a/16: half a
particle layer at the coarsest of the three spacings, so that all are measured by one length.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case, tables
from debrisflow.measures import energies
from debrisflow.schemes import SemiImplicit
from debrisflow.state import State, initial_state

Floats = NDArray[np.float64]
ROOT = Path(__file__).parents[2]
REFERENCE = Path(__file__).parent / "reference"
WIDTH = 0.05715
GRAVITY = 9.81


def reference_table(name: str) -> Floats:
    """Return a reference table, one row a point."""
    return np.loadtxt(REFERENCE / name, delimiter=",", skiprows=3)


def shipped_case(across: int, end: float) -> tables.Case:
    """Return cases/dam_break2d.toml with another number of particles across the column."""
    return load_case(
        ROOT / "cases" / "dam_break2d.toml",
        [f"particles.spacing={WIDTH / across!r}", f"time.end={end!r}"],
    )


def front(x: Floats, spacing: float) -> float:
    """Return the foremost x behind which a/16 holds a layer of a/32 or more, m."""
    enough = max(1, int(np.ceil(0.5 * (WIDTH / 16 / spacing) ** 2)))
    foremost = np.sort(x)[::-1]
    dense = foremost[: x.size - enough + 1] - foremost[enough - 1 :] <= WIDTH / 16
    return float(foremost[np.argmax(dense)] + 0.5 * spacing)


@dataclass
class DamBreak:
    """Series of a run: time (s), front (m), height of the column (m), energy (share of start)."""

    time: Floats
    front: Floats
    height: Floats
    energy: Floats
    state: State

    @property
    def scaled_time(self) -> Floats:
        """T of the experiment."""
        return self.time * np.sqrt(2.0 * GRAVITY / WIDTH)

    def front_error(self, shift: float = 0.0) -> float:
        """Return the rms of (Z - Z_exp)/Z_exp for 0.84 <= T <= 3.33; Z leads by ``shift`` in T."""
        table = reference_table("martin_moyce_1952_front.csv")
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

    def height_error(self) -> float:
        """Return the greatest difference of the residual height for tau <= 2.45, in H0."""
        table = reference_table("martin_moyce_1952_height.csv")
        tau, h = table[table[:, 0] <= 2.45].T
        ours = np.interp(tau, self.time * np.sqrt(GRAVITY / WIDTH), self.height / (2.0 * WIDTH))
        return float(np.abs(ours - h).max())


def run(across: int, end: float = 0.19, overrides: tuple[str, ...] = ()) -> DamBreak:
    """Run the shipped case at a spacing of a / across and return its series."""
    case = shipped_case(across, end)
    if overrides:
        case = load_case(
            ROOT / "cases" / "dam_break2d.toml",
            [f"particles.spacing={WIDTH / across!r}", f"time.end={end!r}", *overrides],
        )
    scheme, state = SemiImplicit(case), initial_state(case)
    spacing = case.particles.spacing
    series = []
    while state.time < end:
        position = state.particles.position[state.particles.fluid]
        energy = energies(
            case,
            position,
            state.particles.velocity[state.particles.fluid],
            state.particles.density[state.particles.fluid],
            state.particles.kind[state.particles.fluid],
        )
        beside = position[:, 0] < 0.2 * WIDTH
        series.append(
            (
                state.time,
                front(position[:, 0], spacing),
                float(position[beside, 1].max()) + 0.5 * spacing,
                sum(energy),
            )
        )
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time += dt
        state.step += 1
    time, x, y, energy = np.array(series).T
    return DamBreak(time, x, y, energy / energy[0], state)
