"""The folder of a finished or running run, opened to be read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, load_case
from debrisflow.case.probes import AnyProbe
from debrisflow.case.probes.grid import GridProbe
from debrisflow.case.probes.line import LineProbe
from debrisflow.errors import OutputError, shown
from debrisflow.particles.record import Particles
from debrisflow.particles.seeding import wall_particles
from debrisflow.results.data_table import DataTable
from debrisflow.results.frames import Frame, read_frame
from debrisflow.results.grids import read_grid
from debrisflow.results.surfaces import Surface, free_surface
from debrisflow.run import deposit, history, ledger, maxima
from debrisflow.run.folder import read_summary
from debrisflow.run.names import CASE, DEPOSIT, FRAMES, HISTORY, LEDGER, LOG, MAXIMA, PROBES
from debrisflow.run.own_files import must_be_own
from debrisflow.run.probes import columns_of
from debrisflow.run.reading import lines_of
from debrisflow.run.tables import Table, read_table, rows_where
from debrisflow.run.vtu import read_collection
from debrisflow.space.plan_grid import plan
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]
LEVELS = (" WARNING ", " ERROR ")  # in the log
MOST_WARNINGS = 200  # that are shown
# of a progress bar over frames
BAR = "{desc} {percentage:3.0f}% |{bar:20}| {n_fmt} of {total_fmt}, {remaining} left"


class Run:
    """The results of one run; tables and frames are read when they are asked for.

    Parameters
    ----------
    folder : Path

    Attributes
    ----------
    folder : Path
    case : ResolvedCase
        With every default resolved.
    """

    def __init__(self, folder: Path) -> None:
        if not (folder / CASE).is_file():
            raise OutputError(f"{folder} is no run folder: it holds no {CASE}")
        must_be_own(folder)
        self.folder = folder
        self.case: ResolvedCase = load_case(folder / CASE)

    @property
    def name(self) -> str:
        """Return the name of the folder."""
        return self.folder.resolve().name

    @cached_property
    def files(self) -> list[tuple[float, Path]]:
        """Return times, s, and files of the frames, those that were whole when this was read.

        Raises
        ------
        OutputError
            If there are none yet.
        """
        collection = self.folder / FRAMES
        listed = read_collection(collection) if collection.is_file() else []
        if not listed:
            raise OutputError(
                f"{self.folder} holds no frames yet: {FRAMES} is missing or lists none"
            )
        if any(after <= before for (before, _), (after, _) in pairwise(listed)):
            raise OutputError(f"{collection} is damaged: its times do not increase")
        return listed

    @property
    def times(self) -> Floats:
        """Return the times of the frames, (n,) array, s."""
        return np.array([time for time, _ in self.files])

    def frame(self, time: float = np.inf) -> Frame:
        """Return the frame that is nearest to a time, s; the last one by default.

        Raises
        ------
        OutputError
            If there is none near that time, as :meth:`nearest` says, or it is damaged.
        """
        number = len(self.files) - 1 if np.isinf(time) else self.nearest([time])[0]
        return read_frame(*self.files[number])

    def nearest(self, times: Iterable[float]) -> list[int]:
        """Return the numbers of the frames nearest to some times, s, without repetition.

        Raises
        ------
        OutputError
            If a time is before the first frame or past the last one by more than half an interval.
        """
        known = self.times
        slack = 0.5 * float(np.diff(known).max(initial=0.0)) + 1e-9
        for time in times:
            if not known[0] - slack <= time <= known[-1] + slack:
                raise OutputError(
                    f"there is no frame at t = {time:g} s: {self.folder} has {known.size} frames "
                    f"from {known[0]:g} to {known[-1]:g} s"
                )
        return sorted({int(np.argmin(np.abs(known - time))) for time in times})

    def frames(self) -> Iterator[Frame]:
        """Yield all frames in the order of time."""
        for time, file in self.files:
            yield read_frame(time, file)

    @cached_property
    def _walls(self) -> Particles:
        return wall_particles(self.case)

    def walls(self, time: float = 0.0) -> Floats:
        """Return places of particles by which the walls can be drawn at a time, s, (n, 3), m.

        Raises
        ------
        OutputError
            On a terrain, whose ground is a smooth surface.
        """
        if self.case.is_terrain:
            raise OutputError(
                f"{self.folder} is a run on a terrain, of which no free surface can be drawn yet; "
                "output.layer_interval keeps the depth at times as rasters"
            )
        position = self._walls.position.copy()
        for number, way in trajectories(self.case).items():
            own = self._walls.wall == number
            position[own] = way.pose(max(time, 0.0)).moved(position[own])
        return position

    def surface(self, time: float = np.inf) -> Surface:
        """Return the free surface in the frame nearest to a time, s; in the last one by default.

        See :func:`debrisflow.results.surfaces.free_surface`.
        """
        frame = self.frame(time)
        return free_surface(frame, self.case, self.walls(frame.time))

    @cached_property
    def history(self) -> DataTable:
        """Return ``history.csv``: a float64 array by column name, rows from t = 0 on."""
        table = _in_time(self.folder / HISTORY, history.COLUMNS)
        rows = rows_where(table, table["time"] >= 0.0)
        return DataTable(rows, history.units(self.case.dimension))

    @cached_property
    def ledger(self) -> DataTable:
        """Return ``ledger.csv`` of a run on a terrain: an array by column name, from t = 0 on."""
        table = _in_time(self.folder / LEDGER, ledger.COLUMNS)
        return DataTable(rows_where(table, table["time"] >= 0.0), ledger.UNITS)

    @cached_property
    def deposit(self) -> DataTable:
        """Return ``deposit.csv``: a float64 array by column name."""
        return DataTable(read_table(self.folder / DEPOSIT), deposit.UNITS)

    @cached_property
    def maxima(self) -> DataTable:
        """Return ``maxima.csv``: a float64 array by column name, a row a cell."""
        file = self.folder / MAXIMA
        table = read_table(file, needed=("x", *maxima.COLUMNS))
        cells = plan(self.case).x.size
        if table["x"].size != cells:
            raise OutputError(
                f"{file} is damaged: it has {table['x'].size} rows for {cells} cells of the plan"
            )
        return DataTable(table, maxima.UNITS)

    def probe(self, name: str) -> DataTable:
        """Return the samples of a probe: a float64 array by column name.

        Those of a line have a row for each time and point.

        Raises
        ------
        OutputError
            If the case has no probe of that name, or its file is missing or damaged.
        """
        probe, spacing = self._probe(name), self.case.particles.spacing
        if isinstance(probe, GridProbe):
            raise OutputError(f"the probe '{name}' is a grid; read it with: grid('{name}')")
        table = _in_time(self.folder / PROBES / f"{name}.csv", ("time",))
        if isinstance(probe, LineProbe):
            rows = np.arange(table["time"].size)
            whole = rows.size - rows.size % probe.count(spacing)  # others are still being written
            table = rows_where(table, rows < whole)
        columns = columns_of(probe, self.case.dimension)
        return DataTable(table, {"time": "s"} | {c.name: c.full_unit for c in columns})

    def grid(self, name: str) -> Table:
        """Return the samples of a probe on a grid, see :func:`debrisflow.results.grids.read_grid`.

        Raises
        ------
        OutputError
            If the case has no grid of that name, or a file is missing or damaged.
        """
        probe = self._probe(name)
        if not isinstance(probe, GridProbe):
            raise OutputError(f"the probe '{name}' is no grid; read it with: probe('{name}')")
        listing = self.folder / PROBES / f"{name}.pvd"
        return read_grid(listing, probe, self.case.particles.spacing)

    def _probe(self, name: str) -> AnyProbe:
        probes = {probe.name: probe for probe in self.case.probe}
        if name not in probes:
            there = f"but {', '.join(probes)}" if probes else "since its case has none"
            raise OutputError(f"{self.folder} has no probe '{name}', {there}")
        return probes[name]

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Return what the run said of itself at its end; empty while it is running."""
        return read_summary(self.folder)

    @cached_property
    def warnings(self) -> list[str]:
        """Return the messages of the warnings and errors in the log."""
        file = self.folder / LOG
        found: list[str] = []
        for line in lines_of(file) if file.exists() else ():
            level = next((level for level in LEVELS if level in line), None)
            if level is not None and len(found) == MOST_WARNINGS:
                return [*found, f"more than {MOST_WARNINGS} warnings are in {file.name}"]
            if level is not None:
                found.append(shown(line.split(level, 1)[1]))
        return found


def _in_time(file: Path, needed: Iterable[str]) -> Table:
    """Return a table whose first column, the time, must not decrease."""
    table = read_table(file, needed=needed)
    time = table["time"]
    if not np.isfinite(time).all() or np.any(np.diff(time) < 0.0):
        raise OutputError(f"{file} is damaged: its times do not increase")
    return table


def open_run(folder: Path | str) -> Run:
    """Return the results of a run folder.

    Parameters
    ----------
    folder : Path or str
        Of a finished run, or of one that is running.

    Raises
    ------
    OutputError
        If the folder holds no run.
    CaseError
        If its case cannot be read.
    """
    return Run(Path(folder))
