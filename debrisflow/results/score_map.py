"""The table and the map of a score: hits, misses and false alarms over the terrain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results.plots.style import BLUE, ORANGE, RED, WIDTH, save, styled
from debrisflow.results.score import Comparison, Row
from debrisflow.run.folder import POSTPROCESS
from debrisflow.run.tables import write_table

HEAD = (
    "score of the run against {observed}",
    "extents and deposits are compared cell by cell on the grid of the DEM, where it is known and",
    "  the change of elevation was surveyed; hss and d2pc depend on the size of that area",
)
COLORS = {"hit": BLUE, "miss": RED, "false alarm": ORANGE}
MARGIN = 5  # cells around the extents
TALLEST = 1.3  # of a map, by its width
TOLD = ("csi", "hss", "d2pc", "foc", "runout_observed", "runout_simulated", "deposit_rms")


def write_score(run: Path, observed: Path, found: Comparison) -> list[Path]:
    """Write the table and the map of a score, and return the files.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    folder = run / POSTPROCESS
    table = folder / "score.csv"
    head = [line.format(observed=observed.name) for line in HEAD]
    write_table(table, Row._fields, head, found.rows)
    with styled():
        figure = score_figure(found)
        told = [
            f"{r.measure} = {r.value:.3g} {r.unit}".strip() for r in found.rows if r.measure in TOLD
        ]
        picture = save(
            figure,
            folder / "score.png",
            f"Simulated extent against {observed.name}",
            [", ".join(told)],
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
        alpha=0.75,
        interpolation="nearest",
    )
    axes.plot(*found.path.xy, color="black", linewidth=0.8, linestyle="--")
    axes.plot(*found.path.coords[0], "k^", markersize=5)
    _finish(axes, extent, grid, found)
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


def _finish(
    axes: Axes, extent: tuple[float, float, float, float], grid: MapGrid, found: Comparison
) -> None:
    """Draw what makes a map of it: coordinates, scale bar, north and a key."""
    west, east, south, north = extent
    axes.set(xlim=(west, east), ylim=(south, north), xlabel="easting, m", ylabel="northing, m")
    axes.set_aspect("equal")
    axes.grid(False)
    axes.ticklabel_format(style="plain", useOffset=False)
    axes.tick_params(axis="y", labelrotation=90)
    length = _round_length(0.3 * (east - west))
    x, y = west + 0.04 * (east - west), south + 0.03 * (north - south)
    axes.plot([x, x + length], [y, y], color="black", linewidth=2.5, solid_capstyle="butt")
    axes.text(x + 0.5 * length, y, f"{length:g} m\n", ha="center", va="baseline", fontsize=7)
    axes.annotate(
        "N",
        (0.96, 0.14),
        (0.96, 0.03),
        xycoords="axes fraction",
        ha="center",
        arrowprops={"arrowstyle": "<-"},
    )
    cells = found.contingency
    counts = (cells.hits, cells.misses, cells.false_alarms)
    handles: list[Patch | Line2D] = [
        Patch(color=color, alpha=0.75, label=f"{name}: {count} cells of {grid.cell:g} m")
        for (name, color), count in zip(COLORS.items(), counts, strict=True)
    ]
    handles.append(
        Line2D([], [], color="black", linewidth=0.8, linestyle="--", marker="^", label="flow path")
    )
    axes.figure.legend(handles=handles, loc="outside upper center", ncols=2, fontsize=7)


def _round_length(most: float) -> float:
    """Return the greatest of 1, 2, 5 times a power of ten within a length, m."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(k * power for k in (1.0, 2.0, 5.0) if k * power <= most))
