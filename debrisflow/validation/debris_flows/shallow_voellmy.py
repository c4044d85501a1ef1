"""Depth-averaged flow by Voellmy's law down a slope and onto a milder one, by finite volumes.

What codes for avalanches and debris flows of the field solve, in one dimension along the bed,

    h_t + (h u)_s = 0
    (h u)_t + (h u^2 + g h^2 cos(theta) / 2)_s
        = g h sin(theta) - sign(u) (mu h (g cos(theta) + kappa u^2) + g u^2 / xi)

with fluxes of Rusanov, first order, and friction that stops but never turns the flow.  The bed of
curvature kappa bends over a length of one depth; a slab that slides through it by an angle a loses
``1 - exp(-mu a)`` of its speed, however long the bend is.

References
----------
Savage & Hutter 1989, Journal of Fluid Mechanics 199, doi:10.1017/S0022112089000340.
Voellmy 1955, Schweizerische Bauzeitung 73.  Christen, Kowalski & Bartelt 2010, RAMMS, Cold Regions
Science and Technology 63, doi:10.1016/j.coldregions.2010.04.005.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GRAVITY = 9.81
DRY = 1e-6
"""Depth, m, under which nothing flows."""
COURANT = 0.4


class Slope(NamedTuple):
    """A bed and its friction.

    Attributes
    ----------
    length, bend : float, m
        Along the bed, and to where it turns milder.
    steep, mild : float, degrees
    sliding : float
    turbulent : float, m/s2
    """

    length: float
    bend: float
    steep: float
    mild: float
    sliding: float
    turbulent: float


class Flow(NamedTuple):
    """The flow at one time.

    Attributes
    ----------
    place, depth : (n,) float64 array, m
    speed : float, m/s
        Of its center of mass.
    energy : float
        Integral of ``h u^2``, m4/s2.
    """

    place: Floats
    depth: Floats
    speed: float
    energy: float

    def reached(self, share: float) -> float:
        """Return up to where a share of the volume lies, m."""
        volume = np.cumsum(self.depth) / self.depth.sum()
        return float(np.interp(share, volume, self.place))


def release(
    bed: Slope, back: float, front: float, depth: float, times: Floats, cell: float = 0.05
) -> list[Flow]:
    """Return the flow of a block of constant depth at times.

    Parameters
    ----------
    bed : Slope
    back, front, depth : float, m
        Of the block.
    times : (n,) float64 array, s
    cell : float, m
    """
    place = np.arange(0.5 * cell, bed.length, cell, dtype=np.float64)
    turned = np.clip((place - bed.bend) / depth + 0.5, 0.0, 1.0)
    angle = np.radians(bed.steep + (bed.mild - bed.steep) * turned)
    h = np.where((place > back) & (place < front), depth, 0.0)
    q, now, found = np.zeros_like(h), 0.0, []
    for time in times:
        while now < time:
            u = np.where(h > DRY, q / np.maximum(h, DRY), 0.0)
            fastest = float(np.max(np.abs(u) + np.sqrt(GRAVITY * h)))
            dt = min(COURANT * cell / fastest, time - now)
            h, q = _step(bed, h, q, u, angle, cell, dt)
            now += dt
        found.append(_flow(place, h, q))
    return found


def _flow(place: Floats, h: Floats, q: Floats) -> Flow:
    wet = h > DRY
    energy = float(np.sum(q[wet] ** 2 / h[wet]) * (place[1] - place[0]))
    return Flow(place, h.copy(), float(q.sum() / h.sum()), energy)


def _step(
    bed: Slope, h: Floats, q: Floats, u: Floats, angle: Floats, cell: float, dt: float
) -> tuple[Floats, Floats]:
    """Return depths and discharges one step later."""
    ratio, curvature = dt / cell, -np.gradient(angle, cell)
    steep = GRAVITY * np.sin(angle)
    friction = bed.sliding * (GRAVITY * np.cos(angle) + curvature * u**2)
    flux = q * u + 0.5 * GRAVITY * np.cos(angle) * h**2
    wave = np.abs(u) + np.sqrt(GRAVITY * np.cos(angle) * h)
    fastest = np.maximum(wave[1:], wave[:-1])
    mass = 0.5 * (q[1:] + q[:-1] - fastest * np.diff(h))
    momentum = 0.5 * (flux[1:] + flux[:-1] - fastest * np.diff(q))
    h = h - ratio * np.diff(mass, prepend=0.0, append=0.0)
    q = q - ratio * np.diff(momentum, prepend=0.0, append=0.0) + dt * steep * h
    wet = h > DRY
    # implicit in the turbulent part, and no further than to rest in the sliding one
    u = np.where(wet, q / np.maximum(h, DRY), 0.0)
    sliding = np.sign(u) * np.maximum(np.abs(u) - dt * friction, 0.0)
    drag = dt * GRAVITY / bed.turbulent * np.abs(sliding) / np.maximum(h, DRY)
    return h, np.where(wet, h * sliding / (1.0 + drag), 0.0)
