"""The sampler of the volume that a dam holds back and of the flow over it."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.probes.dam import DamProbe
from debrisflow.case.structures import levels_of, plan_of
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.measures import particle_volume
from debrisflow.run.probe import Column, Sampler

Floats = NDArray[np.float64]


class Dam(Sampler):
    """Volume that a dam holds back, and what has come over it.

    The volume held back is upstream of the middle of the dam, within its length across the given
    direction, below the level of its crest.  What comes over it crosses the upright plane through
    its middle, across the direction, within that length; particles are counted at every step.

    The running sum holds the particles that went over less those that came back, the volume of
    sediment in them, in particles, whether any has gone over, and when the first did.
    """

    sum_shape = (4,)

    def __init__(self, probe: DamProbe, case: ResolvedCase, particles: Particles) -> None:
        body = next(part for part in case.obstacle if part.name == probe.wall)
        assert isinstance(body, BoxObstacle | MeshObstacle)
        plan = plan_of(body)
        self._name, self._volume = probe.name, particle_volume(case)
        self._crest = levels_of(body)[1] if probe.crest is None else probe.crest
        self._direction = np.array(probe.direction) / np.hypot(*probe.direction)
        self._across = np.array([-self._direction[1], self._direction[0]])
        corners = shapely.get_coordinates(plan)
        across, along = corners @ self._across, corners @ self._direction
        self._ends = float(across.min()), float(across.max())
        self._middle = 0.5 * float(along.min() + along.max())
        self._remember(particles)

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return what is held back and what has come over."""
        held = "upstream of the dam, within its length, below its crest"
        over = "net of what came over the dam since t = 0, exact"
        return (
            Column("trapped_volume", "m3", held),
            Column("trapped_sediment_volume", "m3", held),
            Column("overtopped_volume", "m3", over),
            Column("overtopped_sediment_volume", "m3", over),
            Column("overtopping_time", "s", "when the first came over it; nan before"),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return ("trapped_volume", "overtopped_volume")

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the columns."""
        p = state.particles
        place = p.position[p.fluid]
        held = (self._ahead(place) < 0.0) & self._is_within(place) & (place[:, 2] < self._crest)
        sediment = float(p.sediment_fraction[p.fluid][held].sum())
        number, grains, is_over, first = map(float, state.sums[self._name])
        return (
            np.count_nonzero(held) * self._volume,
            sediment * self._volume,
            number * self._volume,
            grains * self._volume,
            first if is_over else np.nan,
        )

    def add_step(self, state: State) -> None:
        """Count what crossed the plane in the last step; nothing is counted before t = 0."""
        if state.time > 0.0:
            self._count(state)
        self._remember(state.particles)

    def _count(self, state: State) -> None:
        p, kept = state.particles, state.sums[self._name]
        number, place = p.id[p.fluid], p.position[p.fluid]
        known = number < self._before.size
        before = self._before[number[known]]
        place, fraction = place[known], p.sediment_fraction[p.fluid][known]
        now, within = self._ahead(place), self._is_within(place)
        passed = ((now >= 0.0).astype(float) - (before >= 0.0)) * (within & np.isfinite(before))
        kept[0] += passed.sum()
        kept[1] += passed @ fraction
        if kept[2] == 0.0 and np.any(passed > 0.0):
            kept[2:] = 1.0, state.time

    def _ahead(self, place: Floats) -> Floats:
        found: Floats = place[:, :2] @ self._direction - self._middle
        return found

    def _is_within(self, place: Floats) -> NDArray[np.bool_]:
        across = place[:, :2] @ self._across
        return np.asarray((across >= self._ends[0]) & (across <= self._ends[1]))

    def _remember(self, p: Particles) -> None:
        """Keep by their numbers how far ahead of the middle the particles are."""
        self._before = np.full(int(p.id[p.fluid].max(initial=-1)) + 1, np.nan)
        self._before[p.id[p.fluid]] = self._ahead(p.position[p.fluid])
