"""The folder of a run and its files."""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, dump_case
from debrisflow.case.content import content_of, digest_of
from debrisflow.errors import OutputError, shown
from debrisflow.particles.state import State
from debrisflow.run.atomic import UNFINISHED, replaced
from debrisflow.run.checkpoint import Checkpoints
from debrisflow.run.deposit import DepositWriter
from debrisflow.run.grid_file import grid_files
from debrisflow.run.history import HistoryWriter
from debrisflow.run.layers import FOLDER as LAYERS
from debrisflow.run.layers import DepthFrames, Origin, layer_files, write_layers
from debrisflow.run.ledger import LedgerWriter
from debrisflow.run.maxima import write_maxima
from debrisflow.run.measures import DepositProfile
from debrisflow.run.names import (
    CASE,
    CHECKPOINT,
    CHECKPOINT_BEFORE,
    DEPOSIT,
    FAILURE,
    FRAMES,
    HISTORY,
    LEDGER,
    LOG,
    MAPS,
    MAXIMA,
    PICTURES,
    POSTPROCESS,
    PROBES,
    STATUS,
    SUMMARY,
    SURFACES,
)
from debrisflow.run.probe import ProbeOutput, is_probe_file
from debrisflow.run.probes import sampler_of
from debrisflow.run.refusals import refused
from debrisflow.run.summary_file import checked_summary
from debrisflow.run.tables import Row, Series
from debrisflow.run.vtu import FOLDER, Collection, write_particles
from debrisflow.run.walls_file import OBSTACLES, WALLS, write_obstacles, write_walls
from debrisflow.space.ground import ground_of
from debrisflow.space.released import released_depth
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]

RESULTS = (
    CASE,
    FRAMES,
    WALLS,
    OBSTACLES,
    DEPOSIT,
    HISTORY,
    LEDGER,
    MAXIMA,
    SUMMARY,
    LOG,
    STATUS,
    CHECKPOINT,
    CHECKPOINT_BEFORE,
    FAILURE,
)
MOVING = Path(OBSTACLES).stem  # folder of the obstacles that move
DERIVED = (
    "answers.csv",
    "budget.csv",
    "deposit_profile.csv",
    "distances.csv",
    "front.csv",
    "hydrographs.csv",
    "mean_profiles.csv",
    "momentum.csv",
    "probes.csv",
    "profiles.csv",
    "stations.csv",
    "budget.png",
    "deposit.png",
    "flow.png",
    "front.png",
    "grids.png",
    "hydrographs.png",
    "lines.png",
    "maxima.png",
    "normalized_profiles.png",
    "probes.png",
    "profiles.png",
    "report.html",
    "score.csv",
    "score.png",
    SURFACES,
)


class _LogFile(logging.FileHandler):
    """The log of a run; a message that cannot be written, as on a full disk, ends no run."""

    # not in the style of names here: logging calls it by this name
    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802
        """Drop a message; that the disk is full is told by the results."""

    def close(self) -> None:
        """Close the file."""
        with suppress(OSError):
            super().close()


class _Lines(logging.Formatter):
    """Formats messages so that no name in one looks like another message or steers a terminal."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a message whose further lines are indented."""
        return shown(super().format(record)).replace("\n", "\n  ")


