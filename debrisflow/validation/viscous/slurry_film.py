"""Steady films of slurry and of dry grains on a slope, against their profiles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.start import initial_state
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import endless_channel
from debrisflow.validation.marching import advance

Floats = NDArray[np.float64]
GRAVITY, DEPTH, ROWS = 9.81, 0.1, 20
CONCENTRATION, ROCK, WATER = 0.5, 2500.0, 1000.0
VISCOSITY, YIELD_STRESS, CONSISTENCY, EXPONENT = 20.0, 75.0, 40.0, 0.5
# Angles far apart: with those of glass beads, 1 % of the pressure makes 9 % of the speed.
STATIC, DYNAMIC, INERTIA_NUMBER, DIAMETER = 8.0, 45.0, 0.279, 5.0e-3
SLOPES = {"bingham": 10.0, "herschel-bulkley": 10.0, "mu-i": 20.0}


def rheology(law: str) -> dict[str, object]:
    """Return the tables of a film."""
    mixture = {"concentration": CONCENTRATION, "viscosity": 0.0}
    table: dict[str, object] = {"type": law}
    if law == "mu-i":
        table |= {"friction_angle": STATIC, "dynamic_friction_angle": DYNAMIC, "saturated": False}
    else:
        table |= {"yield_stress": YIELD_STRESS}
    if law == "bingham":
        mixture["viscosity"] = VISCOSITY
    elif law == "herschel-bulkley":
        table |= {"consistency": CONSISTENCY, "exponent": EXPONENT}
    sediment = {"density": ROCK, "grain_diameter": DIAMETER}
    return {"mixture": mixture, "sediment": sediment, "rheology": table}


def profile(law: str, y: Floats) -> Floats:
    """Return the speed of the steady film at a height y, m/s.

    Of a Herschel-Bulkley slurry, over a sheared layer of the thickness ``s = h - tau0 / t``,

        u = n / (n + 1) (t / K)^(1/n) s^(1 + 1/n) [1 - (1 - y / s)^(1 + 1/n)]

    with ``t = rho g sin(slope)``, and of dry grains Bagnold's

        u = 2/3 I / d sqrt(C g cos(slope)) [h^(3/2) - (h - y)^(3/2)],  mu(I) = tan(slope)
    """
    slope = np.radians(SLOPES[law])
    if law == "mu-i":
        static, dynamic = np.tan(np.radians([STATIC, DYNAMIC]))
        inertia = INERTIA_NUMBER * (np.tan(slope) - static) / (dynamic - np.tan(slope))
        rise = inertia / DIAMETER * np.sqrt(CONCENTRATION * GRAVITY * np.cos(slope))
        return 2.0 / 3.0 * rise * (DEPTH**1.5 - np.maximum(DEPTH - y, 0.0) ** 1.5)
    n, k = (1.0, VISCOSITY) if law == "bingham" else (EXPONENT, CONSISTENCY)
    density = CONCENTRATION * ROCK + (1.0 - CONCENTRATION) * WATER
    pull = density * GRAVITY * np.sin(slope)
    sheared = DEPTH - YIELD_STRESS / pull
    plug = n / (n + 1.0) * (pull / k) ** (1.0 / n) * sheared ** (1.0 + 1.0 / n)
    return plug * (1.0 - np.maximum(1.0 - y / sheared, 0.0) ** (1.0 + 1.0 / n))


def errors(law: str, end: float) -> Floats:
    """Return the error of the mean speed of every row, in units of that of the surface.

    The film starts with its profile; rows that pass each other make it fluctuate by some 2 %, so
    that the mean is over a half of the time.
    """
    layer = {"y": [0.0, DEPTH], "material": "mixture"}
    case = endless_channel(DEPTH / ROWS, SLOPES[law], [layer], **rheology(law))
    scheme, state = SemiImplicit(case), initial_state(case)
    p = state.particles
    p.velocity[p.fluid, 0] = profile(law, p.position[p.fluid, 1])
    found = []
    for until in np.linspace(0.5 * end, end, 8):
        advance(scheme, state, until=until)
        y, u = p.position[p.fluid, 1], p.velocity[p.fluid, 0]
        row = np.clip((y / DEPTH * ROWS).astype(int), 0, ROWS - 1)
        off = np.bincount(row, u - profile(law, y), minlength=ROWS)
        found.append(off / np.bincount(row, minlength=ROWS))
    return np.asarray(np.mean(found, axis=0) / profile(law, np.array([DEPTH])))


def creep(law: str, slope: float) -> float:
    """Return how far a layer moves in 2 s where its strength should hold it, in spacings."""
    layer = {"y": [0.0, DEPTH], "material": "mixture"}
    case = endless_channel(DEPTH / ROWS, slope, [layer], **rheology(law))
    scheme, state = SemiImplicit(case), initial_state(case)
    p = state.particles
    moved = 0.0
    for until in np.arange(1, 11) * 0.2:
        advance(scheme, state, until=until)
        moved += 0.2 * float(np.abs(p.velocity[p.fluid, 0]).max())
    return moved / case.particles.spacing
