"""Water at rest in a tank of three dimensions: height, pressure, speed, leaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.space.gravity import gravity_vector
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import states
from debrisflow.validation.row import Row, at_most, between, none_of

Floats = NDArray[np.float64]
CASE = CASES / "still_tank3d.toml"
DEPTH, SHALLOW = 1.0, 0.2  # m
STIFF = ("scheme.sound_speed=44.0",)  # m/s, twice the shipped one


@dataclass
class Still3D:
    """What a still tank did in its second half.

    Attributes
    ----------
    drift : float
        Of the mean height of the particles, in that of the start, at the end.
    pressure_error, raw_pressure_error : float
        Rms over the particles of the time-mean pressure less ``rho g (H - z)``, in the pressure at
        the floor; the first with one offset free, since a free surface of particles lies
        somewhere within half a spacing.
    speed : float, m/s
        Rms.
    lost : int
        Particles, through walls or over the rim.
    height, pressure : (n,) float64 array
        Mean over time of each particle, over the depth and over the pressure at the floor.
    """

    drift: float
    pressure_error: float
    raw_pressure_error: float
    speed: float
    lost: int
    height: Floats
    pressure: Floats


def run(overrides: tuple[str, ...] = (), depth: float = DEPTH) -> Still3D:
    """Run the shipped tank, with changes, and measure it; ``depth`` is that of the water, m."""
    case = load_case(CASE, overrides)
    weight = -case.water.density * gravity_vector(case)[2]
    count, squares, start = 0, 0.0, 0.0
    for state in states(case, case.time.end / 300):
        p = state.particles
        z = p.position[p.fluid, 2]
        if state.step == 0:
            start = z.mean()
            heights, pressures = np.zeros((2, p.fluid_count))
        if state.time < 0.5 * case.time.end or p.fluid_count < heights.size:
            continue
        # a particle is known by its number, since it changes rows
        order = np.argsort(p.id[p.fluid])
        heights += z[order] / depth
        pressures += p.pressure[p.fluid][order] / (weight * depth)
        squares += float(np.mean(np.sum(p.velocity[p.fluid] ** 2, axis=1)))
        count += 1
    heights, pressures = heights / max(count, 1), pressures / max(count, 1)
    error = pressures - (1.0 - heights)
    return Still3D(
        float(z.mean() / start - 1.0),
        float(np.std(error)),
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(squares / max(count, 1))),
        int(state.through_wall.sum() + state.left.sum()),
        heights,
        pressures,
    )


def shallow(spacing: float = 0.02, depth: float = SHALLOW) -> tuple[str, ...]:
    """Return the changes for a tank of another depth, of the same shape and the default c."""
    lengths = {
        "particles.spacing": spacing,
        "geometry.length": 0.8 * depth,
        "geometry.width": 0.8 * depth,
        "geometry.height": 1.2 * depth,
        "fill.0.x": [0.0, 0.8 * depth],
        "fill.0.y": [0.0, 0.8 * depth],
        "fill.0.z": [0.0, depth],
        "scheme.sound_speed": 10.0 * (2.0 * 9.81 * depth) ** 0.5,
        "time.end": 3.0,
    }
    return tuple(f"{key}={value!r}" for key, value in lengths.items())


def measure(level: Level) -> Measured:
    """Return what the water did at a level: as shipped, stiffer and in a small tank.

    The finest level is of the shipped tank alone: a lattice of 40 rows takes minutes.
    """
    rows = round(level.across)
    at = f"particles.spacing={DEPTH / rows!r}"
    shipped = run((at,))
    found = _rows(shipped, rows, "")
    if rows < 40:
        found += _rows(run((at, *STIFF)), rows, ", c doubled")
        found += _rows(run(shallow(SHALLOW / rows), SHALLOW), rows, ", 0.2 m deep")
    return Measured(tuple(found), shipped.pressure_error, (_panel(shipped),))


def _rows(found: Still3D, rows: int, where: str) -> list[Row]:
    return [
        at_most(
            f"rms error of the mean pressure, offset free / ρ g H{where}",
            found.pressure_error,
            0.03,
            f"chosen: where a row is {100.0 / rows:g} % of the depth",
            "%",
        ),
        at_most(
            f"the same with the offset{where}",
            found.raw_pressure_error,
            0.05 if rows < 20 else 0.03,
            f"resolution: the surface is unsure by half a row, {50.0 / rows:g} % of the depth",
            "%",
        ),
        between(
            f"drift of the mean height{where}",
            found.drift,
            -0.01,
            0.01,
            "the mean compression under its own weight, g H / 2 c², is 1 %",
            "%",
            is_conserved=True,
        ),
        at_most(
            f"rms speed{where}",
            1e3 * found.speed,
            30.0,
            "chosen: a hundredth of the speed of free fall through the depth, 2 to 4.4 m/s",
            "mm/s",
        ),
        none_of(f"particles lost{where}", found.lost),
    ]


def _panel(found: Still3D) -> Panel:
    seen = np.argsort(found.height, kind="stable")
    return Panel(
        "mean pressure of each particle, 1.5 to 3 s",
        "p / ρ g H",
        "z / H",
        (exact([1.0, 0.0], [0.0, 1.0]), points(found.pressure[seen], found.height[seen])),
    )


COMPARISONS = (
    Comparison(
        name="still_tank",
        title="Still water in a tank of three dimensions",
        group=Group.AT_REST,
        compared=(
            "Mean pressure of every particle from 1.5 to 3 s against ρ g (H - z), mean height and "
            "speed; as shipped, with twice the speed of sound, and in a tank 0.2 m deep."
        ),
        reference="closed form",
        parameters=(
            "tank of 0.8 m by 0.8 m, water 1 m deep, c = 22 m/s, weakly compressible, "
            "`cases/still_tank3d.toml`"
        ),
        levels=(
            Level(10, "10 rows", 5, is_quick=True),
            Level(20, "20 rows", 40),
            Level(40, "40 rows", 200),
        ),
        measure=measure,
        error="rms error of the mean pressure, offset free / ρ g H",
        discussion=(
            "The particles start compressed as their weight compresses them and are shaken by a "
            "small random displacement, so that no symmetry of the lattice holds them."
        ),
    ),
)
