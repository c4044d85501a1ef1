"""How much there is to compute: how many steps, of how many particles, and in what time."""

from __future__ import annotations

from math import exp, inf, sqrt

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import LARGEST_PATH
from debrisflow.case.estimate import particle_estimate
from debrisflow.case.released import volume
from debrisflow.case.resolved import (
    ResolvedExplicitScheme,
    ResolvedHydrographRelease,
    ResolvedTerrain,
)
from debrisflow.case.speeds import fall_speed, given_speed
from debrisflow.case.terrain_speeds import expected_speed
from debrisflow.particles.supply import supply
from debrisflow.space.fills import inflow_section

# A step costs as much as that of so many more particles, whatever their number: 0.2 ms in two
# dimensions and 0.1 ms in three were measured, where a particle took 1.5 and 0.7 us.
COST_OF_A_STEP = 150
SETTLED = 3  # steps after which all kernels have been read from the cache
LEAST = 1.0  # s of wall time; the steps of less tell too little
SHARE_KEPT = 0.1  # of the simulated time, over which steps and growth are averaged
SHARE_FORETOLD = 0.05  # of the simulated time, for which the forecast stands at the start
SECONDS_KEPT = 300.0  # of wall time, over which the speed of computing is averaged


def step_at(case: ResolvedCase, speed: float) -> float:
    """Return the time step that the case allows at a speed, s."""
    scheme = case.scheme
    share = LARGEST_PATH if isinstance(scheme, ResolvedExplicitScheme) else scheme.courant
    path = share * case.particles.spacing
    return min(case.time.largest_step, path / speed if speed > 0 else inf)


def speeds(case: ResolvedCase) -> tuple[float, float]:
    """Return the speed given in the case, and that of a free fall through its height added, m/s.

    On a terrain the second is that which friction lets the flow reach, if it is greater.
    """
    given = given_speed(case.fill, case.inflow, case.geometry, case.walls, case.release)
    if isinstance(case.geometry, ResolvedTerrain):
        reached = expected_speed(
            case.geometry, case.release, case.zone, case.walls.floor, case.gravity
        )
        return given, max(given, reached)
    space = case.fill, case.inflow, case.geometry, case.particles, case.gravity
    return given, given + fall_speed(*space, to_floor=True)


def growth(case: ResolvedCase, time: float) -> float:
    """Return how many particles inflow and hydrographs bring at a time, 1/s."""
    if case.release:
        return sum(
            float(
                np.interp(
                    time - part.start, part.hydrograph.time, part.hydrograph.discharge, 0.0, 0.0
                )
            )
            for part in case.release
            if isinstance(part, ResolvedHydrographRelease)
        ) / (case.particles.spacing**3)
    if case.inflow is None:
        return 0.0
    section = inflow_section(case)
    return supply(case, time)[0] / case.particles.spacing * section.wide * section.high


def mean_number(case: ResolvedCase, fluid: float) -> float:
    """Return the mean number of fluid particles from t = 0 on, if no more leave than must.

    Parameters
    ----------
    case : ResolvedCase
    fluid : float
        Their number at the start.
    """
    times = np.linspace(0.0, case.time.end, 201)
    rate = np.array([growth(case, time) for time in times])
    come = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(times))])
    for part in case.release:
        if part.start > 0.0 and not isinstance(part, ResolvedHydrographRelease):
            come += np.where(times >= part.start, volume(part) / case.particles.spacing**3, 0.0)
    return fluid + float(np.minimum(come, particle_estimate(case)["inflow"]).mean())


class TimeLeft:
    """Estimates the wall time that a run still needs.

    It is the product of the simulated time left, steps per second of it, the mean number of
    particles and the wall time of a particle in a step, and the time to write the files left.
    Each is averaged over what lies behind, long enough that a splash or a pause of the machine
    changes the estimate little.  At the start the forecast stands in for steps and particles that
    are still to come.

    Parameters
    ----------
    case : ResolvedCase
    fluid : int
        Fluid particles at the start of the run or of its continuation.
    """

    def __init__(self, case: ResolvedCase, fluid: int) -> None:
        self._end, whole = case.time.end, case.time.end + case.time.settling
        self._interval = case.output.interval
        self._kept = SHARE_KEPT * whole
        slow, fast = (1.0 / step_at(case, speed) for speed in speeds(case))
        self._span = self._growth_span = SHARE_FORETOLD * whole
        self._steps = self._span * sqrt(slow * fast)
        self._come = self._span * growth(case, 0.0)
        self._most = fluid + particle_estimate(case)["inflow"]
        self._particles, self._time = fluid, -inf
        self._work = self._seconds = self._before = 0.0
        self._counted = 0
        self._passed = self._written = 0.0

    def count(
        self, time: float, dt: float, particles: int, seconds: float, written: float, odd: bool
    ) -> None:
        """Count a step.

        Parameters
        ----------
        time, dt : float, s
            Simulated time after the step, and its length.
        particles : int
            Fluid particles.
        seconds, written : float
            Wall time since the start of the run, that in which files were written apart, and
            without that of compiling.
        odd : bool
            Whether the step took another time than steps do, since kernels were compiled.
        """
        kept = exp(-dt / self._kept)
        self._steps, self._span = kept * self._steps + 1.0, kept * self._span + dt
        if self._time >= 0.0:
            come = particles - self._particles
            self._come = kept * self._come + come
            self._growth_span = kept * self._growth_span + dt
        self._particles, self._time = particles, time
        self._counted += 1
        self._passed, self._written = self._passed + dt, written
        spent, self._before = seconds - self._before, seconds
        if self._counted > SETTLED and not odd:
            kept = exp(-spent / SECONDS_KEPT)
            self._work = kept * self._work + particles + COST_OF_A_STEP
            self._seconds = kept * self._seconds + spent

    @property
    def seconds(self) -> float | None:
        """The wall time left, s; None before enough steps were counted."""
        if self._seconds < LEAST:
            return None
        left = max(self._end - self._time, 0.0)
        work = self._mean_number(left) + COST_OF_A_STEP
        steps = left * self._steps / self._span * work * self._seconds / self._work
        files = self._written / (int(self._passed / self._interval) + 1)  # the first at the start
        return steps + files * left / self._interval

    def _mean_number(self, left: float) -> float:
        """Return the mean number of particles over the simulated time left, s."""
        now, most = self._particles, max(self._particles, self._most)
        rate = self._come / self._growth_span
        if rate * left > most - now:
            filling = (most - now) / rate
            return most - 0.5 * (most - now) * filling / left
        return now + 0.5 * max(rate * left, -now)
