"""How all plots look: size, colors that color-blind readers can tell apart, the caption."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from debrisflow import __version__
from debrisflow.results.fonts import families, writable
from debrisflow.results.parameters import summary
from debrisflow.results.reader import Run
from debrisflow.run.atomic import replaced

WIDTH, LINE = 7.0, 0.12  # inch, of a page's text, and the height of a line of a caption
DPI = 150
CAPTION_LETTERS, MOST_LINES = 150, 10
MOST_NAMES = 12  # in a legend
# Okabe & Ito
BLUE, ORANGE, GREEN, PURPLE, SKY, RED, GRAY = (
    "#0072b2",
    "#e69f00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
    "#d55e00",
    "#555555",
)
CYCLE = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, GRAY)
PHASE_COLORS = {"liquid": SKY, "sediment": RED, "mixture": ORANGE, "all": GRAY}
MATTER_COLORS = {"water": BLUE, "sediment": RED}
LINES = ("-", "--", "-.", ":")
SETTINGS: Any = {
    "font.size": 8,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.fontsize": 7,
    "legend.framealpha": 0.8,
    "axes.titlesize": 8,
    "text.parse_math": False,  # titles and names are people's own
}


def styled() -> AbstractContextManager[None]:
    """Return a context in which figures are made and written with these settings."""
    return mpl.rc_context(SETTINGS | {"font.family": families()})


def panels(
    rows: int, columns: int = 1, height: float | Sequence[float] = 2.3, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as a page and its axes, row by row.

    Parameters
    ----------
    rows, columns : int
    height : float or sequence of float, inch
        Of all rows, or of each.
    options
        As of ``Figure.subplots``.
    """
    heights = [height] * rows if isinstance(height, float) else list(height)
    figure = Figure(figsize=(WIDTH, sum(heights) + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, height_ratios=heights, **options)
    return figure, list(np.ravel(axes))


def save(figure: Figure, path: Path, title: str, captions: Sequence[str], dpi: int = DPI) -> Path:
    """Write a figure with its title above and its captions below it."""
    figure.suptitle(title, fontsize=9, x=0.01, ha="left")
    lines = [line for text in captions for line in textwrap.wrap(text, CAPTION_LETTERS)]
    if len(lines) > MOST_LINES:
        lines[MOST_LINES - 1 :] = [f"and {len(lines) - MOST_LINES + 1} lines more"]
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + LINE * len(lines))
    figure.supxlabel("\n".join(lines), fontsize=6, x=0.01, ha="left", color=GRAY)
    with replaced(path) as unfinished:
        figure.savefig(unfinished, dpi=dpi, format="png", metadata={"Software": "debrisflow"})
    return path


def sequence(count: int) -> list[tuple[float, float, float, float]]:
    """Return colors for curves in an order, from dark to light."""
    return [mpl.colormaps["viridis"](shade) for shade in np.linspace(0.0, 0.85, count)]


def labelled(names: Sequence[str]) -> list[str]:
    """Return names for a legend, of many only some; a name with _ is left out of a legend."""
    step = -(-len(names) // MOST_NAMES)
    return [name if k % step == 0 else f"_{name}" for k, name in enumerate(names)]


def caption(run: Run) -> str:
    """Return the source of a plot: run, parameters that matter, version."""
    parts = (part.replace(" ", "\N{NO-BREAK SPACE}") for part in summary(run.case).split(", "))
    told = ", ".join(parts)
    title = f"{run.case.title}. " if writable(run.case.title) else ""
    return f"{run.name}: {title}{told}. debrisflow {__version__}"
