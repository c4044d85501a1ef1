"""The table and the map of a score: hits, misses and false alarms over the terrain."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from shapely.ops import substring

from debrisflow.case.rasters import Raster
from debrisflow.results.plots.style import BLUE, RED, WIDTH, save, styled
from debrisflow.results.score import Comparison, Row
from debrisflow.run.atomic import made
from debrisflow.run.names import POSTPROCESS
from debrisflow.run.tables import write_table

HEAD = (
    "score of the run against {observed}",
    "extents and deposits are compared cell by cell on the grid of the DEM, where it has data; hss",
    "  and d2pc depend on the size of that area",
)
YELLOW = "#f0e442"  # of Okabe & Ito, too light for lines
COLORS = {"hit": BLUE, "miss": RED, "false alarm": YELLOW}
ENDS = {"runout_observed": ("o", RED), "runout_simulated": ("D", BLUE)}
MARGIN = 5  # cells around the extents
OPACITY = 0.75
TALLEST = 1.3  # of a map, by its width
TOLD = ("threshold", "csi", "hss", "d2pc", "foc", "runout_error", "deposit_rms")


def write_score(run: Path, observed: Path, found: Comparison) -> list[Path]:
    """Write the table and the map of a score, and return the files.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    folder = made(run / POSTPROCESS)
    table = folder / "score.csv"
    head = [line.format(observed=observed.name) for line in HEAD]
    write_table(table, Row._fields, head, found.rows)
    with styled():
        figure = score_figure(found)
        measures = [
            f"{r.measure} = {r.shown} {r.unit}".strip() for r in found.rows if r.measure in TOLD
        ]
        picture = save(
            figure,
            folder / "score.png",
            f"Simulated extent against {observed.name}",
            [", ".join(measures)],
        )
    return [table, picture]


def score_figure(found: Comparison) -> Figure:
    """Return the map of hits, misses and false alarms."""
    rows, columns = _part(found)
    grid = found.terrain.grid
    west, east = grid.west + columns.start * grid.cell, grid.west + columns.stop * grid.cell
    north, south = grid.north - rows.start * grid.cell, grid.north - rows.stop * grid.cell
    ratio = min((north - south) / (east - west), TALLEST)
    figure = Figure(figsize=(WIDTH, WIDTH * ratio * 0.75 + 0.8), layout="constrained")
    axes = figure.subplots()
    extent = (west, east, south, north)
    _draw_terrain(axes, found.terrain, rows, columns, extent)
    kinds = np.where(found.observed, np.where(found.simulated, 1.0, 2.0), 3.0)
    kinds[~((found.observed | found.simulated) & found.compared)] = np.nan
    axes.imshow(
        kinds[rows, columns],
        extent=extent,
        cmap=ListedColormap(list(COLORS.values())),
        vmin=0.5,
        vmax=3.5,
        alpha=OPACITY,
        interpolation="nearest",
    )
    _draw_path(axes, found)
    _finish(axes, extent)
    _draw_key(figure, found)
    return figure


def _part(found: Comparison) -> tuple[slice, slice]:
    """Return the rows and columns that the map shows."""
    either = (found.observed | found.simulated) & found.compared
    i, j = np.nonzero(either)
    rows, columns = either.shape
    return (
        slice(max(int(i.min()) - MARGIN, 0), min(int(i.max()) + MARGIN + 1, rows)),
        slice(max(int(j.min()) - MARGIN, 0), min(int(j.max()) + MARGIN + 1, columns)),
    )


def _draw_terrain(
    axes: Axes,
    terrain: Raster,
    rows: slice,
    columns: slice,
    extent: tuple[float, float, float, float],
) -> None:
    known = np.isfinite(terrain.values)
    level = np.where(known, terrain.values, np.nanmin(terrain.values))
    cell = terrain.grid.cell
    shade = LightSource(315.0, 45.0).hillshade(level, dx=cell, dy=cell)
    axes.imshow(
        np.where(known, shade, np.nan)[rows, columns],
        extent=extent,
        cmap="gray",
        vmin=-0.6,
        vmax=1.0,
        interpolation="bilinear",
    )


def _draw_path(axes: Axes, found: Comparison) -> None:
    """Draw the path as far as the flow came, and where it ended."""
    ends = {row.measure: row.value for row in found.rows if row.measure in ENDS}
    whole = substring(found.path, 0.0, max(ends.values()))
    axes.plot(*whole.xy, color="black", linewidth=0.8, linestyle="--", label="flow path")
    axes.plot(*found.path.coords[0], "k^", markersize=6, label="middle of the release")
    for name, (marker, color) in ENDS.items():
        place = found.path.interpolate(ends[name])
        label = f"{name.replace('_', ' ').replace('runout', 'run-out')}: {ends[name]:.0f} m"
        style: dict[str, Any] = {"color": color, "markeredgecolor": "white", "linestyle": "none"}
        axes.plot(place.x, place.y, marker, markersize=6, label=label, **style)


def _finish(axes: Axes, extent: tuple[float, float, float, float]) -> None:
    """Draw what makes a map of it: coordinates, scale bar and north."""
    west, east, south, north = extent
    axes.set(xlim=(west, east), ylim=(south, north), xlabel="easting, m", ylabel="northing, m")
    axes.set_aspect("equal")
    axes.grid(False)
    axes.ticklabel_format(style="plain", useOffset=False)
    axes.xaxis.set_major_locator(MaxNLocator(3, integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.tick_params(axis="y", labelrotation=90)
    length = _round_length(0.3 * (east - west))
    x, y = west + 0.04 * (east - west), south + 0.03 * (north - south)
    axes.plot([x, x + length], [y, y], color="black", linewidth=2.5, solid_capstyle="butt")
    axes.text(x + 0.5 * length, y, f"{length:g} m\n", ha="center", va="baseline", fontsize=7)
    axes.annotate(
        "N",
        (0.95, 0.02),
        (0.95, 0.12),
        xycoords="axes fraction",
        ha="center",
        arrowprops={"arrowstyle": "<|-", "color": "black", "shrinkA": 0.0},
    )


def _draw_key(figure: Figure, found: Comparison) -> None:
    cells, cell = found.contingency, found.terrain.grid.cell
    counts = (cells.hits, cells.misses, cells.false_alarms)
    handles: list[Artist] = [
        Patch(color=color, alpha=OPACITY, label=f"{name}: {count} cells of {cell:g} m")
        for (name, color), count in zip(COLORS.items(), counts, strict=True)
    ]
    lines, _ = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles=[*handles, *lines], loc="outside right upper", fontsize=7)


def _round_length(most: float) -> float:
    """Return the greatest of 1, 2, 5 times a power of ten within a length, m."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(k * power for k in (1.0, 2.0, 5.0) if k * power <= most))
