"""The samples of the probes of a run as curves: running means, arrivals, peaks, impulses."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.probe import Probe
from debrisflow.case.words import did_you_mean, either
from debrisflow.errors import OutputError
from debrisflow.results.reader import Run
from debrisflow.results.stations import is_within
from debrisflow.run.probes import columns_of, sampler_of
from debrisflow.run.row_statistics import EXTREMES

Floats = NDArray[np.float64]
SMOOTHED = 10  # intervals of a probe over which its running mean goes, if no time is given
ARRIVED = 0.05  # of the greatest change, by which something has arrived
LEAST_CHANGE = 0.01  # of the greatest magnitude; what changes by less does not arrive
LEVELS = ("height", "filled_height")  # columns that are heights of a surface
WITH_IMPULSE = ("Pa", "N")


class ProbeCurve(NamedTuple):
    """One column of the samples of a probe.

    Attributes
    ----------
    probe, column, unit : str
    time, values, smooth : (n,) float64 array
        Samples, and their running mean; a mean since the row before stands in the middle of the
        time over which it was taken.
    impulse : float
        The integral over time, of pressures and forces, else nan.
    span : float, s
        Over which the running mean goes.
    least, greatest : (n,) float64 array
        Of the steps since the row before; the samples where they are not known.
    rise : float
        By which a level must rise for something to have arrived, half a spacing; nan of what is no
        level.
    was_dry : bool
        Whether there were no values at first.
    was_pressed : bool
        Whether the first mean was not 0 although the first row, without a step before it, is: it is
        that of fluid that stood there.
    """

    probe: str
    column: str
    unit: str
    time: Floats
    values: Floats
    smooth: Floats
    impulse: float
    span: float
    least: Floats
    greatest: Floats
    rise: float = np.nan
    was_dry: bool = False
    was_pressed: bool = False

    @property
    def before(self) -> float:
        """Return the value before anything arrives."""
        return float(self.values[int(self.was_pressed)])


class ProbeFigures(NamedTuple):
    """The figures of a curve, a row of ``probes.csv``; nan where it has no answer.

    Attributes
    ----------
    probe, column, unit : str
    arrival : float, s
        Of a level the first sample more than half a spacing above the first one.  Of what was dry
        at first the first one that is not.  Else the first sample that has changed by 5 % of the
        greatest change of the running mean, for a vector that of any component; nan if that is less
        than 1 % of the greatest magnitude.  From then on the mean over its span has too.
    peak, peak_time : float
        The value of greatest magnitude, of all steps if the probe keeps those between two rows,
        else of the samples; and the time of its row, s.
    smooth_peak : float
        That of the running mean.
    impulse : float
        The integral over time, of pressures and forces.
    mean, deviation : float
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
    deviation: float


COLUMNS = ProbeFigures._fields
HEAD = (
    "a row for each curve of a probe; those of sections are in answers.csv",
    "arrival: s, of a height the first sample more than half a spacing above that at the start, of",
    "  a point that was dry the first that is not, else the first that has changed by 5 % of the",
    "  greatest change of the running mean over {span}, for a vector that of any component; from",
    "  then on the mean has too; nan if there is none",
    "peak, peak_time: the value of greatest magnitude, of single steps if the probe keeps their",
    "  least and greatest, else of the samples, and the time of its row in s",
    "smooth_peak: value of greatest magnitude of the running mean",
    "impulse: integral over time, of pressures and forces, in the unit times s",
    "mean, deviation: mean and standard deviation of the samples from {start:g} to {end:g} s",
)


def running_mean(time: Floats, values: Floats, span: float) -> Floats:
    """Return the mean over a span of time around each sample, at the ends over what there is.

    Examples
    --------
    >>> running_mean(np.arange(5.0), np.array([0.0, 0.0, 4.0, 0.0, 0.0]), 2.0)
    array([0., 1., 2., 1., 0.])
    """
    return _mean_between(time, values, time - 0.5 * span, time + 0.5 * span)


def _mean_between(time: Floats, values: Floats, start: Floats, end: Floats) -> Floats:
    """Return means of the straight lines between the samples over spans of time."""
    if time.size < 2:
        return values.copy()
    first, last = np.maximum(start, time[0]), np.minimum(end, time[-1])
    length = last - first
    steps = np.diff(time)
    total = np.concatenate([[0.0], np.cumsum(0.5 * steps * (values[1:] + values[:-1]))])
    gained = _integral_to(last, time, values, total) - _integral_to(first, time, values, total)
    return np.where(length > 0.0, gained / np.where(length > 0.0, length, 1.0), values)


def _integral_to(at: Floats, time: Floats, values: Floats, total: Floats) -> Floats:
    row = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    part, step = at - time[row], time[row + 1] - time[row]
    slope = (values[row + 1] - values[row]) / np.where(step > 0.0, step, 1.0)
    return np.asarray(total[row] + part * (values[row] + 0.5 * slope * part))


