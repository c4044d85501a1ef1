"""A jet against a plate, without gravity: the thrust, and the pressure along the plate.

A slug of water, a = 0.05 m thick and 20 a long, slides along a smooth floor, which is the plane of
symmetry of a jet twice as thick, into the wall at the end of a tank.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.dam_breaks.known import Known
from debrisflow.validation.probed import probed
from debrisflow.validation.row import at_most, near

Floats = NDArray[np.float64]
THICKNESS, SPEED, DENSITY = 0.05, 1.0, 1000.0
LENGTH, HEIGHT = 20.0 * THICKNESS, 8.0 * THICKNESS
END, STEADY = 0.9, (0.4, 0.9)  # s; the slug takes 1 s to arrive
STAGNATION = 0.5 * DENSITY * SPEED**2
HEIGHTS = (np.arange(8) + 0.5) * 0.5 * THICKNESS
"""Of the middles of patches, m."""


def potential_flow(y: Floats) -> Floats:
    """Return the pressure at heights on the plate over that of stagnation, by free streamlines.

    ``p = 1 - q^2`` where ``y = (4 a / pi) (arctan q + artanh q)``, q the speed along the plate
    over that of the jet: from the hodograph, sources of the jet at 1 and -1, sinks at i and -i.

    References
    ----------
    Milne-Thomson 1968, Theoretical Hydrodynamics, chapter XI.
    """
    q = np.concatenate(([0.0], np.linspace(0.001, 0.99999, 20_000)))
    return 1.0 - np.interp(y, 4.0 * THICKNESS / np.pi * (np.arctan(q) + np.arctanh(q)), q) ** 2


class Jet(NamedTuple):
    """What the plate felt while the flow was steady.

    Attributes
    ----------
    thrust : float
        Over ``rho Q u``.
    pressure : (8,) float64 array
        Mean of the reaction on patches half a thickness high over the pressure of stagnation.
    by_fluid : float
        The same by the fluid before the plate, in the lowest quarter of the thickness.
    """

    thrust: float
    pressure: Floats
    by_fluid: float


def build(dimension: int, rows: int) -> ResolvedCase:
    """Return the slug and the plate, in two or three dimensions, the jet so many rows thick."""
    spacing, width = THICKNESS / rows, 4.0 * THICKNESS / rows
    up, flat = "yz"[dimension - 2], dimension == 2
    tank = {"type": "tank", "length": LENGTH} if flat else {"type": "tank3d", "length": LENGTH}
    across = {} if flat else {"y": (0.0, width)}
    slug = {"type": "block", "material": "water", "x": (0.0, LENGTH), up: (0.0, THICKNESS)}
    names = ["floor", "left", "right"] + ([] if flat else ["front", "back"])
    foot = {"x": LENGTH} | ({} if flat else {"y": 0.5 * width})
    patch = {"type": "pressure", "wall": "right", "interval": 0.002}
    patches = [
        patch | foot | {"name": f"row_{k}", up: y, "size": 0.5 * THICKNESS}
        for k, y in enumerate(HEIGHTS)
    ]
    low = {"name": "low", up: 0.125 * THICKNESS, "size": 0.25 * THICKNESS}
    speed = [SPEED] + [0.0] * (dimension - 1)
    return case_of(
        title="jet against a plate",
        particles={"spacing": spacing},
        gravity={"acceleration": 0.0},
        geometry=tank | ({} if flat else {"width": width}) | {"height": HEIGHT},
        walls={name: {"slip": "free-slip"} for name in names},
        fill=[slug | across | {"velocity": speed}],
        scheme={} if flat else {"type": "explicit", "sound_speed": 15.0 * SPEED},
        time={"end": END},
        output={"interval": END},
        probe=[
            *patches,
            patch | foot | low,
            {"type": "force", "name": "force", "wall": "right", "interval": 0.002},
        ],
    )


def run(dimension: int, rows: int) -> Jet:
    """Return what the plate felt, in two or three dimensions, the jet so many rows thick."""
    _, probes = probed(build(dimension, rows))

    def steady(name: str, column: str) -> float:
        table = probes[name]
        inside = (table["time"] >= STEADY[0]) & (table["time"] <= STEADY[1])
        return float(table[column][inside].mean())

    area = THICKNESS * (1.0 if dimension == 2 else 4.0 * THICKNESS / rows)
    found = np.array([steady(f"row_{k}", "reaction") for k in range(HEIGHTS.size)])
    return Jet(
        steady("force", "force_x") / (DENSITY * area * SPEED**2),
        found / STAGNATION,
        steady("low", "pressure") / STAGNATION,
    )


def expected() -> Floats:
    """Return the mean pressure of potential flow on the patches."""
    edges = np.linspace(-0.25, 0.25, 51) * THICKNESS
    return np.array([potential_flow(y + edges).mean() for y in HEIGHTS])


class Limits(NamedTuple):
    """Of the pressure on the patches, by the rows of the jet; and how the fluid's misses its."""

    pressure: dict[int, float]
    missed: Known


