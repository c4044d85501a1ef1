"""Plots of several runs in the same axes, and their plans side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from debrisflow import __version__
from debrisflow.results.deposition import Deposition, deposition, greatest_across
from debrisflow.results.fronts import PHASE_WORDS
from debrisflow.results.plots.curves import draw_reference, legend
from debrisflow.results.plots.maps import map_height, mapped
from debrisflow.results.plots.probes import compared_probes, compared_span
from debrisflow.results.plots.style import CYCLE, LINES, panels, save, styled
from debrisflow.results.references import NORMALIZED, Reference, is_velocity, ours
from debrisflow.results.survey import Survey
from debrisflow.run.tables import Table, rows_where

UNITS_OF_ABSCISSAS = {"time": "{}, s"} | dict.fromkeys("xyz", "{}, m")


def draw_comparison(
    found: Sequence[Survey],
    names: Sequence[str],
    given: Sequence[Reference],
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
    given : sequence of Reference
        Curves that are drawn with those of the runs.
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
            "curves": ("Runs compared", _curves(found, names, given, deposits, time)),
            "normalized_profiles": (
                "Velocity profiles above the bed",
                _profiles(found, names, given),
            ),
            "probes": (
                f"Probes: means over {compared_span(found):g} s",
                compared_probes(found, names, given),
            ),
            "references": ("Runs and references", _references(found, names, given)),
        }
        if found[0].run.case.dimension == 3:
            figures["plans"] = (f"Flow at t = {time:g} s", _plans(deposits, names))
        return [
            save(figure, target / f"{name}.png", title, captions)
            for name, (title, figure) in figures.items()
            if figure is not None
        ]


def _styles(count: int) -> list[tuple[str, str]]:
    """Return color and line of each run."""
    return [(CYCLE[k % len(CYCLE)], LINES[k // len(CYCLE) % len(LINES)]) for k in range(count)]


def _curves(
    found: Sequence[Survey],
    names: Sequence[str],
    given: Sequence[Reference],
    deposits: Sequence[Deposition],
    time: float,
) -> Figure:
    """Return front, speed and energy against time, and deposit and flow at a time."""
    whose = {one.headline for one in found}
    phase = whose.pop() if len(whose) == 1 else "all"
    heights = {"deposit_height": "deposit, cm", "flow_height": "flow height, cm"}
    heights = {
        name: label
        for name, label in heights.items()
        if any(there.table[name].any() for there in deposits)
    }
    figure, (front, speed, energy, *places) = panels(3 + len(heights), height=1.9)
    for one, name, there, (color, line) in zip(
        found, names, deposits, _styles(len(found)), strict=True
    ):
        style: Any = {"color": color, "linestyle": line, "label": name}
        front.plot(one.fronts["time"], one.fronts[f"front_{phase}"], **style)
        speed.plot(one.fronts["time"], one.fronts[f"speed_{phase}"], **style)
        energy.plot(one.budget["time"], one.budget["kinetic_energy"], **style)
        for axes, height in zip(places, heights, strict=True):
            x, values = greatest_across(there.grid, there.table[height])
            axes.plot(x, 100.0 * values, **style)
    for axes, column in ((front, f"front_{phase}"), (speed, f"speed_{phase}")):
        for reference in given:
            if reference.abscissa == "time" and column in reference.curves:
                draw_reference(axes, reference, column, f"{reference.name}: {column}", "black")
    unit = "J" if found[0].run.case.dimension == 3 else "J/m"
    word = "front" if phase == "all" else f"front of the\n{PHASE_WORDS[phase]}"
    front.set_ylabel(f"{word} x, m")
    speed.set_ylabel("speed of\nthe front, m/s")
    energy.set(ylabel=f"kinetic\nenergy, {unit}", xlabel="time, s")
    for axes, label in zip(places, heights.values(), strict=True):
        axes.set(ylabel=f"{label}\nt = {time:g} s", xlabel="x, m")
    latest = max(float(one.fronts["time"][-1]) for one in found)
    for axes in (front, speed, energy):
        axes.set_xlim(0.0, latest)
    legend(front)
    return figure


def _references(
    found: Sequence[Survey], names: Sequence[str], given: Sequence[Reference]
) -> Figure | None:
    """Return the curves of references with those of the runs, but for probes, a panel each."""
    curves = [
        (reference, curve)
        for reference in given
        for curve in reference.curves
        if reference.abscissa != "time" or curve in found[0].fronts
    ]
    if not curves:
        return None
    figure, axes = panels(len(curves))
    for (reference, curve), panel in zip(curves, axes, strict=True):
        is_profile = reference.abscissa not in ("time", "x")
        for one, name, (color, line) in zip(found, names, _styles(len(found)), strict=True):
            style: Any = {"color": color, "linestyle": line, "label": name}
            for x, values in ours(one, reference, curve).values():
                panel.plot(*((values, x) if is_profile else (x, values)), **style)
                style["label"] = None
        draw_reference(panel, reference, curve, reference.name, "black", swapped=is_profile)
        abscissa = UNITS_OF_ABSCISSAS.get(reference.abscissa, "{}").format(reference.abscissa)
        across = (abscissa, curve)
        panel.set(
            xlabel=across[is_profile],
            ylabel=across[not is_profile],
        )
    legend(*axes)
    return figure


def _profiles(
    found: Sequence[Survey], names: Sequence[str], given: Sequence[Reference]
) -> Figure | None:
    """Return u/u_s against y/h at the stations that all have; None where nothing flows there."""
    stations = [
        x
        for x in sorted(set.intersection(*(set(one.stations) for one in found)))
        if any(np.isfinite(_at_station(one, x)["u_over_us"]).any() for one in found)
    ]
    if not stations:
        return None
    columns = 3
    figure, axes = panels(
        -(-len(stations) // columns), columns, height=2.2, sharex=True, sharey=True
    )
    for x, panel in zip(stations, axes, strict=False):
        for one, name, (color, line) in zip(found, names, _styles(len(found)), strict=True):
            part = _at_station(one, x)
            values = part["u_over_us"], part[NORMALIZED]
            panel.plot(*values, ".", color=color, linestyle=line, label=name)
        for reference in (one for one in given if one.abscissa == NORMALIZED):
            for curve in (name for name in reference.curves if is_velocity(found[0], name)):
                label = f"{reference.name}: {curve}"
                draw_reference(panel, reference, curve, label, "black", swapped=True)
        panel.set_title(f"x = {x:g} m", loc="left")
        panel.set(xlim=(0.0, 1.1), ylim=(0.0, 1.05))
    for panel in axes[len(stations) :]:
        panel.axis("off")
    for panel in axes[::columns]:
        panel.set_ylabel("y / h")
    for panel in axes[max(0, len(stations) - columns) : len(stations)]:
        panel.set_xlabel("u / u_s")
        panel.tick_params(labelbottom=True)
    legend(axes[min(columns, len(stations)) - 1])
    return figure


def _at_station(one: Survey, x: float) -> Table:
    """Return the mean profile of a run at a station."""
    return rows_where(one.mean_profiles, one.mean_profiles["station"] == x)


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
