"""Settling columns: speed of the interface, the bed that is left, and its rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.files import CASES

Floats = NDArray[np.float64]
CASE = CASES / "settling2d.toml"
HEIGHT = 0.6
TERMINAL = 0.3836  # m/s, of a sphere of 3 mm and 2650 kg/m3 in water: C_d = 0.44
REST = 2.0  # s


def richardson_zaki(c: float) -> float:
    """Return the settling speed of grains of 3 mm, m/s: n = 2.39 beyond Re = 500."""
    return TERMINAL * (1.0 - c) ** 2.39


@dataclass
class Settled:
    """What a column did: speeds in m/s, heights in m, displacements in spacings.

    ``bed`` is the concentration of the bed from its third row to 0.7 of its height, for its top is
    uneven.
    """

    speed: float
    bed: float
    bed_height: float
    mean_displacement: float
    greatest_displacement: float
    kept: bool


def run(c: float, seed: int = 1, law: str = "wen-yu", spacing: float = 0.01) -> Settled:
    """Let a column settle until the bed has rested for two seconds; 7 s in all."""
    overrides = (
        f"fill.0.sediment_share={c}",
        f"particles.seed={seed}",
        f"particles.spacing={spacing}",
        f"drag.law={law}",
        "time.end=7.0",  # the last grain may roll off the heap at 4.2 s
    )
    case = load_case(CASE, overrides)
    scheme, state = SemiImplicit(case), initial_state(case)
    p, end = state.particles, case.time.end
    counts = np.bincount(p.kind)
    times, heights, resting = [], [], None
    while state.time < end:
        if resting is None and state.time >= end - REST:
            resting = position_by_id(state)
        dt = min(scheme.stable_dt(state), end - state.time)
        scheme.step(state, dt)
        state.time += dt
        state.step += 1
        times.append(state.time)
        heights.append(interface(state, c, spacing))
    assert resting is not None
    moved = np.linalg.norm(position_by_id(state) - resting, axis=1)
    is_rock = np.zeros(moved.size, dtype=bool)
    is_rock[p.id[p.fluid]] = p.sediment_fraction[p.fluid] > 0
    moved = moved[is_rock] / spacing
    height, profile = concentration_profile(state, spacing)
    in_bed = (height > 2 * spacing) & (height < 0.7 * heights[-1])
    return Settled(
        fall_speed(np.array(times), np.array(heights), c / case.sediment.packing_limit),
        float(profile[in_bed].mean()),
        heights[-1],
        float(moved.mean()),
        float(moved.max()),
        np.array_equal(np.bincount(p.kind), counts) and not state.through_wall.any(),
    )


def position_by_id(state: State) -> Floats:
    """Return the positions of the fluid particles in the order of their numbers."""
    p = state.particles
    return p.position[p.fluid][np.argsort(p.id[p.fluid])]


def concentration_profile(state: State, spacing: float) -> tuple[Floats, Floats]:
    """Return heights and shares of sediment in layers of two spacings."""
    p = state.particles
    edges = np.arange(0.0, HEIGHT + 2.5 * spacing, 2.0 * spacing)
    y, fraction = p.position[p.fluid, 1], p.sediment_fraction[p.fluid]
    count = np.histogram(y, edges)[0]
    rock = np.histogram(y, edges, weights=fraction)[0]
    return 0.5 * (edges[1:] + edges[:-1]), rock / np.maximum(count, 1)


def interface(state: State, c: float, spacing: float) -> float:
    """Return the height at which the concentration falls to half of that at the start."""
    height, profile = concentration_profile(state, spacing)
    last = int(np.flatnonzero(profile >= 0.5 * c)[-1])
    if last + 1 == height.size:
        return float(height[last])
    part = (profile[last] - 0.5 * c) / (profile[last] - profile[last + 1])
    return float(height[last] + part * (height[last + 1] - height[last]))


def fall_speed(times: Floats, heights: Floats, packed_share: float) -> float:
    """Return the speed of the interface from 10 to 70 % of its way to the bed of Kynch."""
    way = HEIGHT * (1.0 - packed_share)
    start = times[heights < HEIGHT - 0.1 * way][0]
    end = times[heights < HEIGHT - 0.7 * way][0]
    falling = (times >= start) & (times <= end)
    return -float(np.polyfit(times[falling], heights[falling], 1)[0])
