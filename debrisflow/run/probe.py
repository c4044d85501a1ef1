"""What the samplers of all probes share: columns, running sum and output file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probe import Probe
from debrisflow.neighbors.patches import Band, Patch
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.row_statistics import EXTREMES
from debrisflow.run.tables import Row, Series

Floats = NDArray[np.float64]
_TIME = "time: s; end of the step in which the sample was due"


class Column(NamedTuple):
    """One column of the file of a probe.

    Attributes
    ----------
    name : str
    unit : str
        Empty for a number without one.
    meaning : str
    reference : str
        Addition to the unit: ``per meter of width``, ``above the wall below``.
    """

    name: str
    unit: str
    meaning: str
    reference: str = ""

    @property
    def full_unit(self) -> str:
        """The unit, per meter of width where it is."""
        is_per = self.reference.startswith("per ")
        return f"{self.unit} {self.reference}" if is_per else self.unit

    @property
    def explanation(self) -> str:
        """The text in the head of the file."""
        unit = " ".join(filter(None, (self.unit, self.reference)))
        return "; ".join(filter(None, (unit, self.meaning)))


class Sampler:
    """Base of the classes that take the samples of a probe.

    A sampler reads the particles as they are after a step, in both schemes and in two and three
    dimensions, and leaves them as they are.  Quantities of two dimensions are per meter of width.

    Parameters
    ----------
    probe : Probe
        The table of the probe in the case.
    case : ResolvedCase
    particles : Particles
        At the start of the run or of its continuation; those by which walls are drawn if it reads
        walls in three dimensions.

    Attributes
    ----------
    sum_shape : tuple of int or None
        Shape of the running sum, a float64 array that starts at 0 and is kept in
        ``state.sums[probe.name]``; None for a probe without one.
    patches : sequence of Patch or Band
        The parts of walls whose forces it reads.
    patch_row : int
        The row of the first of them in ``state.patch_force``.
    averaged : tuple of str
        Columns that begin like one of these are means since the row before.
    has_many_points : bool
        Whether a sample has a row for each of many points, so that columns are no curves in time.
    """

    sum_shape: tuple[int, ...] | None = None
    patches: Sequence[Patch | Band] = ()
    patch_row = 0
    averaged: tuple[str, ...] = ()
    has_many_points = False

    def __init__(self, probe: Probe, case: ResolvedCase, particles: Particles) -> None:
        """Check the place of the probe; raise a CaseError if the run finds it wrong."""
        raise NotImplementedError

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """Return whether it looks for a place on the walls as particles draw them."""
        return False

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the columns after the time, in two or three dimensions."""
        raise NotImplementedError

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """Return the columns that plots and figures show; none if others show its samples."""
        return ()

    @classmethod
    def writer(cls, folder: Path, probe: Probe, dimension: int) -> ProbeOutput:
        """Return the file of its samples in the folder of the probes."""
        return ProbeWriter(folder / f"{probe.name}.csv", probe, cls.columns(dimension))

    def rows(self, state: State) -> Iterable[Row]:
        """Return the rows of a sample: one, unless it has many points."""
        return [self.sample(state)]

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the values of the columns."""
        raise NotImplementedError

    def add_step(self, state: State) -> None:
        """Add the last step to the running sum."""


def extreme_columns(columns: Sequence[Column]) -> list[Column]:
    """Return the columns of the least and greatest values of some columns, two for each.

    The values are those of single steps since the row before.
    """
    meaning = "least and greatest of the steps since the row before"
    return [
        Column(column.name + ending, column.unit, meaning, column.reference)
        for column in columns
        for ending in EXTREMES
    ]


def volume_unit(dimension: int) -> str:
    """Return the unit of a volume: m2, per meter of width, in two dimensions."""
    return f"m{dimension}"


class ProbeOutput(Protocol):
    """What writes the samples of a probe; files that are there already are continued."""

    def write(self, time: float, rows: Iterable[Row]) -> None:
        """Append the rows of a sample at a time, s."""

    def flush(self) -> None:
        """Bring what was written to the disk."""

    def truncate_after(self, time: float) -> None:
        """Remove the samples later than a time, s."""

    def close(self) -> None:
        """Close all files."""


class ProbeWriter(Series):
    """Writes ``probes/NAME.csv``; a file that is there already is continued.

    Parameters
    ----------
    path : Path
    probe : Probe
    columns : sequence of Column
        Those after the time.
    """

    def __init__(self, path: Path, probe: Probe, columns: Sequence[Column]) -> None:
        head = [_title(path, f"{probe.type}, {probe.where()} (m)"), _TIME, *_meanings(columns)]
        super().__init__(path, ("time", *(column.name for column in columns)), head)

    def write(self, time: float, rows: Iterable[Row]) -> None:
        """Append the rows of a sample at a time, s."""
        self.append((time, *map(float, row)) for row in rows)


def is_probe_file(path: Path) -> bool:
    """Return whether a file was written by a probe."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.readline().startswith("# " + _title(path, ""))


def _title(path: Path, rest: str) -> str:
    return f"probe {path.stem}: {rest}"


def _meanings(columns: Sequence[Column]) -> Iterator[str]:
    """Yield a line for each group of columns that have the same meaning."""
    for explanation, group in groupby(columns, lambda column: column.explanation):
        yield f"{', '.join(column.name for column in group)}: {explanation}"
