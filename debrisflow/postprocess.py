"""Reads a finished or running run: fronts, profiles across the flow, the last deposit."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyvista
from numpy.typing import NDArray

from debrisflow.case import load_case, tables
from debrisflow.case.probes import SectionProbe
from debrisflow.errors import OutputError
from debrisflow.geometry import floor_bend, height_over_floor
from debrisflow.grid import (
    FLOOR_WORDS,
    PLACE,
    PLACE_WORDS,
    floor_length,
    floor_level,
    plan,
    wrapped,
)
from debrisflow.lattice import reference
from debrisflow.measures import deposit_profile, fronts, is_fluid
from debrisflow.output import CASE, DERIVED, FRAMES, POSTPROCESS, PROBES
from debrisflow.series import Row, write_table
from debrisflow.state import PHASES
from debrisflow.vtu import read_collection

Floats = NDArray[np.float64]
FRONT_HEAD = (
    "time: s",
    "front_*: m; the x behind which 99.5 % of the volume lies that is faster than",
    "  output.rest_speed; nan if nothing is",
    "speed_*: m/s; speed of that front, by central differences between the frames",
)
UP = {2: "y", 3: "z"}
PROFILES_HEAD = (
    "time: s; station: m, x along the bed; averages over one spacing to either side of it{across}",
    "  and over layers one spacing thick; layers without particles are left out",
    "{up}: m, middle of the layer above the fixed floor (under a bed: the bottom of its recess),",
    "  along its normal",
    "velocity: m/s, mean of the component along the floor",
    "concentration: mean of the sediment concentrations that the particles see",
    "samples: particles in the mean",
)
ACROSS = {2: "", 3: ", over the width"}
DEPOSIT_HEAD = (
    "the deposit in the last frame, time = {time!r} s",
    "{place}",
    "floor_level: m, of {floor}",
    "deposit_height, flow_height: m above it along its normal; concentration: volume share of",
    "  sediment up to flow_height; all as in deposit.csv, where their definitions stand",
)


class Frame(NamedTuple):
    """The particles of one file.

    Attributes
    ----------
    time : float
        In s.
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array
    concentration, sediment_fraction, number_density : (n,) array
    """

    time: float
    position: Floats
    velocity: Floats
    kind: NDArray[np.integer]
    concentration: Floats
    sediment_fraction: Floats
    number_density: Floats


def postprocess(folder: Path, stations: Sequence[float] | None = None) -> list[Path]:
    """Measure the frames of a run and write the tables into its folder ``postprocess``.

    Parameters
    ----------
    folder : Path
        Folder of a finished or running run.
    stations : sequence of float, optional
        x of the profiles, m; every eighth of the length if left out.

    Returns
    -------
    list of Path
        ``front.csv``, ``profiles.csv`` and ``deposit_profile.csv``.

    Raises
    ------
    OutputError
        If the folder holds no run, or a frame is missing or damaged.
    """
    if not (folder / CASE).is_file():
        raise OutputError(f"{folder} is no run folder: it holds no {CASE}")
    case = load_case(folder / CASE)
    if stations is None:
        stations = [k * floor_length(case) / 8.0 for k in range(1, 8)]

    front_rows: list[Row] = []
    profile_rows: list[Row] = []
    for frame in read_frames(folder):
        x = fronts(case, frame.position, frame.velocity, frame.kind)
        front_rows.append((frame.time, *x.values()))
        profile_rows.extend(profiles(case, frame, stations))

    target = folder / POSTPROCESS
    front, profile, deposit = (target / name for name in DERIVED)
    names = (*PHASES, "all")
    write_table(
        front,
        ("time", *(f"front_{n}" for n in names), *(f"speed_{n}" for n in names)),
        FRONT_HEAD,
        _with_speeds(front_rows),
    )
    write_table(
        profile,
        ("time", "station", UP[case.dimension], "velocity", "concentration", "samples"),
        [s.format(up=UP[case.dimension], across=ACROSS[case.dimension]) for s in PROFILES_HEAD],
        profile_rows,
    )
    _write_deposit(deposit, case, frame)
    return [front, profile, deposit]


def arrivals(folder: Path) -> dict[str, float]:
    """Return when the first particles had passed each section probe of a run, s.

    The first sample with more gone through than back, so late by less than the probe's interval
    and a step; nan if there is none.

    Parameters
    ----------
    folder : Path
        Folder of a finished or running run.
    """
    found = {}
    for probe in load_case(folder / CASE).probe:
        if isinstance(probe, SectionProbe):
            with (folder / PROBES / f"{probe.name}.csv").open(encoding="utf-8") as file:
                rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
            passed = (float(row["time"]) for row in rows if float(row["volume"]) > 0.0)
            found[probe.name] = next(passed, np.nan)
    return found


def read_frames(folder: Path) -> Iterator[Frame]:
    """Yield the frames of a run in the order of time.

    Raises
    ------
    OutputError
        If there are none, or one is missing or damaged.
    """
    collection = folder / FRAMES
    listed = read_collection(collection) if collection.is_file() else []
    if not listed:
        raise OutputError(f"{folder} holds no frames yet: {FRAMES} is missing or lists none")
    for time, file in listed:
        yield _read_frame(time, file)


def _read_frame(time: float, file: Path) -> Frame:
    # VTK prints its own lines on a file that was cut off, so that is found out before
    if not file.is_file():
        raise OutputError(f"{file} is missing, although {FRAMES} lists it")
    with file.open("rb") as stream:
        stream.seek(max(0, file.stat().st_size - 64))
        if b"</VTKFile>" not in stream.read():
            raise OutputError(f"{file} is damaged: it is cut off before its end")
    try:
        catcher = pyvista.VtkErrorCatcher(raise_errors=True, send_to_logging=False)
        with warnings.catch_warnings(), catcher:
            warnings.simplefilter("ignore")  # pyvista warns of what the catcher raises
            mesh = pyvista.read(file)
        arrays = {name: np.asarray(mesh.point_data[name]) for name in Frame._fields[2:]}
        return Frame(time, np.asarray(mesh.points), **arrays)
    except (RuntimeError, KeyError, ValueError) as error:
        raise OutputError(f"{file} is damaged: VTK cannot read its arrays") from error


def profiles(case: tables.Case, frame: Frame, stations: Iterable[float]) -> Iterator[Row]:
    """Yield the velocity and concentration profile at each station, a row a layer.

    A layer is d0 thick and 2 d0 long; one without particles is left out.  In three dimensions it
    reaches across the whole width, and its height is over the floor, also beside an obstacle.

    Parameters
    ----------
    case : Case
    frame : Frame
    stations : iterable of float
        x, m.

    Yields
    ------
    tuple
        time, s; station, m; height above the fixed floor along its normal, m; mean velocity along
        the floor, m/s; mean concentration; number of particles.
    """
    d0, up = case.particles.spacing, case.dimension - 1
    x = wrapped(case, frame.position)[:, 0]
    fluid = is_fluid(frame.kind)
    for station in stations:
        at = np.full(1, station)
        height = height_over_floor(case, x, frame.position[:, up], at)
        along = np.array([*np.cos(floor_bend(case, at)), *np.sin(floor_bend(case, at))])
        here = fluid & (x >= station - d0) & (x < station + d0) & (height > 0.0)
        layer = (height[here] / d0).astype(int)
        count = np.bincount(layer)
        velocity = np.bincount(layer, frame.velocity[here][:, [0, up]] @ along)
        concentration = np.bincount(layer, frame.concentration[here])
        for j in np.flatnonzero(count):
            means = float(velocity[j] / count[j]), float(concentration[j] / count[j])
            yield frame.time, station, (j + 0.5) * d0, *means, int(count[j])


def _with_speeds(rows: list[Row]) -> list[Row]:
    if len(rows) < 2:
        return [(*row, *[np.nan] * (len(row) - 1)) for row in rows]
    table = np.array(rows, dtype=float)
    speed = np.gradient(table[:, 1:], table[:, 0], axis=0)
    return [tuple(map(float, row)) for row in np.hstack([table, speed])]


def _write_deposit(path: Path, case: tables.Case, frame: Frame) -> None:
    n0 = reference(
        case.dimension, case.particles.effective_radius, case.particles.spacing
    ).number_density
    profile = deposit_profile(case, *frame[1:], reference_number_density=n0)
    place = PLACE[case.dimension]
    words = {"place": PLACE_WORDS[case.dimension], "floor": FLOOR_WORDS[case.dimension]}
    head = [line.format(time=frame.time, **words) for line in DEPOSIT_HEAD]
    columns = [getattr(profile, axis) for axis in place]
    columns += [floor_level(case, plan(case)), *profile[2:]]
    names = (*place, "floor_level", "deposit_height", "flow_height", "concentration")
    rows = ([float(v) for v in row] for row in zip(*columns, strict=True))
    write_table(path, names, head, rows)
