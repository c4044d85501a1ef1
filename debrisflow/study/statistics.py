"""The quantities of a study over its members: mean, spread, shares, and which member is where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.study.map_checks import ARRIVAL
from debrisflow.study.results import Results
from debrisflow.study.tables import Quantity

Floats = NDArray[np.float64]
SHARES = (0.05, 0.5, 0.95)
EARLY = ("_arrival", "_overtopping_time")
"""Ends of the names of answers that are times at which something comes."""


@dataclass(frozen=True)
class Summary:
    """A quantity over the members; nan where no member has it.

    Attributes
    ----------
    name, unit : str
    count : int
        Members that have the quantity.
    mean, deviation : float
        Deviation: the standard deviation of a sample, nan of fewer than two members.
    low, median, high : float
        Below which 5, 50 and 95 % of the members lie, linear between them.
    least, greatest : float
    least_is_worst : bool
        As of an arrival.
    worst, middle : int or None
        Places among the members: of the worst value, and of the value nearest to the median.
    """

    name: str
    unit: str
    count: int
    mean: float
    deviation: float
    low: float
    median: float
    high: float
    least: float
    greatest: float
    least_is_worst: bool
    worst: int | None
    middle: int | None


def summaries(results: Results) -> list[Summary]:
    """Return the quantities of a study over its members, in the order of the study."""
    early = {one.called for one in results.study.quantity if is_early(one)}
    return [
        summary(name, unit, results.values_of(name), name in early)
        for name, unit in results.units.items()
    ]


def is_early(quantity: Quantity) -> bool:
    """Return whether a quantity is a time at which something comes, so that the least is worst.

    Examples
    --------
    >>> is_early(Quantity(answer="road_arrival")), is_early(Quantity(answer="arrival_latest"))
    (True, False)
    """
    return quantity.layer == ARRIVAL or (quantity.answer or "").endswith(EARLY)


def summary(name: str, unit: str, values: Floats, least_is_worst: bool = False) -> Summary:
    """Return a quantity over the members.

    Parameters
    ----------
    name, unit : str
    values : (members,) float64 array
        Nan where a member has none.
    least_is_worst : bool

    Examples
    --------
    >>> found = summary("runout_length", "m", np.array([3.0, np.nan, 1.0, 2.0]))
    >>> found.count, found.mean, found.deviation, found.worst, found.middle
    (3, 2.0, 1.0, 0, 3)
    """
    there = np.flatnonzero(np.isfinite(values))
    known = values[there]
    if not known.size:
        nothing = (np.nan,) * 7
        return Summary(name, unit, 0, *nothing, least_is_worst, None, None)
    low, median, high = np.quantile(known, SHARES)
    worst = np.argmin(known) if least_is_worst else np.argmax(known)
    return Summary(
        name=name,
        unit=unit,
        count=known.size,
        mean=float(known.mean()),
        deviation=float(np.std(known, ddof=1)) if known.size > 1 else np.nan,
        low=float(low),
        median=float(median),
        high=float(high),
        least=float(known.min()),
        greatest=float(known.max()),
        least_is_worst=least_is_worst,
        worst=int(there[worst]),
        middle=int(there[np.argmin(np.abs(known - median))]),
    )
