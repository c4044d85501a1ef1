"""Plots of the probes of many points: lines over the time, grids at the last time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.case.probes.grid import GridProbe
from debrisflow.case.probes.line import LineProbe
from debrisflow.results.plots.style import panels
from debrisflow.results.reader import Run
from debrisflow.run.tables import Table

Floats = NDArray[np.float64]
MOST_PROBES = 8
HEIGHT = 2.0  # inch
WIDEST = 2.4  # inch, of the picture of a grid
BESIDE = 0.75  # inch, for title and ticks of a panel
ARROWS = 24  # along the longer side of a grid
DRY = "#eeeeee"
MOST = 99.5  # percent of the values that a scale of colors holds


def line_figure(run: Run) -> Figure | None:
    """Return speed and pressure along lines over the time; None without samples of lines."""
    tables = {
        probe.name: run.probe(probe.name)
        for probe in run.case.probe
        if isinstance(probe, LineProbe)
    }
    shown = [(name, table) for name, table in tables.items() if table["time"].size][:MOST_PROBES]
    if not shown:
        return None
    figure, axes = panels(len(shown), 2, height=HEIGHT)
    for (name, table), pair in zip(shown, zip(axes[::2], axes[1::2], strict=True), strict=True):
        time, s = np.unique(table["time"]), np.unique(table["s"])
        velocity = [table[key] for key in table if key.startswith("velocity")]
        fields = {"speed, m/s": np.linalg.norm(velocity, axis=0), "pressure, Pa": table["pressure"]}
        for one, (label, values) in zip(pair, fields.items(), strict=True):
            _draw(one, time, s, values.reshape(time.size, s.size).T, label)
            one.set(xlabel="time, s", ylabel="s, m")
        pair[0].set_title(name, loc="left")
    return figure


def grid_figure(run: Run) -> Figure | None:
    """Return speed and pressure on grids at the last time; None without samples of grids.

    Of a box the plane in the middle of its width is shown.
    """
    tables = {
        probe.name: run.grid(probe.name) for probe in run.case.probe if isinstance(probe, GridProbe)
    }
    shown = [(name, table) for name, table in tables.items() if table["time"].size][:MOST_PROBES]
    if not shown:
        return None
    planes = [(name, table, *_plane(table)) for name, table in shown]
    heights = [_height(table[along], table[up]) for _, table, (along, up), *_ in planes]
    figure, axes = panels(len(shown), 2, height=heights)
    pairs = zip(axes[::2], axes[1::2], strict=True)
    for (name, table, (along, across), where, velocity, pressure), pair in zip(
        planes, pairs, strict=True
    ):
        fields = {"speed, m/s": np.linalg.norm(velocity, axis=-1), "pressure, Pa": pressure}
        for one, (label, values) in zip(pair, fields.items(), strict=True):
            _draw(one, table[along], table[across], values.T, label)
            one.set(xlabel=f"{along}, m", ylabel=f"{across}, m", aspect="equal")
        components = ["xyz".index(axis) for axis in (along, across)]
        _arrows(pair[0], table[along], table[across], velocity[..., components])
        pair[0].set_title(f"{name}{where}, t = {table['time'][-1]:g} s", loc="left")
    return figure


def _height(along: Floats, across: Floats) -> float:
    """Return the height of a panel, inch, for a grid in true proportions."""
    share = float(np.ptp(across)) / max(float(np.ptp(along)), 1e-300)
    return BESIDE + min(WIDEST * share, HEIGHT)


def _plane(table: Table) -> tuple[tuple[str, str], str, Floats, Floats]:
    """Return the axes of the plane that is shown, where it is, velocity and pressure on it."""
    velocity, pressure = table["velocity"][-1], table["pressure"][-1]
    axes = [axis for axis in "xyz" if axis in table]
    where = ""
    if len(axes) == 3:
        thin = pressure.shape.index(1) if 1 in pressure.shape else axes.index("y")
        middle = pressure.shape[thin] // 2
        velocity, pressure = (np.take(field, middle, axis=thin) for field in (velocity, pressure))
        where = f", {axes[thin]} = {table[axes[thin]][middle]:g} m"
        axes.pop(thin)
    return (axes[0], axes[1]), where, velocity, pressure


def _draw(axes: Axes, x: Floats, y: Floats, values: Floats, label: str) -> None:
    """Draw values at points; where there are none it is gray.

    The scale ends where only one value in two hundred is beyond it: single particles press hard.
    """
    axes.set_facecolor(DRY)
    shown, limits = np.ma.masked_invalid(values), {}
    if shown.count():
        least, greatest = np.percentile(shown.compressed(), [100.0 - MOST, MOST])
        limits = {"vmin": least, "vmax": greatest}
    mesh = axes.pcolormesh(_edges(x), _edges(y), shown, cmap="viridis", **limits)
    beside = axes.inset_axes((1.02, 0.0, 0.025, 1.0))  # as high as the picture is
    axes.figure.colorbar(mesh, cax=beside, label=label, extend="both")
    axes.grid(False)


def _edges(middles: Floats) -> Floats:
    """Return the edges of cells around middles.

    Examples
    --------
    >>> _edges(np.array([1.0, 2.0, 4.0])), _edges(np.array([3.0]))
    (array([0.5, 1.5, 3. , 5. ]), array([2.5, 3.5]))
    """
    if middles.size == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    between = 0.5 * (middles[1:] + middles[:-1])
    first = 2.0 * middles[0] - between[0]
    return np.array([first, *between, 2.0 * middles[-1] - between[-1]])


def _arrows(axes: Axes, x: Floats, y: Floats, velocity: Floats) -> None:
    """Draw the velocity by arrows."""
    every = max(1, max(x.size, y.size) // ARROWS)
    part = velocity[::every, ::every]
    if np.nan_to_num(part).any():
        axes.quiver(
            x[::every], y[::every], part[..., 0].T, part[..., 1].T, color="white", width=0.004
        )
