"""The sampler of what flows through a section."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.section import SectionProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import PHASES, State, count_phases
from debrisflow.run.measures import particle_volume, wetted_width
from debrisflow.run.probe import Column, Sampler, volume_unit
from debrisflow.space.domain import domain


class Section(Sampler):
    """What flows through the plane x = const.

    The state at the plane is the sum over particles of volume V, velocity u and sediment share f
    nearer than d0 to it, with the weight h = (1 - |x_i - x| / d0) / d0, whose integral is 1:

        A = sum V h,   Q = sum V h u,   Q_s = sum V h u f

    On a lattice the sums are exact wherever the plane stands.  Particles that pass the plane are
    counted at every step, so that the volumes are exact whatever the interval, and a mean discharge
    follows from the difference of two rows.

    The running sum holds, by phase, the particles that went through since t = 0 less those that
    went back, and the volume of sediment in them, in particles.
    """

    sum_shape = (2, len(PHASES))

    def __init__(self, probe: SectionProbe, case: ResolvedCase, particles: Particles) -> None:
        self._x, self._name = probe.x, probe.name
        self._d0, self._axes = case.particles.spacing, case.dimension
        self._volume = particle_volume(case)
        self._period = domain(case).period[0]
        self._remember(particles)

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the state at the plane, and what went through it."""
        unit = volume_unit(dimension)
        flux = "at this time, positive along x"
        passed = "net of what went through since t = 0, exact"
        return (
            Column("discharge", f"{unit}/s", flux),
            Column("sediment_discharge", f"{unit}/s", flux),
            Column("concentration", "", "sediment_discharge / discharge; nan where nothing flows"),
            Column("speed", "m/s", "discharge over the wetted area, nan where it is dry"),
            Column("depth", "m", "wetted area over wetted width"),
            *([Column("width", "m", "wetted")] if dimension == 3 else []),
            Column("volume", unit, passed),
            Column("sediment_volume", unit, passed),
        )

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the columns of the section."""
        p, d0 = state.particles, self._d0
        offset = p.position[p.fluid, 0] - self._x
        if self._period > 0.0:
            offset -= self._period * np.rint(offset / self._period)
        rows = np.flatnonzero(np.abs(offset) < d0)
        part = self._volume * (1.0 - np.abs(offset[rows]) / d0) / d0
        flux = part * p.velocity[rows, 0]
        area, discharge = float(part.sum()), float(flux.sum())
        sediment = float(flux @ p.sediment_fraction[rows])
        width = 1.0 if self._axes == 2 else wetted_width(p.position[rows, 1], d0)
        volumes = [self._volume * float(passed.sum()) for passed in state.sums[self._name]]
        return (
            discharge,
            sediment,
            sediment / discharge if discharge != 0.0 else np.nan,
            discharge / area if area > 0.0 else np.nan,
            area / width if area > 0.0 else 0.0,
            *([width] if self._axes == 3 else []),
            *volumes,
        )

    def add_step(self, state: State) -> None:
        """Count the particles that passed the plane in the last step; none are before t = 0.

        Particles are identified by their number, because their rows change and slip moves them.
        """
        if state.time > 0.0:
            self._count(state)
        self._remember(state.particles)

    def _count(self, state: State) -> None:
        p = state.particles
        known = p.id[p.fluid] < self._before.size
        kind, fraction = p.kind[p.fluid][known], p.sediment_fraction[p.fluid][known]
        before, now = self._before[p.id[p.fluid][known]], p.position[p.fluid, 0][known]
        if self._period > 0.0:
            half = 0.5 * self._period
            now = before + np.remainder(now - before + half, self._period) - half
            passed = np.floor((now - self._x) / self._period)
            passed -= np.floor((before - self._x) / self._period)
        else:
            passed = (now >= self._x).astype(float) - (before >= self._x)
        number, sediment = np.zeros(len(PHASES), dtype=np.int64), np.zeros(len(PHASES))
        count_phases(kind, fraction, number, sediment, passed)
        state.sums[self._name] += np.array([number, sediment])

    def _remember(self, p: Particles) -> None:
        """Keep the x of the particles, fluid and waiting supply, by their numbers."""
        rows = slice(0, p.inflow.stop)
        self._before = np.full(int(p.id[rows].max(initial=-1)) + 1, np.nan)
        self._before[p.id[rows]] = p.position[rows, 0]
