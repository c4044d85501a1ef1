"""Motion of the particles, how fast the fastest is, and who is outside."""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import loop


@loop
def move(dt, velocity, position):
    """Move every particle by its velocity."""
    for i in prange(velocity.shape[0]):
        for k in range(3):
            position[i, k] += dt * velocity[i, k]


@loop
def survey_motion(position, velocity, lower, upper, mouth, fastest, outside):
    """Write, of each block of particles, the greatest squared speed and how many are outside.

    Outside the box from ``lower`` to ``upper``, or beside a flume before its mouth, (x, y0, y1); a
    velocity that is not finite is infinitely fast.
    """
    n = velocity.shape[0]
    for block in prange(fastest.size):
        most, left = 0.0, 0
        for i in range(block * n // fastest.size, (block + 1) * n // fastest.size):
            square = velocity[i, 0] ** 2 + velocity[i, 1] ** 2 + velocity[i, 2] ** 2
            most = max(most, square if square < np.inf else np.inf)
            for k in range(3):
                left += position[i, k] < lower[k] or position[i, k] > upper[k]
            left += position[i, 0] < mouth[0] and not (mouth[1] <= position[i, 1] <= mouth[2])
        fastest[block] = most
        outside[block] = left
