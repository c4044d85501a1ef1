"""Measured or exact curves to compare with, and how far the run is from them."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.results.survey import Survey
from debrisflow.series import Table, read_table

Floats = NDArray[np.float64]
NORMALIZED = "y_over_h"


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
        """Return the names of the curves."""
        return [name for name in self.table if name != self.abscissa]


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
    """

    reference: str
    curve: str
    ours: str
    points: int
    rms: float
    share: float


COLUMNS = Distance._fields
HEAD = (
    "distance of the run from curves of references, at the points of the run within their range",
    "rms: in the unit of the curve; share: rms over the range of the values of the reference",
)


def dilatant_profile() -> Reference:
    """Return the profile of a steady flow of colliding grains, u/u_s = 1 - (1 - y/h)^1.5.

    References
    ----------
    Takahashi 1978, Journal of the Hydraulics Division 104, 1153-1169.
    """
    y = np.linspace(0.0, 1.0, 101)
    return Reference("dilatant", NORMALIZED, {NORMALIZED: y, "u_over_us": 1 - (1 - y) ** 1.5})


def read_reference(path: Path) -> Reference:
    """Return the curves of a CSV file: lines of comment, names of columns, rows of numbers.

    The first column says against what the others are drawn; it and they have the names of our
    tables: ``y_over_h`` with ``u_over_us`` (also under any other name, of a closed form, say),
    ``y`` or ``z`` with the columns of ``mean_profiles.csv``, ``time`` with those of ``front.csv``,
    ``x`` with those of ``deposit_profile.csv``.

    Raises
    ------
    OutputError
        If it cannot be read, or its first column does not increase.
    """
    table = read_table(path, grows=False)
    names = list(table)
    if len(names) < 2:
        raise OutputError(f"{path} has the one column {names[0]}: a curve needs two")
    if table[names[0]].size == 0:
        raise OutputError(f"{path} has no rows: a curve needs points")
    if not np.all(np.diff(table[names[0]]) > 0.0):
        raise OutputError(f"{path}: its first column, {names[0]}, does not increase")
    return Reference(path.stem, names[0], table)


def ours(found: Survey, reference: Reference, curve: str) -> dict[str, tuple[Floats, Floats]]:
    """Return the curves of a run that belong to one of a reference, by what they are.

    Raises
    ------
    OutputError
        If the run has none of these names.
    """
    name = curve
    if reference.abscissa == "time":
        tables = {"run": found.fronts}
    elif reference.abscissa == "x":
        last = found.deposits[-1]
        tables = {f"t = {last.time:g} s": {"x": last.grid.x, **last.table}}
    else:
        tables = _by_station(found)
        if reference.abscissa == NORMALIZED and name not in found.mean_profiles:
            name = "u_over_us"
    known = next(iter(tables.values()), {reference.abscissa: np.empty(0), name: np.empty(0)})
    for column in (reference.abscissa, name):
        if column not in known:
            raise OutputError(
                f"reference {reference.name}: no column {column} to compare with among "
                + ", ".join(known)
            )
    return {label: (part[reference.abscissa], part[name]) for label, part in tables.items()}


def _by_station(found: Survey) -> dict[str, Table]:
    profiles = found.mean_profiles
    parts = {}
    for x in np.unique(profiles["station"]):
        here = profiles["station"] == x
        parts[f"x = {x:g} m"] = {name: values[here] for name, values in profiles.items()}
    if found.chosen and len(parts) > 1:
        parts["mean of the stations"] = found.pooled_profile
    return parts


def distances(found: Survey, reference: Reference) -> list[Distance]:
    """Return how far the curves of a run are from those of a reference."""
    rows = []
    for curve in reference.curves:
        for label, (x, values) in ours(found, reference, curve).items():
            at, exact = reference.table[reference.abscissa], reference.table[curve]
            inside = (x >= at[0]) & (x <= at[-1]) & ~np.isnan(values)
            error = values[inside] - np.interp(x[inside], at, exact)
            rms = float(np.sqrt(np.mean(error**2))) if error.size else np.nan
            extent = float(np.ptp(exact))
            share = rms / extent if extent > 0.0 else np.nan
            rows.append(Distance(reference.name, curve, label, error.size, rms, share))
    return rows
