"""Water at rest over a ground that is not level, in a slab of three dimensions.

Over a plane of 15 or 30 degrees, a bump, a valley and a bowl the water shall lie still: what moves
is error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.height_field import HeightField, foot_on, height_field
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.explicit import Explicit
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.marching import advance
from debrisflow.validation.row import Row, at_most, between, none_of

Floats = NDArray[np.float64]
LENGTH, ACROSS = 1.0, 11  # m, spacings
LEVEL, LOWEST = 1.0, 0.2  # m, of the water and of the lowest ground
DEEPEST = LEVEL - LOWEST
RADIUS = 0.25  # m, of curvature of bump and valley; the bowl's is twice as large
NEAREST = 0.4  # spacings; what is seeded nearer to the ground is left out
CELLS = 0.05  # m, of the ground
WEIGHT = 1000.0 * 9.81  # N/m3, of the water
END = 4.0  # s
Shape = Callable[[Floats, Floats], Floats]


def _slope(degrees: float) -> Shape:
    return lambda x, y: LOWEST + np.tan(np.radians(degrees)) * x


def _wave(sign: float) -> Shape:
    """Return a bump or valley along x of a given radius of curvature at its crest and bottom."""
    height = (LENGTH / (2.0 * np.pi)) ** 2 / RADIUS
    middle = LOWEST + (height if sign < 0.0 else 0.0)
    return lambda x, y: middle + sign * 0.5 * height * (1.0 - np.cos(2.0 * np.pi * x / LENGTH))


def _bowl(x: Floats, y: Floats) -> Floats:
    square = (x - 0.5 * LENGTH) ** 2 + (y - 0.5 * LENGTH) ** 2
    level: Floats = LOWEST + 0.5 * square / (2.0 * RADIUS)
    return level


SHAPES: dict[str, Shape] = {
    "slope of 15°": _slope(15.0),
    "slope of 30°": _slope(30.0),
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
    level : float, m
        Of the surface, by the volume of the particles.
    position, pressure : arrays, m, Pa
        Of the particles at the end.
    """

    speed: float
    current: float
    pressure_error: float
    drift: float
    lost: int
    inside: int
    level: float
    position: Floats
    pressure: Floats


def width_of(spacing: float, is_wide: bool) -> float:
    """Return the width of the tank, m."""
    return LENGTH if is_wide else ACROSS * spacing


