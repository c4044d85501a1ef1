"""Still water, and still water over a layer of sediment density: pressure, height, leaks.

Pressure errors are against the exact distribution below the nominal surface, in units of the
pressure at the floor, over the second half of the simulated time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from debrisflow.case import load_case
from debrisflow.particles.record import Kind
from debrisflow.particles.start import initial_state
from debrisflow.schemes.choice import scheme_of
from debrisflow.validation.files import CASES

GRAVITY = 9.81
HEIGHT = 0.2


@dataclass
class Still:
    """What a still tank did: errors in units of the floor pressure, lengths in the height.

    ``slopes`` are -dp/dy of the lower and the upper half, Pa/m.
    """

    pressure_error: float
    floor_noise: float
    height: float
    interface: float
    slopes: tuple[float, float]
    through_wall: int


def run(name: str, overrides: tuple[str, ...] = (), end: float = 2.0) -> Still:
    """Run a shipped still tank of 0.2 m and measure it."""
    case = load_case(CASES / f"{name}.toml", [f"time.end={end}", *overrides])
    scheme, state = scheme_of(case), initial_state(case)
    p = state.particles
    start = p.position[p.fluid, 1].mean()
    heavy = p.kind[p.fluid] == Kind.SEDIMENT
    lower_density = case.sediment.density if heavy.any() else case.water.density
    interface = 0.5 * HEIGHT

    def exact(y: np.ndarray) -> np.ndarray:
        upper = case.water.density * GRAVITY * (HEIGHT - np.maximum(y, interface))
        return upper + lower_density * GRAVITY * np.maximum(interface - y, 0.0)

    at_floor = float(exact(np.zeros(1))[0])
    errors, floors, profile = [], [], []
    while state.time < end:
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time += dt
        state.step += 1
        if state.time > 0.5 * end and state.step % 5 == 0:
            y, pressure = p.position[p.fluid, 1], p.pressure[p.fluid]
            errors.append(np.mean(((pressure - exact(y)) / at_floor) ** 2))
            lowest = y < case.particles.spacing
            on_floor = pressure[lowest] + lower_density * GRAVITY * y[lowest]
            floors.append(on_floor.mean() / at_floor)
            profile.append(np.column_stack([y, pressure]))
    y, pressure = np.concatenate(profile).T
    margin = 4 * case.particles.spacing
    slopes = []
    for bottom, top in ((0.0, interface), (interface, HEIGHT)):
        middle = (y > bottom + margin) & (y < top - margin)
        slopes.append(-float(np.polyfit(y[middle], pressure[middle], 1)[0]))
    rows, heavy = p.position[p.fluid, 1], p.kind[p.fluid] == Kind.SEDIMENT
    gap = 0.0
    if heavy.any():
        gap = float(max(rows[heavy].max() - interface, interface - rows[~heavy].min(), 0.0))
    return Still(
        float(np.sqrt(np.mean(errors))),
        float(np.std(floors)),
        float(rows.mean() / start),
        gap / case.particles.spacing,
        (slopes[0], slopes[1]),
        int(state.through_wall.sum()),
    )
