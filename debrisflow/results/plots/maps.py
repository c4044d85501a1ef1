"""Plots over the plan: the deposit and the greatest depths and speeds, lines or maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.results.deposition import Deposition, greatest_across, smoothed
from debrisflow.results.plots.curves import legend
from debrisflow.results.plots.style import BLUE, GRAY, MATTER_COLORS, ORANGE, RED, panels, sequence
from debrisflow.results.references import Reference
from debrisflow.results.survey import Survey
from debrisflow.space.plan_grid import Grid

Floats = NDArray[np.float64]
LEVELS = 8
MAP_WIDTH, LEAST_HEIGHT, GREATEST_HEIGHT = 5.4, 0.9, 3.6  # inch


def deposit_figure(found: Survey, given: Sequence[Reference]) -> Figure:
    """Return the deposit: its profiles in two dimensions, its map and profiles in three."""
    if found.run.case.dimension == 3:
        return _deposit_map(found, given)
    return _deposit_profiles(found, given)


def flow_figure(found: Survey, given: Sequence[Reference]) -> Figure | None:
    """Return the height of the flow of what holds no grains; None where there is none."""
    deposits, last = found.deposits, found.deposits[-1]
    if not any(one.table["flow_height"].any() for one in deposits):
        return None
    three = found.run.case.dimension == 3
    figure, axes = panels(
        1 + three, height=[map_height(last.grid), 2.3] if three else 2.3, sharex=True
    )
    if three:
        label = f"flow, cm\nt = {last.time:g} s"
        mapped(axes[0], last.grid, last.table["flow_height"], label, 100.0, contours=False)
    highest = 0.0
    for one, color in zip(deposits, sequence(len(deposits)), strict=True):
        x, height = greatest_across(one.grid, one.table["flow_height"])
        highest = max(highest, 100.0 * float(height.max()))
        axes[-1].plot(x, 100.0 * height, color=color, label=_at(one))
    _draw_references(given, dict.fromkeys(("flow_height", "water_depth"), axes[-1]))
    word = "greatest flow height\nacross, cm" if three else "flow height, cm"
    axes[-1].set(xlabel="x, m", ylabel=word)
    axes[-1].set_ylim(bottom=0.0, top=max(1.05 * highest, axes[-1].get_ylim()[1]))
    legend(axes[-1])
    return figure


def _deposit_profiles(found: Survey, given: Sequence[Reference]) -> Figure:
    deposits, last = found.deposits, found.deposits[-1]
    figure, (height, matter, change) = panels(3, height=2.2, sharex=True)
    x = last.grid.x
    for one, color in zip(deposits, sequence(len(deposits)), strict=True):
        height.plot(x, 100.0 * one.table["deposit_height"], color=color, label=_at(one))
        change.plot(x, 100.0 * one.table["bed_change"], color=color, label=_at(one))
    height.plot(x, 100.0 * last.table["flow_height"], ":", color=BLUE, label=f"flow, {_at(last)}")
    for name, shade in MATTER_COLORS.items():
        values = 100.0 * smoothed(last.grid, last.table[f"{name}_depth"])
        matter.plot(x, values, color=shade, label=f"{name}, {_at(last)}")
    _draw_references(given, _places(height, matter, change))
    height.set_ylabel("deposit over the\nfixed floor, cm")
    matter.set_ylabel("volume over\narea, cm")
    change.set(xlabel="x, m", ylabel="deposition, or\nerosion < 0, cm")
    legend(height, matter, change)
    return figure


def _places(height: Axes, matter: Axes, change: Axes) -> dict[str, Axes]:
    """Return the axes by the columns that belong into them."""
    places = {"sediment_depth": matter, "water_depth": matter, "bed_change": change}
    return places | dict.fromkeys(("deposit_height", "flow_height", "deposit_depth"), height)


def _draw_references(given: Sequence[Reference], places: Mapping[str, Axes]) -> None:
    """Draw curves over x into the axes where they belong."""
    for reference in given:
        if reference.abscissa == "x":
            for name in (name for name in reference.curves if name in places):
                values = reference.table["x"], 100.0 * reference.table[name]
                places[name].plot(*values, "k--", label=f"{reference.name}: {name}")


def _at(one: Deposition) -> str:
    return f"t = {one.time:g} s"


def _deposit_map(found: Survey, given: Sequence[Reference]) -> Figure:
    last = found.deposits[-1]
    tall = map_height(last.grid)
    figure, (lying, flowing, profile) = panels(3, height=(tall, tall, 2.3), sharex=True)
    mapped(
        lying, last.grid, last.table["deposit_height"], f"deposit, cm\nt = {last.time:g} s", 100.0
    )
    label, height = f"flow, cm\nt = {last.time:g} s", last.table["flow_height"]
    mapped(flowing, last.grid, height, label, 100.0, contours=False)
    for one, color in zip(found.deposits, sequence(len(found.deposits)), strict=True):
        x, height = greatest_across(one.grid, one.table["deposit_height"])
        profile.plot(x, 100.0 * height, color=color, label=_at(one))
    x, height = greatest_across(last.grid, last.table["flow_height"])
    profile.plot(x, 100.0 * height, ":", color=BLUE, label=f"flow, {_at(last)}")
    _draw_references(given, _places(profile, profile, profile))
    profile.set(xlabel="x, m", ylabel="greatest height across,\ncm over the floor")
    legend(profile)
    return figure


def maxima_figure(found: Survey) -> Figure | None:
    """Return greatest depth, greatest speed and time of arrival over the plan, those that are."""
    maxima, grid = found.run.maxima, found.deposits[-1].grid
    three = found.run.case.dimension == 3
    known = (
        ("maximal_depth", "greatest\ndepth, cm", 100.0, BLUE),
        ("maximal_speed", "greatest\nspeed, m/s", 1.0, RED),
        ("arrival_time", "arrival, s", 1.0, ORANGE),
    )
    shown = [one for one in known if np.nan_to_num(maxima[one[0]]).any()]
    if not shown:
        return None
    height = map_height(grid) if three else 2.2
    figure, axes = panels(len(shown), height=height, sharex=True)
    for one, (name, label, scale, color) in zip(axes, shown, strict=True):
        if three:
            mapped(one, grid, maxima[name], label, scale, contours=name != "maximal_speed")
        else:
            one.plot(grid.x, scale * maxima[name], color=color)
            one.set_ylabel(label)
    axes[-1].set_xlabel("x, m")
    return figure


def map_height(grid: Grid) -> float:
    """Return the height, inch, of a map in true proportions as wide as a page."""
    ratio = float(np.ptp(grid.across) / np.ptp(grid.along))
    return min(max(MAP_WIDTH * ratio, LEAST_HEIGHT), GREATEST_HEIGHT)


def mapped(
    axes: Axes,
    grid: Grid,
    values: Floats,
    label: str,
    scale: float,
    contours: bool = True,
    limit: float | None = None,
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
    limit : float, optional
        Value at the end of the color bar; exceeded by one cell in two hundred if left out.
    """
    field = np.where(grid.number >= 0, (scale * values)[grid.number], np.nan)
    field = np.where(field > 0.0, field, np.nan)
    shown = np.isfinite(field)
    axes.set_facecolor("#eeeeee")
    base = np.where(grid.number >= 0, 0.0, np.nan).T
    axes.pcolormesh(grid.along, grid.across, base, cmap="gray_r", vmin=0.0, vmax=1.0)
    if shown.any():
        greatest = float(np.nanpercentile(field, 99.5)) if limit is None else scale * limit
        mesh = axes.pcolormesh(
            grid.along, grid.across, field.T, cmap="viridis", vmin=0.0, vmax=greatest
        )
        beside = axes.inset_axes((1.02, 0.0, 0.025, 1.0))
        bar = axes.figure.colorbar(mesh, cax=beside, label=label, extend="max")
        x, y = (0.5 * (edges[:-1] + edges[1:]) for edges in (grid.along, grid.across))
        if contours and min(field.shape) >= 2 and greatest > 0.0:
            levels = np.linspace(0.0, greatest, LEVELS + 1)[1:-1:2]
            levels = levels[(levels > np.nanmin(field)) & (levels < np.nanmax(field))]
            if levels.size:  # none crosses what is nearly even
                filled = np.ma.masked_invalid(field).T
                lines = axes.contour(x, y, filled, levels, colors="black", linewidths=0.4)
                bar.add_lines(lines)
    else:
        told = f"nothing: {label.splitlines()[0]}"
        axes.text(0.5, 0.5, told, transform=axes.transAxes, ha="center", va="center", color=GRAY)
    axes.set(aspect="equal", ylabel="y, m")
    axes.grid(False)
