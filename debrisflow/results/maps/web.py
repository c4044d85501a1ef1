"""The map of a report: the data from which a browser draws it, embedded in the page."""

from __future__ import annotations

import zlib
from base64 import b64encode
from io import BytesIO
from typing import Any

import contourpy
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from debrisflow.case.rasters import Raster
from debrisflow.results.maps.furniture import crs_name
from debrisflow.results.maps.layers import Layer, Layers
from debrisflow.results.maps.looks import DEPTH, Look, Scale, scale_of
from debrisflow.results.maps.places import places
from debrisflow.results.maps.relief import contours, hillshade
from debrisflow.results.maps.sheet import outline
from debrisflow.results.maps.structures import structures
from debrisflow.results.reader import Run
from debrisflow.results.words import Words

Floats = NDArray[np.float64]
STEPS = 65534  # of numbers of 16 bits; 0 stands for no value
MOST_FRAMES = 60
PAGE = (0.7, 0.85)  # the least and the greatest height over width of what is shown
MOST_CELLS = 500_000
DIGITS = 1  # of lines, in cells


def web_map(run: Run, words: Words) -> dict[str, Any]:
    """Return the data of the map of a run: texts, numbers and lists, as JSON has them.

    Places are in cells: x from the west, y from the north.

    Parameters
    ----------
    run : Run
    words : Words

    Raises
    ------
    OutputError
        If the run has no layers, or a file is damaged.
    """
    layers = Layers(run, PAGE, MOST_CELLS)
    terrain = layers.terrain
    grid = terrain.grid
    found: dict[str, Any] = {
        "grid": {
            "west": grid.west,
            "north": grid.north,
            "cell": grid.cell,
            "columns": grid.columns,
            "rows": grid.rows,
            "crs": crs_name(grid.crs) or words("coordinate system not stated"),
        },
        "words": page_words(words),
        "relief": gray_picture(hillshade(terrain)),
        "contours": contour_lines(terrain),
        "elevation": packed(terrain.values),
        "layers": [shown(layers.layer(name), words) for name in layers.names],
        "places": places(run, grid, words),
        "structures": [
            {"name": name, "rings": [in_cells(terrain, ring).tolist() for ring in rings]}
            for name, rings in structures(run.case).items()
        ],
        "release": [],
    }
    if layers.release is not None:
        edges = outline(grid, np.isfinite(layers.release))
        found["release"] = [in_cells(terrain, edge).tolist() for edge in edges]
    if frames := depth_frames(layers, words):
        found["frames"] = frames
    return found


def page_words(words: Words) -> dict[str, str]:
    """Return the words that the script of the page writes, by the names it has for them."""
    known = {
        "opacity": "opacity",
        "time": "time",
        "play": "play",
        "pause": "pause",
        "whole": "show all",
        "terrain": "terrain only",
        "east": "east",
        "north": "north",
        "elevation": "elevation",
        "no_value": "no flow",
        "release": "release",
        "less": "less is not shown",
        "contours": "contours each {interval} m",
        "hint": "Drag to move, wheel to zoom, click for values and curves.",
        "here": "Values here",
        "unsupported": "This browser is too old to draw the map.",
    }
    return {name: words(text) for name, text in known.items()}


def shown(layer: Layer, words: Words) -> dict[str, Any]:
    """Return a layer with its classes and its values."""
    data = {"name": layer.name, "data": packed(layer.values)}
    return data | key(layer.look, layer.scale, words)


def key(look: Look, scale: Scale, words: Words) -> dict[str, Any]:
    """Return what the key of a layer shows."""
    return {
        "title": words(look.title),
        "unit": words(look.unit),
        "bounds": scale.bounds.tolist(),
        "colors": list(scale.colors),
        "names": [words(name) for name in scale.names],
        "isDepth": look.is_depth,
    }


def depth_frames(layers: Layers, words: Words) -> dict[str, Any] | None:
    """Return the depths at times in classes that all share; None if the run kept none."""
    known = layers.frames
    if not known:
        return None
    chosen = np.unique(np.linspace(0, len(known) - 1, MOST_FRAMES).round().astype(int))
    times, names = zip(*(known[k] for k in chosen), strict=True)
    values = np.array([layers.frame(name).values for name in names])
    scale = scale_of(DEPTH, values, layers.threshold)
    data = [packed(frame) for frame in values]
    return {"name": "frames", "times": list(times), "data": data} | key(DEPTH, scale, words)


def packed(values: Floats) -> dict[str, Any]:
    """Return values as 16 bits each, compressed: 0 for none, else 1 + (value - low) / step.

    Parameters
    ----------
    values : (rows, columns) array

    Examples
    --------
    >>> found = packed(np.array([[np.nan, 2.0, 4.0]]))
    >>> found["low"], round(found["step"] * 65534, 9)
    (2.0, 2.0)
    """
    known = np.isfinite(values)
    low, high = (
        (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    )
    step = (high - low) / STEPS or 1.0
    numbers = np.zeros(values.shape, dtype="<u2")
    numbers[known] = 1 + np.round((values[known] - low) / step)
    text = b64encode(zlib.compress(numbers.tobytes(), 9)).decode("ascii")
    return {"low": low, "step": step, "values": text}


def gray_picture(brightness: Floats) -> str:
    """Return a brightness of 0 to 1, (rows, columns), as a picture in a data URL; nan is white."""
    gray = np.nan_to_num(255.0 * brightness, nan=255.0).round().astype(np.uint8)
    file = BytesIO()
    Image.fromarray(gray).save(file, format="PNG", optimize=True)
    return "data:image/png;base64," + b64encode(file.getvalue()).decode("ascii")


def contour_lines(terrain: Raster) -> dict[str, Any]:
    """Return the contours of a terrain: interval, and by elevation lines as x, y, x, y, ..."""
    found = contours(terrain)
    if min(terrain.values.shape) < 2:
        return {"interval": found.interval, "levels": []}
    maker = contourpy.contour_generator(z=np.ma.masked_invalid(terrain.values))
    levels = []
    for elevations, labelled in ((found.thin, False), (found.labelled, True)):
        for elevation in elevations.tolist():
            # a value stands in the middle of its cell
            lines = (np.asarray(line) + 0.5 for line in maker.lines(elevation))
            flat = [np.round(line, DIGITS).ravel().tolist() for line in lines]
            levels.append({"level": elevation, "labelled": labelled, "lines": flat})
    return {"interval": found.interval, "levels": levels}


def in_cells(terrain: Raster, points: Floats) -> Floats:
    """Return points on the map, (n, 2) array, m, in cells from the west and from the north."""
    grid = terrain.grid
    x, y = points.T
    return np.column_stack([(x - grid.west) / grid.cell, (grid.north - y) / grid.cell])