class RunFolder:
    """The folder that holds the case, the results and the checkpoint of one run.

    While it is open, messages logged by the package are written into its ``run.log``.

    Parameters
    ----------
    path : Path
        An existing folder; see :meth:`create` and :meth:`open`.
    case : ResolvedCase

    Attributes
    ----------
    path : Path
    case : ResolvedCase
    content : dict
        Of the case and its files as they are when the run begins or goes on.
    checkpoints : Checkpoints
    log : logging.Logger
        Logger of the package.
    """

    def __init__(self, path: Path, case: ResolvedCase) -> None:
        self.path, self.case = path, case
        self.checkpoints = Checkpoints(path)
        self.content = content_of(case)
        self._frames = Collection(path / FRAMES)
        self._obstacles: Collection | None = None
        if trajectories(case):
            self._obstacles = Collection(path / OBSTACLES, MOVING, "vtp")
        self._deposit = DepositWriter(path / DEPOSIT, case.dimension)
        self._history = HistoryWriter(path / HISTORY, case.dimension)
        self._ledger = LedgerWriter(path / LEDGER) if case.is_terrain else None
        self._depths: DepthFrames | None = None
        if case.is_terrain and case.output.layer_interval is not None:
            self._depths = DepthFrames(path / LAYERS, ground_of(case).grid)
        if case.probe:
            (path / PROBES).mkdir(exist_ok=True)
        self._probes = {
            probe.name: sampler_of(probe.type).writer(path / PROBES, probe, case.dimension)
            for probe in case.probe
        }
        self.log = logging.getLogger("debrisflow")
        if self.log.level == logging.NOTSET:
            self.log.setLevel(logging.INFO)
        self._handler = _LogFile(path / LOG, encoding="utf-8")
        self._handler.setFormatter(_Lines("%(asctime)s %(levelname)s %(message)s"))
        self.log.addHandler(self._handler)

    @classmethod
    def create(cls, path: Path, case: ResolvedCase, overwrite: bool = False) -> Self:
        """Return a new folder for a case; the case is written into it with all defaults.

        Parameters
        ----------
        path : Path
            Created if it does not exist; other files in it are left alone.
        case : Case
        overwrite : bool
            Remove the results that the folder holds; otherwise they are an error.

        Raises
        ------
        OutputError
            If the folder holds results, or cannot be written.
        """
        try:
            path.mkdir(parents=True, exist_ok=True)
            _clear(path, overwrite)
            (path / LOG).touch()  # so that a case alone is never one of a run
            _write_case(path, case)  # the first file, so that any other results can be gone on with
            return cls(path, case)
        except OSError as error:
            raise refused(path, error) from error

    @classmethod
    def open(cls, path: Path, case: ResolvedCase) -> Self:
        """Return the folder of an earlier run of a case, to be continued.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        begun = any((path / name).exists() for name in (CHECKPOINT, CHECKPOINT_BEFORE))
        results = (FRAMES, DEPOSIT, HISTORY)
        missing = [name for name in results if begun and not (path / name).exists()]
        try:
            folder = cls(path, case)
        except OSError as error:
            raise refused(path, error) from error
        for name in missing:
            folder.log.warning("%s is missing: it begins anew at the checkpoint", path / name)
        return folder

    def write_case(self) -> None:
        """Write the case with all its defaults."""
        _write_case(self.path, self.case)

    def write_frame(self, state: State) -> None:
        """Write the particles as the next frame, and the maxima until then.

        Walls are written once, into a file of their own, as surfaces; with the frames where they
        are particles in two dimensions.
        """
        p = state.particles
        rows = slice(None)
        if not (self.path / WALLS).exists():
            write_walls(self.path / WALLS, self.case)
        if self.case.dimension == 3:
            rows = slice(0, p.inflow.stop)
        self._frames.append(state.time, lambda file: write_particles(file, p, rows))
        if self._obstacles is not None:
            time = state.time
            self._obstacles.append(time, lambda file: write_obstacles(file, self.case, time))
        self.write_maxima(state)

    def write_failed(self, state: State) -> Path:
        """Write all particles of a state that failed, and return the file."""
        path = self.path / FAILURE
        write_particles(path, state.particles)
        return path

    def write_maxima(self, state: State) -> None:
        """Write the maxima of the run up to the time of the state; a terrain has layers instead."""
        if not self.case.is_terrain:
            write_maxima(self.path / MAXIMA, self.case, state.time, state.maxima)

    def write_layers(self, state: State, deposit: Floats, depth: Floats) -> None:
        """Write the layers of a map up to the time of the state.

        Parameters
        ----------
        state : State
        deposit, depth : (columns, rows) float64 array, m
            Of what lies at rest, and of all fluid.
        """
        ground = ground_of(self.case)
        others = {
            "deposit": deposit,
            "final_depth": depth,
            "terrain": ground.given + self.case.terrain.origin[2],
            "release": released_depth(self.case),
        }
        for name in ("deposit", "final_depth", "release"):
            others[name] = np.where(others[name] > 0.0, others[name], np.nan)
        write_layers(
            self.path / LAYERS, ground.grid, state.layers, others, self._origin(state.time)
        )

    def write_depth(self, time: float, depth: Floats) -> None:
        """Write the depth at a time, s, (columns, rows) array, m, as a raster."""
        if self._depths is not None:
            self._depths.write(depth, self._origin(time))

    def _origin(self, time: float) -> Origin:
        case = self.case
        return Origin(
            digest_of(self.content), case.particles.spacing, case.output.layer_depth, time
        )

    def write_deposit(self, time: float, profile: DepositProfile) -> None:
        """Append a deposit profile at a time, s."""
        self._deposit.write(time, profile)

    def write_history(self, row: Mapping[str, float | int]) -> None:
        """Append a row of :func:`debrisflow.run.history.history_row`."""
        self._history.write(row)

    def write_ledger(self, row: Row) -> None:
        """Append a row of :func:`debrisflow.run.ledger.ledger_row`."""
        if self._ledger is not None:
            self._ledger.write(row)

    def write_probe(self, name: str, time: float, rows: Iterable[Row]) -> None:
        """Append the rows of a sample of a probe at a time, s."""
        self._probes[name].write(time, rows)

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write the summary of a run that has ended."""
        with replaced(self.path / SUMMARY) as unfinished:
            unfinished.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")

    def flush(self) -> None:
        """Bring all tables to the disk, so that they are not behind a checkpoint saved next."""
        for table in self._tables():
            table.flush()

    def rewind(self, time: float) -> None:
        """Remove rows and frames later than a time, s, and the summary of an earlier end."""
        self._frames.drop_after(time)
        if self._obstacles is not None:
            self._obstacles.drop_after(time)
        for table in self._tables():
            table.truncate_after(time)
        for name in (MAXIMA, SUMMARY, FAILURE):
            (self.path / name).unlink(missing_ok=True)

    def detach_log(self) -> None:
        """Stop writing log messages into this folder."""
        self.log.removeHandler(self._handler)
        self._handler.close()

    def close(self) -> None:
        """Close all files."""
        for table in self._tables():
            table.close()
        self.detach_log()

    def _tables(self) -> list[Series | DepthFrames | ProbeOutput]:
        tables = [self._deposit, self._history, self._ledger, self._depths, *self._probes.values()]
        return [table for table in tables if table is not None]

    def __enter__(self) -> Self:
        """Return the folder itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close all files."""
        self.close()


