"""A slab of constant depth that slides down a plane by Voellmy's law, against its closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.start import initial_state
from debrisflow.schemes.choice import scheme_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.debris_flows.voellmy_slab import (
    ACROSS,
    DEPTH,
    INTERVAL,
    SLIDING,
    SLOPE,
    TURBULENT,
    advance_evenly,
    slab_case,
)
from debrisflow.validation.row import near, stated

Floats = NDArray[np.float64]
GRAVITY = 9.81
SETTLED, EARLY, END = 0.25, 1.25, 12.0
"""From when the slab is carried, until when sliding friction alone counts, and the end, s."""
RIGID = {"type": "bingham", "yield_stress": 1e5, "concentration_ramp": (0.1, 0.2)}
"""Ten times the stress on the floor, so that rows do not slide over each other."""
CLOSED = "closed form; frictionless side walls six spacings apart bear 2 % of the weight"


def terminal_speed() -> float:
    """Return the speed at which friction balances gravity, m/s."""
    angle = np.radians(SLOPE)
    excess = np.sin(angle) - SLIDING * np.cos(angle)
    return float(np.sqrt(TURBULENT * DEPTH * excess))


def speed(time: Floats, start: float = 0.0) -> Floats:
    """Return the speed of a rigid slab that starts with a speed, m/s.

    ``V tanh(g t V / (xi h) + artanh(start / V))``, see :func:`terminal_speed`.
    """
    v = terminal_speed()
    found: Floats = v * np.tanh(GRAVITY * time * v / (TURBULENT * DEPTH) + np.arctanh(start / v))
    return found


def run(rows: int) -> tuple[Floats, Floats]:
    """Return times, s, and mean speeds, m/s, of a slab that repeats along the slope."""
    length = ACROSS * DEPTH / rows
    channel = {"length": length, "height": 2.0 * DEPTH, "periodic": True}
    tables = {"rheology": RIGID} if rows > 1 else {}
    case = slab_case(rows, channel, (0.0, length), END, **tables)
    scheme, state = scheme_of(case), initial_state(case)
    times = np.arange(0.0, END + 0.5 * INTERVAL, INTERVAL)
    speeds = []
    for due in times:
        advance_evenly(scheme, state, due)
        speeds.append(float(state.particles.velocity[state.particles.fluid, 0].mean()))
    return times, np.array(speeds)


def measure(level: Level) -> Measured:
    """Return the speed of a slab at a level."""
    times, found = run(round(level.across))
    settled = times >= SETTLED
    known = speed(times[settled] - SETTLED, float(found[settled][0]))
    off = np.abs(found[settled] - known).max() / terminal_speed()
    early, late = ((times[settled] == at) for at in (EARLY, END))
    gain, expected = (float((u[early] - u[0])[0]) for u in (found[settled], known))
    lag = np.interp(found[settled][0], speed(times), times)
    rows = (
        near(
            "gain of speed from 0.25 to 1.25 s, hardly any drag",
            gain,
            expected,
            CLOSED,
            share=0.02,
            unit="m/s",
        ),
        near(
            "speed after 12 s, 99 % of the steady one",
            float(found[-1]),
            float(known[late][0]),
            CLOSED,
            share=0.02,
            unit="m/s",
        ),
        stated("time by which the slab starts late", SETTLED - float(lag), "s"),
    )
    panel = Panel(
        "speed",
        "t (s)",
        "u (m/s)",
        (
            exact(times, speed(times)),
            computed(times, found),
        ),
    )
    return Measured(rows, float(off), (panel,))


COMPARISONS = (
    Comparison(
        name="voellmy_layer",
        title="Slab of constant depth by Voellmy's law",
        group=Group.DEBRIS_FLOWS,
        compared=(
            "The speed of a rigid slab from rest on an endless slope against V tanh(g t V / (ξ h))"
            ", with V² = ξ h (sin θ - μ cos θ)."
        ),
        reference="closed form of Voellmy's law; Voellmy 1955, Schweizerische Bauzeitung 73",
        parameters=(
            "1 m deep, slope of 25°, μ = 0.2, ξ = 500 m/s²; several rows are held together by a "
            "strength of 100 kPa"
        ),
        levels=(
            Level(1, "1 row", 1, is_quick=True),
            Level(2, "2 rows", 2, is_quick=True),
            Level(4, "4 rows", 6),
        ),
        measure=measure,
        error="greatest error of the speed / steady speed",
        discussion=(
            "The first second tests sliding friction alone, by Coulomb's law. The slab is compared "
            "from 0.25 s on, with the speed that it has then: until it is carried, within less "
            "than 0.1 s, a rigid one does not move."
        ),
    ),
)
