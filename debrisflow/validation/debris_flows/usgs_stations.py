"""What was measured at the sections of the debris-flow flume of the US Geological Survey.

What was measured is known as means over about eight releases.  Such a mean passes 1 cm when the
first of them arrives: at 32 m its 0.023 m after 3.5 s, with a standard deviation of 0.065 m, are
one release that is 0.18 m deep and seven that are not there yet.  A computed front has no scatter,
and is compared by the mean arrival,

    t = integral of max(1 - h / h2, 0) dt, to when the front has passed

with the mean depth h2 of the half second behind the front.

References
----------
Iverson, Logan, LaHusen & Berti 2010, doi:10.1029/2009JF001514.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.results.references import Reference, read_reference
from debrisflow.validation.files import CASES

Floats = NDArray[np.float64]
TABLES = {"sgm": "usgs_flume_sgm.csv", "sg_smooth": "usgs_flume_sg_smooth.csv"}
FULL_RATE = {
    "sgm": {"h32": (3.47, 0.211), "h66": (6.88, 0.186), "h90": (10.48, 0.208)},
    "sg_smooth": {"h2": (0.91, 0.614), "h32": (3.54, 0.172), "h66": (6.02, 0.114)},
}
"""First passage of 1 cm, s, and greatest mean, m, of the records at 100 Hz."""


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


def experiment(sand: str) -> Reference:
    """Return the measured table of the rough bed, ``sgm``, or the smooth one, ``sg_smooth``."""
    return read_reference(CASES / "data" / TABLES[sand])


def stations(sand: str) -> dict[str, Station]:
    """Return what was measured, by the names of the probes."""
    table = experiment(sand)
    found = {}
    for curve in table.curves:
        probe, depth = curve.split(".")[0], table.table[curve]
        band, known = table.band(curve), np.isfinite(depth)
        spread = None if band is None else 0.5 * (band[1] - band[0])[known]
        seen = station(table.table["time"][known], depth[known], spread)
        first, peak = FULL_RATE[sand][probe]
        found[probe] = seen._replace(first=first, peak=peak)
    return found
