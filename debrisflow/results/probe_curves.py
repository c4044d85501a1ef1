"""The samples of the probes of a run as curves: smoothed, with arrival, peaks, impulse and mean."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.probe import Probe
from debrisflow.results.reader import Run
from debrisflow.results.stations import flow_probes, is_within
from debrisflow.run.probes import columns_of, sampler_of

Floats = NDArray[np.float64]
SMOOTHED = 10  # intervals of a probe over which its curve is smoothed, unless told otherwise
ARRIVED = 0.05  # of the greatest change, by which something has arrived
LOADS = ("Pa", "N")


class ProbeCurve(NamedTuple):
    """One column of the samples of a probe.

    Attributes
    ----------
    probe, column, unit : str
    time, values, smooth : (n,) float64 array
        Samples, and their running mean.
    span : float, s
        Over which the mean runs.
    """

    probe: str
    column: str
    unit: str
    time: Floats
    values: Floats
    smooth: Floats
    span: float


class ProbeFigures(NamedTuple):
    """What a curve comes to, a row of ``probes.csv``; nan where it has no answer.

    Attributes
    ----------
    probe, column, unit : str
    arrival : float, s
        When the smooth curve has first changed by 5 % of its greatest change.
    peak, peak_time : float
        The sample of greatest magnitude, and its time, s.
    smooth_peak : float
        That of the smooth curve.
    impulse : float
        The integral over time, of pressures and forces.
    mean, scatter : float
        Mean and standard deviation of the samples within the window.
    """

    probe: str
    column: str
    unit: str
    arrival: float
    peak: float
    peak_time: float
    smooth_peak: float
    impulse: float
    mean: float
    scatter: float


COLUMNS = ProbeFigures._fields
HEAD = (
    "a row for each curve of a probe; those of sections are in answers.csv",
    "arrival: s, when the smooth curve has first changed by 5 % of its greatest change",
    "peak, peak_time: the sample of greatest magnitude, and its time in s; smooth_peak: of the",
    "  running mean over {span}",
    "impulse: integral over time, of pressures and forces, in the unit times s",
    "mean, scatter: mean and standard deviation of the samples from {start:g} to {end:g} s",
)


def smoothed(time: Floats, values: Floats, span: float) -> Floats:
    """Return the mean over a span of time around each sample, at the ends over what there is.

    Examples
    --------
    >>> smoothed(np.arange(5.0), np.array([0.0, 0.0, 4.0, 0.0, 0.0]), 2.0)
    array([0., 1., 2., 1., 0.])
    """
    if time.size < 2 or span <= 0.0:
        return values.copy()
    steps = np.diff(time)
    total = np.concatenate([[0.0], np.cumsum(0.5 * steps * (values[1:] + values[:-1]))])
    first = np.maximum(time - 0.5 * span, time[0])
    last = np.minimum(time + 0.5 * span, time[-1])
    ends = (_integral_to(at, time, values, total) for at in (first, last))
    before, after = ends
    return np.asarray((after - before) / (last - first))


def _integral_to(at: Floats, time: Floats, values: Floats, total: Floats) -> Floats:
    """Return the integral of the straight lines between the samples up to some times."""
    row = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    part = at - time[row]
    slope = (values[row + 1] - values[row]) / (time[row + 1] - time[row])
    return np.asarray(total[row] + part * (values[row] + 0.5 * slope * part))


def probe_curves(run: Run, span: float | None = None) -> list[ProbeCurve]:
    """Return the curves of the probes of a run, but those of sections, from t = 0 on.

    Parameters
    ----------
    run : Run
    span : float, s, optional
        Of the running mean; ten intervals of each probe if left out.

    Raises
    ------
    OutputError
        If the file of a probe is missing or damaged.
    """
    sections = {probe.name for probe in flow_probes(run.case)}
    shown = [probe for probe in run.case.probe if probe.name not in sections]
    return [curve for probe in shown for curve in _curves(run, probe, span)]


def _curves(run: Run, probe: Probe, span: float | None) -> list[ProbeCurve]:
    dimension, table = run.case.dimension, run.probe(probe.name)
    units = {column.name: column.unit for column in columns_of(probe, dimension)}
    found = []
    for name in sampler_of(probe.type).headline(dimension):
        known = (table["time"] >= 0.0) & ~np.isnan(table[name])
        time, values = table["time"][known], table[name][known]
        over = SMOOTHED * probe.interval if span is None else span
        if time.size:
            smooth = smoothed(time, values, over)
            found.append(ProbeCurve(probe.name, name, units[name], time, values, smooth, over))
    return found


def figures_of(curve: ProbeCurve, window: tuple[float, float]) -> ProbeFigures:
    """Return what a curve comes to, with mean and scatter within a window of time, s."""
    changed = np.abs(curve.smooth - curve.smooth[0])
    arrived = changed > ARRIVED * changed.max()
    peak = int(np.argmax(np.abs(curve.values)))
    inside = curve.values[is_within(curve.time, window)]
    is_load = curve.unit in LOADS
    return ProbeFigures(
        probe=curve.probe,
        column=curve.column,
        unit=curve.unit,
        arrival=float(curve.time[np.argmax(arrived)]) if arrived.any() else np.nan,
        peak=float(curve.values[peak]),
        peak_time=float(curve.time[peak]),
        smooth_peak=float(curve.smooth[np.argmax(np.abs(curve.smooth))]),
        impulse=float(np.trapezoid(curve.values, curve.time)) if is_load else np.nan,
        mean=float(inside.mean()) if inside.size else np.nan,
        scatter=float(inside.std()) if inside.size else np.nan,
    )


def told_span(span: float | None) -> str:
    """Return over which time curves are smoothed, in words."""
    return f"{SMOOTHED} intervals of the probe" if span is None else f"{span:g} s"
