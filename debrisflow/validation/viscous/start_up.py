"""Start-up of plane Poiseuille and Couette flow and of a film on a slope, against their series."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.rheology import Coulomb
from debrisflow.particles.start import initial_state
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Curve, Panel, exact, points
from debrisflow.validation.marching import advance
from debrisflow.validation.row import at_most

Floats = NDArray[np.float64]
Profile = Callable[[Floats, float], Floats]
LENGTH, VISCOSITY = 1.0e-3, 1.0e-6
TERMS = np.arange(1, 200)
SLOW, FAST = 1.25e-5, 1.25e-3
"""Speeds of the steady flow, m/s: rows hardly pass each other; the fastest passes the wall's by 25
spacings."""
TIMES = 0.05, 0.1, 0.2, 0.5, 1.0


def poiseuille(y: Floats, tau: float) -> Floats:
    """Return u / u_max at y / L and nu t / L^2 (Morris, Fox & Zhu 1997)."""
    n = 2 * np.arange(100)[:, None] + 1
    decaying = 32.0 / (np.pi * n) ** 3 * np.sin(n * np.pi * y) * np.exp(-((n * np.pi) ** 2) * tau)
    profile: Floats = 4.0 * y * (1.0 - y) - decaying.sum(axis=0)
    return profile


def couette(y: Floats, tau: float) -> Floats:
    """Return u / U at y / L and nu t / L^2; the wall at y = L moves."""
    n = TERMS[:, None]
    series = 2.0 / (n * np.pi) * (-1.0) ** n * np.sin(n * np.pi * y)
    profile: Floats = y + (series * np.exp(-((n * np.pi) ** 2) * tau)).sum(axis=0)
    return profile


def film(y: Floats, tau: float) -> Floats:
    """Return u / u_surface at y / h and nu t / h^2: half a channel of twice the depth."""
    return poiseuille(0.5 * y, 0.25 * tau)


class StartUp(NamedTuple):
    """One of the flows.

    Attributes
    ----------
    profile : callable
        Of y / L and nu t / L^2, over the steady speed.
    force : tuple of float
        Body force that makes the steady speed 1 m/s, m/s2, over ``nu / L^2``.
    is_closed : bool
        Whether there is a second wall.
    is_driven : bool
        Whether that wall moves.
    """

    profile: Profile
    force: tuple[float, float]
    is_closed: bool
    is_driven: bool


POISEUILLE = StartUp(poiseuille, (8.0, 0.0), True, False)
COUETTE = StartUp(couette, (0.0, 0.0), True, True)
FILM = StartUp(film, (2.0, -2.0), False, False)


def channel(flow: StartUp, rows: int, speed: float) -> ResolvedCase:
    """Return a channel of 1 mm, periodic along x, with ``rows`` of particles across."""
    spacing = LENGTH / rows
    length = 16 * spacing
    x, y = (part * VISCOSITY * speed / LENGTH**2 for part in flow.force)
    return case_of(
        title="viscous",
        particles={"spacing": spacing},
        gravity={"vector": (x, y)},
        geometry={
            "type": "tank",
            "length": length,
            "height": LENGTH if flow.is_closed else 2.0 * LENGTH,
            "ceiling": flow.is_closed,
            "periodic": True,
        },
        fill=[{"type": "block", "x": (0.0, length), "y": (0.0, LENGTH), "material": "water"}],
        water={"viscosity": 1000.0 * VISCOSITY},
        walls={"ceiling": {"velocity": (speed if flow.is_driven else 0.0, 0.0)}},
        time={"end": 2.0},
        output={"interval": 0.1},
    )


def profiles(
    flow: StartUp, rows: int, speed: float, is_implicit: bool = False
) -> list[tuple[Floats, Floats]]:
    """Return y / L and u over the steady speed of all particles at the times of the comparison.

    With a strength, which finds no sediment here, viscosity is implicit.
    """
    case = channel(flow, rows, speed)
    if is_implicit:
        case = case.model_copy(update={"rheology": Coulomb(type="coulomb")})
    scheme, state = SemiImplicit(case), initial_state(case)
    p, found = state.particles, []
    for tau in TIMES:
        advance(scheme, state, until=tau * LENGTH**2 / VISCOSITY)
        y, u = p.position[p.fluid, 1] / LENGTH, p.velocity[p.fluid, 0] / speed
        found.append((y.copy(), u))
    return found


def greatest_error(flow: StartUp, found: list[tuple[Floats, Floats]]) -> float:
    """Return the greatest error of profiles, in units of the steady speed."""
    pairs = zip(TIMES, found, strict=True)
    return max(float(np.abs(u - flow.profile(y, tau)).max()) for tau, (y, u) in pairs)


def measure(flow: StartUp, level: Level) -> Measured:
    """Return the errors of a flow at a level."""
    rows = round(level.across)
    slow = profiles(flow, rows, SLOW)
    errors = {
        "greatest error of the profile / steady speed": slow,
        "the same, rows of particles pass each other": profiles(flow, rows, FAST),
        "the same, implicit viscosity": profiles(flow, rows, SLOW, is_implicit=True),
    }
    reason = "chosen: 2 % at 20 rows, at the others as second order has it"
    most = 0.02 * (20.0 / rows) ** 2
    return Measured(
        tuple(
            at_most(name, greatest_error(flow, found), most, reason, "%")
            for name, found in errors.items()
        ),
        greatest_error(flow, slow),
        (Panel("speed across", "u / steady speed", "y / L", tuple(_curves(flow, slow))),),
    )


def _curves(flow: StartUp, found: list[tuple[Floats, Floats]]) -> list[Curve]:
    y = np.linspace(0.0, 1.0, 41)
    lines = [exact(flow.profile(y, tau), y) for tau in TIMES]
    dots = np.concatenate([np.column_stack([u, at])[::7] for at, u in found])
    return [*lines, points(*dots.T)]


LEVELS = (Level(10, "10 rows", 2), Level(20, "20 rows", 8, is_quick=True), Level(40, "40 rows", 60))
_shared = partial(
    Comparison,
    group=Group.VISCOUS,
    parameters="gap or depth of 1 mm, kinematic viscosity 1e-6 m²/s, periodic along the flow",
    levels=LEVELS,
    error="greatest error of the slow profile / steady speed",
)
_HOW = (
    "Profiles of the velocity at ν t / L² = 0.05, 0.1, 0.2, 0.5 and 1 against the series; slow, so "
    "that the lattice stays, and 100 times as fast."
)
_MORRIS = "series; Morris, Fox & Zhu 1997, doi:10.1006/jcph.1997.5776"
COMPARISONS = (
    _shared(
        name="poiseuille",
        title="Start-up of plane Poiseuille flow",
        compared=_HOW,
        reference=_MORRIS,
        measure=partial(measure, POISEUILLE),
    ),
    _shared(
        name="couette",
        title="Start-up of plane Couette flow",
        compared=_HOW,
        reference=_MORRIS,
        measure=partial(measure, COUETTE),
    ),
    _shared(
        name="film",
        title="Start-up of a laminar film on a slope",
        compared=_HOW,
        reference="series of half a channel of twice the depth; steady: Nusselt 1916",
        measure=partial(measure, FILM),
    ),
)