def _write_case(path: Path, case: ResolvedCase) -> None:
    with replaced(path / CASE) as unfinished:
        unfinished.write_text(dump_case(case), encoding="utf-8")


def _results(path: Path) -> Iterator[Path]:
    """Yield the files in a folder that a run has written, including unfinished ones."""
    tables_and_logs = [path / name for name in RESULTS]
    probes = [file for file in path.glob(f"{PROBES}/*.csv") if is_probe_file(file)]
    probes += [*grid_files(path / PROBES), *layer_files(path / LAYERS)]
    derived = [path / POSTPROCESS / name for name in DERIVED]
    for file in (*tables_and_logs, *probes, *derived):
        for written in (file, file.with_name(file.name + UNFINISHED)):
            if written.is_file():
                yield written
    for folder, name in (
        (FOLDER, r"\d{6,}\.vtu"),
        (MOVING, r"\d{6,}\.vtp"),
        (PICTURES, r"(side|plan|perspective)_\w+\.(png|gif)"),
        (MAPS, r"\w+\.png"),
        (f"{POSTPROCESS}/{Path(SURFACES).stem}", r"\d{6,}\.vtp"),
        (POSTPROCESS, r"class_.+\.(tif|asc|prj|qml|geojson|csv)"),
    ):
        ours = re.compile(f"{name}({re.escape(UNFINISHED)})?")
        yield from (file for file in path.glob(f"{folder}/*") if ours.fullmatch(file.name))


def _clear(path: Path, overwrite: bool) -> None:
    results = list(_results(path))
    whole = [file for file in results if file.suffix != UNFINISHED]
    if [file.name for file in whole] == [LOG]:
        return  # of a run that was stopped before it began; its log is continued
    if [file.name for file in whole] == [CASE]:
        # a run never leaves a case alone, so this is the user's own file, with comments to be kept
        raise OutputError(
            f"{path} holds a {CASE} that no run wrote, and results would replace it; "
            "choose another folder"
        )
    if whole and not overwrite:
        raise OutputError(
            f"{path} holds results ({whole[0].name}); "
            "choose another folder, replace them with --overwrite, or go on with a run that was "
            f"stopped: debrisflow resume {path}"
        )
    for file in results:
        file.unlink()
    folders = {file.parent for file in results} | {
        path / name for name in (FOLDER, MOVING, LAYERS, PROBES, POSTPROCESS, PICTURES, MAPS)
    }
    for folder in sorted(folders - {path}, reverse=True):  # those inside others first
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def read_summary(folder: Path) -> dict[str, Any]:
    """Return what a run said of itself at its end; empty while it is running.

    Raises
    ------
    OutputError
        If the file is damaged, or a value in it is of another kind than a run writes.
    """
    return checked_summary(folder / SUMMARY)