def measure(dimension: int, limits: Limits, level: Level) -> Measured:
    """Return what the plate felt at a level."""
    rows = round(level.across)
    found = run(dimension, rows)
    off = float(np.abs(found.pressure - expected()).max())
    resolution = "chosen, by the rows on a patch half the thickness high: two to eight"
    return Measured(
        (
            near(
                "thrust / ρ Q u",
                found.thrust,
                1.0,
                "chosen: 3 %, a speed within 1.5 %",
                share=0.03,
            ),
            at_most(
                "pressure by the reaction, greatest difference / that of stagnation",
                off,
                limits.pressure[rows],
                resolution,
                "%",
            ),
            near(
                "pressure of the fluid at the foot / that of stagnation",
                found.by_fluid,
                1.0,
                "chosen: 10 %; one to four rows are on the lowest quarter",
                share=0.10,
                **limits.missed.at(level.label),
            ),
        ),
        off,
        (_panel(found),),
    )


def _panel(found: Jet) -> Panel:
    y = np.linspace(0.0, 4.0, 81)
    curves = (
        exact(y, potential_flow(y * THICKNESS), "potential flow"),
        points(HEIGHTS / THICKNESS, found.pressure, "reaction of the plate"),
    )
    return Panel(
        "pressure along the plate",
        "height / thickness of the jet",
        "p / that of stagnation",
        curves,
    )


_PRESSED = Known(
    "an impact in two dimensions presses rows together, which then carry more stress than the "
    "pressure of their particles; the reaction of the plate, in the row above, is right. It comes "
    "nearer with the spacing",
    {"4 rows": 0.52, "8 rows": 0.70, "16 rows": 0.85},
)
_FLAT = Limits({4: 0.10, 8: 0.10, 16: 0.03}, _PRESSED)
_SOLID = Limits({4: 0.10, 8: 0.05, 12: 0.05}, Known("", {}))
_shared = partial(
    Comparison,
    group=Group.DAM_BREAKS,
    compared=(
        "Thrust on the plate, and the mean pressure on eight patches half a thickness high, from "
        "0.4 to 0.9 s, against free-streamline theory of the steady jet."
    ),
    reference="potential flow by its hodograph; Milne-Thomson 1968, Theoretical Hydrodynamics, XI",
    error="greatest difference of the pressure on patches / that of stagnation",
)
COMPARISONS = (
    _shared(
        name="jet2d",
        title="Jet on a plate, two dimensions",
        parameters="semi-implicit scheme, no gravity, walls that slip freely, jet of 0.05 m, 1 m/s",
        levels=(
            Level(4, "4 rows", 2, is_quick=True),
            Level(8, "8 rows", 5, is_quick=True),
            Level(16, "16 rows", 30, is_quick=True),
        ),
        measure=partial(measure, 2, _FLAT),
    ),
    _shared(
        name="jet3d",
        title="Jet on a plate, three dimensions",
        parameters=(
            "explicit scheme, speed of sound 15 times that of the jet, no gravity, walls that slip "
            "freely, jet of 0.05 m, 1 m/s, four spacings wide"
        ),
        levels=(
            Level(4, "4 rows", 5),
            Level(8, "8 rows", 25, is_quick=True),
            Level(12, "12 rows", 90),
        ),
        measure=partial(measure, 3, _SOLID),
    ),
)
