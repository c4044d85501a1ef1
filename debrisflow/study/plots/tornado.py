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
from debrisflow.study.distributions import AnyParameter, Choice
from debrisflow.study.member import Values
from debrisflow.study.plots.labels import label_of, parameter_label, shown_value
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
OF_LISTS = "of a list of values they end at the value with the least and the greatest mean"


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

    @property
    def size(self) -> float:
        """How far the ends are apart; nan if one is missing."""
        return abs(self.high.value - self.low.value)


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
    ends = sorted(ends_of(study, points, values), key=lambda one: np.nan_to_num(one.size))
    middle = middle_of(study, values)
    figure, (axes,) = panels(1, height=max(LEAST_HEIGHT, OF_ROW * len(ends) + 0.8))
    for row, one in enumerate(ends):
        _draw(axes, row, one, middle)
    axes.axvline(middle, color=GRAY, linewidth=0.8)
    axes.set_yticks(range(len(ends)), [parameter_label(one.parameter) for one in ends])
    axes.set_ylim(-0.6, len(ends) - 0.4)
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.12)
    axes.set_xlabel(label_of(name, unit))
    sides = [("at its low end", BLUE), ("at its high end", ORANGE), ("of a list of words", GRAY)]
    words = any(is_of_words(one.parameter) for one in ends)
    handles = [Patch(color=color, label=label) for label, color in sides[: 3 if words else 2]]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False)
    return figure


def explanation(study: Study) -> str:
    """Return what the bars of a tornado plot are, for its caption."""
    if isinstance(study.design, OneAtATime):
        low, high = (f"{100 * share:g} %" for share in study.design.shares)
        what = f"{OF_ENDS}their medians; ends: {low} and {high} of all values are below"
        return f"Line: all parameters at their medians; {what}."
    lists = f"; {OF_LISTS}" if any(isinstance(one, Choice) for one in study.parameter) else ""
    return f"Line: mean of all members; {OF_FIFTHS} of the parameter{lists}."


def middle_of(study: Study, values: Floats) -> float:
    """Return the quantity of the base of a design of one at a time, of others the mean."""
    if isinstance(study.design, OneAtATime):
        return float(values[0])
    there = values[np.isfinite(values)]
    return float(there.mean()) if there.size else np.nan


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
    """Return the values with the least and the greatest mean; numbers in their order."""
    means = [_mean(values[there & (numbers == k)]) for k in range(len(parameter.values))]
    if np.isnan(means).all():
        return Ends(parameter, MISSING, MISSING)
    pair = [int(np.nanargmin(means)), int(np.nanargmax(means))]
    if not is_of_words(parameter):
        pair.sort(key=lambda k: float(parameter.values[k]))
    low, high = (End(shown_value(parameter.values[k]), means[k]) for k in pair)
    return Ends(parameter, low, high)


def _mean(values: Floats) -> float:
    return float(values.mean()) if values.size else np.nan


def is_of_words(parameter: AnyParameter) -> bool:
    """Return whether the values of a parameter are words, of which none is lower or higher."""
    return isinstance(parameter, Choice) and isinstance(parameter.values[0], str)


def _draw(axes: Axes, row: int, ends: Ends, middle: float) -> None:
    """Draw the bars of one parameter; beside each other where both go the same way."""
    colors = (GRAY, GRAY) if is_of_words(ends.parameter) else (BLUE, ORANGE)
    beside = (ends.low.value - middle) * (ends.high.value - middle) > 0.0
    for end, color, side in ((ends.low, colors[0], -1), (ends.high, colors[1], 1)):
        away = end.value - middle
        if not np.isfinite(away):
            continue
        place = row + 0.19 * side if beside else row
        axes.barh(place, away, 0.36 if beside else 0.6, left=middle, color=color)
        axes.annotate(
            end.label,
            (end.value, place),
            xytext=(3 if away >= 0.0 else -3, 0),
            textcoords="offset points",
            ha="left" if away >= 0.0 else "right",
            va="center",
            fontsize=7,
        )
