"""Measured or exact curves to compare with, and how far the run is from them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.words import did_you_mean
from debrisflow.errors import OutputError
from debrisflow.results.deposition import Deposition, greatest_across
from debrisflow.results.probe_curves import probe_curve
from debrisflow.results.survey import AnySurvey, Survey
from debrisflow.run.tables import Table, read_table, rows_where

Floats = NDArray[np.float64]
NORMALIZED = "y_over_h"
DILATANT = "dilatant"
ABSCISSAS = (NORMALIZED, "y", "z", "time", "x")
RUN = "run"  # the one curve of a run that there is
POOLED = "mean of the stations"
FEWEST_POINTS = 3
BAND = (".low", ".high")
GREATEST_SHIFT, SHIFTS = 0.1, 100
"""Share of the time of both curves by which one is shifted at most, and how many are tried."""


class Reference(NamedTuple):
    """The curves of one file.

    Attributes
    ----------
    name : str
        Of the file, without its ending.
    abscissa : str
        Name of the first column, which is a column of ours.
    table : Table
        All columns; the first increases.
    """

    name: str
    abscissa: str
    table: Table

    @property
    def curves(self) -> list[str]:
        """Return the names of the curves, bands not among them."""
        return [name for name in self.table if name != self.abscissa and not name.endswith(BAND)]

    def band(self, curve: str) -> Floats | None:
        """Return the least and greatest values of a curve, (2, n) array; None without them."""
        names = [curve + end for end in BAND]
        return np.array([self.table[name] for name in names]) if names[0] in self.table else None


class Distance(NamedTuple):
    """How far a curve of the run is from one of a reference.

    Attributes
    ----------
    reference, curve : str
        File and column.
    ours : str
        Which curve of the run.
    points : int
        Points of ours within the range of the reference.
    rms : float
        Root mean square of the difference there, in the unit of the curve; nan without points.
    share : float
        ``rms`` over the range of the values of the reference.
    shift, shifted_rms : float
        Of a curve in time: by how many seconds it is moved to come nearest, at most by a tenth of
        the time that it has in common with the reference, and the ``rms`` then, at the points that
        stay within the range of the reference.
    in_band : float
        Share of the points within the band of the reference; nan without one.
    """

    reference: str
    curve: str
    ours: str
    points: int
    rms: float
    share: float
    shift: float = np.nan
    shifted_rms: float = np.nan
    in_band: float = np.nan


COLUMNS = Distance._fields
HEAD = (
    "distance of the run from curves of references, at the points of the run within their range;",
    "  of y_over_h without the one at the surface, and none where fewer than three are left",
    "rms: in the unit of the curve; share: rms over the range of the values of the reference",
    "shift, shifted_rms: s, by which a curve in time is moved to come nearest, at most by a tenth",
    "  of the time of both curves, and rms then, at the points that stay within its range;",
    "  in_band: share of the points within its band; of probes the running mean is compared",
)


def format_distance(one: Distance) -> str:
    """Return a distance as a line."""
    curve = f"distance to {one.reference}, {one.curve}, {one.ours}: "
    if not one.points:
        return curve + "the run has no points within its range"
    shift = band = ""
    if one.shift == 0.0:
        shift = "; moving the run in time brings it no nearer"
    elif not np.isnan(one.shift):
        shift = f"; {one.shifted_rms:.3g} if the run is moved by {one.shift:+.3g} s"
    if not np.isnan(one.in_band):
        band = f"; {one.in_band:.0%} of the points within the band"
    share = "" if np.isnan(one.share) else f" ({one.share:.1%} of the reference's range)"
    return f"{curve}rms {one.rms:.3g}{share} at {one.points} points{shift}{band}"


def dilatant_profile() -> Reference:
    """Return the profile of a steady flow of colliding grains, u/u_s = 1 - (1 - y/h)^1.5.

    References
    ----------
    Takahashi 1978, Journal of the Hydraulics Division 104, 1153-1169.
    """
    y = np.linspace(0.0, 1.0, 101)
    return Reference(DILATANT, NORMALIZED, {NORMALIZED: y, "u_over_us": 1 - (1 - y) ** 1.5})


def read_reference(path: Path) -> Reference:
    """Return the curves of a CSV file: lines of comment, names of columns, rows of numbers.

    The first column says against what the others are drawn; it and they have the names of our
    tables: ``y_over_h`` with ``u_over_us`` (also under any other name, of a closed form, say),
    ``y`` or ``z`` with the columns of ``mean_profiles.csv``, ``time`` with those of ``front.csv``
    or, as ``PROBE.COLUMN``, with those of a probe, ``x`` with those of ``deposit_profile.csv``.
    ``NAME.low`` and ``NAME.high`` are the band of the curve ``NAME``.

    Raises
    ------
    OutputError
        If it cannot be read, its first column does not increase, or a band lacks its curve or one
        of its sides.
    """
    table = read_table(path, grows=False)
    names = list(table)
    if len(names) < 2:
        raise OutputError(
            f"{path} has the one column {names[0]}: a curve needs two, with a comma between them"
        )
    if names[0] not in ABSCISSAS:
        raise OutputError(
            f"{path}: its first column is {names[0]}, and should be one of {', '.join(ABSCISSAS)}"
        )
    if table[names[0]].size == 0:
        raise OutputError(f"{path} has no rows: a curve needs points")
    if not np.all(np.diff(table[names[0]]) > 0.0):
        raise OutputError(f"{path}: its first column, {names[0]}, does not increase")
    for name in names:
        if name.endswith(BAND):
            curve = name.rpartition(".")[0]
            needed = {curve, *(curve + end for end in BAND)}
            if missing := sorted(needed - set(names)):
                raise OutputError(
                    f"{path}: the column {name} is a side of the band of {curve}, and there is no "
                    f"column {missing[0]}" + did_you_mean(missing[0], set(names) - needed)
                )
    return Reference(path.stem, names[0], table)


def ours(found: AnySurvey, reference: Reference, curve: str) -> dict[str, tuple[Floats, Floats]]:
    """Return the curves of a run that belong to one of a reference, by what they are.

    Raises
    ------
    OutputError
        If the run has none of these names.
    """
    name = curve
    if reference.abscissa == "time" and curve not in found.fronts:
        return {RUN: _of_probe(found, reference, curve)}
    if not isinstance(found, Survey) and reference.abscissa != "time":
        raise OutputError(
            f"reference {reference.name}: a run on a terrain has curves over the time only, and "
            f"not over {reference.abscissa}"
        )
    if not isinstance(found, Survey) or reference.abscissa == "time":
        tables = {RUN: found.fronts}
    elif reference.abscissa == "x":
        tables = {f"t = {found.deposits[-1].time:g} s": _along_x(found.deposits[-1])}
    else:
        tables = _by_station(found)
        if reference.abscissa == NORMALIZED and is_velocity(found, name):
            name = "u_over_us"
    known = next(iter(tables.values()), {reference.abscissa: np.empty(0), name: np.empty(0)})
    for column in (reference.abscissa, name):
        if column not in known:
            raise OutputError(
                f"reference {reference.name}: no column {column} to compare with among "
                + ", ".join(known)
            )
    return {label: (part[reference.abscissa], part[name]) for label, part in tables.items()}


def _of_probe(found: AnySurvey, reference: Reference, curve: str) -> tuple[Floats, Floats]:
    """Return the running mean of a probe by ``PROBE.COLUMN``."""
    known = [name for name in found.fronts if name != "time"]
    if "." not in curve:
        raise OutputError(
            f"reference {reference.name}: no column {curve} to compare with among "
            + ", ".join([*known, "PROBE.COLUMN"])
            + did_you_mean(curve, known)
        )
    try:
        one = probe_curve(found.run, curve, found.smoothing)
    except OutputError as error:
        raise OutputError(f"reference {reference.name}, column {curve}: {error}") from error
    return one.time, one.smooth


def is_velocity(found: Survey, name: str) -> bool:
    """Return whether a curve over y/h stands for u/u_s: by its name, or as no other quantity."""
    return name == "u_over_us" or name not in found.mean_profiles


def _along_x(last: Deposition) -> Table:
    """Return the deposit along x; in three dimensions the greatest values across."""
    across = {name: greatest_across(last.grid, values) for name, values in last.table.items()}
    x = next(middles for middles, _ in across.values())
    return {"x": x} | {name: values for name, (_, values) in across.items()}


def _by_station(found: Survey) -> dict[str, Table]:
    profiles = found.mean_profiles
    parts = {}
    for x in np.unique(profiles["station"]):
        parts[f"x = {x:g} m"] = rows_where(profiles, profiles["station"] == x)
    if found.chosen and len(parts) > 1:
        parts[POOLED] = found.pooled_profile
    return parts


def distances(found: AnySurvey, reference: Reference) -> list[Distance]:
    """Return how far the curves of a run are from those of a reference.

    At the points of the run within the range of the reference.  Of a normalized profile without the
    point at its surface, which is 1 in both, and not where fewer than three are left.
    """
    rows = []
    for curve in reference.curves:
        known = ~np.isnan(reference.table[curve])
        at, exact = reference.table[reference.abscissa][known], reference.table[curve][known]
        for label, (x, values) in ours(found, reference, curve).items():
            ends = (at[0], at[-1]) if at.size else (np.inf, -np.inf)
            inside = ~np.isnan(values) & (x >= ends[0]) & (x <= ends[1])
            if reference.abscissa == NORMALIZED:
                inside &= x < 1.0
                inside &= np.count_nonzero(inside) >= FEWEST_POINTS
            points = int(np.count_nonzero(inside))
            rms = _rms(x[inside], values[inside], at, exact)
            extent = float(np.ptp(exact)) if exact.size else 0.0
            share = rms / extent if extent > 0.0 else np.nan
            shift, shifted = np.nan, np.nan
            if reference.abscissa == "time" and points:
                shift, shifted = _best_shift(x, values, at, exact)
            part = _share_in_band(x[inside], values[inside], reference, curve)
            row = Distance(reference.name, curve, label, points, rms, share, shift, shifted, part)
            rows.append(row)
    return rows


def _rms(x: Floats, values: Floats, at: Floats, exact: Floats) -> float:
    """Return the rms of the difference to a curve at some points; nan without points."""
    return float(np.sqrt(np.mean((values - np.interp(x, at, exact)) ** 2))) if x.size else np.nan


def _best_shift(x: Floats, values: Floats, at: Floats, exact: Floats) -> tuple[float, float]:
    """Return by how much a curve in time is moved to come nearest to another, and the rms then.

    At the points that stay within the range of the other one whichever way they are moved; of two
    times that are as good the shorter one.
    """
    known = ~np.isnan(values)
    start, end = max(at[0], x[known].min()), min(at[-1], x[known].max())
    most = GREATEST_SHIFT * max(float(end - start), 0.0)
    stays = known & (x - most >= at[0]) & (x + most <= at[-1])
    if np.count_nonzero(stays) < FEWEST_POINTS:
        return np.nan, np.nan
    later = np.linspace(0.0, most, SHIFTS + 1)
    shifts = sorted((*later, *-later[1:]), key=abs)
    errors = [_rms(x[stays] + shift, values[stays], at, exact) for shift in shifts]
    best = int(np.argmin(errors))
    return float(shifts[best]), errors[best]


def _share_in_band(x: Floats, values: Floats, reference: Reference, curve: str) -> float:
    """Return the share of points that are within the band of a curve; nan without one."""
    band, at = reference.band(curve), reference.table[reference.abscissa]
    if band is None:
        return np.nan
    known = ~np.isnan(band).any(axis=0)
    inside = (x >= at[known].min(initial=np.inf)) & (x <= at[known].max(initial=-np.inf))
    if not inside.any():
        return np.nan
    low, high = (np.interp(x[inside], at[known], side[known]) for side in band)
    return float(np.mean((values[inside] >= low) & (values[inside] <= high)))


def distances_to_all(found: AnySurvey, given: Sequence[Reference]) -> list[Distance]:
    """Return the distances to references, and where there are grains to the dilatant profile.

    On a terrain to references only.
    """
    has_profile = isinstance(found, Survey) and found.mean_profiles["sediment_fraction"].any()
    exact = (dilatant_profile(),) if has_profile else ()
    return [row for one in (*exact, *given) for row in distances(found, one)]
