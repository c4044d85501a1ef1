"""A slab that slides down a plane with Coulomb friction, and one that comes to rest on a plane.

An endless slab, in a channel that repeats along its length, neither spreads nor shears: its grains
rub on each other more than on the floor.  So it moves as a block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.schemes.choice import scheme_of
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.row import at_most, near, stated

Floats = NDArray[np.float64]
DEPTH = 0.1  # m
GRAVITY = 9.81
FRICTION, INTERNAL = 20.0, 40.0  # degrees, along the floor and between the grains
STEEP, MILD = 30.0, 5.0  # degrees, of the planes
LAUNCH = 2.0  # m/s, of the slab on the mild plane
WIDTH, ALONG = 0.6, 12  # m; spacings, after which the channel repeats
SLIDING, STOPPING = 1.0, 1.2  # s; the slab on the mild plane stops after 0.74 s
STOPPED = 0.94  # s, from when on it has to stand still
SAMPLES = 25
FREE = {"friction": {"law": "none"}}


class Path(NamedTuple):
    """Mean velocity along the plane and its integral, (samples,) float64 arrays, s, m/s, m."""

    time: Floats
    speed: Floats
    way: Floats


def acceleration(slope: float) -> float:
    """Return ``g (sin(slope) - cos(slope) tan(friction))``, m/s2, along the plane."""
    angle, friction = np.radians(slope), np.radians(FRICTION)
    return float(GRAVITY * (np.sin(angle) - np.cos(angle) * np.tan(friction)))


def slab(rows: int, slope: float, speed: float) -> ResolvedCase:
    """Return the case of a slab that starts with a speed, m/s."""
    spacing = DEPTH / rows
    length, width = ALONG * spacing, WIDTH
    block = {"x": (0.0, length), "y": (0.0, width), "z": (0.0, DEPTH)}
    return case_of(
        title="slab with Coulomb friction",
        particles={"spacing": spacing},
        gravity={"slope": slope},
        geometry={
            "type": "channel3d",
            "periodic": True,
            "length": length,
            "width": width,
            "height": 2.0 * DEPTH,
        },
        walls={
            "floor": {"friction": {"law": "coulomb", "angle": FRICTION}},
            "front": FREE,
            "back": FREE,
        },
        fill=[{"type": "block", "material": "mixture", "velocity": (speed, 0.0, 0.0), **block}],
        rheology={"type": "coulomb", "friction_angle": INTERNAL, "saturated": False},
        scheme={"type": "explicit", "sound_speed": 20.0},
        time={"end": 10.0},
        output={"interval": 1.0},
    )


def run(rows: int, slope: float, speed: float, end: float) -> Path:
    """Let a slab slide; its way is the mean of what its particles cover, step by step."""
    case = slab(rows, slope, speed)
    scheme, state = scheme_of(case), initial_state(case)
    p, way, series = state.particles, 0.0, [(0.0, speed, 0.0)]
    for time in np.linspace(0.0, end, SAMPLES + 1)[1:]:
        steps = int(np.ceil((time - state.time) / scheme.stable_dt(state)))
        dt = (time - state.time) / steps
        for _ in range(steps):
            scheme.step(state, dt)
            state.time += dt
            state.step += 1
            way += dt * float(p.velocity[p.fluid, 0].mean())
        series.append((state.time, float(p.velocity[p.fluid, 0].mean()), way))
    return Path(*np.array(series).T)


def measure(level: Level) -> Measured:
    """Return how a slab accelerates on a steep plane and stops on a mild one."""
    rows = round(level.across)
    sliding = run(rows, STEEP, 0.0, SLIDING)
    stopping = run(rows, MILD, LAUNCH, STOPPING)
    late = sliding.time > 0.5 * SLIDING
    found = float(np.polyfit(sliding.time[late], sliding.speed[late], 1)[0])
    drive, brake = acceleration(STEEP), acceleration(MILD)
    pull = GRAVITY * float(np.sin(np.radians(STEEP)))
    rubbed = (pull - found) / (pull - drive)
    stop = -0.5 * LAUNCH**2 / brake
    still = float(np.abs(stopping.speed[stopping.time > STOPPED]).max())
    return Measured(
        (
            near(
                "acceleration on the steep plane",
                found,
                drive,
                "chosen: what side walls without friction may bear of the weight",
                share=0.02,
                unit="m/s²",
            ),
            near(
                "stopping distance on the mild plane",
                float(stopping.way[-1]),
                stop,
                "chosen: the same; the slab settles in its lattice while it brakes",
                share=0.02,
                unit="m",
            ),
            at_most(
                "mean speed 0.2 s after it should have stopped and later",
                1e3 * still,
                1.0,
                "chosen: friction holds what stands still; the slab started with 2 m/s",
                "mm/s",
            ),
            stated("share of the friction that the side walls take away", 1.0 - rubbed, "%"),
        ),
        abs(found / drive - 1.0),
        tuple(_panels(sliding, stopping)),
    )


def _panels(sliding: Path, stopping: Path) -> list[Panel]:
    time = np.linspace(0.0, SLIDING, 21)
    after = np.linspace(0.0, STOPPING, 61)
    braked = np.maximum(LAUNCH + acceleration(MILD) * after, 0.0)
    return [
        Panel(
            "from rest on 30°",
            "t (s)",
            "mean speed (m/s)",
            (exact(time, acceleration(STEEP) * time), computed(sliding.time, sliding.speed)),
        ),
        Panel(
            "from 2 m/s on 5°",
            "t (s)",
            "mean speed (m/s)",
            (exact(after, braked), computed(stopping.time, stopping.speed)),
        ),
    ]


COMPARISONS = (
    Comparison(
        name="coulomb_slab",
        title="Slab that slides and stops by Coulomb friction",
        group=Group.DEBRIS_FLOWS,
        compared=(
            "Acceleration of a slab from rest on 30°, in the second half of a second, and the "
            "distance in which one with 2 m/s stops on 5°."
        ),
        reference="closed form, block on a plane: a = g (sin θ - cos θ tan δ), u² / (2 |a|)",
        parameters=(
            "three dimensions, endless slab 0.1 m deep and 0.6 m wide, friction of 20° along "
            "the floor, 40° between the grains, which are dry; speed of sound 20 m/s"
        ),
        levels=(
            Level(2, "2 rows", 3, is_quick=True),
            Level(4, "4 rows", 12, is_quick=True),
            Level(8, "8 rows", 90),
        ),
        measure=measure,
        error="acceleration on the steep plane over that of the closed form - 1",
        discussion=(
            "The friction between the grains is greater than that along the floor, so that the "
            "slab does not shear: rows differ in speed by less than 1 mm/s. The side walls, which "
            "have no friction, push what is beside them upward a little, and so take load off the "
            "floor: 3 and 5 % of it in a channel six spacings wide and four and eight rows deep, "
            "half as much in one twice as wide."
        ),
    ),
)
