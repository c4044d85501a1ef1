"""Dam break over a wet bed behind a gate that is drawn, against Stoker's closed form (1957)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from debrisflow.case import ResolvedCase, load_case
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.dam_breaks.fronts import EXPERIMENTS, GRAVITY
from debrisflow.validation.dam_breaks.known import Known
from debrisflow.validation.marching import states
from debrisflow.validation.row import near, none_of

Floats = NDArray[np.float64]
CASE = EXPERIMENTS / "wet_bed.toml"
GATE, LENGTH = 0.38, 2.5
HIGH, LOW = 0.15, 0.04
"""Depths, m; in the experiment the lower one is 0.038 m, which no lattice of these spacings has."""
BIN, INTERVAL = 0.02, 0.02  # m, s
STEADY = 0.6, 1.2
"""s, from when the gate has long been drawn until the wave from the back wall comes near."""
BEHIND = 0.30, 0.13
"""m behind the bore between which depths are averaged; as at the piston's, the roller is taken to
be one and a half depths long."""


class Stoker(NamedTuple):
    """The region between fan and bore: its depth, m, its speed, and that of the bore, m/s."""

    depth: float
    speed: float
    bore: float


def stoker(high: float, low: float) -> Stoker:
    """Return the closed form of the dam break over a wet bed.

    Shallow water without friction, the gate gone at once: ``u = 2 (c0 - c)`` across the fan and
    ``u = (h - h1) sqrt(g (h + h1) / (2 h h1))``, ``S = u h / (h - h1)`` across the bore.

    References
    ----------
    Stoker 1957, Water Waves, chapter 10.8.

    Examples
    --------
    >>> [round(value, 4) for value in stoker(0.15, 0.038)]
    [0.0832, 0.6195, 1.1406]
    """

    def fan(depth: float) -> float:
        return float(2.0 * (np.sqrt(GRAVITY * high) - np.sqrt(GRAVITY * depth)))

    def jump(depth: float) -> float:
        return float((depth - low) * np.sqrt(GRAVITY * (depth + low) / (2.0 * depth * low)))

    depth = float(brentq(lambda h: fan(h) - jump(h), low, high))
    return Stoker(depth, fan(depth), fan(depth) * depth / (depth - low))


class Surge(NamedTuple):
    """A run: times, s, places of the bore, m; x, m, and depths, m, at times, (n, m); lost."""

    time: Floats
    bore: Floats
    x: Floats
    depth: Floats
    lost: int


def build(spacing: float) -> ResolvedCase:
    """Return the shipped case at a spacing, with a lower depth that is a whole number of rows."""
    changes = [
        f"particles.spacing={spacing!r}",
        f"fill.1.y=[0.0, {LOW!r}]",
        f"time.end={STEADY[1]!r}",
    ]
    return load_case(CASE, changes)


def run(spacing: float) -> Surge:
    """Run the case and return where its bore is: where the depth is half-way."""
    case, half = build(spacing), 0.5 * (stoker(HIGH, LOW).depth + LOW)
    edges = np.arange(0.0, LENGTH + 0.5 * BIN, BIN)
    times, places, depths = [], [], []
    for state in states(case, INTERVAL):
        x = state.particles.position[state.particles.fluid, 0]
        depth = np.histogram(x, edges)[0] * spacing**2 / BIN
        times.append(state.time)
        places.append(_last_above(edges, depth, half))
        depths.append(depth)
    middles = 0.5 * (edges[1:] + edges[:-1])
    lost = int(state.through_wall.sum())
    return Surge(np.array(times), np.array(places), middles, np.array(depths), lost)


def _last_above(edges: Floats, depth: Floats, half: float) -> float:
    """Return where a depth falls below a value for good, between the middles of bins."""
    k = int(np.flatnonzero(depth > half).max())
    share = (depth[k] - half) / (depth[k] - depth[k + 1])
    return float(edges[k] + (0.5 + share) * (edges[1] - edges[0]))


def depth_behind(found: Surge) -> float:
    """Return the mean depth behind the bore while it is steady."""
    means = []
    for time, place, depth in zip(found.time, found.bore, found.depth, strict=True):
        if STEADY[0] <= time:
            inside = (found.x > place - BEHIND[0]) & (found.x < place - BEHIND[1])
            means.append(depth[inside].mean())
    return float(np.mean(means))


def measure(level: Level) -> Measured:
    """Return how bore and depth compare."""
    found, form = run(LOW / level.across), stoker(HIGH, LOW)
    late = found.time >= STEADY[0]
    speed = float(np.polyfit(found.time[late], found.bore[late], 1)[0])
    depth = depth_behind(found)
    path = (found.bore[-1] - GATE) / (form.bore * found.time[-1])
    shallow = "chosen: 5 %, as for the bore of a piston; the roller is a jump in theory"
    rows = (
        near("speed of the bore, 0.6 to 1.2 s", speed, form.bore, shallow, share=0.05, unit="m/s"),
        near(
            "depth behind the bore",
            100.0 * depth,
            100.0 * form.depth,
            shallow,
            share=0.05,
            unit="cm",
            **_GATED.at(level.label),
        ),
        near(
            "path of the bore to 1.2 s / closed form",
            path,
            1.0,
            "chosen: 5 %; the gate is open to the depth after 0.1 s, half of it lost, 4 % of 1.2 s",
            share=0.05,
        ),
        none_of("particles through a wall", found.lost),
    )
    error = abs(speed / form.bore - 1.0) + abs(depth / form.depth - 1.0)
    return Measured(rows, error, _panels(found, form))


def _panels(found: Surge, form: Stoker) -> tuple[Panel, ...]:
    when = np.array([0.0, STEADY[1]])
    way = Panel(
        "bore",
        "t (s)",
        "place of the bore (m)",
        (exact(when, GATE + form.bore * when), computed(found.time, found.bore)),
    )
    last = found.time[-1]
    x = np.linspace(wave_from_wall(last, form), LENGTH, 501)
    curves = exact(x, _profile(x, last, form)), computed(found.x, found.depth[-1])
    return (way, Panel("depth after 1.2 s", "x (m)", "depth (m)", curves))


def wave_from_wall(until: float, form: Stoker, steps: int = 1000) -> float:
    """Return how far the wave has come that the fan's arrival at x = 0 sends back, m.

    It moves at ``u + c``, which is ``(4 c0 + (x - x_g) / t) / 3`` in the fan.
    """
    c0 = float(np.sqrt(GRAVITY * HIGH))
    behind = form.speed + float(np.sqrt(GRAVITY * form.depth))
    time, x = GATE / c0, 0.0
    dt = (until - time) / steps
    for _ in range(steps):
        x += dt * min((4.0 * c0 + (x - GATE) / time) / 3.0, behind)
        time += dt
    return x


def _profile(x: Floats, time: float, form: Stoker) -> Floats:
    """Return the depth along x, without the wave from the wall at x = 0."""
    c0, c = np.sqrt(GRAVITY * HIGH), np.sqrt(GRAVITY * form.depth)
    s = (x - GATE) / time
    fan = (2.0 * c0 - s) ** 2 / (9.0 * GRAVITY)
    ends = [s < -c0, s < form.speed - c, s < form.bore]
    profile: Floats = np.select(ends, [HIGH, fan, form.depth], LOW)
    return profile


_GATED = Known(
    "the closed form has no gate: drawn at 1.5 m/s it holds back the upper water first. Tried: "
    "without the gate the depth is 8.2 cm at 10 and at 5 mm, within the limit",
    {"d0 = 10 mm": 7.9, "d0 = 5 mm": 7.9, "d0 = 3.3 mm": 7.9},
    uncertain=("d0 = 10 mm", "d0 = 5 mm", "d0 = 3.3 mm"),
)
COMPARISONS = (
    Comparison(
        name="wet_bed",
        title="Dam break over a wet bed behind a gate",
        group=Group.DAM_BREAKS,
        compared=(
            "Speed, place and depth of the bore from 0.6 to 1.2 s against Stoker's closed form, "
            "whose gate is gone at once."
        ),
        reference="closed form; Stoker 1957, Water Waves; set-up of Janosi et al. 2004, "
        "doi:10.1007/s00348-004-0804-4",
        parameters=(
            "experiments/wet_bed.toml with 40 mm instead of 38 mm of water before the gate, a "
            "whole number of rows; smooth walls, gate drawn at 1.5 m/s"
        ),
        levels=(
            Level(4, "d0 = 10 mm", 4, is_quick=True),
            Level(8, "d0 = 5 mm", 22),
            Level(12, "d0 = 3.3 mm", 72),
        ),
        measure=measure,
        error="sum of the errors of speed and depth",
        discussion=(
            "The closed form is drawn ahead of the wave that returns from the back wall, and the "
            "depth is averaged from 0.13 to 0.30 m behind the bore, beyond its roller and ahead of "
            "that wave."
        ),
    ),
)
