"""A map sheet: one layer over the relief, with key, scale, north arrow and sources."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from types import MappingProxyType
from typing import Any, NamedTuple

import contourpy
import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results.fonts import families, wrapped, writable
from debrisflow.results.maps.furniture import HALO, INK, draw_frame, draw_scale_and_north
from debrisflow.results.maps.layers import Layer
from debrisflow.results.maps.looks import Look
from debrisflow.results.maps.relief import Contours, contours, hillshade
from debrisflow.results.words import Words

Floats = NDArray[np.float64]
WIDEST, TALLEST = 5.6, 8.0  # inch, of a map
LEFT, RIGHT, ABOVE, BELOW = 0.6, 1.35, 0.62, 0.5  # inch, around it
LINE, LETTERS = 0.115, 0.052  # inch, of the text below: a line, and the mean width of a letter
OPAQUE = 0.85  # of a layer over the relief
PAPER = 0.84  # gray behind the color bar: about that of the relief, so that colors are alike
RELEASE = "#d4006a"
OUTLINED = "#1a1a1a"
CONTOUR = "#4a3b28"
SHORTEST_LINE = 2.5  # cells
LABEL_AT = (0.3, 0.7)  # shares of lines that follow each other, so that labels lie apart
NAME_LETTERS = 16  # of a line of the name of a class
SETTINGS: Any = {"text.parse_math": False, "font.size": 7.5, "axes.unicode_minus": False}


class Ground(NamedTuple):
    """What is under all layers of a run.

    Attributes
    ----------
    terrain : Raster
        Elevation, m.
    release : (rows, columns) array or None
        Depth of what is released, m, nan where nothing is.
    structures : mapping of list of (n, 2) array, m, by name
        Outlines of dams and the like.
    """

    terrain: Raster
    release: Floats | None = None
    structures: Mapping[str, list[Floats]] = MappingProxyType({})

    @property
    def grid(self) -> MapGrid:
        """Return the grid of the part that is shown."""
        return self.terrain.grid


class Text(NamedTuple):
    """The words around a map.

    Attributes
    ----------
    title, subtitle : str
    source : tuple of str
        Lines below the map.
    """

    title: str
    subtitle: str
    source: tuple[str, ...]


def styled(words: Words) -> AbstractContextManager[None]:
    """Return a context in which maps are drawn and written, with fonts for a language."""
    return mpl.rc_context(SETTINGS | {"font.family": families(words.language)})


def draw_map(ground: Ground, layer: Layer, text: Text, words: Words) -> Figure:
    """Return the map of a layer.

    Parameters
    ----------
    ground : Ground
    layer : Layer
    text : Text
    words : Words
    """
    figure, axes, size = figure_of(ground.grid, text)
    levels = draw_relief(axes, ground.terrain)
    _draw_layer(axes, ground.grid, layer)
    released = ground.release is not None and bool(np.isfinite(ground.release).any())
    _draw_outline(axes, ground.grid, np.isfinite(layer.values), INK, 0.5)
    if layer.look.outlined is not None:
        for color, width in (("white", 3.0), (OUTLINED, 1.6)):
            _draw_outline(axes, ground.grid, layer.values >= layer.look.outlined, color, width)
    if ground.release is not None:
        for color, width in (("white", 2.6), (RELEASE, 1.4)):
            _draw_outline(axes, ground.grid, np.isfinite(ground.release), color, width)
    for name, rings in ground.structures.items():
        draw_structure(axes, name, rings)
    draw_frame(axes, ground.grid, words)
    draw_scale_and_north(axes, ground.grid, size, np.isfinite(layer.values), words)
    _draw_key(figure, axes, layer, words)
    _draw_signs(figure, axes, layer.look, levels, released, words)
    return figure


def figure_of(grid: MapGrid, text: Text) -> tuple[Figure, Axes, tuple[float, float]]:
    """Return a figure with its texts, the axes of the map and their size, inch."""
    ratio = (grid.north - grid.south) / (grid.east - grid.west)
    width = min(WIDEST, TALLEST / ratio)
    height = width * ratio
    whole = LEFT + width + RIGHT
    letters = int(whole / LETTERS)
    lines = [line for given in text.source for line in wrapped(given, letters)]
    below = BELOW + LINE * len(lines) + 0.08
    tall = ABOVE + height + below
    figure = Figure(figsize=(whole, tall))
    axes = figure.add_axes((LEFT / whole, below / tall, width / whole, height / tall))
    figure.text(0.1 / whole, 1.0 - 0.12 / tall, text.title, va="top", fontsize=11.5)
    figure.text(0.1 / whole, 1.0 - 0.36 / tall, text.subtitle, va="top", fontsize=8, color=INK)
    figure.text(
        0.1 / whole, 0.06 / tall, "\n".join(lines), va="bottom", fontsize=6, color="#444444"
    )
    return figure, axes, (width, height)


def _extent(grid: MapGrid) -> tuple[float, float, float, float]:
    return grid.west, grid.east, grid.south, grid.north


def draw_relief(axes: Axes, terrain: Raster) -> Contours:
    """Draw hillshade and contours, and return the elevations of these."""
    grid, found = terrain.grid, contours(terrain)
    axes.imshow(
        hillshade(terrain), cmap="gray", vmin=0.0, vmax=1.0, extent=_extent(grid),
        interpolation="bilinear", zorder=1,
    )  # fmt: skip
    x = grid.west + grid.cell * (np.arange(grid.columns) + 0.5)
    y = grid.north - grid.cell * (np.arange(grid.rows) + 0.5)
    level = np.ma.masked_invalid(terrain.values)
    for levels, width in ((found.thin, 0.3), (found.labelled, 0.7)):
        if levels.size and min(level.shape) >= 2:
            lines = axes.contour(
                x, y, level, levels, colors=CONTOUR, linewidths=width, alpha=0.75, zorder=4
            )
            if levels is found.labelled:
                drawn = axes.clabel(lines, fmt="%g", fontsize=6, inline_spacing=2)
                for label in drawn:
                    label.set(path_effects=HALO, color=CONTOUR, zorder=5, clip_on=True)
    return found


def _draw_layer(axes: Axes, grid: MapGrid, layer: Layer) -> None:
    scale = layer.scale
    colors, norm = scale.map_and_norm
    shown = np.ma.masked_invalid(layer.values)
    axes.imshow(
        shown, cmap=colors, norm=norm, extent=_extent(grid), interpolation="nearest",
        alpha=OPAQUE, zorder=3,
    )  # fmt: skip
    if layer.look.has_lines:
        for number, bound in enumerate(scale.bounds[1:].tolist()):
            _draw_line(axes, grid, layer, bound, LABEL_AT[number % 2])


def _draw_line(axes: Axes, grid: MapGrid, layer: Layer, value: float, share: float) -> None:
    """Draw where a layer has a value, with a label on the way; not around single cells."""
    lines = value_lines(grid, layer.values, value)
    lengths = [float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines]
    for line, length in zip(lines, lengths, strict=True):
        if length < SHORTEST_LINE * grid.cell:
            continue
        axes.plot(*line.T, color="black", linewidth=0.9, zorder=6, scalex=False, scaley=False)
        if length == max(lengths):
            x, y = line[int(share * (len(line) - 1))]
            axes.text(
                x, y, f"{value:g} {layer.look.unit}", fontsize=6.5, ha="center", va="center",
                path_effects=HALO, zorder=9, clip_on=True,
            )  # fmt: skip


def value_lines(grid: MapGrid, values: Floats, value: float) -> list[Floats]:
    """Return lines on the map where values of cells have a value, (n, 2) arrays, m.

    Examples
    --------
    >>> values = np.array([[0.0, 2.0], [0.0, 2.0]])
    >>> [line.tolist() for line in value_lines(MapGrid(0.0, 0.0, 1.0, 2, 2), values, 1.0)]
    [[[1.0, 0.5], [1.0, 1.5]]]
    """
    if min(values.shape) < 2:
        return []
    x = grid.west + grid.cell * (np.arange(grid.columns) + 0.5)
    y = grid.north - grid.cell * (np.arange(grid.rows) + 0.5)
    maker = contourpy.contour_generator(x, y, np.ma.masked_invalid(values))
    return [np.asarray(line) for line in maker.lines(value)]


def _draw_outline(
    axes: Axes, grid: MapGrid, inside: NDArray[np.bool_], color: str, width: float
) -> None:
    """Draw the border of some cells along their edges."""
    lines = outline(grid, inside)
    axes.add_collection(
        LineCollection(lines, colors=color, linewidths=width, capstyle="round", zorder=6)
    )


def draw_structure(axes: Axes, name: str, rings: Sequence[Floats]) -> None:
    """Draw a structure with its name."""
    for ring in rings:
        axes.add_patch(Polygon(ring, facecolor="white", edgecolor=INK, linewidth=1.0, zorder=7))
    if rings and writable(name):
        x, y = rings[0].max(axis=0)
        axes.annotate(
            name, (x, y), xytext=(3, 3), textcoords="offset points", fontsize=6.5,
            path_effects=HALO, zorder=9, annotation_clip=True,
        )  # fmt: skip


def outline(grid: MapGrid, inside: NDArray[np.bool_]) -> list[Floats]:
    """Return the edges between cells inside and outside, each as two points on the map, m.

    Examples
    --------
    >>> cells = np.array([[False, False], [True, False]])
    >>> len(outline(MapGrid(0.0, 0.0, 1.0, 2, 2), cells))
    4
    """
    padded = np.pad(inside, 1)
    x = grid.west + grid.cell * np.arange(grid.columns + 1)
    y = grid.north - grid.cell * np.arange(grid.rows + 1)
    upright = np.argwhere(padded[1:-1, 1:] != padded[1:-1, :-1])
    level = np.argwhere(padded[1:, 1:-1] != padded[:-1, 1:-1])
    return [np.array([(x[k], y[i]), (x[k], y[i + 1])]) for i, k in upright] + [
        np.array([(x[k], y[i]), (x[k + 1], y[i])]) for i, k in level
    ]


def _draw_key(figure: Figure, axes: Axes, layer: Layer, words: Words) -> None:
    """Draw the color bar with the unit, or the names of classes, and what is not shown."""
    left, bottom, width, height = axes.get_position().bounds
    whole, tall = figure.get_size_inches()
    scale = layer.scale
    over = [_over_paper(color) for color in scale.colors]
    if scale.names:
        names = ["\n".join(wrapped(words(name), NAME_LETTERS)) for name in scale.names]
        patches = [
            Patch(facecolor=c, edgecolor=INK, label=n) for c, n in zip(over, names, strict=True)
        ]
        draw_legend(
            figure, patches[::-1], (left + width + 0.1 / whole, bottom + height), "upper left"
        )
        return
    high = min(0.6 * height, 3.2 / tall)
    place = (left + width + 0.2 / whole, bottom + height - high, 0.16 / whole, high)
    bar_axes = figure.add_axes(place, facecolor=str(PAPER))
    count = scale.bounds.size - 1
    bar = figure.colorbar(
        ScalarMappable(scale.map_and_norm[1], _colors(over, count)), cax=bar_axes,
        spacing="uniform", extend="max" if scale.is_open else "neither", extendfrac=0.1,
    )  # fmt: skip
    bar.set_ticks(scale.bounds.tolist(), labels=[f"{bound:g}" for bound in scale.bounds])
    bar_axes.tick_params(labelsize=7, length=2)
    bar.set_label(f"{words(layer.look.title)}, {words(layer.look.unit)}", fontsize=7.5)
    if layer.look.is_depth:
        place = (place[0] - 0.1 / whole, place[1] - 0.1 / tall, *place[2:])
        figure.text(*place[:2], words("less is not shown"), fontsize=6.5, va="top")


def _colors(colors: Sequence[Any], count: int) -> Colormap:
    return ListedColormap(colors[:count]).with_extremes(over=colors[-1])


def draw_legend(
    figure: Figure, handles: Sequence[Artist], place: tuple[float, float], corner: str
) -> None:
    """Draw a key with a corner at a place of the figure."""
    how: Any = {"handlelength": 1.4, "borderaxespad": 0.0, "labelspacing": 0.8, "fontsize": 7}
    how |= {"loc": corner, "bbox_to_anchor": place, "frameon": False}
    figure.legend(handles=handles, **how)


def _over_paper(color: str) -> tuple[float, float, float]:
    """Return a color as it looks over the relief."""
    red, green, blue = (OPAQUE * part + (1.0 - OPAQUE) * PAPER for part in to_rgb(color))
    return red, green, blue


def _draw_signs(
    figure: Figure, axes: Axes, look: Look, levels: Contours, released: bool, words: Words
) -> None:
    """Draw the key of lines below the color bar."""
    left, bottom, width, _ = axes.get_position().bounds
    whole, _ = figure.get_size_inches()
    label = words("contours each\n{interval} m", interval=f"{levels.interval:g}")
    handles: list[Artist] = [Line2D([], [], color=CONTOUR, linewidth=0.7, label=label)]
    if look.outlined is not None:
        text = f"{look.outlined:g} {look.unit}"
        handles.append(Line2D([], [], color=OUTLINED, linewidth=1.6, label=text))
    if released:
        handles.append(Line2D([], [], color=RELEASE, linewidth=1.4, label=words("release")))
    draw_legend(figure, handles, (left + width + 0.1 / whole, bottom), "lower left")
