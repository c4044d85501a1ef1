"""How far the flow reaches in time, when it arrives, and how mobile it was."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.maxima import is_reached
from debrisflow.particles.state import PHASES
from debrisflow.results.frames import Frame
from debrisflow.run.measures import FRONT_SHARE, flow_height, fronts, whole_depth
from debrisflow.run.tables import Row, Table
from debrisflow.space.fills import inflow_section
from debrisflow.space.floor import floor_level
from debrisflow.space.gravity import gravity_vector
from debrisflow.space.plan_grid import floor_length, plan

Floats = NDArray[np.float64]
OUTER_SHARE = 0.999
EDGE = 2.0  # spacings before the end of the domain, where a front is at it
NAMES = (*PHASES, "all")
PHASE_WORDS = {"liquid": "water", "sediment": "sediment", "mixture": "mixture", "all": "all"}
COLUMNS = (
    "time",
    *(f"front_{name}" for name in NAMES),
    *(f"outer_front_{name}" for name in NAMES),
    "moving_share",
    *(f"speed_{name}" for name in NAMES),
)
HEAD = (
    "time: s",
    "front_*: m; the x behind which 99.5 % of the volume lies that is faster than",
    "  output.rest_speed; fluid counts as behind it where it stood in the first frame and the flow",
    "  is not more than half a spacing deeper; nan if nothing has come farther",
    "outer_front_*: m; the same for 99.9 %",
    "moving_share: share of the volume inside that is faster than output.rest_speed",
    "speed_*: m/s; speed of front_*, by central differences between the frames",
)


class Start(NamedTuple):
    """What was there in the first frame, over the cells of the plan.

    Attributes
    ----------
    depth : (cells,) float64 array, m
        Of all fluid.
    rested : (cells,) bool array
        Where it rested.
    """

    depth: Floats
    rested: NDArray[np.bool_]

    def fills(self, case: ResolvedCase) -> bool:
        """Return whether there was fluid over the whole length and none is supplied.

        Then nothing can run out; what is supplied may, over a bed.
        """
        number = plan(case).number
        is_wet = (number >= 0) & (self.depth[number] > 0.0)
        return case.inflow is None and bool(is_wet.any(axis=1).all())


def start_of(case: ResolvedCase, first: Frame) -> Start:
    """Return what is there in the first frame."""
    return Start(*whole_depth(case, first.position, first.velocity, first.kind))


def front_row(case: ResolvedCase, frame: Frame, start: Start) -> Row:
    """Return time, fronts, outer fronts and moving share of a frame, without the speeds."""
    d0 = case.particles.spacing
    n0 = reference(case.dimension, case.particles.effective_radius, d0).number_density
    depth = flow_height(case, frame.position, frame.kind, frame.number_density, n0)
    reached = is_reached(depth, *start, d0)
    arrays = frame.position, frame.velocity, frame.kind, reached
    shares = (fronts(case, *arrays, share) for share in (FRONT_SHARE, OUTER_SHARE))
    moving = frame.speed[frame.fluid] > case.output.rest_speed
    share = float(moving.mean()) if moving.size else 0.0
    return (frame.time, *(x for found in shares for x in found.values()), share)


def front_table(rows: list[Row]) -> Table:
    """Return the table of the fronts of all frames, with the speeds between them."""
    known = np.array(rows, dtype=float)
    front = known[:, 1 : 1 + len(NAMES)]
    speed = np.full_like(front, np.nan)
    if len(rows) > 1:
        speed = np.gradient(front, known[:, 0], axis=0)
    return dict(zip(COLUMNS, np.hstack([known, speed]).T, strict=True))


def arrival(time: Floats, front: Floats, x: float) -> float:
    """Return when a front first reaches a place, s; nan if it does not.

    Linear between the samples.  A front that starts beyond the place arrives nowhere before it.

    Parameters
    ----------
    time, front : (n,) array, s, m
        nan where there is no front.
    x : float, m

    Examples
    --------
    >>> time, front = np.array([0.0, 1.0, 2.0, 3.0]), np.array([np.nan, 1.0, 3.0, 2.0])
    >>> arrival(time, front, 2.0), arrival(time, front, 4.0), arrival(time, front, 0.5)
    (1.5, nan, nan)
    """
    known = ~np.isnan(front)
    time, front = time[known], front[known]
    reached = np.flatnonzero(front >= x)
    if reached.size == 0 or reached[0] == 0:
        return float("nan")
    before = slice(reached[0] - 1, reached[0] + 1)
    return float(np.interp(x, front[before], time[before]))


def moving_parts(phases: Sequence[str]) -> tuple[str, ...]:
    """Return whose fronts a run is told by, of its phases: the headline first.

    Where water flows beside what carries grains, these are the headline and the water is told
    beside it; else all is one.

    Examples
    --------
    >>> moving_parts(["liquid"]), moving_parts(["liquid", "sediment"])
    (('all',), ('sediment', 'liquid'))
    """
    grains = [name for name in phases if name != "liquid"]
    return (grains[0], "liquid") if len(grains) == 1 and len(phases) == 2 else ("all",)


def headline_of(phases: Sequence[str]) -> str:
    """Return whose front is the headline, as :func:`moving_parts` has it."""
    return moving_parts(phases)[0]


class Mobility(NamedTuple):
    """Fall and travel of a flow, from the top of its source to the farthest front.

    Attributes
    ----------
    toe : float, m
        Greatest x that the front reached.
    time : float, s
        When it did.
    runout : float, m
        From the source to there along x.
    fall, travel : float, m
        H and L: the vertical and the horizontal distance, in the directions of gravity.
    bound : str
        Why the flow may go farther than that; empty if it does not.
    """

    toe: float
    time: float
    runout: float
    fall: float
    travel: float
    bound: str

    @property
    def equivalent_friction(self) -> float:
        """Return H / L."""
        return self.fall / self.travel if self.travel > 0.0 else np.nan


def mobility(case: ResolvedCase, time: Floats, front: Floats, source: Floats) -> Mobility:
    """Return fall and travel of a flow from its source to its toe, which is on the fixed floor.

    Parameters
    ----------
    case : ResolvedCase
    time, front : (n,) array, s, m
        Of all phases.
    source : (2,) array, m
        See :func:`source_of`.
    """
    if np.isnan(front).all():
        return Mobility(np.nan, np.nan, np.nan, np.nan, np.nan, bound="")
    last = int(np.nanargmax(front))
    toe, bound = float(front[last]), ""
    if toe > floor_length(case) - EDGE * case.particles.spacing:
        bound = "a lower bound: it reached the end of the domain"
    elif last == len(front) - 1:
        bound = "a lower bound: the front still advances in the last frame"
    end = np.array([toe, float(floor_level(case, np.array([toe]))[0])])
    gravity = gravity_vector(case)[[0, case.dimension - 1]]
    strength = float(np.linalg.norm(gravity))
    if strength == 0.0:
        return Mobility(toe, float(time[last]), toe - source[0], np.nan, np.nan, bound)
    down = gravity / strength
    level = np.array([-down[1], down[0]])
    path = end - source
    fall, travel = float(path @ down), abs(float(path @ level))
    return Mobility(toe, float(time[last]), toe - float(source[0]), fall, travel, bound)


def source_of(case: ResolvedCase, first: Frame) -> Floats:
    """Return where the flow comes from, along x and upwards, (2,) float64 array, m.

    The top of the supply at x = 0, or without one the highest particle of the first frame, of those
    within half a spacing of it the one that is farthest upstream.
    """
    d0 = case.particles.spacing
    if case.inflow is not None:
        floor = float(floor_level(case, np.zeros(1))[0])
        return np.array([0.0, floor + inflow_section(case).high * d0])
    position = first.position[first.fluid]
    if len(position) == 0:
        return np.full(2, np.nan)
    gravity = gravity_vector(case)
    height, level = -position @ gravity, 0.5 * d0 * float(np.linalg.norm(gravity))
    highest = position[height >= height.max() - level]
    top = highest[np.argmin(highest[:, 0])]
    return np.array([top[0], top[case.dimension - 1] + 0.5 * d0])
