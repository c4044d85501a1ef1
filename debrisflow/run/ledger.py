"""The ledger of a run on a terrain: what was released, and where it is, to the particle."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.particles.state import State
from debrisflow.run.measures import particle_volume
from debrisflow.run.tables import Row, Series

COLUMNS = ("time", "released", "moving", "at_rest", "left", "through_ground", "volume_released")
UNITS = {"time": "s", "volume_released": "m3"}
PLACES = ("moving", "at_rest", "left", "through_ground")
"""Where what was released is."""
HEAD = (
    "time: s",
    "released: particles since the start; released = moving + at_rest + left + through_ground",
    "moving, at_rest: particles on the terrain, as fast as output.rest_speed or slower",
    "left: particles that went over an edge of the DEM or the top of the space, or onto cells "
    "without a level",
    "through_ground: particles that were lost through the ground or an obstacle",
    "volume_released: m3, of the particles released",
)


def ledger_row(case: ResolvedCase, state: State) -> Row:
    """Return the row of a state."""
    p = state.particles
    speed = np.linalg.norm(p.velocity[p.fluid], axis=1)
    rests = int(np.count_nonzero(speed < case.output.rest_speed))
    released = int(state.released.sum())
    return (
        state.time,
        released,
        p.fluid_count - rests,
        rests,
        int(state.left.sum()),
        int(state.through_wall.sum()),
        released * particle_volume(case),
    )


class LedgerWriter(Series):
    """Writes ``ledger.csv``; a file that is there already is continued."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, COLUMNS, HEAD)

    def write(self, row: Row) -> None:
        """Append a row."""
        self.append([row])
