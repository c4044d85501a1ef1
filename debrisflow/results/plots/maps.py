"""Plots over the plan: the deposit and the greatest depths and speeds, lines or maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.grid import Grid
from debrisflow.results.deposition import Deposition
from debrisflow.results.plots.curves import legend
from debrisflow.results.plots.style import BLUE, GRAY, ORANGE, RED, panels, sequence
from debrisflow.results.references import Reference
from debrisflow.results.survey import Survey

Floats = NDArray[np.float64]
LEVELS = 8


def deposit_figure(found: Survey, given: Sequence[Reference]) -> Figure:
    """Return the deposit: its profiles in two dimensions, its map and profiles in three."""
    if found.run.case.dimension == 3:
        return _deposit_map(found)
    return _deposit_profiles(found, given)


def _deposit_profiles(found: Survey, given: Sequence[Reference]) -> Figure:
    figure, (height, change) = panels(2, height=2.6, sharex=True)
    deposits, last = found.deposits, found.deposits[-1]
    x = last.grid.x
    if last.table["initial_bed"].any():
        height.plot(x, last.table["initial_bed"], "--", color=GRAY, label="initial bed")
    for one, color in zip(deposits, sequence(len(deposits)), strict=True):
        height.plot(x, one.table["deposit_height"], color=color, label=_at(one))
        change.plot(x, one.table["bed_change"], color=color, label=_at(one))
    height.plot(x, last.table["flow_height"], ":", color=BLUE, label=f"flow, {_at(last)}")
    for reference in given:
        if reference.abscissa == "x":
            for name in reference.curves:
                values = reference.table["x"], reference.table[name]
                height.plot(*values, "k--", label=f"{reference.name}: {name}")
    change.axhline(0.0, color=GRAY, lw=0.8)
    height.set_ylabel("height of the deposit\nover the fixed floor, m")
    change.set(xlabel="x, m", ylabel="deposit less initial bed, m\n(erosion < 0)")
    legend(height, change)
    return figure


def _at(one: Deposition) -> str:
    return f"t = {one.time:g} s"


def _deposit_map(found: Survey) -> Figure:
    last = found.deposits[-1]
    figure, (lying, flowing, profile) = panels(3, height=2.5, sharex=True)
    mapped(
        lying, last.grid, last.table["deposit_height"], f"deposit, cm\nt = {last.time:g} s", 100.0
    )
    mapped(flowing, last.grid, last.table["flow_height"], f"flow, cm\nt = {last.time:g} s", 100.0)
    for one, color in zip(found.deposits, sequence(len(found.deposits)), strict=True):
        x, height = greatest_across(one.grid, one.table["deposit_height"])
        profile.plot(x, 100.0 * height, color=color, label=_at(one))
    x, height = greatest_across(last.grid, last.table["flow_height"])
    profile.plot(x, 100.0 * height, ":", color=BLUE, label=f"flow, {_at(last)}")
    profile.set(xlabel="x, m", ylabel="greatest height across,\ncm over the floor")
    legend(profile)
    return figure


def maxima_figure(found: Survey) -> Figure:
    """Return greatest depth, greatest speed and time of arrival over the plan."""
    maxima, grid = found.run.maxima, found.deposits[-1].grid
    shown = (
        ("maximal_depth", "greatest depth, cm", 100.0),
        ("maximal_speed", "greatest speed, m/s", 1.0),
        ("arrival_time", "arrival, s", 1.0),
    )
    figure, axes = panels(3, height=2.2, sharex=True)
    for one, (name, label, scale), color in zip(axes, shown, (BLUE, RED, ORANGE), strict=True):
        if found.run.case.dimension == 3:
            mapped(one, grid, maxima[name], label, scale, contours=name != "maximal_speed")
        else:
            one.plot(grid.x, scale * maxima[name], color=color)
            one.set_ylabel(label)
        if np.isnan(maxima[name]).all():
            one.text(0.5, 0.5, "nowhere", transform=one.transAxes, ha="center", color=GRAY)
    axes[-1].set_xlabel("x, m")
    return figure


def mapped(
    axes: Axes, grid: Grid, values: Floats, label: str, scale: float, contours: bool = True
) -> None:
    """Draw a map of values over the cells of a grid in true proportions.

    Parameters
    ----------
    axes : Axes
    grid : Grid
    values : (n,) array
        0 and nan are left white.
    label : str
        Of the color bar, with the unit.
    scale : float
        By which values are multiplied for that unit.
    contours : bool
        Draw lines of equal value too, which noise would tangle.
    """
    field = np.where(grid.number >= 0, (scale * values)[grid.number], np.nan)
    field = np.where(field > 0.0, field, np.nan)
    shown = np.isfinite(field)
    axes.set_facecolor("#eeeeee")
    base = np.where(grid.number >= 0, 0.0, np.nan).T
    axes.pcolormesh(grid.along, grid.across, base, cmap="gray_r", vmin=0.0, vmax=1.0)
    if shown.any():
        greatest = float(np.nanpercentile(field, 99.5))
        mesh = axes.pcolormesh(
            grid.along, grid.across, field.T, cmap="viridis", vmin=0.0, vmax=greatest
        )
        beside = axes.inset_axes((1.02, 0.0, 0.025, 1.0))
        axes.figure.colorbar(mesh, cax=beside, label=label, extend="max")
        x, y = (0.5 * (edges[:-1] + edges[1:]) for edges in (grid.along, grid.across))
        if contours and min(field.shape) >= 2 and greatest > 0.0:
            levels = np.linspace(0.0, greatest, LEVELS + 1)[1:-1:2]
            axes.contour(x, y, np.nan_to_num(field).T, levels, colors="black", linewidths=0.4)
    axes.set(aspect="equal", ylabel="y, m")
    axes.grid(False)


def greatest_across(grid: Grid, values: Floats) -> tuple[Floats, Floats]:
    """Return the middles of the columns of a grid along x, and the greatest value in each."""
    field = np.where(grid.number >= 0, values[grid.number], -np.inf)
    return 0.5 * (grid.along[:-1] + grid.along[1:]), field.max(axis=1)
