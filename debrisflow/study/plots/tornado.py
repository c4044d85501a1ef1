"""The tornado plot: how far each parameter moves a quantity, the farthest first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from debrisflow.results.plots.style import BLUE, GRAY, ORANGE, panels
from debrisflow.study.designs import numbers_of
from debrisflow.study.distributions import AnyParameter, Choice, Value, Values
from debrisflow.study.plots.labels import is_of_words, label_of, parameter_label, shown_value
from debrisflow.study.sensitivity import moved_alone
from debrisflow.study.tables import OneAtATime, Study

Floats = NDArray[np.float64]
Chosen = NDArray[np.bool_]
FIFTH = 0.2
OF_ROW, LEAST_HEIGHT = 0.4, 1.6  # inch
OF_ENDS = "the bars end at the quantity with one parameter at its low or high end, the others at "
OF_FIFTHS = (
    "the bars end at the mean over the fifth of the members with the lowest or highest value"
)
OF_WORDS = "of a list of words they end at the one with the least and with the greatest mean"


class End(NamedTuple):
    """One end of the bars of a parameter.

    Attributes
    ----------
    label : str
        The value of the parameter.
    value : float
        Of the quantity there; nan where it is missing.
    """

    label: str
    value: float


class Ends(NamedTuple):
    """Where the bars of one parameter end."""

    parameter: AnyParameter
    low: End
    high: End

    def size(self, middle: float) -> float:
        """Return how far apart the ends are, and the middle, as far as they are there."""
        there = [one for one in (self.low.value, self.high.value, middle) if np.isfinite(one)]
        return max(there) - min(there) if there else 0.0


MISSING = End("", np.nan)


def tornado_figure(
    study: Study, points: Sequence[Values], values: Floats, name: str, unit: str
) -> Figure:
    """Return bars from the middle to the ends of each parameter.

    Parameters
    ----------
    study : Study
    points : sequence of dict
        Of the members of the design.
    values : (members,) float64 array
        Of the quantity; nan where there is none.
    name, unit : str
        Of the quantity.
    """
    middle = middle_of(study, values)
    ends = sorted(ends_of(study, points, values), key=lambda one: one.size(middle))
    figure, (axes,) = panels(1, height=max(LEAST_HEIGHT, OF_ROW * len(ends) + 0.8))
    for row, one in enumerate(ends):
        _draw(axes, row, one, middle)
    axes.axvline(middle, color=GRAY, linewidth=0.8)
    axes.set_yticks(range(len(ends)), [parameter_label(one.parameter) for one in ends])
    axes.set_ylim(-0.6, len(ends) - 0.4)
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.12)
    axes.set_xlabel(label_of(name, unit))
    sides = [("at its low end", BLUE), ("at its high end", ORANGE), ("one of its words", GRAY)]
    words = any(is_of_words(one.parameter) for one in ends)
    handles = [Patch(color=color, label=label) for label, color in sides[: 3 if words else 2]]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False)
    return figure


def explanation(study: Study, values: Floats) -> str:
    """Return what the line and the bars of a tornado plot are, for its caption."""
    alone = isinstance(study.design, OneAtATime)
    line = "all parameters at their medians" if alone else "mean of all members"
    if alone and np.isnan(values[0]):
        line = "mean of all members, as there is no value with all parameters at their medians"
    if isinstance(study.design, OneAtATime):
        low, high = (f"{100 * share:g} %" for share in study.design.shares)
        return (
            f"Line: {line}; {OF_ENDS}their medians; ends: {low} and {high} of all values are below."
        )
    words = f"; {OF_WORDS}" if any(is_of_words(one) for one in study.parameter) else ""
    return f"Line: {line}; {OF_FIFTHS} of the parameter{words}."


def middle_of(study: Study, values: Floats) -> float:
    """Return the quantity of the base of a design of one at a time, of others the mean."""
    if isinstance(study.design, OneAtATime) and np.isfinite(values[0]):
        return float(values[0])
    return _mean(values[np.isfinite(values)])


def ends_of(study: Study, points: Sequence[Values], values: Floats) -> list[Ends]:
    """Return where the bars of each parameter end.

    Parameters
    ----------
    study : Study
    points : sequence of dict
    values : (members,) float64 array
    """
    found = []
    for k, parameter in enumerate(study.parameter):
        numbers = numbers_of(parameter, points)
        there = np.isfinite(values)
        if isinstance(study.design, OneAtATime):
            every = np.column_stack([numbers_of(one, points) for one in study.parameter])
            there &= np.isin(np.arange(len(values)), moved_alone(every, k))
        if isinstance(parameter, Choice):
            found.append(_ends_of_list(parameter, numbers, values, there))
        elif isinstance(study.design, OneAtATime):
            found.append(_ends_alone(parameter, numbers, values, there))
        else:
            found.append(_ends_of_fifths(parameter, numbers, values, there))
    return found


def _ends_alone(parameter: AnyParameter, numbers: Floats, values: Floats, there: Chosen) -> Ends:
    """Return the ends of a parameter that moved alone."""
    low, high = (
        End(shown_value(float(numbers[side][0])), _mean(values[side & there]))
        for side in (numbers < numbers[0], numbers > numbers[0])
    )
    return Ends(parameter, low, high)


def _ends_of_fifths(
    parameter: AnyParameter, numbers: Floats, values: Floats, there: Chosen
) -> Ends:
    """Return the means over the lowest and the highest fifth, with all members at its bound."""
    if not there.any():
        return Ends(parameter, MISSING, MISSING)
    least, greatest = np.quantile(numbers[there], [FIFTH, 1.0 - FIFTH])
    low, high = (
        End(shown_value(_mean(numbers[side])), _mean(values[side]))
        for side in (there & (numbers <= least), there & (numbers >= greatest))
    )
    return Ends(parameter, low, high)


def _ends_of_list(parameter: Choice, numbers: Floats, values: Floats, there: Chosen) -> Ends:
    """Return the lowest and the highest number, or the words with the least and greatest mean."""
    listed: Sequence[Value] = parameter.values
    ends = [
        End(shown_value(value), _mean(values[there & (numbers == k)]))
        for k, value in enumerate(listed)
    ]
    if is_of_words(parameter):
        ends = [end for end in ends if np.isfinite(end.value)] or [MISSING]
        order = np.argsort([end.value for end in ends], kind="stable")
    else:
        order = np.argsort(np.array(listed, dtype=np.float64), kind="stable")
    return Ends(parameter, ends[order[0]], ends[order[-1]])


def _mean(values: Floats) -> float:
    return float(values.mean()) if values.size else np.nan


def _draw(axes: Axes, row: int, ends: Ends, middle: float) -> None:
    """Draw the bars of one parameter; beside each other where both go the same way."""
    colors = (GRAY, GRAY) if is_of_words(ends.parameter) else (BLUE, ORANGE)
    away = ends.low.value - middle, ends.high.value - middle
    beside = away[0] * away[1] > 0.0
    for k, end in enumerate((ends.low, ends.high)):
        place = row + 0.19 * (2 * k - 1) if beside else row
        if np.isfinite(end.value):
            axes.barh(place, away[k], 0.36 if beside else 0.6, left=middle, color=colors[k])
            _write(axes, end.label, end.value, place, is_right=away[k] >= 0.0)
        elif end.label:
            _write(axes, f"{end.label}: no value", middle, place, is_right=not away[1 - k] >= 0.0)


def _write(axes: Axes, text: str, x: float, y: float, is_right: bool) -> None:
    """Write a text to the right or the left of a place."""
    axes.annotate(
        text,
        (x, y),
        xytext=(3 if is_right else -3, 0),
        textcoords="offset points",
        ha="left" if is_right else "right",
        va="center",
        fontsize=7,
    )
