"""The map sheets of a run, a picture a layer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from debrisflow import __version__
from debrisflow.results.fonts import INSTALL, japanese_font, writable
from debrisflow.results.maps.layers import Layer, Layers
from debrisflow.results.maps.sheet import Ground, Text, draw_map, styled
from debrisflow.results.maps.structures import structures
from debrisflow.results.reader import Run
from debrisflow.results.words import Words
from debrisflow.run.atomic import made, replaced
from debrisflow.run.names import MAPS

DPI = 200


def draw_maps(
    run: Run, words: Words, names: Sequence[str] = (), dpi: int = DPI
) -> tuple[list[Path], list[str]]:
    """Draw the layers of a run over its terrain into its folder ``maps``.

    Parameters
    ----------
    run : Run
    words : Words
        Of the language; English where there is no font for it.
    names : sequence of str
        Of the layers; all that there are if empty.
    dpi : int
        Dots per inch.

    Returns
    -------
    files : list of Path
    messages : list of str
        What a person should know of them.

    Raises
    ------
    OutputError
        If the run has no layers or none of such a name, or a file cannot be written.
    """
    layers = Layers(run)
    chosen = [layers.layer(name) for name in names or layers.names]
    ground = Ground(layers.terrain, layers.release, structures(run.case))
    drawn, messages = drawable(words)
    files = []
    with styled(drawn):
        for layer in chosen:
            figure = draw_map(ground, layer, text_of(run, layers, layer, drawn), drawn)
            files.append(made(run.folder / MAPS) / f"{layer.name}.png")
            with replaced(files[-1]) as unfinished:
                made_by = {"Software": "debrisflow"}
                figure.savefig(unfinished, dpi=dpi, format="png", metadata=made_by)
    return files, messages


def drawable(words: Words) -> tuple[Words, list[str]]:
    """Return the words that pictures can be written with, and what is to be said of it."""
    if words.language == "ja" and japanese_font() is None:
        return Words(), [INSTALL]
    return words, []


def text_of(run: Run, layers: Layers, layer: Layer, words: Words) -> Text:
    """Return what is written around a map."""
    case, grid = run.case, layers.terrain.grid
    subtitle = case.title if writable(case.title) else run.name
    name = run.name if writable(run.name) else "-"
    source = words(
        "Run {name}: particles of {spacing} m, cells of {cell} m, t = 0 to {time} s. "
        "debrisflow {version}.",
        name=name,
        spacing=f"{case.particles.spacing:g}",
        cell=f"{grid.cell:g}",
        time=f"{run.summary.get('time', case.time.end):g}",
        version=__version__,
    )
    estimator = words(
        "Depth along the vertical: volume of the particles over the area of a cell. Cells in which "
        "it never exceeded {threshold} m are not shown.",
        threshold=f"{layers.threshold:g}",
    )
    lines = [source, estimator]
    if layer.source:
        source = layer.source if writable(layer.source) else "-"
        lines.append(words("Thresholds: {source}", source=source))
    return Text(words(layer.look.title), subtitle, tuple(lines))
