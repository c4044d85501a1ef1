"""Water at rest in a tank of three dimensions: height, pressure, speed, leaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from debrisflow.case import load_case
from debrisflow.space.gravity import gravity_vector
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import states

CASE = CASES / "still_tank3d.toml"


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
    """

    drift: float
    pressure_error: float
    raw_pressure_error: float
    speed: float
    lost: int


def run(overrides: tuple[str, ...] = (), depth: float = 1.0) -> Still3D:
    """Run the shipped tank, with changes, and measure it; ``depth`` is that of the water, m."""
    case = load_case(CASE, overrides)
    weight = -case.water.density * gravity_vector(case)[2]
    count, squares, start = 0, 0.0, 0.0
    for state in states(case, case.time.end / 300):
        p = state.particles
        z = p.position[p.fluid, 2]
        if state.step == 0:
            start = z.mean()
            summed = np.zeros(p.fluid_count)
            reference = p.fluid_count
        if state.time < 0.5 * case.time.end or p.fluid_count < reference:
            continue
        # a particle is known by its number, since it changes rows
        difference = p.pressure[p.fluid] - weight * (depth - z)
        summed += difference[np.argsort(p.id[p.fluid])]
        squares += float(np.mean(np.sum(p.velocity[p.fluid] ** 2, axis=1)))
        count += 1
    error = summed / max(count, 1) / (weight * depth)
    return Still3D(
        float(z.mean() / start - 1.0),
        float(np.std(error)),
        float(np.sqrt(np.mean(error**2))),
        float(np.sqrt(squares / max(count, 1))),
        int(state.through_wall.sum() + state.left.sum()),
    )


def shallow(spacing: float = 0.02, depth: float = 0.2) -> tuple[str, ...]:
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
