"""Map elements: coordinates on the frame, a scale bar and a north arrow."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.ticker import FuncFormatter, MultipleLocator
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid
from debrisflow.results.words import Words

ROUND = (1.0, 2.0, 5.0, 10.0)
BAR, PARTS = 1.4, 4  # inch, of the scale bar, at most, and its black and white parts
BOX = (2.0, 0.5)  # inch, of the corner with scale bar and north arrow
INSIDE = 0.07  # inch, from the frame
INTERVALS = 4  # between ticks along the shorter side
HALO: list[AbstractPathEffect] = [withStroke(linewidth=1.8, foreground="white")]
# right and up; of corners that are equally free the first is taken
CORNERS = ((0, 0), (1, 0), (0, 1), (1, 1))
INK = "#222222"
AT_CORNER = 0.03  # of the height of a map, where a label would touch that of the other axis


def crs_name(crs: str) -> str:
    """Return the name of a coordinate reference system given as WKT; empty if there is none.

    Examples
    --------
    >>> crs_name('PROJCS["WGS 84 / UTM zone 10N",GEOGCS["WGS 84"]]')
    'WGS 84 / UTM zone 10N'
    """
    found = re.search(r'(?:PROJCS|PROJCRS|LOCAL_CS|ENGCRS)\["([^"]+)"', crs)
    return found.group(1) if found else ""


def round_length(most: float) -> float:
    """Return the greatest of 1, 2, 5, 10 and so on that is not more than a length.

    Examples
    --------
    >>> round_length(73.0), round_length(0.3), round_length(100.0)
    (50.0, 0.2, 100.0)
    """
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(step * power for step in ROUND if step * power <= most * (1.0 + 1e-9)))


def grouped(value: float) -> str:
    """Return a whole number in groups of three digits, with thin spaces between them.

    Examples
    --------
    >>> grouped(-71400.0).split()
    ['-71', '400']
    """
    return f"{value:,.0f}".replace(",", "\N{THIN SPACE}")


def draw_frame(axes: Axes, grid: MapGrid, words: Words) -> None:
    """Write map coordinates on the frame of a map, in true proportions."""
    axes.set(xlim=(grid.west, grid.east), ylim=(grid.south, grid.north), aspect="equal")
    shorter = min(grid.east - grid.west, grid.north - grid.south)
    step = round_length(shorter / INTERVALS * 1.3)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: grouped(value)))
    ends, corner = (grid.south, grid.north), AT_CORNER * (grid.north - grid.south)
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: grouped(value) if _is_within(value, ends, corner) else "")
    )
    axes.tick_params(
        labelsize=6.5, length=3, top=True, right=True, direction="out", color=INK, pad=2
    )
    axes.tick_params(axis="y", labelrotation=90)
    for label in axes.get_yticklabels():
        label.set_verticalalignment("center")
    axes.grid(True, color="white", alpha=0.35, linewidth=0.4)
    name = crs_name(grid.crs) or words("coordinate system not stated")
    axes.set_xlabel(words("Easting, m ({crs})", crs=name), fontsize=7)
    axes.set_ylabel(words("Northing, m"), fontsize=7)


def _is_within(value: float, ends: tuple[float, float], margin: float) -> bool:
    """Return whether a value is farther than a margin from both ends of an interval."""
    return ends[0] + margin < value < ends[1] - margin


def emptiest_corner(covered: NDArray[np.bool_], share: tuple[float, float]) -> tuple[int, int]:
    """Return the corner of a map in which least is covered, as right and up, 0 or 1.

    Parameters
    ----------
    covered : (rows, columns) bool array
        The northernmost row first.
    share : (float, float)
        Of the width and the height of the map, that the corner takes.

    Examples
    --------
    >>> covered = np.zeros((4, 4), dtype=bool)
    >>> covered[2:, :2] = True  # in the south-west
    >>> emptiest_corner(covered, (0.5, 0.5))
    (1, 0)
    """
    rows, columns = covered.shape
    wide, deep = (min(int(np.ceil(s * n)), n) for s, n in zip(share, (columns, rows), strict=True))
    found = {}
    for right, up in CORNERS:
        side = slice(columns - wide, None) if right else slice(0, wide)
        part = slice(0, deep) if up else slice(rows - deep, None)
        found[right, up] = int(covered[part, side].sum())
    return min(CORNERS, key=lambda corner: found[corner])


def draw_scale_and_north(
    axes: Axes, grid: MapGrid, size: tuple[float, float], covered: NDArray[np.bool_], words: Words
) -> None:
    """Draw a scale bar and a north arrow into the corner of a map where least is covered.

    Parameters
    ----------
    axes : Axes
    grid : MapGrid
        Of the part that is shown.
    size : (float, float), inch
        Of the map.
    covered : (rows, columns) bool array
        Cells that should stay free.
    words : Words
    """
    right, up = emptiest_corner(covered, (BOX[0] / size[0], BOX[1] / size[1]))
    inch = (grid.east - grid.west) / size[0]
    west = grid.east - (BOX[0] + INSIDE) * inch if right else grid.west + INSIDE * inch
    south = grid.north - (BOX[1] + INSIDE) * inch if up else grid.south + INSIDE * inch
    paper = Rectangle((west, south), BOX[0] * inch, BOX[1] * inch, zorder=8)
    paper.set(facecolor="white", edgecolor=INK, linewidth=0.5, alpha=0.88)
    axes.add_patch(paper)
    _draw_bar(axes, west + 0.12 * inch, south + 0.13 * inch, inch)
    _draw_north(axes, west + (BOX[0] - 0.17) * inch, south + 0.06 * inch, inch, words)


def _draw_bar(axes: Axes, west: float, south: float, inch: float) -> None:
    """Draw a scale bar from its corner; an inch of paper is given in m of the map."""
    length, thick = round_length(BAR * inch), 0.06 * inch
    for part in range(PARTS):
        color = INK if part % 2 == 0 else "white"
        piece = Rectangle((west + part * length / PARTS, south), length / PARTS, thick, zorder=9)
        piece.set(facecolor=color, edgecolor=INK, linewidth=0.5)
        axes.add_patch(piece)
    for share in (0.0, 0.5, 1.0):
        text = f"{share * length:g}" + (" m" if share == 1.0 else "")
        place = (west + share * length, south + thick + 0.04 * inch)
        axes.text(*place, text, ha="center", va="bottom", fontsize=6.5, color=INK, zorder=9)


def _draw_north(axes: Axes, x: float, y: float, inch: float, words: Words) -> None:
    """Draw an arrow to the north of the map, its foot at a place."""
    tip, wing, notch = 0.27 * inch, 0.07 * inch, 0.06 * inch
    for side, color in ((-1, INK), (1, "white")):
        corners = [(x, y + tip), (x + side * wing, y), (x, y + notch)]
        axes.add_patch(Polygon(corners, facecolor=color, edgecolor=INK, linewidth=0.5, zorder=9))
    axes.text(
        x, y + tip + 0.01 * inch, words("N"), ha="center", va="bottom",
        fontsize=7, color=INK, zorder=9,
    )  # fmt: skip
