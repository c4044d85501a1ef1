"""The summary of a run at its end."""

from __future__ import annotations

import platform
from importlib.metadata import version
from typing import Any

from debrisflow._jit import THREADING_LAYER
from debrisflow.case import ResolvedCase
from debrisflow.particles.state import PHASES, State
from debrisflow.run import ledger
from debrisflow.run.events import COMPILING
from debrisflow.run.measures import energies, particle_volume
from debrisflow.run.progress import Progress


def summary(
    case: ResolvedCase,
    state: State,
    reason: str,
    threads: int,
    progress: Progress,
) -> dict[str, Any]:
    """Return the contents of ``summary.json``.

    ``wall_seconds`` excludes the time in which kernels were compiled, ``compile_seconds``; the
    phases of ``wall_seconds_by_phase`` add up to both together.  Rates are without start-up.

    Parameters
    ----------
    case : ResolvedCase
    state : State
        At the end.
    reason : str
        Why the run ended.
    threads : int
    progress : Progress
    """
    phases, seconds = progress.phases(), progress.seconds
    compiling = phases[COMPILING]
    ways = {
        "entered": (state.entered, state.entered_sediment),
        "left": (state.left, state.left_sediment),
        "through_wall": (state.through_wall, state.through_wall_sediment),
    }
    volume = particle_volume(case)
    return {
        "title": case.title,
        "end_reason": reason,
        "time": state.time,
        "steps": state.step,
        "wall_seconds": sum(phases.values()) - compiling,
        "compile_seconds": compiling,
        "wall_seconds_by_phase": phases,
        "particle_steps_per_second": progress.particle_steps / seconds,
        "seconds_per_step": seconds / max(1, progress.steps),
        "threads": threads,
        "threading_layer": THREADING_LAYER,
        "particles": state.particles.count,
        **{
            way: dict(zip(PHASES, number.tolist(), strict=True))
            for way, (number, _) in ways.items()
        },
        "sediment_volume": {
            way: float(sediment.sum()) * volume for way, (_, sediment) in ways.items()
        },
        **_ledger(case, state),
        **_energy(case, state),
        **_guard(case, state),
        "versions": {"python": platform.python_version()}
        | {name: version(name) for name in ("debrisflow", "numpy", "numba", "scipy")},
    }


def _ledger(case: ResolvedCase, state: State) -> dict[str, dict[str, float]]:
    """Return what was released on a terrain and where it is, as the last row of the ledger."""
    if not case.is_terrain:
        return {}
    row = dict(zip(ledger.COLUMNS, ledger.ledger_row(case, state), strict=True))
    return {"ledger": {name: float(row[name]) for name in ledger.COLUMNS[1:]}}


def _energy(case: ResolvedCase, state: State) -> dict[str, float]:
    """Return which share of its greatest value the kinetic energy has, where a rule asks for it."""
    if case.time.stop_energy is None:
        return {}
    p, fluid = state.particles, state.particles.fluid
    motion = p.position[fluid], p.velocity[fluid]
    kinetic = energies(case, *motion, p.density[fluid], p.kind[fluid]).kinetic
    return {"energy_share": kinetic / state.peak_energy if state.peak_energy > 0.0 else 0.0}


def _guard(case: ResolvedCase, state: State) -> dict[str, float]:
    """Return which share of the fluid particles bounced off a wall in a step, on the mean.

    Pressure is to keep them off walls as surfaces.  The impulse of a bounce is in the forces on
    walls, but in no pressure.
    """
    if not case.has_surfaces:
        return {}
    return {"bounced_share": state.bounces / max(1, state.particle_steps)}
