"""Water at rest over a ground that is not level, in a slab of three dimensions.

Over a plane of 15 or 30 degrees, a bump, a valley and a bowl the water shall lie still: what moves
is error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.neighbors.height_field import HeightField, foot_on, height_field
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.explicit import Explicit
from debrisflow.validation.cases import case_of

Floats = NDArray[np.float64]
SPACING, LENGTH, ACROSS = 0.05, 1.0, 11  # m, m, spacings
LEVEL, LOWEST = 1.0, 0.2  # m, of the water and of the lowest ground
NEAREST = 0.4  # spacings; what is seeded nearer to the ground is left out
CELLS = 0.05  # m, of the ground
Shape = Callable[[Floats, Floats], Floats]


def _slope(degrees: float) -> Shape:
    return lambda x, y: LOWEST + np.tan(np.radians(degrees)) * x


def _wave(sign: float) -> Shape:
    """Return a bump or valley along x whose radius of curvature is 5 spacings."""
    height = 0.5 * (LENGTH / (2.0 * np.pi)) ** 2 / (5.0 * SPACING) * 2.0
    middle = LOWEST + (height if sign < 0.0 else 0.0)
    return lambda x, y: middle + sign * 0.5 * height * (1.0 - np.cos(2.0 * np.pi * x / LENGTH))


def _bowl(x: Floats, y: Floats) -> Floats:
    square = (x - 0.5 * LENGTH) ** 2 + (y - 0.5 * LENGTH) ** 2
    return LOWEST + 0.5 * square / (10.0 * SPACING)


SHAPES: dict[str, Shape] = {
    "15 degrees": _slope(15.0),
    "30 degrees": _slope(30.0),
    "bump": _wave(1.0),
    "valley": _wave(-1.0),
    "bowl": _bowl,
}


@dataclass
class StillGround:
    """What water at rest over a ground did in the last half of the time.

    Attributes
    ----------
    speed, current : float, m/s
        Rms of the speed, and of the velocity averaged over time in cells of two spacings.
    pressure_error : float
        Rms over the cells of the time-mean pressure less ``rho g (H - z)``, with one offset free,
        over that at the depth of the water.
    drift : float
        Of the mean height in the last half, over the depth.
    lost, inside : int
        Particles that left or went through a wall; found in the ground by a tenth of a spacing.
    """

    speed: float
    current: float
    pressure_error: float
    drift: float
    lost: int
    inside: int


def build(end: float, is_wide: bool) -> tables.Case:
    """Return the case: water on a level floor, which the ground then covers."""
    width = LENGTH if is_wide else ACROSS * SPACING
    block = {"type": "block", "x": (0.0, LENGTH), "y": (0.0, width), "z": (0.0, LEVEL)}
    smooth = {"slip": "free-slip"}
    tank = {"type": "tank3d", "periodic": not is_wide, "length": LENGTH, "width": width}
    return case_of(
        title="still water over a ground",
        particles={"spacing": SPACING},
        geometry=tank | {"height": 1.5 * LEVEL},
        walls=dict.fromkeys(("floor", "left", "right"), smooth),
        fill=[block | {"material": "water"}],
        scheme={"type": "explicit", "sound_speed": 22.0},
        time={"end": end},
        output={"interval": end},
    )


def ground_of(shape: Shape) -> HeightField:
    """Return the ground of a shape, over more than the tank."""
    middle = (np.arange(60) + 0.5) * CELLS - 1.0
    return height_field(
        shape(*np.meshgrid(middle, middle, indexing="ij")), CELLS, (-1.0, -1.0), number=0
    )


def distances(position: Floats, ground: HeightField) -> Floats:
    """Return the distance of places, (n, 3) array, m, to a ground."""
    return np.array([foot_on(x, y, z, ground)[0] for x, y, z in position])


def start(case: tables.Case, ground: HeightField) -> State:
    """Return the state of a case at its start, without what lies in the ground."""
    state = initial_state(case)
    p = state.particles
    kept = np.flatnonzero(distances(p.position[p.fluid], ground) > NEAREST * SPACING)
    p.fluid_count = kept.size
    p.keep(kept, kept.size)
    return state


def run(name: str, end: float = 4.0) -> StillGround:
    """Let water lie over a ground, and measure what it does."""
    is_wide = name == "bowl"
    case, ground = build(end, is_wide), ground_of(SHAPES[name])
    state, scheme = start(case, ground), Explicit(case, ground)
    scheme.fill_number_density(state)
    shape = [int(np.ceil(size / (2.0 * SPACING))) for size in (LENGTH, LENGTH, LEVEL * 1.2)]
    sums = np.zeros((5, *shape))
    speeds, heights, inside = [], [], 0
    while state.time < end:
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time, state.step = state.time + dt, state.step + 1
        if state.time < 0.5 * end or state.step % 5:
            continue
        p = state.particles
        x, u = p.position[p.fluid], p.velocity[p.fluid]
        cell = tuple(np.clip((x // (2.0 * SPACING)).astype(int), 0, np.array(shape) - 1).T)
        excess = p.pressure[p.fluid] - 1000.0 * 9.81 * (LEVEL - x[:, 2])
        for total, value in zip(sums, (np.ones(len(x)), *u.T, excess), strict=True):
            np.add.at(total, cell, value)
        speeds.append(np.mean(np.sum(u**2, axis=1)))
        heights.append(x[:, 2].mean())
    inside = int(np.count_nonzero(distances(x, ground) < -0.1 * SPACING))
    count = sums[0]
    means = sums[1:, count > 0.2 * count.max()] / count[count > 0.2 * count.max()]
    return StillGround(
        speed=float(np.sqrt(np.mean(speeds))),
        current=float(np.sqrt(np.mean(np.sum(means[:3] ** 2, axis=0)))),
        pressure_error=float(np.std(means[3]) / (1000.0 * 9.81 * (LEVEL - LOWEST))),
        drift=float((heights[-1] - heights[0]) / (LEVEL - LOWEST)),
        lost=int(state.through_wall.sum() + state.left.sum()),
        inside=inside,
    )
