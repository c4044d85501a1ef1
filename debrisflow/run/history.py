"""The history of a run: a row of totals at each output time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.lattice import Reference
from debrisflow.particles.state import PHASES, State
from debrisflow.run.measures import elastic_energy, energies, fronts, mass, particle_volume
from debrisflow.run.tables import Series

WAYS = ("in", "out", "inside", "through_wall")
COLUMNS = (
    "time",
    "step",
    "dt",
    "ppe_iterations",
    *(f"particles_{way}_{phase}" for way in WAYS for phase in PHASES),
    *(f"mass_{way}_{phase}" for way in WAYS for phase in PHASES),
    *(f"sediment_volume_{way}" for way in WAYS),
    *(f"front_{phase}" for phase in (*PHASES, "all")),
    "kinetic_energy",
    "potential_energy",
    "elastic_energy",
    "maximal_speed",
    "least_density_ratio",
    "greatest_density_ratio",
)
HEAD = (
    "time, dt: s; time is negative while the fills settle before the start",
    "ppe_iterations: iterations of the last step's pressure equation; 0 in the explicit scheme",
    "particles_*: count since the start of the run; in through the inflow, out over an open end",
    "  or a rim, inside now, through_wall lost through a wall",
    "mass_*: kg{per_width}, of the same particles",
    "sediment_volume_*: m3{per_width}, in these particles",
    "front_*: m; the x behind which 99.5 % of the volume lies that is faster than",
    "  output.rest_speed; fluid counts as behind it where it stood at t = 0 and the flow is not",
    "  more than half a spacing deeper; nan if nothing has come farther; on a terrain the distance",
    "  in plan from the middle of the first release instead of x",
    "kinetic_energy, potential_energy, elastic_energy: J{per_width}; potential energy is 0 at the",
    "  origin; elastic is that of the compression in the explicit scheme",
    "maximal_speed: m/s",
    "least_density_ratio, greatest_density_ratio: n/n0 of the fluid particles",
)

PER_WIDTH = {2: " per meter of width", 3: ""}


def units(dimension: int) -> dict[str, str]:
    """Return the units of the columns; empty for a number without one."""
    per_width = PER_WIDTH[dimension]
    by_beginning = {
        "time": "s",
        "dt": "s",
        "mass": f"kg{per_width}",
        "sediment_volume": f"m3{per_width}",
        "front": "m",
        "kinetic_energy": f"J{per_width}",
        "potential_energy": f"J{per_width}",
        "elastic_energy": f"J{per_width}",
        "maximal_speed": "m/s",
    }
    found = dict.fromkeys(COLUMNS, "")
    for beginning, unit in by_beginning.items():
        found |= {name: unit for name in COLUMNS if name.startswith(beginning)}
    return found


def history_row(
    case: ResolvedCase,
    state: State,
    ppe_iterations: int,
    reference: Reference,
    reached: NDArray[np.bool_] | None = None,
) -> dict[str, float | int]:
    """Return the totals of a state, by the names in ``COLUMNS``; nan where there is no fluid.

    Parameters
    ----------
    case : ResolvedCase
    state : State
    ppe_iterations : int
        Iterations of the last pressure equation.
    reference : Reference
        Lattice constants, of which n0 is used.
    reached : (cells,) bool array, optional
        Over which cells of the plan the flow has come; over all if left out.
    """
    p, fluid = state.particles, state.particles.fluid
    motion = p.position[fluid], p.velocity[fluid]
    front = fronts(case, *motion, p.kind[fluid], reached)
    energy = energies(case, *motion, p.density[fluid], p.kind[fluid])
    ratio = p.number_density[fluid] / reference.number_density
    return {
        "time": state.time,
        "step": state.step,
        "dt": state.dt,
        "ppe_iterations": ppe_iterations,
        **_budget(case, state),
        **{f"front_{phase}": x for phase, x in front.items()},
        "kinetic_energy": energy.kinetic,
        "potential_energy": energy.potential,
        "elastic_energy": elastic_energy(
            case, p.density[fluid], p.kind[fluid], p.compression[fluid]
        ),
        "maximal_speed": float(np.linalg.norm(p.velocity[fluid], axis=1).max(initial=0.0)),
        "least_density_ratio": float(ratio.min()) if ratio.size else np.nan,
        "greatest_density_ratio": float(ratio.max()) if ratio.size else np.nan,
    }


def _budget(case: ResolvedCase, state: State) -> dict[str, float | int]:
    """Return particles and mass by way and phase, and the volume of sediment by way."""
    counts = {
        "in": (state.entered, state.entered_sediment),
        "out": (state.left, state.left_sediment),
        "inside": state.inside(),
        "through_wall": (state.through_wall, state.through_wall_sediment),
    }
    budget: dict[str, float | int] = {}
    for way in WAYS:
        number, sediment = counts[way]
        masses = mass(case, number, sediment)
        for k, phase in enumerate(PHASES):
            budget[f"particles_{way}_{phase}"] = int(number[k])
            budget[f"mass_{way}_{phase}"] = float(masses[k])
        budget[f"sediment_volume_{way}"] = float(sediment.sum()) * particle_volume(case)
    return budget


class HistoryWriter(Series):
    """Writes ``history.csv``; a file that is there already is continued.

    Parameters
    ----------
    path : Path
    dimension : int
        In two dimensions masses and energies are per meter of width.
    """

    def __init__(self, path: Path, dimension: int) -> None:
        head = [line.format(per_width=PER_WIDTH[dimension]) for line in HEAD]
        super().__init__(path, COLUMNS, head)

    def write(self, row: Mapping[str, float | int]) -> None:
        """Append a row, given by the names of its columns."""
        self.append([[row[name] for name in COLUMNS]])
