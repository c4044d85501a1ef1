"""Styles of layers for QGIS: classes with rounded limits, in colors for all readers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
DOCTYPE = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"  # heads a style
DEPTH = (0.25, 0.5, 1.0, 2.0, 4.0)
TIME = (10.0, 20.0, 30.0, 60.0, 120.0, 300.0)
LIMITS: dict[str, Sequence[float]] = {
    "peak_depth": DEPTH,
    "deposit": DEPTH,
    "final_depth": DEPTH,
    "release": DEPTH,
    "peak_speed": (1.0, 2.0, 5.0, 10.0, 20.0),
    "peak_momentum_flux": (1.0, 3.0, 10.0, 30.0, 100.0),
    "peak_pressure": (5.0, 10.0, 30.0, 50.0, 100.0),
    "arrival": TIME,
    "duration": TIME,
}
"""Upper limits of the classes of a layer but the last, in its unit; others have shades of gray."""
# Maps of matplotlib and ColorBrewer that are even to the eye and safe for color-blind readers, from
# light to dark: what is more, or comes sooner, stands out of a light map
VIRIDIS = ("#ece51b", "#84d44b", "#32b67a", "#21908d", "#306a8e", "#423f85", "#460b5e")
PLASMA = ("#f4ed27", "#fdac33", "#eb7655", "#cb4679", "#9e199d", "#6400a7", "#20068f")
INFERNO = ("#f3f68a", "#fcac11", "#eb6628", "#ba3655", "#7c1d6d", "#3b0964", "#030210")
MAGMA = ("#fcf0b2", "#fea772", "#ef5d5e", "#b5367a", "#752181", "#341069", "#03030f")
BLUES = ("#eef8b3", "#c2e7b4", "#71c8bd", "#34a9c3", "#1f78b4", "#24439b", "#0e2265")
BROWNS = ("#fff2b1", "#fed87a", "#feb13e", "#f5841e", "#d85a09", "#a93c03", "#712806")
PALETTES = {
    "peak_speed": PLASMA,
    "peak_momentum_flux": INFERNO,
    "peak_pressure": MAGMA,
    "arrival": VIRIDIS[::-1],
    "duration": BLUES,
    "deposit": BROWNS,
    "release": BROWNS,
}
DARK, LIGHT = "#202020", "#f8f8f8"


def style(name: str, unit: str, values: Floats, clear: float | None = None) -> str:
    """Return the style of a layer, the text of a ``.qml`` file.

    Parameters
    ----------
    name, unit : str
    values : float64 array
        Of its cells; nan for no data.
    clear : float, optional
        A value that is not shown.
    """
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    if name in LIMITS:
        items = list(class_items(LIMITS[name], unit, palette_of(name)))
        return pseudocolors("DISCRETE", 0.8, low, high, items, clear)
    items = [(low, f"{low:.0f} {unit}", DARK), (high, f"{high:.0f} {unit}", LIGHT)]
    return pseudocolors("INTERPOLATED", 1.0, low, high, items, clear)


def palette_of(name: str) -> tuple[str, ...]:
    """Return the colors of a layer, from those of little to those of much."""
    return PALETTES.get(name, VIRIDIS)


def colors_of(palette: Sequence[str], classes: int) -> list[str]:
    """Return the colors of some classes, spread evenly over a palette.

    Examples
    --------
    >>> colors_of(("#ffffff", "#888888", "#000000"), 2)
    ['#ffffff', '#000000']
    """
    step = (len(palette) - 1) / max(classes - 1, 1)
    return [palette[round(k * step)] for k in range(classes)]


def class_items(
    limits: Sequence[float], unit: str, palette: Sequence[str] = VIRIDIS
) -> Iterator[tuple[float, str, str]]:
    """Yield upper limit, label and color of each class.

    Examples
    --------
    >>> for item in class_items((1.0, 2.0), "m"):
    ...     print(*item)
    1.0 up to 1 m #ece51b
    2.0 1 to 2 m #21908d
    inf more than 2 m #460b5e
    """
    labels = [f"up to {limits[0]:g} {unit}"]
    labels += [f"{a:g} to {b:g} {unit}" for a, b in pairwise(limits)]
    labels.append(f"more than {limits[-1]:g} {unit}")
    colors = colors_of(palette, len(labels))
    yield from zip((*limits, math.inf), labels, colors, strict=True)


def palette(classes: Iterable[tuple[int, str, str]]) -> str:
    """Return the style of a raster of classes: number, name and color of each."""
    root = ElementTree.Element("qgis", version="3.28", styleCategories="Symbology")
    renderer = ElementTree.SubElement(
        ElementTree.SubElement(root, "pipe"),
        "rasterrenderer",
        type="paletted",
        band="1",
        opacity="0.8",
        alphaBand="-1",
        nodataColor="",
    )
    ElementTree.SubElement(renderer, "rasterTransparency")
    entries = ElementTree.SubElement(renderer, "colorPalette")
    for number, name, color in classes:
        ElementTree.SubElement(
            entries, "paletteEntry", value=str(number), label=name, color=color, alpha="255"
        )
    return _text(root)


def pseudocolors(
    kind: str,
    opacity: float,
    low: float,
    high: float,
    items: Iterable[tuple[float, str, str]],
    clear: float | None = None,
) -> str:
    """Return a style of one band in pseudocolors, as QGIS reads it.

    Parameters
    ----------
    kind : str
        ``DISCRETE`` for classes up to values, ``INTERPOLATED`` for colors at values.
    opacity : float
        From 0 to 1.
    low, high : float
        Of the values.
    items : iterable of (float, str, str)
        Value, label and color.
    clear : float, optional
        A value that is not shown.
    """
    root = ElementTree.Element("qgis", version="3.28", styleCategories="Symbology")
    pipe = ElementTree.SubElement(root, "pipe")
    renderer = ElementTree.SubElement(
        pipe,
        "rasterrenderer",
        type="singlebandpseudocolor",
        band="1",
        opacity=f"{opacity:g}",
        alphaBand="-1",
        nodataColor="",
        classificationMin=f"{low:.9g}",
        classificationMax=f"{high:.9g}",
    )
    transparency = ElementTree.SubElement(renderer, "rasterTransparency")
    if clear is not None:
        ElementTree.SubElement(
            ElementTree.SubElement(transparency, "singleValuePixelList"),
            "pixelListEntry",
            min=f"{clear:.9g}",
            max=f"{clear:.9g}",
            percentTransparent="100",
        )
    shader = ElementTree.SubElement(
        ElementTree.SubElement(renderer, "rastershader"),
        "colorrampshader",
        colorRampType=kind,
        classificationMode="1",
        clip="0",
        minimumValue=f"{low:.9g}",
        maximumValue=f"{high:.9g}",
    )
    for value, label, color in items:
        ElementTree.SubElement(
            shader, "item", value=f"{value:.9g}", label=label, color=color, alpha="255"
        )
    return _text(root)


def _text(root: ElementTree.Element) -> str:
    ElementTree.SubElement(root, "blendMode").text = "0"
    ElementTree.indent(root)
    return DOCTYPE + ElementTree.tostring(root, encoding="unicode") + "\n"
