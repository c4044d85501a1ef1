"""An endless saturated bed on a slope: the slope at which it slides, how deep a flow moves it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import endless_channel
from debrisflow.validation.marching import advance

Floats = NDArray[np.float64]
ROCK, WATER = 2650.0, 1000.0
SETTLING, REST = 1.0, 2.0
MOVING = 0.05  # m/s


@dataclass
class Rest:
    """How far the particles of a bed moved in 2 s, in spacings."""

    mean: float
    greatest: float


def limit_slope(friction_angle: float, c: float = 0.55) -> float:
    """Return the slope at which an endless bed saturated to its surface slides, degrees.

    ``tan theta = C (rho_s - rho_l) tan phi / (C rho_s + (1 - C) rho_l)``.
    """
    buoyant = c * (ROCK - WATER)
    return float(np.degrees(np.arctan(buoyant * _tan(friction_angle) / (buoyant + WATER))))


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


def moving_depth(
    slope: float, friction_angle: float, spacing: float, rows: int, water_rows: int, time: float
) -> float:
    """Return the depth under the surface of the bed at which the grains move at 5 cm/s, m.

    0 if none does.  The speed is that of rows one spacing high, linear between their middles.
    """
    scheme, state = start(slope, friction_angle, spacing, rows, water_rows)
    advance(scheme, state, until=time)
    p = state.particles
    is_rock = p.sediment_fraction[p.fluid] > 0
    row = (p.position[p.fluid, 1][is_rock] / spacing).astype(int)
    count = np.bincount(row, minlength=rows)[:rows]
    total = np.bincount(row, p.velocity[p.fluid, 0][is_rock], minlength=rows)[:rows]
    speed = np.divide(total, count, out=np.zeros(rows), where=count > 0)
    if speed.max() < MOVING:
        return 0.0
    height = float(np.interp(MOVING, np.maximum.accumulate(speed), np.arange(rows) + 0.5))
    return spacing * (rows - height)


def _by_id(state: State) -> Floats:
    p = state.particles
    return p.position[p.fluid, :2][np.argsort(p.id[p.fluid])].copy()
