"""A page of panels laid out in centimeters: heading, panels with their times, key of the colors."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from debrisflow.particles.arrays import COLORED
from debrisflow.results.fonts import families, is_latin
from debrisflow.results.pictures.coloring import COLOR_MAP, Scale

WIDTH = 16.0  # of a page's text, cm
TALLEST_PAGE = 23.0
TALLEST_PANEL = 11.0
MOST_COLUMNS = 3
CENTIMETERS_PER_INCH = 2.54
HEADING, KEY, ABOVE, BELOW, LABEL, RIGHT = 1.15, 1.55, 0.5, 0.15, 0.75, 0.35
TEXT, SMALL = 8.0, 7.0


class Layout(NamedTuple):
    """Places of the panels of a page, cm.

    Attributes
    ----------
    columns, rows : int
    width, height : float
        Of a panel.
    left : float
        Beside each panel, for the ticks and the word of the axis.
    """

    columns: int
    rows: int
    width: float
    height: float
    left: float

    @property
    def page(self) -> float:
        """Return the height of the page, cm."""
        return HEADING + self.rows * (ABOVE + self.height + BELOW) + LABEL + KEY

    def place(self, number: int) -> tuple[float, float, float, float]:
        """Return left, bottom, width and height of a panel, as shares of the page."""
        row, column = divmod(number, self.columns)
        slot = WIDTH / self.columns
        spare = slot - self.left - self.width - RIGHT
        x = column * slot + self.left + 0.5 * spare
        y = self.page - HEADING - row * (ABOVE + self.height + BELOW) - ABOVE - self.height
        return x / WIDTH, y / self.page, self.width / WIDTH, self.height / self.page


def layout(panels: int, aspect: float, left: float = 1.55) -> Layout:
    """Return how panels fit on a page: below each other, or side by side where these are too tall.

    Parameters
    ----------
    panels : int
    aspect : float
        Height of a panel over its width.
    left : float, cm
        Room beside each panel.

    Examples
    --------
    >>> layout(6, 0.15).columns, layout(6, 0.5).columns, layout(6, 1.0).columns
    (1, 2, 3)
    """
    for columns in range(1, min(panels, MOST_COLUMNS) + 1):
        width = WIDTH / columns - left - RIGHT
        width = min(width, TALLEST_PANEL / aspect)
        fitting = Layout(columns, ceil(panels / columns), width, width * aspect, left)
        if fitting.page <= TALLEST_PAGE:
            break
    return fitting


def panel_width(left: float = 1.55) -> float:
    """Return the width of a panel that has the page for itself, cm."""
    return WIDTH - left - RIGHT


class Sheet:
    """A page whose panels show pictures over their window.

    Parameters
    ----------
    panels : int
    plan : Layout
    dots : int
        Dots per inch.
    heading : (str, str)
        Title, and a line of what else is to be known.
    """

    def __init__(self, panels: int, plan: Layout, dots: int, heading: tuple[str, str]) -> None:
        self.panels, self.plan = panels, plan
        size = (WIDTH / CENTIMETERS_PER_INCH, plan.page / CENTIMETERS_PER_INCH)
        self.figure = Figure(figsize=size, dpi=dots)
        title, line = heading
        self._text(0.35, 0.25, title, fontsize=TEXT + 1.0, fontweight="bold", va="top")
        self._text(0.35, 0.72, line, fontsize=SMALL, va="top", color="#333333")

    def _text(self, x: float, from_top: float, text: str, **how: Any) -> None:
        place = (x / WIDTH, 1.0 - from_top / self.plan.page)
        if not is_latin(text):  # fonts for Japanese may come without bold letters
            how |= {"fontfamily": families(), "fontweight": "normal"}
        self.figure.text(*place, text, parse_math=False, **how)

    @property
    def pixels(self) -> tuple[int, int]:
        """Return width and height of a panel."""
        dots = self.figure.dpi / CENTIMETERS_PER_INCH
        return round(self.plan.width * dots), round(self.plan.height * dots)

    def panel(self, number: int) -> Axes:
        """Return the empty axes of a panel."""
        return self.figure.add_axes(self.plan.place(number))

    def label(self, axes: Axes, number: int) -> None:
        """Write the ticks of a panel, and the word of its x axis where no panel is below."""
        lowest = number + self.plan.columns >= self.panels
        axes.tick_params(labelsize=SMALL, length=2.5, pad=2, labelbottom=lowest)
        if lowest:
            axes.set_xlabel("x (m)", fontsize=SMALL, labelpad=2)

    def add_scale(self, scale: Scale) -> None:
        """Draw the color bar of a field."""
        place = (0.25, 1.05 / self.plan.page, 0.5, 0.25 / self.plan.page)
        axes = self.figure.add_axes(place)
        values = ScalarMappable(Normalize(scale.low, scale.high), colormaps[COLOR_MAP])
        extend = "max" if scale.clipped else "neither"
        bar = self.figure.colorbar(values, cax=axes, orientation="horizontal", extend=extend)
        note = f"; beyond the scale up to {scale.greatest:.3g} in these panels"
        label = COLORED[scale.by].color_label + (note if scale.clipped else "")
        bar.set_label(label, fontsize=SMALL)
        axes.tick_params(labelsize=SMALL, length=2.5, pad=2)
        axes.xaxis.set_major_locator(MaxNLocator(6))

    def add_kinds(self, words: dict[str, str]) -> None:
        """Draw a legend: a word for each color."""
        patches = [Patch(color=color, label=word) for color, word in words.items()]
        self.figure.legend(
            handles=patches,
            loc="center",
            bbox_to_anchor=(0.5, 0.65 / self.plan.page),
            ncols=len(patches),
            frameon=False,
            fontsize=TEXT,
        )

    def image(self) -> NDArray[np.uint8]:
        """Return the page as it stands, (height, width, 3) array of 0 to 255."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas = FigureCanvasAgg(self.figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
