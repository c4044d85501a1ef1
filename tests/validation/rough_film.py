"""A turbulent film on a slope over a rough floor, against its mixing-length profile."""

from __future__ import annotations

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


def run(rows: int, depth: float, roughness: float, mixing_length: float) -> float:
    """Return the mean speed of a film ``rows`` particles deep, periodic along x, m/s."""
    case = endless_channel(
        depth / rows,
        SLOPE,
        [{"y": [0.0, depth], "material": "water"}],
        walls={"floor": {"roughness": roughness}},
        strength={"type": "coulomb", "mixing_length": mixing_length},
    )
    scheme, state = SemiImplicit(case), initial_state(case)
    speeds = []
    for until in STEADY:
        advance(scheme, state, until=until)
        speeds.append(state.particles.velocity[state.particles.fluid, 0].mean())
    return float(np.mean(speeds))
