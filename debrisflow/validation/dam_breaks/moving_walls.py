"""Walls that move, in two dimensions: gates that are drawn, a sluice, a piston, and waves.

All walls are smooth.  Closed forms:

- the discharge under a gate drawn a above a floor, ``C_c a sqrt(2 g (H - C_c a))``, with the
  contraction of a free jet, ``C_c = pi / (pi + 2)``, and the depth H before the gate;
- the bore that a piston drives at the speed U into water of depth h: behind it the depth H with
  ``U = (H - h) sqrt(g (h + H) / (2 h H))``, its own speed ``U H / (H - h)``;
- the standing wave of small amplitude in a tank, without damping.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from debrisflow.case import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.schemes.choice import scheme_of
from debrisflow.validation.cases import case_of
from debrisflow.validation.marching import states

Floats = NDArray[np.float64]
GRAVITY = 9.81
CONTRACTION = np.pi / (np.pi + 2.0)


def _case(
    spacing: float, length: float, height: float, fill: tuple[float, float], end: float, **more: Any
) -> ResolvedCase:
    """Return a tank with smooth walls, and water in it from one x to another."""
    (start, stop), depth = fill, more.pop("depth")
    smooth = {"slip": "free-slip"}
    block = {"type": "block", "material": "water", "x": (start, stop), "y": (0.0, depth)}
    return case_of(
        title="moving walls",
        particles={"spacing": spacing},
        geometry={"type": "tank", "length": length, "height": height},
        fill=[block],
        walls=dict.fromkeys(("floor", "left", "right"), smooth),
        time={"end": end},
        output={"interval": end},
        **more,
    )


def _plate(x: float, thickness: float, height: float, **motion: Any) -> dict[str, Any]:
    ends = {"x": (x, x + thickness), "y": (0.0, height)}
    return {"type": "box", "name": "plate", "slip": "free-slip", "motion": motion} | ends


def front_after(speed: float | None, spacing: float = 0.01) -> float:
    """Return the front of a column 20 cm high, 0.25 s after a gate is drawn at a speed, m/s, in m.

    The fourth particle from ahead; None for no gate.
    """
    gate = [] if speed is None else [_plate(0.2, spacing, 0.4, velocity=(0.0, speed))]
    case = _case(spacing, 1.0, 0.5, (0.0, 0.2), 0.25, depth=0.2, obstacle=gate)
    for state in states(case, case.time.end):
        last = state
    return float(np.sort(last.particles.position[last.particles.fluid, 0])[-4])


class Sluice(NamedTuple):
    """What ran under a gate, by halves of the time.

    Attributes
    ----------
    drawn : float
        Volume that passed while the gate rose from half its opening on, over that of the orifice.
    open : float
        The same while it stood open.
    """

    drawn: float
    open: float


def sluice(rows: int, opening: float = 0.08) -> Sluice:
    """Return what passes a gate that is drawn to an opening of a number of rows within a second."""
    spacing, length, depth, rise, end = opening / rows, 1.2, 0.4, 1.0, 2.0
    gate = _plate(length, 0.02, 0.5, time=(0.0, rise, end), y=(0.0, opening, opening))
    case = _case(spacing, length + 3.2, 0.6, (0.0, length), end, depth=depth, obstacle=[gate])
    found = [
        (state.time, np.count_nonzero(state.particles.position[state.particles.fluid, 0] < length))
        for state in states(case, 0.02)
    ]
    time, count = np.array(found).T
    volume = count * spacing**2
    jet = CONTRACTION * PchipInterpolator((0.0, rise, end), (0.0, opening, opening))(time)
    head = np.maximum(volume / length - jet, 0.0)
    rate = jet * np.sqrt(2.0 * GRAVITY * head)
    ratio = {}
    for name, start, stop in (("drawn", 0.5 * rise, rise), ("open", rise, end)):
        within = (time >= start) & (time <= stop)
        passed = volume[within][0] - volume[within][-1]
        ratio[name] = float(passed / np.trapezoid(rate[within], time[within]))
    return Sluice(**ratio)


class Bore(NamedTuple):
    """A bore: depth behind it, and how far it has come, over those of the closed form."""

    depth: float
    path: float


def bore(rows: int, before: float = 0.2, behind: float = 0.36) -> Bore:
    """Return the bore 1.5 s after a piston started into water of a number of rows."""
    speed = (behind - before) * np.sqrt(GRAVITY * (before + behind) / (2.0 * before * behind))
    fast, start, reach, end = speed * behind / (behind - before), 0.1, 4.0, 1.5
    spacing = before / rows
    piston = _plate(0.0, start, 0.7, velocity=(speed, 0.0))
    case = _case(
        spacing, start + reach, 0.8, (start, start + reach), end, depth=before, obstacle=[piston]
    )
    for state in states(case, end):
        last = state
    x, piston_at = last.particles.position[last.particles.fluid, 0], start + speed * last.time
    there = start + fast * last.time
    # from the piston to a depth before the front, where the rollers of a bore end
    stop = there - 1.5 * behind
    depth = np.count_nonzero(x < stop) * spacing**2 / (stop - piston_at)
    edges = np.arange(piston_at, start + reach, 0.05)
    depths = np.histogram(x, edges)[0] * spacing**2 / 0.05
    front = edges[1:][depths > 0.5 * (before + behind)].max()
    return Bore(depth / behind, (front - start) / (there - start))


def swing(rows: int, halves: int = 6, depth: float = 0.3, length: float = 1.0) -> Floats:
    """Return how far the water of a tank swings back and forth in a standing wave, by half periods.

    The greatest displacement of its middle along x in each, over that of a wave of the amplitude of
    a tenth of the depth that is not damped.
    """
    amplitude, k = 0.1 * depth, np.pi / length
    frequency = np.sqrt(GRAVITY * k * np.tanh(k * depth))
    case = _case(
        depth / rows, length, 2.0 * depth, (0.0, length), halves * np.pi / frequency, depth=depth
    )
    state, scheme = initial_state(case), scheme_of(case)
    p = state.particles
    x, y = p.position[p.fluid, :2].T
    size = amplitude * frequency / np.sinh(k * depth)
    p.velocity[p.fluid, 0] = size * np.cosh(k * y) * np.sin(k * x)
    p.velocity[p.fluid, 1] = -size * np.sinh(k * y) * np.cos(k * x)
    scheme.fill_number_density(state)
    found = []
    while state.time < case.time.end:
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time, state.dt, state.step = state.time + dt, dt, state.step + 1
        found.append((state.time, p.position[p.fluid, 0].mean() - 0.5 * length))
    time, middle = np.array(found).T
    half = np.minimum((time * frequency / np.pi).astype(int), halves - 1)
    whole = 2.0 * amplitude / (np.pi * k * depth)
    return np.array([np.abs(middle[half == n]).max() for n in range(halves)]) / whole
