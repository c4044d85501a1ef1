"""What flows in a flume with a movable bed, over its height: speed and share of sediment."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.validation.debris_flows.flume import Flume

Floats = NDArray[np.float64]
MIXED = 0.1
"""Speed, m/s, from which on the concentration of what moves counts."""
HEAD = 0.5
"""Length of the head behind the front, m."""
COLUMN = 0.1
"""Length, m, of the columns in which particles are ordered by their height."""
STATIONS = (6.86, 6.88, 6.90, 6.92, 6.94)
"""Where the study takes its profiles of A1, m."""
MOST_ROWS = 200
STILL = 0.1
"""Share of the surface speed at which the moving layer is taken to begin."""


class Profile(NamedTuple):
    """Speed over the height of the moving layer.

    Attributes
    ----------
    height : (n,) float64 array
        Over the depth; 0 where the speed is a tenth of that of the surface.
    speed : (n,) float64 array
        Over that of the surface.
    depth : float, m
    surface : float, m/s
    """

    height: Floats
    speed: Floats
    depth: float
    surface: float

    @property
    def error(self) -> float:
        """Return the root mean square distance from the dilatant profile."""
        return float(np.sqrt(np.mean((self.speed - dilatant(self.height)) ** 2)))


def dilatant(height: Floats) -> Floats:
    """Return u / u_s of a dilatant fluid at y / h (Bagnold 1954, Takahashi 1978)."""
    profile: Floats = 1.0 - (1.0 - height) ** 1.5
    return profile


def speed_profile(flume: Flume, start: float, end: float) -> Profile:
    """Return the mean profile of the frames between two times at the end of the bed.

    As the study takes them: means over one spacing to either side of the stations and, here, over
    the frames, in layers one spacing thick.  The surface is the uppermost layer that is a third
    full.
    """
    d0 = flume.case.particles.spacing
    speed, count = np.zeros((2, MOST_ROWS))
    bottom, frames = -flume.channel.bed_thickness, 0
    for time, frame in flume.frames.items():
        if not start <= time <= end:
            continue
        frames += 1
        for station in STATIONS:
            here = np.abs(frame.position[:, 0] - station) < d0
            layer = ((frame.position[here, 1] - bottom) / d0).astype(int)
            count += np.bincount(layer, minlength=MOST_ROWS)[:MOST_ROWS]
            speed += np.bincount(layer, frame.velocity[here, 0], minlength=MOST_ROWS)[:MOST_ROWS]
    top = int(np.flatnonzero(count > frames * len(STATIONS) * 2.0 / 3.0)[-1])
    u = speed[: top + 1] / np.maximum(count[: top + 1], 1)
    y = np.arange(0.5, top + 1, dtype=np.float64) * d0
    slow = u < STILL * u[-1]
    above = int(np.flatnonzero(slow)[-1]) if slow.any() else 0
    zero = float(np.interp(STILL * u[-1], u[above : above + 2], y[above : above + 2]))
    depth = float(y[-1] - zero)
    return Profile((y[above + 1 :] - zero) / depth, u[above + 1 :] / u[-1], depth, float(u[-1]))


class Mixed(NamedTuple):
    """Volume share of sediment in what moves faster than 0.1 m/s.

    Attributes
    ----------
    above : float
        In the half meter behind the front, above the level of the bed at the start.
    body, surface, base : float
        Behind it, from half a meter past the beginning of the bed on: of all of it, of the upper
        fifth of each 0.1 m, and of the lower fifth.
    """

    above: float
    body: float
    surface: float
    base: float


def concentrations(flume: Flume, time: float) -> Mixed:
    """Return the shares of sediment at the time of a frame."""
    frame = flume.frames[time]
    x, y = frame.position.T
    front = float(np.interp(time, flume.time, flume.front))
    moves = np.linalg.norm(frame.velocity, axis=1) > MIXED
    in_head = moves & (x > front - HEAD) & (x <= front + flume.case.particles.spacing)
    height, body = _body(flume, time)
    parts = (
        frame.fraction[in_head & (y > 0.0)],
        body,
        body[height > 0.8],
        body[height < 0.2],
    )
    return Mixed(*(float(part.mean()) if part.size else np.nan for part in parts))


def concentration_profile(
    flume: Flume, times: tuple[float, ...], layers: int = 5
) -> tuple[Floats, Floats]:
    """Return the middles of layers of the moving body, over its height, and their shares."""
    found = [_body(flume, time) for time in times]
    height, fraction = (np.concatenate(part) for part in zip(*found, strict=True))
    edges = np.linspace(0.0, 1.0, layers + 1)
    count = np.histogram(height, edges)[0]
    share = np.histogram(height, edges, weights=fraction)[0] / np.maximum(count, 1)
    return 0.5 * (edges[1:] + edges[:-1]), share


def _body(flume: Flume, time: float) -> tuple[Floats, Floats]:
    """Return height by order and sediment fraction of the particles of the body."""
    frame = flume.frames[time]
    x, y = frame.position.T
    front = float(np.interp(time, flume.time, flume.front))
    moves = np.linalg.norm(frame.velocity, axis=1) > MIXED
    inside = moves & (x > flume.channel.bed_start + HEAD) & (x <= front - HEAD)
    return _rank_in_column(x[inside], y[inside]), frame.fraction[inside]


def _rank_in_column(x: Floats, y: Floats) -> Floats:
    """Return how many of the particles in the same column are lower, as a share."""
    rank, number = np.empty(y.size), (x / COLUMN).astype(int)
    for column in np.unique(number):
        rows = np.flatnonzero(number == column)
        rank[rows[np.argsort(y[rows])]] = (np.arange(rows.size) + 0.5) / rows.size
    return rank
