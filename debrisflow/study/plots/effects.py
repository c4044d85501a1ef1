"""Plots of the indices of sensitivity: shares of the variance, and elementary effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from debrisflow.results.plots.style import BLUE, GRAY, LINES, ORANGE, panels
from debrisflow.study.plots.labels import label_of
from debrisflow.study.sensitivity import Effect

SHARES = {"S1": ("alone (S1)", BLUE), "ST": ("with interactions (ST)", ORANGE)}
OF_BAR, LEAST_HEIGHT = 0.4, 1.6  # inch
SLOPES = {1.0: "sigma = mu*", 0.5: "sigma = mu* / 2", 0.1: "sigma = mu* / 10"}


def shares_figure(effects: Sequence[Effect]) -> Figure:
    """Return bars of the shares of the variance with their confidence, the greatest first.

    Parameters
    ----------
    effects : sequence of Effect
        On one quantity, ``S1`` and ``ST`` where there are any.
    """
    measures = [name for name in SHARES if any(one.measure == name for one in effects)]
    by = {(one.measure, one.parameter): one for one in effects}
    names = sorted(
        dict.fromkeys(one.parameter for one in effects),
        key=lambda name: np.nan_to_num(by[measures[-1], name].value),
    )
    figure, (axes,) = panels(1, height=max(LEAST_HEIGHT, OF_BAR * len(names) + 0.8))
    width = 0.7 / len(measures)
    for k, measure in enumerate(measures):
        label, color = SHARES[measure]
        rows = [by[measure, name] for name in names]
        axes.barh(
            np.arange(len(names)) + width * ((len(measures) - 1) / 2 - k),
            [one.value for one in rows],
            width,
            xerr=[one.confidence for one in rows],
            color=color,
            label=label,
            error_kw={"ecolor": "black", "elinewidth": 0.8, "capsize": 2},
        )
    axes.axvline(0.0, color=GRAY, linewidth=0.8)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(-0.6, len(names) - 0.4)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("share of the variance; lines: 95 % confidence")
    figure.legend(loc="outside upper right", ncols=2, frameon=False)
    return figure


def morris_figure(effects: Sequence[Effect], unit: str) -> Figure:
    """Return the scatter of the elementary effects over their mean size, a point a parameter.

    Parameters
    ----------
    effects : sequence of Effect
        On one quantity, ``mu_star`` and ``sigma``.
    unit : str
        Of the quantity.
    """
    mean = {one.parameter: one for one in effects if one.measure == "mu_star"}
    scatter = {one.parameter: one.value for one in effects if one.measure == "sigma"}
    figure, (axes,) = panels(1, height=3.6)
    for name, one in mean.items():
        place = one.value, scatter[name]
        axes.errorbar(
            *place,
            xerr=one.confidence,
            fmt="o",
            color=BLUE,
            markersize=5,
            capsize=2,
            elinewidth=0.8,
        )
        axes.annotate(name, place, xytext=(5, 4), textcoords="offset points", fontsize=8)
    far = np.nanmax([0.0, *(one.value + one.confidence for one in mean.values())]) or 1.0
    high = np.nanmax([0.0, *scatter.values()])
    for (slope, label), line in zip(SLOPES.items(), LINES, strict=False):
        axes.plot([0.0, far], [0.0, slope * far], line, color=GRAY, linewidth=0.8, label=label)
    axes.set_xlim(0.0, 1.15 * far)
    axes.set_ylim(-0.02 * far, max(1.15 * high, 0.15 * far))
    axes.set_xlabel(label_of("mean size of the effect, mu*", unit))
    axes.set_ylabel(label_of("standard deviation, sigma", unit))
    axes.legend(loc="upper left")
    return figure