def probe_curves(run: Run, span: float | None = None) -> list[ProbeCurve]:
    """Return the curves by which the probes of a run are shown, from t = 0 on.

    Those that have no samples, as a patch on a mesh has no reaction, are left out.

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
    found = [
        _curve(run, probe, column, span)
        for probe in run.case.probe
        for column in sampler_of(probe.type).headline(run.case.dimension)
    ]
    return [curve for curve in found if curve is not None]


def probe_curve(run: Run, name: str, span: float | None = None) -> ProbeCurve:
    """Return the curve of any column of a probe, called ``PROBE.COLUMN``.

    Raises
    ------
    OutputError
        If there is no such probe or column, or it has no samples.
    """
    probes = {probe.name: probe for probe in run.case.probe}
    own, _, column = name.partition(".")
    if own not in probes:
        there = f"its probes are {either(probes)}" if probes else "it has no probes"
        raise OutputError(f"{run.folder} has no probe {own}; {there}{did_you_mean(own, probes)}")
    if sampler_of(probes[own].type).has_many_points:
        raise OutputError(
            f"probe {own} is a {probes[own].type}: its columns are of many points, and no curves "
            "in time; give a probe of the type point"
        )
    columns = [one.name for one in columns_of(probes[own], run.case.dimension)]
    if column not in columns:
        raise OutputError(
            f"probe {own} has no column {column or 'given'}, but {either(columns)}"
            + did_you_mean(column, columns)
        )
    curve = _curve(run, probes[own], column, span)
    if curve is None:
        raise OutputError(f"probe {own} has no samples of {column} in {run.folder}")
    return curve


def _curve(run: Run, probe: Probe, column: str, span: float | None) -> ProbeCurve | None:
    """Return the curve of a column; None if the file has no numbers of it."""
    table, sampler = run.probe(probe.name), sampler_of(probe.type)
    if column not in table:
        return None  # of an older version
    unit = {one.name: one.unit for one in columns_of(probe, run.case.dimension)}[column]
    known = (table["time"] >= 0.0) & ~np.isnan(table[column])
    time, values = table["time"][known], table[column][known]
    if time.size == 0:
        return None
    impulse = np.nan
    has_impulse = unit in WITH_IMPULSE and not column.endswith(EXTREMES)
    low, high = (
        table[column + ending][known] if column + ending in table else values for ending in EXTREMES
    )
    is_mean = column.startswith(sampler.averaged)
    if is_mean:
        if has_impulse:
            impulse = float(np.sum(values[1:] * np.diff(time)))
        time = np.concatenate([time[:1], 0.5 * (time[1:] + time[:-1])])
    elif has_impulse:
        impulse = float(np.trapezoid(values, time))
    over = SMOOTHED * probe.interval if span is None else span
    return ProbeCurve(
        probe=probe.name,
        column=column,
        unit=unit,
        time=time,
        values=values,
        smooth=running_mean(time, values, over),
        impulse=impulse,
        span=over,
        least=low,
        greatest=high,
        rise=0.5 * run.case.particles.spacing if column in LEVELS else np.nan,
        was_dry=bool(np.isnan(table[column][table["time"] >= 0.0][0])),
        was_pressed=is_mean and values.size > 1 and values[0] == 0.0 != values[1],
    )


def probe_figures(curves: Sequence[ProbeCurve], window: tuple[float, float]) -> list[ProbeFigures]:
    """Return the figures of curves, with mean and deviation within a window of time, s."""
    greatest: dict[tuple[str, str], float] = {}
    for curve in curves:
        change = float(np.abs(curve.smooth - curve.before).max())
        greatest[_vector(curve)] = max(greatest.get(_vector(curve), 0.0), change)
    return [_figures_of(curve, window, greatest[_vector(curve)]) for curve in curves]


def _vector(curve: ProbeCurve) -> tuple[str, str]:
    """Return a name that the components of a vector share."""
    return curve.probe, re.sub("_[xyz]$", "", curve.column)


def _figures_of(
    curve: ProbeCurve, window: tuple[float, float], greatest_change: float
) -> ProbeFigures:
    farthest = np.where(np.abs(curve.least) > np.abs(curve.greatest), curve.least, curve.greatest)
    peak = int(np.argmax(np.abs(farthest)))
    inside = curve.values[is_within(curve.time, window)]
    return ProbeFigures(
        probe=curve.probe,
        column=curve.column,
        unit=curve.unit,
        arrival=_arrival(curve, greatest_change),
        peak=float(farthest[peak]),
        peak_time=float(curve.time[peak]),
        smooth_peak=float(curve.smooth[np.argmax(np.abs(curve.smooth))]),
        impulse=curve.impulse,
        mean=float(inside.mean()) if inside.size else np.nan,
        deviation=float(inside.std()) if inside.size else np.nan,
    )


def _arrival(curve: ProbeCurve, greatest_change: float) -> float:
    if curve.was_dry:
        return float(curve.time[0])
    values, before = curve.values, curve.before
    ahead = _mean_between(curve.time, values, curve.time, curve.time + curve.span)
    if np.isnan(curve.rise):
        if greatest_change <= LEAST_CHANGE * np.abs(curve.smooth).max():
            return np.nan
        least = ARRIVED * greatest_change
        there = (np.abs(values - before) > least) & (np.abs(ahead - before) > least)
    else:
        there = (values - before > curve.rise) & (ahead - before > curve.rise)
    there &= curve.time >= curve.time[int(curve.was_pressed)]
    return float(curve.time[np.argmax(there)]) if there.any() else np.nan


def format_span(span: float | None) -> str:
    """Return over which time a running mean goes, in words."""
    return f"{SMOOTHED} intervals of the probe" if span is None else f"{span:g} s"
