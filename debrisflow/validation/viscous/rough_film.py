"""A turbulent film over a rough floor, against its profile, and a sheet over a smooth one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow.case import tables
from debrisflow.particles.start import initial_state
from debrisflow.physics.turbulence import KARMAN
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import case_of, endless_channel
from debrisflow.validation.marching import advance

SLOPE, GRAVITY = 15.0, 9.81
STEADY = (4.0, 5.0, 6.0)  # s


def mean_speed(depth: float, roughness: float, mixing_length: float) -> float:
    """Return the mean speed of a steady film, m/s.

    ``l du/dy = u* sqrt(1 - y / h)``, l the lesser of the mixing length and ``kappa (y + z0)``,
    ``z0 = k_s / 30``, u = 0 at the floor, ``u* = sqrt(g h sin(slope))``.
    """
    count = 100_000
    y = (np.arange(count) + 0.5) * depth / count
    length = np.minimum(mixing_length, KARMAN * (y + roughness / 30.0))
    friction_speed = np.sqrt(GRAVITY * depth * np.sin(np.radians(SLOPE)))
    rise = friction_speed * np.sqrt(1.0 - y / depth) / length
    return float(np.sum(rise * (depth - y)) / count)


class Film(NamedTuple):
    """What a film did: mean speed along the floor, and rms speed across, m/s."""

    speed: float
    across: float


def build(
    dimension: int, rows: int, depth: float, roughness: float, mixing_length: float
) -> tables.Case:
    """Return the case of a film, periodic along x, in three dimensions between smooth sides."""
    spacing, rheology = depth / rows, {"type": "coulomb", "mixing_length": mixing_length}
    if dimension == 2:
        layer, floor = {"y": [0.0, depth], "material": "water"}, {"roughness": roughness}
        return endless_channel(spacing, SLOPE, [layer], walls={"floor": floor}, rheology=rheology)
    size = {"length": 12.0 * spacing, "width": 8.0 * spacing}
    block = {"x": (0.0, size["length"]), "y": (0.0, size["width"]), "z": (0.0, depth)}
    smooth = {"slip": "free-slip"}
    floor = {"friction": {"law": "log", "roughness": roughness}}
    return case_of(
        title="turbulent film",
        particles={"spacing": spacing},
        gravity={"slope": SLOPE},
        geometry={"type": "channel3d", "periodic": True, "height": 4.0 * depth, **size},
        walls={"floor": floor, "front": smooth, "back": smooth},
        fill=[{"type": "block", "material": "water", **block}],
        rheology=rheology,
        scheme={"type": "explicit", "courant": 1.2, "sound_speed": 15.0},
        time={"end": STEADY[-1]},
        output={"interval": STEADY[-1]},
    )


def run(
    rows: int, depth: float, roughness: float, mixing_length: float, dimension: int = 2
) -> Film:
    """Return what a film ``rows`` particles deep did once it was steady."""
    case = build(dimension, rows, depth, roughness, mixing_length)
    scheme, state = scheme_of(case), initial_state(case)
    found = []
    for until in STEADY:
        advance(scheme, state, until=until)
        velocity = state.particles.velocity[state.particles.fluid]
        across = np.sqrt(np.mean(np.sum(velocity[:, 1:] ** 2, axis=1)))
        found.append((velocity[:, 0].mean(), across))
    return Film(*np.mean(found, axis=0).tolist())


class Sheet(NamedTuple):
    """What a sheet lost to the floor, N/m2, and its rms speed across, m/s."""

    drag: float
    across: float


def slide(rows: int, speed: float = 3.0, spacing: float = 0.01) -> Sheet:
    """Return what a sheet of water did that slides over a level, smooth floor for a second."""
    layer = {"y": [0.0, rows * spacing], "material": "water", "velocity": [speed, 0.0]}
    case = endless_channel(spacing, 0.0, [layer], walls={"floor": {"slip": "free-slip"}})
    scheme, state = SemiImplicit(case), initial_state(case)
    p, across = state.particles, []
    for until in np.arange(1, 21) / 20.0:
        advance(scheme, state, until=until)
        across.append(np.sqrt(np.mean(p.velocity[p.fluid, 1] ** 2)))
    lost = speed - p.velocity[p.fluid, 0].mean()
    return Sheet(case.water.density * rows * spacing * lost, float(np.mean(across[10:])))
