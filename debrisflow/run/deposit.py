"""The time series of the height of the deposit over the floor."""

from __future__ import annotations

from pathlib import Path

from debrisflow.run.measures import DepositProfile
from debrisflow.run.tables import Series
from debrisflow.space.plan_grid import FLOOR_WORDS, PLACE, PLACE_WORDS

COLUMNS = ("deposit_height", "flow_height", "concentration")
UNITS = {"time": "s", "x": "m", "y": "m", "deposit_height": "m", "flow_height": "m"}
HEAD = (
    "time: s",
    "{place}",
    "deposit_height: m over {floor},",
    "  along its normal; top of the particles that follow each other upward from the floor without",
    "  a gap of more than 1.5 spacings, are slower than output.rest_speed and, other than mixture,",
    "  see a sediment concentration of 0.3 or more",
    "flow_height: m over the same floor; top of the particles with n >= 0.5 n0 that follow each",
    "  other upward without a gap of more than 1.5 spacings; from the lowest on where that is more",
    "  than a spacing over the floor, as in a jet",
    "concentration: volume share of sediment in them; nan where there is nothing",
)


class DepositWriter(Series):
    """Writes ``deposit.csv``; a file that is there already is continued.

    Parameters
    ----------
    path : Path
    dimension : int
        In three dimensions the place of a row is x and y.
    """

    def __init__(self, path: Path, dimension: int) -> None:
        words = {"place": PLACE_WORDS[dimension], "floor": FLOOR_WORDS[dimension]}
        head = [line.format(**words) for line in HEAD]
        super().__init__(path, ("time", *PLACE[dimension], *COLUMNS), head)

    def write(self, time: float, profile: DepositProfile) -> None:
        """Append the rows of a profile at a time, s."""
        values = (getattr(profile, name) for name in self.columns[1:])
        self.append((time, *map(float, row)) for row in zip(*values, strict=True))
