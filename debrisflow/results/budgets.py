"""Budgets of mass, energy and momentum over a run."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import PHASES
from debrisflow.results.frames import Frame
from debrisflow.run.history import PER_WIDTH, WAYS
from debrisflow.run.measures import particle_volume
from debrisflow.run.tables import Row, Table
from debrisflow.space.gravity import gravity_vector

MATTER = ("water", "sediment")
BUDGET_HEAD = (
    "time: s",
    "mass_*_water, mass_*_sediment: kg{per_width}, of the water and of the grains in particles;",
    "  in through the inflow, out over an open end or a rim, inside now, through_wall lost, since",
    "  the start of the run",
    "closure_water, closure_sediment: kg{per_width}; inside - (inside at t = 0 + in - out -",
    "  through_wall), these three since t = 0",
    "kinetic_energy, potential_energy, elastic_energy, total_energy: J{per_width}; total is the",
    "  sum of the others",
)
MOMENTUM_UNITS = "momentum_x, momentum_{up}: N s{per_width}, of the fluid"
MOMENTUM_HEAD = (
    "time: s",
    MOMENTUM_UNITS,
    "gravity_x: N{per_width}, weight of the fluid along x",
    "resistance_x: N{per_width}, gravity_x less the rate of change of momentum_x: what walls take,",
    "  and what leaves less what enters",
)


def budget_table(case: ResolvedCase, history: Table) -> Table:
    """Return mass by matter, its closure, and energies at the times of the history.

    Parameters
    ----------
    case : ResolvedCase
    history : Table
        As ``history.csv`` names it; the first row is the state from which the budget runs.
    """
    table = {"time": history["time"]}
    for way in WAYS:
        sediment = case.sediment.density * history[f"sediment_volume_{way}"]
        total = sum(history[f"mass_{way}_{phase}"] for phase in PHASES)
        table[f"mass_{way}_water"] = total - sediment
        table[f"mass_{way}_sediment"] = sediment
    for matter in MATTER:
        mass = {way: table[f"mass_{way}_{matter}"] for way in WAYS}
        balance = mass["inside"] - mass["in"] + mass["out"] + mass["through_wall"]
        table[f"closure_{matter}"] = balance - balance[:1]
    energies = ("kinetic_energy", "potential_energy", "elastic_energy")
    table |= {name: history[name] for name in energies}
    table["total_energy"] = sum((history[name] for name in energies), np.zeros(len(table["time"])))
    return table


def budget_head(dimension: int) -> list[str]:
    """Return what the columns of ``budget.csv`` mean."""
    return [line.format(per_width=PER_WIDTH[dimension]) for line in BUDGET_HEAD]


def momentum_row(case: ResolvedCase, frame: Frame) -> Row:
    """Return time, momentum along x and upwards, N s, and weight along x, N, of the fluid."""
    fluid, up = frame.fluid, case.dimension - 1
    mass = frame.density[fluid].astype(float) * particle_volume(case)
    along, upward = (float(mass @ frame.velocity[fluid, axis]) for axis in (0, up))
    return frame.time, along, upward, float(mass.sum() * gravity_vector(case)[0])


def momentum_table(case: ResolvedCase, rows: list[Row]) -> Table:
    """Return the momentum of all frames, and what holds the flow back along x."""
    time, along, upward, weight = np.array(rows, dtype=float).T
    rate = np.gradient(along, time) if time.size > 1 else np.full(1, np.nan)
    up = "y" if case.dimension == 2 else "z"
    return {
        "time": time,
        "momentum_x": along,
        f"momentum_{up}": upward,
        "gravity_x": weight,
        "resistance_x": weight - rate,
    }


def momentum_head(dimension: int) -> list[str]:
    """Return what the columns of ``momentum.csv`` mean."""
    words = {"per_width": PER_WIDTH[dimension], "up": "y" if dimension == 2 else "z"}
    return [line.format(**words) for line in MOMENTUM_HEAD]
