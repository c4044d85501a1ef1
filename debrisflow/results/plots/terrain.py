"""Plots of a run on a terrain, of one and of several together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from debrisflow import __version__
from debrisflow.results.budgets import MATTER
from debrisflow.results.plots.curves import draw_reference, legend
from debrisflow.results.plots.probes import compared_probes, compared_span
from debrisflow.results.plots.style import (
    BLUE,
    CYCLE,
    GRAY,
    GREEN,
    LINES,
    MATTER_COLORS,
    ORANGE,
    RED,
    SKY,
    panels,
    save,
    styled,
)
from debrisflow.results.references import Reference
from debrisflow.results.stations import flow_probes
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.run.measures import particle_volume

PLACES = {
    "moving": ("moving", SKY),
    "at_rest": ("at rest", ORANGE),
    "left": ("left over an edge", GRAY),
    "through_ground": ("lost through the ground", RED),
}
FRONT_LABELS = {
    "front": "front along\nthe path, m",
    "front_speed": "speed of\nthe front, m/s",
    "area": "area\nreached, m²",
}
PATH_LABELS = {
    "peak_depth": "peak depth, m",
    "peak_speed": "peak speed,\nm/s",
    "arrival": "arrival, s",
    "width": "width, m",
}


def terrain_figures(
    found: TerrainSurvey, given: Sequence[Reference]
) -> dict[str, tuple[str, Figure | None]]:
    """Return title and figure by name; None where there is nothing to show."""
    return {
        "front": ("How far the flow has reached", front_figure(found, given)),
        "path": ("Along the flow path", path_figure(found)),
        "ledger": ("Where what was released is", ledger_figure(found)),
        "hydrographs": ("Discharge and passed volume of sections", section_figure(found)),
        "budget": ("Budgets of mass and energy", budget_figure(found)),
    }


def front_figure(found: TerrainSurvey, given: Sequence[Reference]) -> Figure | None:
    """Return front, its speed and the area reached against time; None if nothing was reached."""
    table = found.fronts
    if np.isnan(table["front"]).all():
        return None
    figure, axes = panels(len(FRONT_LABELS), height=1.9, sharex=True)
    place, speed, area = axes
    place.plot(table["time"], table["front"], color=BLUE, label="farthest, along the path")
    place.plot(table["time"], table["reach"], color=GREEN, label="farthest, straight")
    place.plot(
        table["time"],
        table["moving_front"],
        ":",
        color=GRAY,
        label="99.5 % of what moves, straight",
    )
    speed.plot(table["time"], table["front_speed"], color=BLUE, label="along the path")
    area.plot(table["time"], table["area"], color=BLUE, label="ever deeper than the threshold")
    for name, one in zip(("front", "front_speed", "area"), axes, strict=True):
        _draw_references(one, given, name)
        one.set_ylabel(FRONT_LABELS[name] if one is not place else "distance in plan, m")
    speed.set_ylim(bottom=0.0)
    area.set_xlabel("time, s")
    legend(*axes)
    return figure


def _draw_references(axes: Axes, given: Sequence[Reference], name: str) -> None:
    """Draw the curves of references over the time that have a name."""
    for reference in given:
        if reference.abscissa == "time" and name in reference.curves:
            draw_reference(axes, reference, name, f"{reference.name}: {name}", "black")


def path_figure(found: TerrainSurvey) -> Figure | None:
    """Return terrain, greatest values, arrival and width along the path; None without a flow."""
    table = found.profile
    if not found.reached.any():
        return None
    figure, (ground, *axes) = panels(
        1 + len(PATH_LABELS), height=[2.3, 1.4, 1.4, 1.4, 1.4], sharex=True
    )
    ground.plot(table["s"], table["elevation"], color="black", label="terrain")
    flow = found.mobility
    levels = np.interp([0.0, flow.runout], table["s"], table["elevation"])
    slope = -float(np.diff(levels)[0]) / flow.runout if flow.runout > 0.0 else np.nan
    ground.plot([0.0, flow.runout], levels, "--", color=ORANGE, label=f"mean slope {slope:.3f}")
    ground.set_ylabel("elevation, m")
    for name, one in zip(PATH_LABELS, axes, strict=True):
        one.plot(table["s"], np.where(table["width"] > 0.0, table[name], np.nan), color=BLUE)
        one.set_ylabel(PATH_LABELS[name])
        one.set_ylim(bottom=0.0)
    for one in (ground, *axes):
        one.axvline(flow.runout, color=GRAY, linewidth=0.8, linestyle=":")
    axes[-1].set(xlabel="distance along the flow path in plan, m", xlim=(0.0, _shown(found)))
    legend(ground)
    return figure


def _shown(found: TerrainSurvey) -> float:
    """Return up to where the path is shown: a tenth beyond the flow, m."""
    return float(min(1.1 * found.mobility.runout + 2.0 * found.grid.cell, found.path.length))


def ledger_figure(found: TerrainSurvey) -> Figure | None:
    """Return the parts of the released volume against time, stacked; None if there is none."""
    table, volume = found.run.ledger, particle_volume(found.run.case)
    if not table["released"].any():
        return None
    figure, (axes,) = panels(1, height=2.6)
    shown = [name for name in PLACES if table[name].any()]
    axes.stackplot(
        table["time"],
        [table[name] * volume for name in shown],
        labels=[PLACES[name][0] for name in shown],
        colors=[PLACES[name][1] for name in shown],
        alpha=0.8,
    )
    axes.plot(table["time"], table["released"] * volume, color="black", label="released")
    error = found.ledger_error
    axes.set_title(f"greatest error of the ledger: {error:g} particles", loc="left")
    axes.set(xlabel="time, s", ylabel="volume, m³")
    legend(axes)
    return figure


def section_figure(found: TerrainSurvey) -> Figure | None:
    """Return discharge, that of the grains, and the volume that passed; None without a flow."""
    curves = [(probe.name, found.run.probe(probe.name)) for probe in flow_probes(found.run.case)]
    labels = {
        "discharge": "discharge, m³/s",
        "sediment_discharge": "of which\ngrains, m³/s",
        "volume": "passed volume, m³",
    }
    shown = [
        name for name in labels if any(np.nan_to_num(table[name]).any() for _, table in curves)
    ]
    if not shown:
        return None
    figure, axes = panels(len(shown), height=1.9, sharex=True)
    for name, one in zip(shown, axes, strict=True):
        for (label, table), color in zip(curves, CYCLE * len(curves), strict=False):
            one.plot(table["time"], table[name], color=color, label=label)
        one.set_ylabel(labels[name])
    axes[-1].set_xlabel("time, s")
    legend(axes[0])
    return figure


def budget_figure(found: TerrainSurvey) -> Figure:
    """Return mass by matter and energies against time."""
    table = found.budget
    figure, (mass, energy) = panels(2, height=2.1, sharex=True)
    ways = {"inside": "-", "in": "--", "out": ":", "through_wall": "-."}
    words = {"inside": "on the terrain", "in": "released", "out": "left", "through_wall": "lost"}
    for matter, color in MATTER_COLORS.items():
        for way, line in ways.items():
            values = table[f"mass_{way}_{matter}"]
            if values.any():
                label = f"{matter}, {words[way]}"
                mass.plot(table["time"], values / 1000.0, line, color=color, label=label)
    for name, color in (("kinetic", ORANGE), ("elastic", GREEN)):
        if table[f"{name}_energy"].any():
            energy.plot(table["time"], table[f"{name}_energy"] / 1e6, color=color, label=name)
    worst = max(float(np.abs(table[f"closure_{one}"]).max(initial=0.0)) for one in MATTER)
    mass.set_title(f"greatest error of the balance: {worst:.2g} kg", loc="left")
    mass.set_ylabel("mass, t")
    energy.set(ylabel="energy, MJ", xlabel="time, s")
    legend(mass, energy)
    return figure


def draw_terrain_comparison(
    found: Sequence[TerrainSurvey],
    names: Sequence[str],
    given: Sequence[Reference],
    differing: Sequence[str],
    target: Path,
) -> list[Path]:
    """Draw runs on terrains together into a folder and return the files.

    Parameters
    ----------
    found : sequence of TerrainSurvey
    names : sequence of str
        Of the runs.
    given : sequence of Reference
    differing : sequence of str
        The parameters that differ, for the caption.
    target : Path
    """
    captions = [", ".join(names) + f". debrisflow {__version__}", *differing]
    with styled():
        probes = f"Probes: means over {compared_span(found):g} s"
        figures = {
            "curves": ("Runs compared", _compared_fronts(found, names, given)),
            "path": ("Along the flow path of each", _compared_paths(found, names)),
            "probes": (probes, compared_probes(found, names, given)),
        }
        return [
            save(figure, target / f"{name}.png", title, captions)
            for name, (title, figure) in figures.items()
            if figure is not None
        ]


def _styles(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return color, line and label of each run."""
    return [
        {
            "color": CYCLE[k % len(CYCLE)],
            "linestyle": LINES[k // len(CYCLE) % len(LINES)],
            "label": name,
        }
        for k, name in enumerate(names)
    ]


def _compared_fronts(
    found: Sequence[TerrainSurvey], names: Sequence[str], given: Sequence[Reference]
) -> Figure:
    """Return front, its speed, area and kinetic energy of runs against time."""
    figure, axes = panels(len(FRONT_LABELS) + 1, height=1.8, sharex=True)
    for one, style in zip(found, _styles(names), strict=True):
        for name, panel in zip(FRONT_LABELS, axes, strict=False):
            panel.plot(one.fronts["time"], one.fronts[name], **style)
        axes[-1].plot(one.budget["time"], one.budget["kinetic_energy"] / 1e6, **style)
    for name, panel in zip(FRONT_LABELS, axes, strict=False):
        panel.set_ylabel(FRONT_LABELS[name])
        _draw_references(panel, given, name)
    axes[1].set_ylim(bottom=0.0)
    axes[-1].set(ylabel="kinetic\nenergy, MJ", xlabel="time, s")
    legend(axes[0])
    return figure


def _compared_paths(found: Sequence[TerrainSurvey], names: Sequence[str]) -> Figure:
    """Return terrain and greatest values of runs along their paths."""
    figure, axes = panels(len(PATH_LABELS), height=1.8, sharex=True)
    for one, style in zip(found, _styles(names), strict=True):
        table = one.profile
        for name, panel in zip(PATH_LABELS, axes, strict=True):
            shown = np.where(table["width"] > 0.0, table[name], np.nan)
            panel.plot(table["s"], shown, **style)
    for name, panel in zip(PATH_LABELS, axes, strict=True):
        panel.set_ylabel(PATH_LABELS[name])
        panel.set_ylim(bottom=0.0)
    axes[-1].set_xlabel("distance along the flow path in plan, m")
    legend(axes[0])
    return figure
