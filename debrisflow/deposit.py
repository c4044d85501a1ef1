"""The deposit series: how high the deposit stands along the bed, in time."""

from __future__ import annotations

from pathlib import Path

from debrisflow.measures import DepositProfile
from debrisflow.series import Series

COLUMNS = ("time", "x", "deposit_height", "flow_height", "concentration")
HEAD = (
    "time: s",
    "x: m, along the bed; middle of a bin 2 spacings wide",
    "deposit_height: m above the fixed floor (under a bed: the bottom of its recess), along its",
    "  normal; top of the particles that follow each other upward from the floor without a gap",
    "  of more than 1.5 spacings, are slower than output.rest_speed and, other than mixture,",
    "  see a sediment concentration of 0.3 or more",
    "flow_height: m above the fixed floor; top of the highest particle with n >= 0.5 n0",
    "concentration: volume share of sediment up to flow_height; nan where there is nothing",
)


class DepositWriter(Series):
    """Writes ``deposit.csv``; a file that is there already is continued.

    Parameters
    ----------
    path : Path
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, COLUMNS, HEAD)

    def write(self, time: float, profile: DepositProfile) -> None:
        """Append the rows of a profile at a time, s."""
        self.append((time, *map(float, row)) for row in zip(*profile, strict=True))
