"""A flume with a movable bed in two dimensions: how it is stepped, and what is kept of its run."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, load_case
from debrisflow.case.releases import Hydrograph
from debrisflow.case.resolved import ResolvedChannel, UnsteadyInflow
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import advance

Floats = NDArray[np.float64]
MOVING = 0.2
"""Speed, m/s, from which on what flows belongs to the front."""
SAMPLE = 0.02
"""Time between two rows of the record, s."""
DEPOSITED = 0.3
"""Concentration from which on sediment is a deposit, as in deposit.csv."""


@dataclass
class Frame:
    """The fluid at a time: id, position, velocity, sediment fraction and C."""

    id: NDArray[np.int64]
    position: Floats
    velocity: Floats
    fraction: Floats
    concentration: Floats


@dataclass
class Flume:
    """What a flume did.

    Attributes
    ----------
    case : ResolvedCase
    bed : int
        Particles of the bed at the start; their ids are less.
    time, front : (n,) float64 array, s, m
        See :func:`front_of`.
    sediment : (n, 2) int array
        Sediment particles in the upstream and in the downstream half of the bed's length.
    left : (n, 3) int array
        Particles past the end by phase.
    frames : dict
        :class:`Frame` by time, s.
    supplied : float, m2
    through_wall : int
    """

    case: ResolvedCase
    bed: int
    time: Floats = field(default_factory=lambda: np.empty(0))
    front: Floats = field(default_factory=lambda: np.empty(0))
    sediment: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 2), dtype=int))
    left: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 3), dtype=int))
    frames: dict[float, Frame] = field(default_factory=dict)
    supplied: float = 0.0
    through_wall: int = 0

    @property
    def channel(self) -> ResolvedChannel:
        """The channel of the case."""
        return channel_of(self.case)

    def arrival(self, x: float) -> float:
        """Return when the front passes x, s; nan if it does not."""
        reached = np.maximum.accumulate(self.front)
        if not reached.size or reached[-1] < x:
            return np.nan
        return float(np.interp(x, reached, self.time))

    def moved(self, start: float, end: float) -> Floats:
        """Return how far the particles of the bed moved between two frames, in spacings."""
        before, after = self.frames[start], self.frames[end]
        kept, one, other = np.intersect1d(before.id, after.id, return_indices=True)
        step = after.position[other] - before.position[one]
        lengths: Floats = np.linalg.norm(step[kept < self.bed], axis=1)
        return lengths / self.case.particles.spacing

    def rested(self, start: float, end: float) -> Floats:
        """Return how far the deposited sediment moved between two frames, in spacings."""
        before, after = self.frames[start], self.frames[end]
        _, one, other = np.intersect1d(before.id, after.id, return_indices=True)
        rock = (after.fraction[other] > 0.0) & (before.concentration[one] >= DEPOSITED)
        step = after.position[other][rock] - before.position[one][rock]
        lengths: Floats = np.linalg.norm(step, axis=1)
        return lengths / self.case.particles.spacing

    def eroded(self) -> float:
        """Return the share of its sediment that the upstream half has lost at the end."""
        return float(1.0 - self.sediment[-1, 0] / self.sediment[0, 0])


def channel_of(case: ResolvedCase) -> ResolvedChannel:
    """Return the channel of a case in two dimensions; TypeError of others."""
    if isinstance(case.geometry, ResolvedChannel):
        return case.geometry
    raise TypeError("the case is not a channel in two dimensions")


def front_of(x: Floats, speed: Floats, area: float, width: float, depth: float) -> float:
    """Return how far the flow reaches, m.

    Through bins of ``width`` that are filled by at least ``depth`` on average with what is faster
    than 0.2 m/s, two such bins in a row: the x behind which the last of them holds that much.  So a
    splash is no front, and what counts as one has the same thickness at every spacing.

    Parameters
    ----------
    x, speed : (n,) array, m, m/s
    area : float, m2
        Of a particle.
    width, depth : float, m
    """
    x = np.sort(x[(speed > MOVING) & (x >= 0.0)])
    least = max(round(width * depth / area), 1)
    number = (x / width).astype(int)
    filled = np.bincount(number, minlength=2) >= least
    last = np.flatnonzero(filled[1:] & filled[:-1])
    return float(x[number == last[-1] + 1][-least]) if last.size else 0.0


def run(
    name: str,
    overrides: tuple[str, ...] = (),
    end: float | None = None,
    frames: tuple[float, ...] = (),
    width: float = 0.1,
    depth: float = 0.008,
    scheme: type[SemiImplicit] = SemiImplicit,
    supply_until: float | None = None,
) -> Flume:
    """Run a flume; ``width`` and ``depth`` are those of :func:`front_of`.

    The supply may end before the run, 0 for a run without any.
    A frame is kept every tenth of a second, and at the times ``frames``, multiples of 0.02 s.
    """
    case = load_case(CASES / f"{name}.toml", overrides)
    if supply_until is not None:
        case = _supplied_until(case, supply_until)
    end = case.time.end if end is None else end
    solver, state = scheme(case), initial_state(case)
    flume = Flume(case, state.particles.fluid_count)
    time, front, sediment, left = [], [], [], []
    samples = np.arange(round(end / SAMPLE) + 1) * SAMPLE
    advance(solver, state, until=0.0)
    for until in samples:
        advance(solver, state, until=until)
        p = state.particles
        x, fluid = p.position[p.fluid, 0], p.fluid
        speed = np.linalg.norm(p.velocity[fluid], axis=1)
        time.append(state.time)
        front.append(front_of(x, speed, case.particles.spacing**2, width, depth))
        middle = 0.5 * (flume.channel.bed_start + flume.channel.bed_end)
        upstream = x[p.sediment_fraction[fluid] > 0.0] < middle
        sediment.append((np.count_nonzero(upstream), np.count_nonzero(~upstream)))
        left.append(state.left.copy())
        if np.isclose(until, (*frames, round(until, 1))).any():
            flume.frames[round(float(until), 3)] = frame_of(state)
    flume.time, flume.front = np.array(time), np.array(front)
    flume.sediment, flume.left = np.array(sediment), np.array(left)
    flume.supplied = float(state.entered.sum() * case.particles.spacing**2)
    flume.through_wall = int(state.through_wall.sum())
    return flume


def discharge_of(case: ResolvedCase) -> float:
    """Return the steady discharge of the supply, m2/s, in three dimensions m3/s."""
    if case.inflow is None or case.inflow.discharge is None:
        raise TypeError("the case has no steady supply")
    return case.inflow.discharge


def _supplied_until(case: ResolvedCase, end: float) -> ResolvedCase:
    """Return a case whose supply falls to nothing within a fifth of a second from ``end`` on."""
    assert case.inflow is not None
    q = discharge_of(case) if end > 0.0 else 0.0
    graph = Hydrograph(
        time=(0.0, max(end, 0.1), end + 0.2), discharge=(q, q, 0.0), concentration=(0.0, 0.0, 0.0)
    )
    supply = UnsteadyInflow(depth=case.inflow.depth, hydrograph=graph)
    return case.model_copy(update={"inflow": supply})


def frame_of(state: State) -> Frame:
    """Return a copy of the fluid of a state."""
    p = state.particles
    return Frame(
        p.id[p.fluid].copy(),
        p.position[p.fluid, :2].copy(),
        p.velocity[p.fluid, :2].copy(),
        p.sediment_fraction[p.fluid].copy(),
        p.concentration[p.fluid].copy(),
    )
