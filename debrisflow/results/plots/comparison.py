"""Plots of several runs in the same axes, and their plans side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from debrisflow import __version__
from debrisflow.results.deposition import Deposition, deposition, greatest_across
from debrisflow.results.plots.curves import legend
from debrisflow.results.plots.maps import map_height, mapped
from debrisflow.results.plots.probes import compared_probes, compared_span
from debrisflow.results.plots.style import CYCLE, LINES, panels, save, styled
from debrisflow.results.references import NORMALIZED
from debrisflow.results.survey import Survey
from debrisflow.run.tables import rows_where


def draw_comparison(
    found: Sequence[Survey],
    names: Sequence[str],
    differing: Sequence[str],
    time: float,
    target: Path,
) -> list[Path]:
    """Draw runs together into a folder and return the files.

    Parameters
    ----------
    found : sequence of Survey
    names : sequence of str
        Of the runs.
    differing : sequence of str
        The parameters that differ, for the caption.
    time : float, s
        At which deposit and flow are shown.
    target : Path
    """
    deposits = [deposition(one.run.case, one.run.frame(time)) for one in found]
    captions = [", ".join(names) + f". debrisflow {__version__}", *differing]
    with styled():
        figures = {
            "curves": ("Runs compared", _curves(found, names, deposits, time)),
            "normalized_profiles": ("Velocity profiles above the bed", _profiles(found, names)),
        }
        probes = compared_probes(found, names)
        if probes is not None:
            figures["probes"] = (f"Probes: means over {compared_span(found):g} s", probes)
        if found[0].run.case.dimension == 3:
            figures["plans"] = (f"Flow at t = {time:g} s", _plans(deposits, names))
        return [
            save(figure, target / f"{name}.png", title, captions)
            for name, (title, figure) in figures.items()
        ]


def _styles(count: int) -> list[tuple[str, str]]:
    """Return color and line of each run."""
    return [(CYCLE[k % len(CYCLE)], LINES[k // len(CYCLE) % len(LINES)]) for k in range(count)]


def _curves(
    found: Sequence[Survey], names: Sequence[str], deposits: Sequence[Deposition], time: float
) -> Figure:
    figure, (front, speed, energy, deposit, flow) = panels(5, height=1.9)
    for one, name, there, (color, line) in zip(
        found, names, deposits, _styles(len(found)), strict=True
    ):
        style: Any = {"color": color, "linestyle": line, "label": name}
        front.plot(one.fronts["time"], one.fronts["front_all"], **style)
        speed.plot(one.fronts["time"], one.fronts["speed_all"], **style)
        energy.plot(one.budget["time"], one.budget["kinetic_energy"], **style)
        for axes, height in ((deposit, "deposit_height"), (flow, "flow_height")):
            x, values = greatest_across(there.grid, there.table[height])
            axes.plot(x, 100.0 * values, **style)
    unit = "J" if found[0].run.case.dimension == 3 else "J/m"
    front.set_ylabel("front x, m")
    speed.set_ylabel("speed of\nthe front, m/s")
    energy.set(ylabel=f"kinetic\nenergy, {unit}", xlabel="time, s")
    deposit.set_ylabel(f"deposit, cm\nt = {time:g} s")
    flow.set(ylabel=f"flow height, cm\nt = {time:g} s", xlabel="x, m")
    latest = max(float(one.fronts["time"][-1]) for one in found)
    for axes in (front, speed, energy):
        axes.set_xlim(0.0, latest)
    legend(front)
    return figure


def _profiles(found: Sequence[Survey], names: Sequence[str]) -> Figure:
    stations = sorted(set.intersection(*(set(one.stations) for one in found)))
    columns = 3
    rows = max(1, -(-len(stations) // columns))
    figure, axes = panels(rows, columns, height=2.2, sharex=True, sharey=True)
    for x, panel in zip(stations, axes, strict=False):
        for one, name, (color, line) in zip(found, names, _styles(len(found)), strict=True):
            part = rows_where(one.mean_profiles, one.mean_profiles["station"] == x)
            values = part["u_over_us"], part[NORMALIZED]
            panel.plot(*values, ".", color=color, linestyle=line, label=name)
        panel.set_title(f"x = {x:g} m", loc="left")
        panel.set(xlim=(0.0, 1.1), ylim=(0.0, 1.05))
    for panel in axes[len(stations) :]:
        panel.axis("off")
    for panel in axes[::columns]:
        panel.set_ylabel("y / h")
    for panel in axes[max(0, len(stations) - columns) : len(stations)]:
        panel.set_xlabel("u / u_s")
        panel.tick_params(labelbottom=True)
    if stations:
        legend(axes[min(columns, len(stations)) - 1])
    return figure


def _plans(deposits: Sequence[Deposition], names: Sequence[str]) -> Figure:
    tall = map_height(deposits[0].grid) + 0.2
    figure, axes = panels(len(deposits), height=tall, sharex=True, sharey=True)
    greatest = max(float(np.percentile(one.table["flow_height"], 99.5)) for one in deposits)
    for one, name, panel in zip(deposits, names, axes, strict=True):
        height = one.table["flow_height"]
        mapped(panel, one.grid, height, "flow height, cm", 100.0, contours=False, limit=greatest)
        panel.set_title(name, loc="left")
    axes[-1].set_xlabel("x, m")
    return figure
