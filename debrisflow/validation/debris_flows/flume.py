"""Debris flow over a movable bed in a flume (A1, A3): rest, front, erosion, profiles."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case, tables
from debrisflow.case.resolved import UnsteadyInflow
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.space.floor import height_over_floor, runout_bend
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import advance

Floats = NDArray[np.float64]
MOVING = 0.2  # m/s, of the front
MIXED = 0.1  # m/s, of the layer whose concentration counts
SAMPLE = 0.02  # s
HEAD = 0.5  # m
DEPOSIT = 0.3  # m
DEPOSITED = 0.3  # concentration, as in deposit.csv
STATIONS = (6.86, 6.88, 6.90, 6.92, 6.94)  # m, of the study in A1


@dataclass
class Particles:
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
    case : Case
    bed : int
        Particles of the bed at the start; their ids are less.
    time, front : (n,) float64 array, s, m
        See :func:`front_of`.
    sediment : (n, 2) int array
        Sediment particles in the upstream and in the downstream half of the bed's length.
    left : (n, 3) int array
        Particles past the end by phase.
    frames : dict
        :class:`Particles` by time, s.
    supplied : float, m2
    through_wall : int
    """

    case: tables.Case
    bed: int
    time: Floats = field(default_factory=lambda: np.empty(0))
    front: Floats = field(default_factory=lambda: np.empty(0))
    sediment: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 2), dtype=int))
    left: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 3), dtype=int))
    frames: dict[float, Particles] = field(default_factory=dict)
    supplied: float = 0.0
    through_wall: int = 0

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
        return np.linalg.norm(step[kept < self.bed], axis=1) / self.case.particles.spacing

    def rested(self, start: float, end: float) -> Floats:
        """Return how far the deposited sediment moved between two frames, in spacings."""
        before, after = self.frames[start], self.frames[end]
        _, one, other = np.intersect1d(before.id, after.id, return_indices=True)
        rock = (after.fraction[other] > 0.0) & (before.concentration[one] >= DEPOSITED)
        step = after.position[other][rock] - before.position[one][rock]
        return np.linalg.norm(step, axis=1) / self.case.particles.spacing

    def eroded(self) -> float:
        """Return the share of its sediment that the upstream half has lost at the end."""
        return float(1.0 - self.sediment[-1, 0] / self.sediment[0, 0])

    def concentrations(self, time: float) -> dict[str, float]:
        """Return the volume share of sediment in what moves faster than 0.1 m/s.

        In the ``head``, the half meter behind the front: all of it, and what is ``above`` the level
        of the bed at the start.  In the ``body`` behind it, from half a meter past the beginning of
        the bed on: all of it, the ``surface`` (the upper fifth of each 0.1 m) and the ``base`` (the
        lower fifth).
        """
        frame, x = self.frames[time], self.frames[time].position[:, 0]
        front = float(np.interp(time, self.time, self.front))
        moves = np.linalg.norm(frame.velocity, axis=1) > MIXED
        in_head = moves & (x > front - HEAD) & (x <= front + self.case.particles.spacing)
        above = in_head & (frame.position[:, 1] > 0.0)
        in_body = moves & (x > self.case.geometry.bed_start + HEAD) & (x <= front - HEAD)
        height = _rank_in_column(x[in_body], frame.position[in_body, 1])
        body = frame.fraction[in_body]
        parts = {
            "head": frame.fraction[in_head],
            "above": frame.fraction[above],
            "body": body,
            "surface": body[height > 0.8],
            "base": body[height < 0.2],
        }
        return {name: float(part.mean()) if part.size else np.nan for name, part in parts.items()}

    def profile_error(self, start: float, end: float) -> tuple[float, float, float]:
        """Return rms of u/u_s to the dilatant profile, the depth, m, and u_s, m/s.

        As the study takes them: means over one spacing to either side of the stations and, here,
        over the frames between two times, in layers one spacing thick.  y = 0 is where u is a tenth
        of u_s, the speed of the uppermost layer that is a third full.
        """
        d0 = self.case.particles.spacing
        speed, count = np.zeros((2, 200))
        bottom, frames = -self.case.geometry.bed_thickness, 0
        for time, frame in self.frames.items():
            if not start <= time <= end:
                continue
            frames += 1
            for station in STATIONS:
                here = np.abs(frame.position[:, 0] - station) < d0
                layer = ((frame.position[here, 1] - bottom) / d0).astype(int)
                count += np.bincount(layer, minlength=200)[:200]
                speed += np.bincount(layer, frame.velocity[here, 0], minlength=200)[:200]
        top = int(np.flatnonzero(count > frames * len(STATIONS) * 2.0 / 3.0)[-1])
        u = speed[: top + 1] / np.maximum(count[: top + 1], 1)
        y = (np.arange(top + 1) + 0.5) * d0
        surface = u[-1]
        above = int(np.flatnonzero(u < 0.1 * surface)[-1]) if (u < 0.1 * surface).any() else 0
        zero = float(np.interp(0.1 * surface, u[above : above + 2], y[above : above + 2]))
        depth = y[-1] - zero
        scaled = (y[above + 1 :] - zero) / depth
        dilatant = 1.0 - (1.0 - scaled) ** 1.5
        error = float(np.sqrt(np.mean((u[above + 1 :] / surface - dilatant) ** 2)))
        return error, float(depth), float(surface)


