"""The dam break of Martin & Moyce in three dimensions: a slab that repeats across the flow.

A column a wide and n^2 a high, the slab 11 spacings wide, the least that a periodic space allows,
on a floor with the friction of a smooth wall.
Two fronts are measured: the place ahead of which the layer is thinner than H/40 on average over
H/20, by one length at all spacings; and the first column of particles that is not half a particle
deep.  The tank is 7 a long, so that no front reaches its end before T = 3.5.
"""

from __future__ import annotations

import numpy as np

from debrisflow.case import tables
from debrisflow.validation.cases import case_of
from debrisflow.validation.dam_breaks.dam_break import (
    GRAVITY,
    HIGH,
    SQUARE,
    WIDTH,
    DamBreak,
    Experiment,
    Floats,
    column_height,
    front,
)
from debrisflow.validation.marching import energy, states

ACROSS_SLAB, LENGTH, LAST = 11, 7, 3.5
SMOOTH = 5e-5  # m, the roughness that stands for a smooth floor: 3.3 nu / u* at u* = 0.07 m/s
SAMPLES = 200
SPACINGS = {HIGH: (10, 20, 30), SQUARE: (16, 32, 48)}  # particles across a


def build(
    across: int, experiment: Experiment = HIGH, scheme: dict[str, float] | None = None
) -> tables.Case:
    """Return the case at a spacing of a / across, until T = 3.5."""
    spacing, high = WIDTH / across, experiment.ratio * WIDTH
    slab = ACROSS_SLAB * spacing
    tank = {"length": LENGTH * WIDTH, "width": slab, "height": high + 2 * spacing}
    block = {"x": (0.0, WIDTH), "y": (0.0, slab), "z": (0.0, high)}
    return case_of(
        title="dam break of Martin & Moyce, a slab",
        particles={"spacing": spacing},
        geometry={"type": "tank3d", "periodic": True, **tank},
        walls={"floor": {"friction": {"law": "log", "roughness": SMOOTH}}},
        fill=[{"type": "block", "material": "water", **block}],
        scheme={"type": "explicit"} | (scheme or {}),
        time={"end": LAST / np.sqrt(experiment.ratio * GRAVITY / WIDTH)},
        output={"interval": 1.0},
    )


def last_column(x: Floats, spacing: float) -> float:
    """Return where the first column a spacing wide is that is not half a particle deep, m."""
    count = np.bincount((x / spacing).astype(int))
    thin = np.append(count < 0.5 * ACROSS_SLAB, True)
    return float(spacing * np.argmax(thin))


def run(
    across: int, experiment: Experiment = HIGH, scheme: dict[str, float] | None = None
) -> DamBreak:
    """Run the slab at a spacing of a / across and return its series."""
    case = build(across, experiment, scheme)
    spacing = case.particles.spacing
    stretch, area = experiment.ratio * WIDTH / 20, spacing**2 / ACROSS_SLAB
    series = []
    for state in states(case, case.time.end / SAMPLES):
        position = state.particles.position[state.particles.fluid]
        reach = front(position[:, 0], spacing, stretch, area)
        column = last_column(position[:, 0], spacing)
        height = column_height(position, 2, spacing)
        series.append((state.time, reach, height, energy(case, state), column))
    time, x, z, total, columns = np.array(series).T
    return DamBreak(time, x, z, total / total[0], state, experiment, columns)
