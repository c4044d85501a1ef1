"""The quantity of each member against the value of each parameter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.results.plots.style import BLUE, ORANGE, panels
from debrisflow.study.designs import numbers_of
from debrisflow.study.distributions import Choice, Values
from debrisflow.study.plots.labels import is_of_words, label_of, parameter_label, shown_value
from debrisflow.study.tables import Study

Floats = NDArray[np.float64]
COLUMNS = 3
FIFTHS, LEAST_MEMBERS = 5, 20  # of a line of means
MOST_LEVELS = 10  # values of a parameter up to which each has a mean of its own
EXPLANATION = (
    "A dot a member; orange: means over fifths of the members, by the parameter, or at each of its "
    "values where these are few."
)


def scatter_figure(
    study: Study, points: Sequence[Values], values: Floats, name: str, unit: str
) -> Figure:
    """Return a panel for each parameter.

    Parameters
    ----------
    study : Study
    points : sequence of dict
        Of the members.
    values : (members,) float64 array
        Of the quantity; nan where there is none.
    name, unit : str
        Of the quantity.
    """
    count = len(study.parameter)
    columns = min(COLUMNS, count)
    figure, axes = panels(-(-count // columns), columns, sharey=True)
    there = np.isfinite(values)
    for k, (parameter, panel) in enumerate(zip(study.parameter, axes, strict=False)):
        numbers = numbers_of(parameter, points)
        panel.plot(numbers[there], values[there], ".", color=BLUE, alpha=0.5, markersize=4)
        if there.sum() >= LEAST_MEMBERS:
            line = "o" if is_of_words(parameter) else "-o"
            panel.plot(*_means(numbers[there], values[there]), line, color=ORANGE, markersize=3)
        if isinstance(parameter, Choice):
            labels = [shown_value(value) for value in parameter.values]
            panel.set_xticks(range(len(labels)), labels)
            panel.set_xlim(-0.5, len(labels) - 0.5)
        panel.set_xlabel(parameter_label(parameter))
        if k % columns == 0:
            panel.set_ylabel(label_of(name, unit))
    for panel in axes[count:]:
        panel.set_visible(False)
    return figure


def _means(numbers: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return the means of parts of the members: their parameter, their quantity."""
    levels = np.unique(numbers)
    if len(levels) <= MOST_LEVELS:
        parts = [np.flatnonzero(numbers == level) for level in levels]
    else:
        parts = np.array_split(np.argsort(numbers, kind="stable"), FIFTHS)
    of_numbers, of_values = (
        np.array([row[part].mean() for part in parts]) for row in (numbers, values)
    )
    return of_numbers, of_values
