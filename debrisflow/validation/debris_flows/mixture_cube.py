"""Collapse of a cube of debris mixture in a tank (B1): leaks, energy, front, spray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from debrisflow.case import load_case
from debrisflow.neighbors.lattice import reference
from debrisflow.run.measures import FRONT_SHARE
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import energy, states

CASE = CASES / "dam_break3d.toml"
FRONT_TIME = 0.8
THIN, SPRAY = 0.8, 0.4  # of n0
FRONT_HEIGHT = 3.0  # spacings


@dataclass
class Cube:
    """What a collapse did.

    Attributes
    ----------
    front : float, m
        x behind which 99.5 % of the particles lie at 0.8 s.
    thin : float
        Share of the particles with n < 0.8 n0 then.
    height : float, m
        Greatest z of a particle then.
    spray : float
        Share of the particles with n < 0.4 n0 higher than the thin front, three rows, then: 0.3 is
        one particle on a surface.
    energy : float
        Greatest kinetic, potential and elastic energy over that at the start.
    through_wall : int
    """

    front: float
    thin: float
    height: float
    spray: float
    energy: float
    through_wall: int


def run(concentration: float | None, end: float = 2.0, overrides: tuple[str, ...] = ()) -> Cube:
    """Let the cube collapse, with the stress of grains of a concentration or, if None, without.

    Without stress the mixture has the density of a concentration of 0.4.
    """
    changes = [f"mixture.concentration={concentration or 0.4!r}", f"time.end={end!r}"]
    if concentration is None:
        changes.append("collision_stress.enabled=false")
    case = load_case(CASE, [*changes, *overrides])
    lattice = reference(3, case.particles.effective_radius, case.particles.spacing)
    least = THIN * lattice.number_density
    start = greatest = height = spray = front = thin = 0.0
    for state in states(case, 0.01):
        p = state.particles
        total = energy(case, state)
        start, greatest = start or total, max(greatest, total)
        if state.time >= FRONT_TIME and front == 0.0:
            x = p.position[p.fluid, 0]
            front = float(np.quantile(x, FRONT_SHARE, method="inverted_cdf"))
            n = p.number_density[p.fluid]
            height = float(p.position[p.fluid, 2].max())
            over = p.position[p.fluid, 2] > FRONT_HEIGHT * case.particles.spacing
            spray = float(np.mean(over & (n < SPRAY * lattice.number_density)))
            thin = float(np.mean(n < least))
    return Cube(front, thin, height, spray, greatest / start, int(state.through_wall.sum()))
