"""The figure of a comparison: what was computed at all levels over its reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator

from debrisflow.results.plots.style import BLUE, GRAY, panels, save, sequence, styled
from debrisflow.validation.convergence import Convergence
from debrisflow.validation.curves import Curve, Kind, Panel
from debrisflow.validation.result import Result

FIGURES = "figures"
COLUMNS, HEIGHT = 2, 2.4  # of panels, and inch of a row of them
LEVELS_WITH_ORDER = 2
DPI = 100  # all figures stand on one page
FEW_POINTS, DOTS = 40, (5.0, 2.0)
"""Points of a curve below which its dots are large, and the sizes of large and small ones."""


def drawn(folder: Path) -> set[str]:
    """Return the names of the comparisons that have a figure in a folder."""
    return {file.stem for file in (folder / FIGURES).glob("*.png")}


def draw(result: Result, folder: Path) -> Path | None:
    """Draw a comparison into a folder, and return the file; None if there is nothing to show.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    shown, errors = result.panels, result.convergence
    has_errors = len(errors.steps) >= LEVELS_WITH_ORDER
    count = len(shown) + has_errors
    if count == 0:
        return None
    path = folder / FIGURES / f"{result.comparison.name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    labels = [level.label for level in result.levels]
    colors = dict(zip(labels, reversed(sequence(len(labels))), strict=True))
    columns = min(COLUMNS, count)
    with styled():
        figure, grid = panels(-(-count // columns), columns, HEIGHT)
        for axes, panel in zip(grid, shown, strict=False):
            _draw_panel(axes, panel, colors)
        if has_errors:
            _draw_errors(grid[len(shown)], errors)
        for axes in grid[count:]:
            axes.axis("off")
        origins = dict.fromkeys(
            f"debrisflow {level.origin.version}, {level.origin.date}" for level in result.levels
        )
        one = result.comparison
        captions = [f"Reference: {one.reference}.", "; ".join(origins)]
        return save(figure, path, one.title, captions, DPI)


def _draw_panel(axes: Axes, panel: Panel, colors: Mapping[str, object]) -> None:
    for curve, label in _labelled(panel):
        color = next((colors[name] for name in colors if label.startswith(name)), BLUE)
        if curve.kind is Kind.MEASURED:
            axes.plot(curve.x, curve.y, "o", color="black", ms=2.5, label=label, zorder=3)
        elif curve.kind is Kind.EXACT:
            axes.plot(curve.x, curve.y, color="black", lw=0.9, label=label)
        elif curve.kind is Kind.POINTS:
            size = DOTS[len(curve.x) >= FEW_POINTS]
            axes.plot(curve.x, curve.y, "o", color=color, mew=0, ms=size, label=label)
        else:
            axes.plot(curve.x, curve.y, color=color, lw=1.0, label=label)
    axes.set_title(panel.title, loc="left")
    axes.set(xlabel=panel.x_label, ylabel=panel.y_label)
    axes.legend()


def _labelled(panel: Panel) -> Iterator[tuple[Curve, str]]:
    """Yield curves with labels, of those with the same one only the first in the legend."""
    seen: set[str] = set()
    for curve in panel.curves:
        yield curve, f"_{curve.label}" if curve.label in seen else curve.label
        seen.add(curve.label)


def _tick(axis: Axis) -> None:
    """Give a logarithmic axis ticks at 1, 2 and 5, or more within less than a decade."""
    low, high = sorted(axis.get_view_interval())
    digits = (
        (1, 2, 3, 4, 5, 6, 8) if high < 10.0 * low else (1, 2, 5) if high < 100.0 * low else (1,)
    )
    axis.set_major_locator(LogLocator(subs=digits))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def _draw_errors(axes: Axes, errors: Convergence) -> None:
    """Draw the error over the processor time, the levels beside their points."""
    seconds = [max(step.seconds, 0.1) for step in errors.steps]
    values = [100.0 * step.error for step in errors.steps]
    axes.plot(seconds, values, "o-", color=BLUE)
    for step, x, y in zip(errors.steps, seconds, values, strict=True):
        axes.annotate(
            step.label, (x, y), (3, 3), textcoords="offset points", color=GRAY, fontsize=7
        )
    axes.set(xscale="log", xlabel="processor time (s)", ylabel="error (%)")
    axes.margins(x=0.25, y=0.15)  # for the names of the levels
    if min(values) > 0.0 and max(values) / min(values) > 3.0:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.2 * max(values))
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            _tick(axis)
    told = f"order {errors.order:.1f}" if isfinite(errors.order) else "no order"
    axes.set_title(f"error over cost: {told}", loc="left")
