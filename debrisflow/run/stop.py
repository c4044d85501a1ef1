"""The rule by which a run ends before its end time: when what flows has come to rest."""

from __future__ import annotations

from math import inf

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import UnsteadyInflow
from debrisflow.particles.releases import end_of, is_pending
from debrisflow.particles.state import State
from debrisflow.space.scene import trajectories


class StopRule:
    """Whether the kinetic energy has fallen below a share of its greatest value.

    Not before all that comes in or moves by a schedule has done so: until then a flow may be at
    rest and start again.

    Parameters
    ----------
    case : ResolvedCase
    """

    def __init__(self, case: ResolvedCase) -> None:
        self._case, self._share = case, case.time.stop_energy
        self._earliest = last_schedule(case) if self._share is not None else inf

    def is_met(self, state: State, energy: float) -> bool:
        """Return whether a run is to end at a kinetic energy, J; its greatest one is kept.

        What moves while fills settle does not count.
        """
        if self._share is None or state.time < 0.0:
            return False
        state.peak_energy = max(state.peak_energy, energy)
        falls, state.sampled_energy = energy < state.sampled_energy, energy
        if not falls or state.time <= self._earliest or is_pending(self._case, state):
            return False  # what has just been released starts at rest
        return energy < self._share * state.peak_energy


def last_schedule(case: ResolvedCase) -> float:
    """Return the time, s, after which nothing comes in or moves by a schedule.

    Infinite where a supply never ends.
    """
    times = [trajectory.end for trajectory in trajectories(case).values()]
    times += [end_of(release) for release in case.release]
    if case.inflow is not None:
        graph = case.inflow.hydrograph if isinstance(case.inflow, UnsteadyInflow) else None
        times.append(graph.time[-1] if graph and graph.discharge[-1] == 0.0 else inf)
    return max(times, default=0.0)
