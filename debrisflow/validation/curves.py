"""What a figure shows of a comparison, as data that can be written and drawn again."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

MOST_POINTS = 250
"""Of a curve; more are thinned, for a figure does not show them."""


class Kind(StrEnum):
    """How a curve is drawn."""

    MEASURED = "measured"
    EXACT = "exact"
    COMPUTED = "computed"
    POINTS = "points"


class Curve(NamedTuple):
    """One curve.

    Attributes
    ----------
    label : str
        In the legend; of a computed one what its level does not say, mostly nothing.
    x, y : tuple of float
    kind : Kind
        ``measured``: black dots; ``exact``: a black line; ``computed``: a line in the color of the
        level; ``points``: dots in it.
    """

    label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    kind: Kind


class Panel(NamedTuple):
    """A pair of axes.

    Attributes
    ----------
    title, x_label, y_label : str
    curves : tuple of Curve
        Those of the reference are the same at all levels.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]


def computed(x: ArrayLike, y: ArrayLike, label: str = "") -> Curve:
    """Return a curve of a run."""
    return _curve(label, x, y, Kind.COMPUTED)


def points(x: ArrayLike, y: ArrayLike, label: str = "") -> Curve:
    """Return points of a run that no line joins."""
    return _curve(label, x, y, Kind.POINTS)


def measured(x: ArrayLike, y: ArrayLike, label: str = "measured") -> Curve:
    """Return a curve of an experiment."""
    return _curve(label, x, y, Kind.MEASURED)


def exact(x: ArrayLike, y: ArrayLike, label: str = "closed form") -> Curve:
    """Return a curve of a closed form."""
    return _curve(label, x, y, Kind.EXACT)


def _curve(label: str, x: ArrayLike, y: ArrayLike, kind: Kind) -> Curve:
    return Curve(label, _thinned(x), _thinned(y), kind)


def _thinned(values: ArrayLike) -> tuple[float, ...]:
    """Return the values with five digits, of many only some, evenly chosen."""
    array = np.asarray(values, dtype=np.float64).ravel()
    if array.size > MOST_POINTS:
        array = array[np.linspace(0, array.size - 1, MOST_POINTS).astype(int)]
    return tuple(float(f"{value:.5g}") for value in array)


def joined(panels: Sequence[Panel]) -> list[Panel]:
    """Return panels of several levels by their titles, in the order of the first."""
    by_title: dict[str, list[Panel]] = {}
    for panel in panels:
        by_title.setdefault(panel.title, []).append(panel)
    return [
        same[0]._replace(curves=tuple(curve for panel in same for curve in panel.curves))
        for same in by_title.values()
    ]
