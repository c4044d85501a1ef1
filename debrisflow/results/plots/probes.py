"""Plots of the samples of probes, of one run and of several."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from debrisflow.results.plots.curves import legend
from debrisflow.results.plots.style import CYCLE, LINES, SETTINGS, panels
from debrisflow.results.probe_curves import ProbeCurve
from debrisflow.results.references import Reference
from debrisflow.results.survey import Survey

HEIGHT = 1.5  # inch, of a panel
THIN = 0.4 * SETTINGS["lines.linewidth"]


def probe_figure(found: Survey, given: Sequence[Reference]) -> Figure:
    """Return the samples of the probes, a panel each, with running means and references."""
    parts = [list(part) for _, part in groupby(found.probe_curves, lambda one: one.probe)]
    figure, axes = panels(len(parts), height=HEIGHT, sharex=True)
    for part, one in zip(parts, axes, strict=True):
        for curve, color in zip(part, CYCLE, strict=False):
            one.plot(curve.time, curve.values, color=color, linewidth=THIN, alpha=0.5)
            one.plot(curve.time, curve.smooth, color=color, label=curve.column.replace("_", " "))
            _draw_references(one, curve, given)
        _name(one, part[0])
    axes[-1].set_xlabel("time, s")
    legend(*axes)
    return figure


def compared_probes(found: Sequence[Survey], names: Sequence[str]) -> Figure | None:
    """Return the running means of the curves that all runs have, a panel each; None if none."""
    known = [{(one.probe, one.column): one for one in each.probe_curves} for each in found]
    common = [key for key in known[0] if all(key in curves for curves in known)]
    if not common:
        return None
    figure, axes = panels(len(common), height=HEIGHT, sharex=True)
    for key, one in zip(common, axes, strict=True):
        for k, (curves, name) in enumerate(zip(known, names, strict=True)):
            curve, line = curves[key], LINES[k // len(CYCLE) % len(LINES)]
            one.plot(curve.time, curve.smooth, line, color=CYCLE[k % len(CYCLE)], label=name)
        _name(one, known[0][key], key[1].replace("_", " "))
    axes[-1].set_xlabel("time, s")
    legend(axes[0])
    return figure


def _name(axes: Axes, curve: ProbeCurve, column: str = "") -> None:
    """Write the name of a probe over a panel, and its unit beside it."""
    axes.set_title(" ".join(filter(None, (curve.probe, column))), loc="left")
    axes.set_ylabel(curve.unit)


def _draw_references(axes: Axes, curve: ProbeCurve, given: Sequence[Reference]) -> None:
    name = f"{curve.probe}.{curve.column}"
    for reference, line in zip(given, LINES * len(given), strict=False):
        if reference.abscissa != "time" or name not in reference.curves:
            continue
        time, values = reference.table["time"], reference.table[name]
        known = ~np.isnan(values)
        axes.plot(time[known], values[known], line, color="black", label=reference.name)
        band = reference.band(name)
        if band is not None:
            axes.fill_between(time, *band, color="black", alpha=0.15, linewidth=0.0)
