"""A turbulent film over a rough floor, against its profile, and a sheet over a smooth one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow.particles.state import initial_state
from debrisflow.physics.turbulence import KARMAN
from debrisflow.schemes.semi_implicit import SemiImplicit
from tests.building import advance, endless_channel

SLOPE, GRAVITY = 15.0, 9.81
STEADY = (4.0, 5.0, 6.0)  # s


def mean_speed(depth: float, roughness: float, mixing_length: float) -> float:
    """Return the mean speed of a steady film, m/s.

    ``l du/dy = u* sqrt(1 - y / h)``, l the lesser of the mixing length and ``kappa (y + z0)``,
    ``z0 = k_s / 30``, u = 0 at the floor, ``u* = sqrt(g h sin(slope))``.
    """
    count = 100_000
    y = (np.arange(count) + 0.5) * depth / count
    length = np.minimum(mixing_length, KARMAN * (y + roughness / 30.0))
    friction_speed = np.sqrt(GRAVITY * depth * np.sin(np.radians(SLOPE)))
    rise = friction_speed * np.sqrt(1.0 - y / depth) / length
    return float(np.sum(rise * (depth - y)) / count)


class Film(NamedTuple):
    """What a film did: mean speed along the floor, and rms speed across, m/s."""

    speed: float
    across: float


def run(rows: int, depth: float, roughness: float, mixing_length: float) -> Film:
    """Return what a film ``rows`` particles deep, periodic along x, did once it was steady."""
    case = endless_channel(
        depth / rows,
        SLOPE,
        [{"y": [0.0, depth], "material": "water"}],
        walls={"floor": {"roughness": roughness}},
        strength={"type": "coulomb", "mixing_length": mixing_length},
    )
    scheme, state = SemiImplicit(case), initial_state(case)
    found = []
    for until in STEADY:
        advance(scheme, state, until=until)
        velocity = state.particles.velocity[state.particles.fluid]
        found.append((velocity[:, 0].mean(), np.sqrt(np.mean(velocity[:, 1] ** 2))))
    return Film(*np.mean(found, axis=0).tolist())


class Sheet(NamedTuple):
    """What a sheet lost to the floor, N/m2, and its rms speed across, m/s."""

    drag: float
    across: float


def slide(rows: int, speed: float = 3.0, spacing: float = 0.01) -> Sheet:
    """Return what a sheet of water did that slides over a level, smooth floor for a second."""
    layer = {"y": [0.0, rows * spacing], "material": "water", "velocity": [speed, 0.0]}
    case = endless_channel(spacing, 0.0, [layer], walls={"floor": {"slip": "free-slip"}})
    scheme, state = SemiImplicit(case), initial_state(case)
    p, across = state.particles, []
    for until in np.arange(1, 21) / 20.0:
        advance(scheme, state, until=until)
        across.append(np.sqrt(np.mean(p.velocity[p.fluid, 1] ** 2)))
    lost = speed - p.velocity[p.fluid, 0].mean()
    return Sheet(case.water.density * rows * spacing * lost, float(np.mean(across[10:])))