def _rank_in_column(x: Floats, y: Floats) -> Floats:
    """Return how many of the particles in the same 0.1 m of x are lower, as a share."""
    rank, number = np.empty(y.size), (x / 0.1).astype(int)
    for column in np.unique(number):
        rows = np.flatnonzero(number == column)
        rank[rows[np.argsort(y[rows])]] = (np.arange(rows.size) + 0.5) / rows.size
    return rank


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
        middle = 0.5 * (case.geometry.bed_start + case.geometry.bed_end)
        upstream = x[p.sediment_fraction[fluid] > 0.0] < middle
        sediment.append((np.count_nonzero(upstream), np.count_nonzero(~upstream)))
        left.append(state.left.copy())
        if np.isclose(until, (*frames, round(until, 1))).any():
            flume.frames[round(float(until), 3)] = _particles(state)
    flume.time, flume.front = np.array(time), np.array(front)
    flume.sediment, flume.left = np.array(sediment), np.array(left)
    flume.supplied = float(state.entered.sum() * case.particles.spacing**2)
    flume.through_wall = int(state.through_wall.sum())
    return flume


def _supplied_until(case: tables.Case, end: float) -> tables.Case:
    """Return a case whose supply falls to nothing within a fifth of a second from ``end`` on."""
    q = case.inflow.discharge if end > 0.0 else 0.0
    graph = tables.Hydrograph(
        time=(0.0, max(end, 0.1), end + 0.2), discharge=(q, q, 0.0), concentration=(0.0, 0.0, 0.0)
    )
    supply = UnsteadyInflow(depth=case.inflow.depth, hydrograph=graph)
    return case.model_copy(update={"inflow": supply})


def still_depths(found: Flume, time: float, edges: Floats) -> Floats:
    """Return the volume of a bed's sediment, pores included, by its length between edges, m."""
    frame = found.frames[time]
    count = np.histogram(frame.position[frame.fraction > 0.0, 0], edges)[0]
    limit = found.case.sediment.packing_limit
    return count * found.case.particles.spacing**2 / limit / np.diff(edges)


@dataclass
class Deposit:
    """A deposit in the last two seconds of a run.

    Attributes
    ----------
    moved : (n,) float64 array
        How far its grains moved, in spacings; grains in a film of water do not belong to it.
    on_runout : float
        Share of the sediment on the run-out.
    depth : float, m
        Just behind the bend.
    slope : float
        By which the surface of the first 0.3 m of it falls below the horizontal, degrees.
    """

    moved: Floats
    on_runout: float
    depth: float
    slope: float


def deposit(name: str, overrides: tuple[str, ...] = (), end: float | None = None) -> Deposit:
    """Run a flume with a run-out to its end and return its deposit."""
    case = load_case(CASES / f"{name}.toml", overrides)
    end = case.time.end if end is None else end
    scheme, state = SemiImplicit(case), initial_state(case)
    advance(scheme, state, until=end - 2.0)
    before = _particles(state)
    advance(scheme, state, until=end)
    after = _particles(state)
    _, one, other = np.intersect1d(before.id, after.id, return_indices=True)
    deposited = (after.fraction[other] > 0.0) & (before.concentration[one] >= DEPOSITED)
    moved = np.linalg.norm(after.position[other] - before.position[one], axis=1)[deposited]
    x, y = after.position[after.fraction > 0.0].T
    bend, d0 = case.geometry.runout_start, case.particles.spacing
    height = height_over_floor(case, x, y, x)
    number = np.floor((x - bend) / (2.0 * d0)).astype(int)
    places = np.arange(round(DEPOSIT / (2.0 * d0)))
    # over the floor, so that a place without sediment has the depth 0 and not that of x = 0
    depth = np.array([height[number == k].max(initial=-0.5 * d0) for k in places]) + 0.5 * d0
    along = (places + 0.5) * 2.0 * d0 / np.cos(runout_bend(case))
    thinning = np.degrees(np.arctan(-np.polyfit(along, depth, 1)[0]))
    return Deposit(
        moved / d0,
        float(np.mean(x > bend)),
        float(depth[:3].mean()),
        float(case.geometry.runout_slope + thinning),
    )


def _particles(state: State) -> Particles:
    p = state.particles
    return Particles(
        p.id[p.fluid].copy(),
        p.position[p.fluid, :2].copy(),
        p.velocity[p.fluid, :2].copy(),
        p.sediment_fraction[p.fluid].copy(),
        p.concentration[p.fluid].copy(),
    )