def build(spacing: float, end: float, is_wide: bool) -> ResolvedCase:
    """Return the case: water on a level floor, which the ground then covers."""
    width = width_of(spacing, is_wide)
    block = {"type": "block", "x": (0.0, LENGTH), "y": (0.0, width), "z": (0.0, LEVEL)}
    smooth = {"slip": "free-slip"}
    tank = {"type": "tank3d", "periodic": not is_wide, "length": LENGTH, "width": width}
    return case_of(
        title="still water over a ground",
        particles={"spacing": spacing},
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


def start(case: ResolvedCase, ground: HeightField) -> State:
    """Return the state of a case at its start, without what lies in the ground."""
    state = initial_state(case)
    p = state.particles
    kept = np.flatnonzero(distances(p.position[p.fluid], ground) > NEAREST * case.particles.spacing)
    p.fluid_count = kept.size
    p.keep(kept, kept.size)
    return state


def level_of(volume: float, shape: Shape, width: float) -> float:
    """Return the level, m, of water of a volume, m3, that covers all of a ground."""
    count = 200
    x, y = (size * (np.arange(count) + 0.5) / count for size in (LENGTH, width))
    return float(shape(*np.meshgrid(x, y)).mean() + volume / (LENGTH * width))


def run(name: str, spacing: float, end: float = END) -> StillGround:
    """Let water lie over a ground, and measure what it does."""
    is_wide = name == "bowl"
    case, ground = build(spacing, end, is_wide), ground_of(SHAPES[name])
    state, scheme = start(case, ground), Explicit(case, ground)
    scheme.fill_number_density(state)
    size = np.array((LENGTH, LENGTH, 1.2 * LEVEL))
    shape = np.ceil(size / (2.0 * spacing)).astype(int)
    sums = np.zeros((5, *shape))
    speeds, heights, p = [], [], state.particles
    while state.time < end:
        advance(scheme, state, steps=1)
        if state.time < 0.5 * end or state.step % 5:
            continue
        x, u = p.position[p.fluid], p.velocity[p.fluid]
        cell = tuple(np.clip((x // (2.0 * spacing)).astype(int), 0, shape - 1).T)
        excess = p.pressure[p.fluid] - WEIGHT * (LEVEL - x[:, 2])
        for total, value in zip(sums, (np.ones(len(x)), *u.T, excess), strict=True):
            np.add.at(total, cell, value)
        speeds.append(np.mean(np.sum(u**2, axis=1)))
        heights.append(x[:, 2].mean())
    position = p.position[p.fluid].copy()
    is_full = sums[0] > 0.2 * sums[0].max()
    means = sums[1:, is_full] / sums[0][is_full]
    return StillGround(
        speed=float(np.sqrt(np.mean(speeds))),
        current=float(np.sqrt(np.mean(np.sum(means[:3] ** 2, axis=0)))),
        pressure_error=float(np.std(means[3]) / (WEIGHT * DEEPEST)),
        drift=float((heights[-1] - heights[0]) / DEEPEST),
        lost=int(state.through_wall.sum() + state.left.sum()),
        inside=int(np.count_nonzero(distances(position, ground) < -0.1 * spacing)),
        level=level_of(p.fluid_count * spacing**3, SHAPES[name], width_of(spacing, is_wide)),
        position=position,
        pressure=p.pressure[p.fluid].copy(),
    )


def measure(names: Sequence[str], level: Level) -> Measured:
    """Return what water over some grounds did at a level."""
    spacing = DEEPEST / level.across
    found = {name: run(name, spacing) for name in names}
    rows = [row for name, each in found.items() for row in _rows(name, round(level.across), each)]
    lost = sum(each.lost + each.inside for each in found.values())
    rows.append(none_of("particles lost or in the ground, all grounds", lost))
    return Measured(
        tuple(rows),
        max(each.pressure_error for each in found.values()),
        tuple(_panel(name, each) for name, each in found.items()),
    )


def _rows(name: str, rows: int, found: StillGround) -> list[Row]:
    fall = "of the speed of free fall through the depth, 4 m/s"
    return [
        at_most(
            f"{name}: rms error of the mean pressure, offset free / that of the depth",
            found.pressure_error,
            0.03,
            "chosen: as in the level tank, `still_tank`",
            "%",
        ),
        at_most(
            f"{name}: rms of the mean current",
            1e3 * found.current,
            10.0,
            f"chosen: a quarter of a hundredth {fall}",
            "mm/s",
            miss=COARSE if rows < 16 and name == "slope of 30°" else "",
            worst=11.0,
        ),
        at_most(
            f"{name}: rms speed", 1e3 * found.speed, 30.0, f"chosen: a hundredth {fall}", "mm/s"
        ),
        between(
            f"{name}: drift of the mean height",
            found.drift,
            -0.01,
            0.01,
            "the mean compression under its own weight, g H / 2 c², is 1 %",
            "%",
            is_conserved=True,
        ),
    ]


def _panel(name: str, found: StillGround) -> Panel:
    depth = found.level - found.position[:, 2]
    seen = np.argsort(depth, kind="stable")
    line = np.array([0.0, DEEPEST])
    return Panel(
        f"{name}, after {END:g} s",
        "pressure, kPa",
        "depth below the surface, m",
        (exact(WEIGHT * line / 1e3, line), points(found.pressure[seen] / 1e3, depth[seen])),
    )


COARSE = "Cause not known, but an error of the spacing: with twice as many rows it is held."
_shared = partial(
    Comparison,
    group=Group.AT_REST,
    reference="closed form: ρ g (H - z), and nothing moves",
    parameters=(
        "slab 1 m long, 11 spacings wide and periodic across (a bowl: 1 m wide), water up to "
        "0.8 m deep, ground without friction, c = 22 m/s, weakly compressible"
    ),
    error="greatest of the rms errors of the mean pressure / that of the depth",
)
_COMPARED = (
    "Pressure, mean over 2 to 4 s in cells of two spacings, against ρ g (H - z); current, speed "
    "and drift against none, over "
)
_LEVEL = (
    "The lattice cannot fill what is left above a ground, so that the level, which the figures "
    "take from the volume of the particles, is half a spacing below 1 m, and the offset is free."
)
COMPARISONS = (
    _shared(
        name="still_slope",
        title="Still water over slopes",
        compared=_COMPARED + "planes of 15 and 30°.",
        levels=(
            Level(8, "8 rows", 2, is_quick=True),
            Level(16, "16 rows", 13, is_quick=True),
            Level(32, "32 rows", 350),
        ),
        measure=partial(measure, ("slope of 15°", "slope of 30°")),
        discussion=(
            "A ground is a smooth surface without particles. What is wrong with its share in the "
            "sums around a particle would drive a current along it. " + _LEVEL
        ),
    ),
    _shared(
        name="still_ground",
        title="Still water over curved ground",
        compared=_COMPARED + "a bump, a valley and a bowl.",
        levels=(
            Level(16, "16 rows", 28, is_quick=True),
            Level(20, "20 rows", 100),
            Level(24, "24 rows", 200),
        ),
        measure=partial(measure, ("bump", "valley", "bowl")),
        discussion=(
            "Radii of curvature: 0.25 m, of the bowl 0.5 m. That is 5 spacings at 16 rows, the "
            "least that the ground follows; coarser, it would be taken as less curved. " + _LEVEL
        ),
    ),
)
