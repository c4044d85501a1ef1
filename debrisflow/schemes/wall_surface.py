"""What the terms of a scheme need to know of the walls of a case."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.wall_access import WallSurface
from debrisflow.particles.record import Particles
from debrisflow.space.domain import WALL_NAMES


def wall_surface(particles: Particles, case: ResolvedCase) -> WallSurface:
    """Return what the viscous terms need to know of the walls."""
    named = [getattr(case.walls, name) for name in WALL_NAMES]
    # One entry more, so that the index -1 of other particles finds zeros.
    slip = [float(wall.slip == "free-slip") for wall in (*named, *case.obstacle)] + [0.0]
    roughness = [wall.roughness for wall in named] + [0.0] * (len(case.obstacle) + 1)
    return WallSurface(
        particles.wall_normal,
        particles.wall_depth,
        np.array(slip)[particles.wall],
        np.array(roughness)[particles.wall],
    )
