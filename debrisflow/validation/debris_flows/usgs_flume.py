"""Release of 10 m3 into the debris-flow flume of the US Geological Survey, from the shipped case.

What was measured is known as means over about eight releases.  Such a mean passes 1 cm when the
first of them arrives: at 32 m its 0.023 m after 3.5 s, with a standard deviation of 0.065 m, are
one release that is 0.18 m deep and seven that are not there yet.  A computed front has no scatter,
and is compared by the mean arrival,

    t = integral of max(1 - h / h2, 0) dt, to when the front has passed

with the mean depth h2 of the half second behind the front.  The clock of the measurements starts
0.2 s before the gate is open, as those who computed them before have taken it (George & Iverson).

References
----------
Iverson, Logan, LaHusen & Berti 2010, doi:10.1029/2009JF001514.  George & Iverson 2014,
doi:10.1098/rspa.2013.0820; in the set-up of its computations beds of bumps have a friction angle of
40.7 degrees and smooth ones of 31 degrees.
"""

from __future__ import annotations

from math import radians, tan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.results.references import read_reference
from debrisflow.run.simulation import simulate
from debrisflow.validation.files import CASES
from debrisflow.validation.probed import series

Floats = NDArray[np.float64]
TABLES = {"sgm": "usgs_flume_sgm.csv", "sg_smooth": "usgs_flume_sg_smooth.csv"}
FULL_RATE = {  # s and m: first passage of 1 cm, and greatest mean, of the records at 100 Hz
    "sgm": {"h32": (3.47, 0.211), "h66": (6.88, 0.186), "h90": (10.48, 0.208)},
    "sg_smooth": {"h2": (0.91, 0.614), "h32": (3.54, 0.172), "h66": (6.02, 0.114)},
}
APART = 34.0  # m from the first of the two long sections to the second
SMOOTH = (f"walls.floor.friction.coefficient={tan(radians(31.0)):.4f}",)
CONCRETE = (*SMOOTH, "walls.floor.friction.turbulence=3450")
"""The smooth bed with the law of the wall, xi = g [ln(11 h / k_s) / kappa]^2, for h = 0.2 m and
concrete of k_s = 1 mm; on the bumps of 16 mm the fitted xi is that of k_s = 35 mm."""
GATE = 0.2  # s, from the start of the clock until the gate is open
END = 13.0  # s
SMOOTHED = 0.1  # s
SPACINGS = 0.1, 0.0667  # m


class Series(NamedTuple):
    """Times, s, and depths, m, (n,) float64 arrays."""

    time: Floats
    depth: Floats


class Station(NamedTuple):
    """What a section saw.

    Attributes
    ----------
    first, mean : float, s
        When the depth passed 1 cm for the first time, and the mean arrival.
    peak : float, m
        Greatest depth; of a run of a running mean over 0.1 s.
    deviation : float, m
        Standard deviation of the releases at the time of the peak; nan of a run.
    """

    first: float
    mean: float
    peak: float
    deviation: float = np.nan


def station(time: Floats, depth: Floats, deviation: Floats | None = None) -> Station:
    """Return what a section saw of depths at times."""
    wet, peak = np.flatnonzero(depth > 0.01), float(np.max(depth))
    if wet.size == 0:
        return Station(np.nan, np.nan, peak)
    half = time[np.argmax(depth > 0.5 * peak)]
    behind = (time > half + 0.1) & (time < half + 0.6)
    dry = np.clip(1.0 - depth / depth[behind].mean(), 0.0, 1.0)[time <= half + 0.1]
    mean = time[0] + np.trapezoid(dry, time[time <= half + 0.1])
    at = np.nan if deviation is None else float(deviation[np.argmax(depth)])
    return Station(float(time[wet[0]]), float(mean), peak, at)


def measured(sand: str) -> dict[str, Station]:
    """Return what was measured, by the names of the probes."""
    table = read_reference(CASES / "data" / TABLES[sand])
    found = {}
    for curve in table.curves:
        probe, depth = curve.split(".")[0], table.table[curve]
        band, known = table.band(curve), np.isfinite(depth)
        spread = None if band is None else 0.5 * (band[1] - band[0])[known]
        seen = station(table.table["time"][known], depth[known], spread)
        first, peak = FULL_RATE[sand][probe]
        found[probe] = seen._replace(first=first, peak=peak)
    return found


def run(changes: tuple[str, ...] = ()) -> dict[str, Station]:
    """Return what the sections of the shipped case saw, with changes as ``--set`` takes them.

    By the clock of the measurements.
    """
    return {probe: station(time + GATE, depth) for probe, (time, depth) in depths(changes).items()}


def depths(changes: tuple[str, ...] = ()) -> dict[str, Series]:
    """Return times since the gate is open and depths of a run, by the names of the probes."""
    case = load_case(CASES / "usgs_flume3d.toml", (f"time.end={END}", *changes))
    with TemporaryDirectory() as folder:
        simulate(case, Path(folder) / "run", threads=1)
        return depths_of(Path(folder) / "run")


def depths_of(folder: Path) -> dict[str, Series]:
    """Return the same of the folder of a run, running means over 0.1 s."""
    found = {}
    for path in sorted((folder / "probes").glob("h*.csv")):
        rows = series(path)
        wide = max(1, round(SMOOTHED / np.diff(rows["time"]).mean()))
        smooth = np.convolve(rows["filled_height"], np.full(wide, 1.0 / wide), "same")
        found[path.stem] = Series(rows["time"], smooth)
    return found


def front_speed(found: dict[str, Station]) -> float:
    """Return the mean speed of the front from 32 to 66 m, m/s."""
    return APART / (found["h66"].mean - found["h32"].mean)
