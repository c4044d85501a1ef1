"""Styles of layers for QGIS: classes with rounded limits, in colors for all readers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
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
# viridis, from light to dark: what is more stands out of a light map
COLORS = ("#fde725", "#90d743", "#35b779", "#21918c", "#31688e", "#443983", "#440154")
DARK, LIGHT = "#202020", "#f8f8f8"


def style(name: str, unit: str, values: Floats) -> str:
    """Return the style of a layer, the text of a ``.qml`` file.

    Parameters
    ----------
    name, unit : str
    values : float64 array
        Of its cells; nan for no data.
    """
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    if name in LIMITS:
        return _qml("DISCRETE", 0.8, low, high, class_items(LIMITS[name], unit))
    items = [(low, f"{low:.0f} {unit}", DARK), (high, f"{high:.0f} {unit}", LIGHT)]
    return _qml("INTERPOLATED", 1.0, low, high, items)


def class_items(limits: Sequence[float], unit: str) -> Iterator[tuple[float, str, str]]:
    """Yield upper limit, label and color of each class.

    Examples
    --------
    >>> for item in class_items((1.0, 2.0), "m"):
    ...     print(*item)
    1.0 up to 1 m #fde725
    2.0 1 to 2 m #21918c
    inf more than 2 m #440154
    """
    labels = [f"up to {limits[0]:g} {unit}"]
    labels += [f"{a:g} to {b:g} {unit}" for a, b in pairwise(limits)]
    labels.append(f"more than {limits[-1]:g} {unit}")
    step = (len(COLORS) - 1) / len(limits)
    for k, (limit, label) in enumerate(zip((*limits, math.inf), labels, strict=True)):
        yield limit, label, COLORS[round(k * step)]


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


def _qml(
    kind: str, opacity: float, low: float, high: float, items: Iterable[tuple[float, str, str]]
) -> str:
    """Return a style of one band in pseudocolors, as QGIS reads it."""
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
    ElementTree.SubElement(renderer, "rasterTransparency")
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
    head = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    return head + ElementTree.tostring(root, encoding="unicode") + "\n"
