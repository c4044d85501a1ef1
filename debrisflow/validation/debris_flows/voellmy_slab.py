"""A slab of mixture that slides down a plane onto a milder run-out, by Voellmy's law.

What a field flow is at practical spacings: a few rows of particles deep.  The run-out shall depend
little on their number.  There is no closed form, since the slab spreads; a finer run is the
reference.  The channel is six particles wide, between walls without friction, so that the flow is
that of a plane.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.resolved import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.scheme import Scheme
from debrisflow.validation.cases import case_of

DEPTH, LENGTH = 1.0, 20.0  # m, of the slab
BACK, BEND, END = 2.0, 72.0, 130.0  # x of the rear of the slab, the bend and the end, m
SLOPE, MILD = 25.0, 5.0  # degrees
SLIDING, TURBULENT = 0.2, 500.0  # mu, and xi in m/s2
ACROSS = 6  # spacings
ROWS = (1, 2, 4, 8)
INTERVAL, LATEST, REST = 0.25, 60.0, 0.01  # s, s, share of the greatest kinetic energy
FREE = {"friction": {"law": "none"}}


class Runout(NamedTuple):
    """What a slab did until it came to rest.

    Attributes
    ----------
    front, middle : float, m
        Distance behind the bend, along the run-out, that 99 % of the volume and half of it reach.
    arrival : float, s
        When 1 % of the volume had passed the bend.
    speed : float, m/s
        The greatest of the mean velocity.
    time : float, s
        When it was at rest.
    lost : int
        Particles that left the channel.
    """

    front: float
    middle: float
    arrival: float
    speed: float
    time: float
    lost: int


def build(rows: int) -> ResolvedCase:
    """Return the case of a slab some rows of particles deep."""
    spacing = DEPTH / rows
    width = ACROSS * spacing
    friction = {"law": "voellmy", "coefficient": SLIDING, "turbulence": TURBULENT}
    block = {"x": (BACK, BACK + LENGTH), "y": (0.0, width), "z": (0.0, DEPTH)}
    return case_of(
        title="slab by Voellmy's law",
        particles={"spacing": spacing},
        gravity={"slope": SLOPE},
        geometry={
            "type": "channel3d",
            "length": END,
            "width": width,
            "height": 30.0,
            "runout_start": BEND,
            "runout_slope": MILD,
        },
        walls={"floor": {"friction": friction}, "left": FREE, "front": FREE, "back": FREE},
        fill=[{"type": "block", "material": "mixture", **block}],
        scheme={"type": "explicit", "sound_speed": 120.0, "courant": 1.0},
        time={"end": LATEST},
        output={"interval": LATEST},
    )


def behind_bend(state: State) -> NDArray[np.float64]:
    """Return the distances of the particles behind the bend along the run-out, m, in order."""
    x = state.particles.position[state.particles.fluid, 0]
    return np.sort((x - BEND) / np.cos(np.radians(SLOPE - MILD)))


def run(rows: int) -> Runout:
    """Return what a slab some rows deep did."""
    case = build(rows)
    scheme, state = scheme_of(case), initial_state(case)
    count, peak, speed, arrival = state.particles.fluid_count, 0.0, 0.0, np.nan
    for due in np.arange(INTERVAL, LATEST + INTERVAL, INTERVAL):
        _advance(scheme, state, due)
        velocity = state.particles.velocity[state.particles.fluid]
        energy = float(np.sum(velocity**2))
        peak, speed = max(peak, energy), max(speed, float(np.abs(velocity.mean(axis=0)[0])))
        places = behind_bend(state)
        if np.isnan(arrival) and places[int(0.99 * places.size)] > 0.0:
            arrival = due
        if energy < REST * peak:
            break
    return Runout(
        front=float(np.quantile(places, 0.99)),
        middle=float(np.quantile(places, 0.5)),
        arrival=arrival,
        speed=speed,
        time=state.time,
        lost=count - state.particles.fluid_count,
    )


def _advance(scheme: Scheme, state: State, due: float) -> None:
    """Take steps up to a time, s."""
    while state.time < due:
        steps = max(1, int(np.ceil((due - state.time) / scheme.stable_dt(state))))
        dt = (due - state.time) / steps
        scheme.step(state, dt)
        state.time = due if steps == 1 else state.time + dt
        state.step += 1
