"""Maps of the share of runs that reach a cell, before and after a fit, over the observed extent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from debrisflow.results.flow_path import centers
from debrisflow.results.plots.style import GRAY, RED, WIDTH, save, styled
from debrisflow.results.score import Extents
from debrisflow.run.atomic import made
from debrisflow.study.calibration.observations import extents, is_in
from debrisflow.study.tables import Extent, Part, Study

Floats = NDArray[np.float64]
HATCH: Any = {"hatch.color": "#b0b0b0", "hatch.linewidth": 0.4}
MARGIN = 4  # cells around what is reached
TALLEST, PANELS = 8.0, 0.7  # inch, and the share of the width that the panels have
CONTOURS = 12  # of the terrain
EDGES = (0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0)  # of the classes of shares


def write_extent_maps(
    study: Study, groups: Mapping[str, Sequence[Path]], target: Path
) -> list[Path]:
    """Draw a map for each observed extent into a folder, a panel for each group of runs.

    Parameters
    ----------
    study : Study
    groups : mapping of sequence of Path
        Folders of finished runs by what they are, none empty.
    target : Path

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    made(target, is_deep=True)
    part = study.calibration.held_out if study.calibration else None
    written = []
    for one in study.observation:
        if isinstance(one, Extent):
            found = {
                _counted(name, len(folders)): [extents(folder, one) for folder in folders]
                for name, folders in groups.items()
            }
            with styled(), mpl.rc_context(HATCH):
                figure = _figure(found, part)
                title = f"Share of the runs that reach a cell, and {one.name} as observed"
                words = ["The line is the observed extent; gray: contours of the terrain."]
                if part is not None:
                    words = [f"{words[0]} Hatched: held out, and not used in the fit."]
                written.append(save(figure, target / f"{one.name}.png", title, words))
    return written


def _counted(name: str, count: int) -> str:
    """Return a title that states how many runs there are.

    Examples
    --------
    >>> _counted("design", 16), _counted("best fit", 1)
    ('design: 16 runs', 'best fit: 1 run')
    """
    return f"{name}: {count} run{'s' if count > 1 else ''}"


def _figure(groups: Mapping[str, Sequence[Extents]], part: Part | None) -> Figure:
    shares = {
        name: np.mean([one.simulated for one in found], axis=0) for name, found in groups.items()
    }
    first = next(iter(groups.values()))[0]
    rows, columns = np.nonzero(np.any([*shares.values(), first.observed], axis=0))
    grid = first.terrain.grid
    x, y = centers(grid)
    margin = MARGIN * grid.cell
    x_limits = x[columns.min()] - margin, x[columns.max()] + margin
    y_limits = y[rows.max()] - margin, y[rows.min()] + margin
    ratio = (y_limits[1] - y_limits[0]) / (x_limits[1] - x_limits[0])
    height = min(PANELS * WIDTH / len(groups) * ratio + 1.0, TALLEST)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(1, len(groups), sharey=True, squeeze=False).ravel()
    for here, (name, share) in zip(axes, shares.items(), strict=True):
        areas = _panel(here, share, first, is_in(part, grid))
        here.set_title(name)
        here.set_xlim(x_limits)
        here.set_ylim(y_limits)
        here.set_xlabel("east, m")
    axes[0].set_ylabel("north, m")
    axes[0].legend(handles=[Line2D([], [], color=RED, label="observed")], loc="best")
    figure.colorbar(areas, ax=axes.tolist(), label="share of the runs", shrink=0.6)
    return figure


def _panel(axes: Axes, share: Floats, found: Extents, held_out: NDArray[np.bool_]) -> QuadMesh:
    x, y = centers(found.terrain.grid)
    level = found.terrain.values
    if np.nanmin(level) < np.nanmax(level):
        axes.contour(x, y, level, CONTOURS, colors=GRAY, linewidths=0.3, linestyles="solid")
    areas = axes.pcolormesh(
        x, y, np.where(share > 0.0, share, np.nan), cmap="Blues", norm=BoundaryNorm(EDGES, 256)
    )
    if not found.observed.all():
        axes.contour(x, y, found.observed.astype(float), [0.5], colors=RED, linewidths=1.0)
    if held_out.any():
        axes.contourf(x, y, held_out.astype(float), [0.5, 1.5], colors="none", hatches=["//"])
    axes.set_aspect("equal")
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.tick_params(axis="x", rotation=45)
    axes.grid(False)
    return areas
