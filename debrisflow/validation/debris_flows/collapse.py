"""Collapse of a mixed column (A2): the same seeding with and without the collision stress."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from debrisflow.case import load_case, tables
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.run.measures import energies
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.files import CASES

CASE = CASES / "column_collapse2d.toml"
LAG_TIME, END = 0.75, 2.0


@dataclass
class Collapse:
    """What a collapse did.

    Attributes
    ----------
    sediment, water : float, m
        x of the centers of mass at 0.75 s.
    layering : dict
        By time, s: by how much the center of the water is above that of the sediment, over half of
        the depth that both fill when level: 0 mixed, 1 two level layers.
    energy : float
        Greatest kinetic and potential energy over that at the start.
    step : float, s
        Mean time step.
    through_wall : int
    """

    sediment: float
    water: float
    layering: dict[float, float]
    energy: float
    step: float
    through_wall: int


def run(
    with_stress: bool, seed: int, overrides: tuple[str, ...] = (), end: float = END
) -> Collapse:
    """Let the column collapse."""
    changes = [f"collision_stress.enabled={str(with_stress).lower()}", f"particles.seed={seed}"]
    case = load_case(CASE, [*changes, *overrides])
    scheme, state = SemiImplicit(case), initial_state(case)
    start = energy(case, state)
    greatest, layers = start, {}
    for time in (LAG_TIME, 1.5, END):
        while state.time < min(time, end):
            dt = min(scheme.stable_dt(state), time - state.time)
            scheme.step(state, dt)
            state.time += dt
            state.step += 1
            greatest = max(greatest, energy(case, state))
        layers[time] = layering(case, state)
        if time == LAG_TIME:
            sediment, water = (center[0] for center in centers(state))
    return Collapse(
        sediment,
        water,
        layers,
        greatest / start,
        state.time / state.step,
        int(state.through_wall.sum()),
    )


def energy(case: tables.Case, state: State) -> float:
    """Return kinetic and potential energy of the fluid, J/m."""
    p = state.particles
    return sum(energies(case, p.position, p.velocity, p.density, p.kind))


def centers(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return the centers of mass of sediment and water, m."""
    p = state.particles
    is_rock = p.sediment_fraction[p.fluid] > 0
    position = p.position[p.fluid]
    return position[is_rock].mean(axis=0), position[~is_rock].mean(axis=0)


def layering(case: tables.Case, state: State) -> float:
    """Return the layering of :class:`Collapse`."""
    sediment, water = centers(state)
    area = state.particles.fluid_count * case.particles.spacing**2
    return float((water[1] - sediment[1]) / (0.5 * area / case.geometry.length))
