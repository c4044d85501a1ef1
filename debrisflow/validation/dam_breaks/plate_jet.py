"""A jet against a plate, without gravity: the thrust, and the pressure along the plate.

A slug of water, a = 0.05 m thick and 20 a long, slides along a smooth floor, which is the plane of
symmetry of a jet twice as thick, into the wall at the end of a tank.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.validation.cases import case_of
from debrisflow.validation.probed import probed

Floats = NDArray[np.float64]
THICKNESS, SPEED, DENSITY = 0.05, 1.0, 1000.0
LENGTH, HEIGHT = 20.0 * THICKNESS, 8.0 * THICKNESS
END, STEADY = 0.9, (0.4, 0.9)  # s; the slug takes 1 s to arrive
STAGNATION = 0.5 * DENSITY * SPEED**2


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
    height, pressure, expected : (8,) float64 array
        Middles of patches half a thickness high, m; the mean of the reaction there over the
        pressure of stagnation, and that of potential flow.
    by_fluid : float
        The same by the fluid before the plate, in the lowest quarter of the thickness.
    """

    thrust: float
    height: Floats
    pressure: Floats
    expected: Floats
    by_fluid: float


def run(dimension: int, rows: int = 8) -> Jet:
    """Return what the plate felt, in two or three dimensions, the jet so many rows thick."""
    spacing, width = THICKNESS / rows, 4.0 * THICKNESS / rows
    up, flat = "yz"[dimension - 2], dimension == 2
    tank = {"type": "tank", "length": LENGTH} if flat else {"type": "tank3d", "length": LENGTH}
    across = {} if flat else {"y": (0.0, width)}
    slug = {"type": "block", "material": "water", "x": (0.0, LENGTH), up: (0.0, THICKNESS)}
    names = ["floor", "left", "right"] + ([] if flat else ["front", "back"])
    foot = {"x": LENGTH} | ({} if flat else {"y": 0.5 * width})
    patch = {"type": "pressure", "wall": "right", "interval": 0.002}
    height = (np.arange(8) + 0.5) * 0.5 * THICKNESS
    patches = [
        patch | foot | {"name": f"row_{k}", up: y, "size": 0.5 * THICKNESS}
        for k, y in enumerate(height)
    ]
    low = {"name": "low", up: 0.125 * THICKNESS, "size": 0.25 * THICKNESS}
    speed = [SPEED] + [0.0] * (dimension - 1)
    case = case_of(
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
    _, probes = probed(case)

    def steady(name: str, column: str) -> float:
        table = probes[name]
        inside = (table["time"] >= STEADY[0]) & (table["time"] <= STEADY[1])
        return float(table[column][inside].mean())

    area = THICKNESS * (1.0 if flat else width)
    found = np.array([steady(f"row_{k}", "reaction") for k in range(height.size)])
    edges = np.linspace(-0.25, 0.25, 51) * THICKNESS
    expected = np.array([potential_flow(y + edges).mean() for y in height])
    return Jet(
        steady("force", "force_x") / (DENSITY * area * SPEED**2),
        height,
        found / STAGNATION,
        expected,
        steady("low", "pressure") / STAGNATION,
    )
