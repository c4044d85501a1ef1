"""Plots of the samples of probes, of one run and of several."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from debrisflow.results.plots.curves import draw_reference, legend
from debrisflow.results.plots.style import CYCLE, LINES, SETTINGS, panels
from debrisflow.results.probe_curves import ProbeCurve, probe_curve
from debrisflow.results.references import Reference
from debrisflow.results.survey import AnySurvey

HEIGHT = 1.5  # inch, of a panel
MOST_PANELS = 16
THIN = 0.4 * SETTINGS["lines.linewidth"]


def curves_to_draw(found: AnySurvey, given: Sequence[Reference]) -> list[ProbeCurve]:
    """Return the curves of the probes, with those beside them that a reference has, by probe."""
    curves = list(found.probe_curves)
    known = {_key(one) for one in curves}
    for name in _asked(found, given):
        if name not in known:
            curves.append(probe_curve(found.run, name, found.smoothing))
    order = [probe.name for probe in found.run.case.probe]
    return sorted(curves, key=lambda one: order.index(one.probe))


def _asked(found: AnySurvey, given: Sequence[Reference]) -> list[str]:
    """Return the columns of probes that references have, each once."""
    columns = [name for one in given if one.abscissa == "time" for name in one.curves]
    return [name for name in dict.fromkeys(columns) if name not in found.fronts]


def probe_figure(curves: Sequence[ProbeCurve], given: Sequence[Reference]) -> Figure:
    """Return the samples of probes, a panel each, with running means, extremes and references.

    What is 0 all the time is left out beside what is not.
    """
    measured = {name for one in given for name in one.curves}
    parts = []
    for _, group in groupby(curves, lambda one: one.probe):
        part = list(group)
        parts.append([one for one in part if one.values.any() or _key(one) in measured] or part)
    shown = parts[:MOST_PANELS]
    figure, axes = panels(len(shown), height=HEIGHT, sharex=True)
    for part, one in zip(shown, axes, strict=True):
        for curve, color in zip(part, CYCLE, strict=False):
            words = curve.column.replace("_", " ")
            one.plot(curve.time, curve.values, color=color, linewidth=THIN, alpha=0.5)
            one.plot(curve.time, curve.smooth, color=color, label=words)
            _draw_references(one, given, curve, color)
        _draw_extremes(one, part)
        _name(one, part[0])
    _finish(axes, len(parts))
    legend(*axes)
    return figure


def _draw_extremes(axes: Axes, part: Sequence[ProbeCurve]) -> None:
    """Draw the extremes of steps as bands, which do not set the scale: one step may press hard."""
    scale = axes.get_ylim()
    for curve, color in zip(part, CYCLE, strict=False):
        if np.any(curve.least < curve.greatest):
            axes.fill_between(
                curve.time, curve.least, curve.greatest, color=color, alpha=0.15, linewidth=0.0
            )
    axes.set_ylim(scale)


def _draw_references(axes: Axes, given: Sequence[Reference], curve: ProbeCurve, color: str) -> None:
    """Draw the curves of references that belong to one of a probe."""
    for reference in given:
        if reference.abscissa == "time" and _key(curve) in reference.curves:
            label = f"{reference.name}: {curve.column.replace('_', ' ')}"
            draw_reference(axes, reference, _key(curve), label, color)


def compared_probes(
    found: Sequence[AnySurvey], names: Sequence[str], given: Sequence[Reference]
) -> Figure | None:
    """Return the running means of the curves that all runs have, a panel each; None if none.

    What is 0 all the time in all runs is left out.
    """
    curves_of = [curves_to_draw(each, given) for each in found]
    known = [{(one.probe, one.column): one for one in curves} for curves in curves_of]
    common = [key for key in known[0] if all(key in curves for curves in known)]
    asked = _asked(found[0], given)
    common = [
        key
        for key in common
        if ".".join(key) in asked or any(curves[key].values.any() for curves in known)
    ]
    if not common:
        return None
    # those that are measured first, since only so many are drawn
    common.sort(key=lambda key: ".".join(key) not in asked)
    shown = common[:MOST_PANELS]
    figure, axes = panels(len(shown), height=HEIGHT, sharex=True)
    for key, one in zip(shown, axes, strict=True):
        for k, (curves, name) in enumerate(zip(known, names, strict=True)):
            curve, line = curves[key], LINES[k // len(CYCLE) % len(LINES)]
            one.plot(curve.time, curve.smooth, line, color=CYCLE[k % len(CYCLE)], label=name)
        _draw_references(one, given, known[0][key], "black")
        _name(one, known[0][key], key[1].replace("_", " "))
    _finish(axes, len(common))
    legend(*axes[: max(1, len(asked))])
    return figure


def compared_span(found: Sequence[AnySurvey]) -> float:
    """Return the time over which the running means of runs go, s."""
    return max((curve.span for one in found for curve in one.probe_curves), default=np.nan)


def _key(curve: ProbeCurve) -> str:
    """Return the name of a curve in a reference."""
    return f"{curve.probe}.{curve.column}"


def _name(axes: Axes, curve: ProbeCurve, column: str = "") -> None:
    """Write the name of a probe over a panel, and its unit beside it."""
    axes.set_title(" ".join(filter(None, (curve.probe, column))), loc="left")
    axes.set_ylabel(curve.unit)


def _finish(axes: Sequence[Axes], count: int) -> None:
    """Write what the time is, and how many panels there would be more."""
    more = f"; {count - len(axes)} more are in the tables only" if count > len(axes) else ""
    axes[-1].set_xlabel(f"time, s{more}")
