"""Where a moving obstacle is, and how fast it moves (NumPy and SciPy only).

It turns in the plane of x and up about an axis that moves with it:

    r' = c + d + R (r - c),   u = dd/dt + omega x (r' - c - d)

with the displacement d, the turn R and the axis c.
"""

from __future__ import annotations

from math import cos, inf, radians, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from debrisflow.case import ResolvedCase
from debrisflow.case.motion import Motion
from debrisflow.space.domain import domain, wall_layers

Floats = NDArray[np.float64]


class Pose(NamedTuple):
    """Where a body is that has moved.

    Attributes
    ----------
    displacement : (3,) float64 array, m
        d, in a space that repeats that to the nearest image.
    turn : (3, 3) float64 array
        R.
    axis : (3,) float64 array, m
        c, where the body started.
    """

    displacement: Floats
    turn: Floats
    axis: Floats

    def moved(self, places: Floats) -> Floats:
        """Return where places of the body, (..., 3) array, m, are."""
        there: Floats = self.axis + self.displacement + (places - self.axis) @ self.turn.T
        return there

    def turned(self, vectors: Floats) -> Floats:
        """Return directions in the body, (..., 3) array."""
        there: Floats = vectors @ self.turn.T
        return there


class Trajectory:
    """The way of an obstacle that moves.

    Parameters
    ----------
    motion : Motion
    corners : (n, 3) float64 array, m
        Points that span the obstacle at the start.
    case : ResolvedCase
    """

    def __init__(self, motion: Motion, corners: Floats, case: ResolvedCase) -> None:
        self._up, self._motion = case.dimension - 1, motion
        self._period = domain(case).period
        self.corners = corners
        self._last = inf if motion.velocity is None else self._gone(motion.velocity, case)
        self._columns = {
            name: PchipInterpolator(motion.time, column) for name, column in motion.table.items()
        }

    def _gone(self, velocity: tuple[float, ...], case: ResolvedCase) -> float:
        """Return the time at which a drawn obstacle has left the space, s."""
        space, reach = domain(case), wall_layers(case) * case.particles.spacing
        ends = [inf]
        for axis, speed in enumerate(velocity):
            if speed > 0.0:
                ends.append((space.upper[axis] + reach - self.corners[:, axis].min()) / speed)
            elif speed < 0.0:
                ends.append((space.lower[axis] - reach - self.corners[:, axis].max()) / speed)
        return self._motion.start + max(min(ends), 0.0)

    @property
    def axes(self) -> set[int]:
        """The axes along which the body moves, both of its plane where it turns."""
        if self._motion.velocity is not None:
            return {axis for axis, speed in enumerate(self._motion.velocity) if speed != 0.0}
        moved = {
            "xyz".index(name)
            for name, column in self._motion.table.items()
            if name != "angle" and any(column)
        }
        return moved | ({0, self._up} if "angle" in self._columns else set())

    @property
    def end(self) -> float:
        """The time from which on the body stands still, or has left the space, s."""
        return self._last if self._motion.time is None else self._motion.time[-1]

    def pose(self, time: float) -> Pose:
        """Return where the body is at a time, s."""
        displacement, turn, axis = np.zeros(3), np.eye(3), np.zeros(3)
        if self._motion.velocity is not None:
            moves_for = max(min(time, self._last) - self._motion.start, 0.0)
            velocity = self._motion.velocity
            displacement[: len(velocity)] = moves_for * np.array(velocity)
        for name, column in self._columns.items():
            value = float(column(np.clip(time, column.x[0], column.x[-1])))
            if name == "angle":
                along, across = cos(radians(value)), sin(radians(value))
                turn[0, 0] = turn[self._up, self._up] = along
                turn[0, self._up], turn[self._up, 0] = -across, across
            else:
                displacement["xyz".index(name)] = value
        # its images stand a period to either side, so that it may go round any number of times
        displacement -= self._period * np.rint(
            displacement / np.where(self._period, self._period, 1.0)
        )
        if self._motion.about is not None:
            axis[[0, self._up]] = self._motion.about
        return Pose(displacement, turn, axis)

    def velocity(self, time: float) -> tuple[Floats, Floats]:
        """Return dd/dt, m/s, and omega, rad/s, at a time, s; each a (3,) array."""
        velocity, spin = np.zeros(3), np.zeros(3)
        if self._motion.velocity is not None:
            if self._motion.start <= time < self._last:
                velocity[: len(self._motion.velocity)] = self._motion.velocity
            return velocity, spin
        for name, column in self._columns.items():
            if not column.x[0] <= time < column.x[-1]:
                continue
            rate = float(column(time, 1))
            if name == "angle":
                # from x upward: about z in two dimensions, against y in three
                spin[3 - self._up] = radians(rate) * (1.0 if self._up == 1 else -1.0)
            else:
                velocity["xyz".index(name)] = rate
        return velocity, spin

    def speed(self, time: float) -> float:
        """Return the greatest speed of a point of the body at a time, m/s."""
        velocity, spin = self.velocity(time)
        pose = self.pose(time)
        arms = pose.moved(self.corners) - pose.axis - pose.displacement
        return float(np.linalg.norm(velocity + np.cross(spin, arms), axis=1).max())
