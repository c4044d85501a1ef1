"""Plots against time and over the height: fronts, hydrographs, budgets, profiles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.case.probes import SectionProbe
from debrisflow.results import stations
from debrisflow.results.budgets import MATTER
from debrisflow.results.fronts import NAMES, arrival
from debrisflow.results.plots.style import (
    CYCLE,
    GRAY,
    GREEN,
    LINES,
    MATTER_COLORS,
    ORANGE,
    PHASE_COLORS,
    panels,
    sequence,
)
from debrisflow.results.references import NORMALIZED, Distance, Reference, dilatant_profile
from debrisflow.results.survey import Survey
from debrisflow.series import Table

Floats = NDArray[np.float64]
PROFILE_LABELS = {
    "velocity": "velocity, m/s",
    "concentration": "concentration",
    "density": "density, kg/m³",
    "shear_rate": "shear rate, 1/s",
    "granular_temperature": "granular temperature, m²/s²",
}


def front_figure(found: Survey, given: Sequence[Reference]) -> Figure:
    """Return front against time by phase, and its speed."""
    figure, (place, speed) = panels(2, sharex=True)
    table = found.fronts
    present = [name for name in NAMES if not np.isnan(table[f"front_{name}"]).all()]
    if len(present) == 2:
        present = ["all"]  # one phase is all
    for name in present:
        color = PHASE_COLORS[name]
        place.plot(table["time"], table[f"front_{name}"], color=color, label=name)
        place.plot(table["time"], table[f"outer_front_{name}"], ":", color=color)
        speed.plot(table["time"], table[f"speed_{name}"], color=color, label=name)
    place.plot([], [], "-", color="black", label="99.5 % of the volume")
    place.plot([], [], ":", color="black", label="99.9 %")
    history = found.run.history
    known = [(arrival(history["time"], history["front_all"], x), x) for x in found.stations]
    place.plot(*zip(*known, strict=True), "o", ms=3, color="black", label="arrival at a station")
    for reference in given:
        if reference.abscissa == "time":
            for name, line in zip(reference.curves, LINES, strict=False):
                label = f"{reference.name}: {name}"
                axes = speed if name.startswith("speed") else place
                axes.plot(reference.table["time"], reference.table[name], line, c="k", label=label)
    place.set_ylabel("front x, m")
    speed.set(xlabel="time, s", ylabel="speed of the front, m/s")
    legend(place, speed)
    return figure


def legend(*axes: Axes) -> None:
    """Put a legend beside each of some axes that have curves with names."""
    for one in axes:
        if one.get_legend_handles_labels()[1]:
            one.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
        else:
            one.text(0.5, 0.5, "nothing to show", transform=one.transAxes, ha="center", color=GRAY)


def profile_figure(found: Survey, given: Sequence[Reference]) -> Figure:
    """Return velocity, concentration, density, shear rate and granular temperature by height."""
    up = stations.UP[found.run.case.dimension]
    figure, axes = panels(2, 3, height=2.9, sharey=True)
    places = np.unique(found.mean_profiles["station"])
    for (name, label), one in zip(PROFILE_LABELS.items(), axes, strict=False):
        if name == "granular_temperature" and not found.mean_profiles[name].any():
            one.text(0.5, 0.5, "no collision stress", transform=one.transAxes, ha="center", c=GRAY)
        for x, color in zip(places, sequence(len(places)), strict=True):
            part = _of_station(found.mean_profiles, x)
            one.plot(part[name], part[up], ".-", ms=3, color=color, label=f"x = {x:g} m")
        for reference in given:
            if reference.abscissa == up and name in reference.curves:
                values = reference.table[name], reference.table[up]
                one.plot(*values, "k--", label=reference.name)
        one.set_xlabel(label)
    for one in axes[::3]:
        one.set_ylabel("height over the floor, m")
    handles, labels = axes[0].get_legend_handles_labels()
    axes[-1].axis("off")
    if labels:
        axes[-1].legend(handles, labels, loc="upper left")
    else:
        axes[-1].text(0.0, 0.5, "no particles at the stations\nwithin the window", color=GRAY)
    return figure


def _of_station(table: Table, x: float) -> Table:
    here = table["station"] == x
    return {name: values[here] for name, values in table.items()}


def normalized_figure(
    found: Survey, given: Sequence[Reference], measured: Sequence[Distance]
) -> Figure:
    """Return u/u_s against y/h by station, with the dilatant profile and the distances to it."""
    figure, (one,) = panels(1, height=4.2)
    parts = {x: _of_station(found.mean_profiles, x) for x in found.stations}
    labels = [f"x = {x:g} m" for x in parts]
    if found.chosen and len(found.stations) > 1:
        parts[np.inf] = found.pooled_profile
        labels.append("mean of the stations")
    rms = {row.ours: row.rms for row in measured if row.reference == "dilatant"}
    markers = "osv^D<>ph*"
    for number, (part, label) in enumerate(zip(parts.values(), labels, strict=True)):
        told = f"{label}: rms {rms[label]:.3f}" if np.isfinite(rms.get(label, np.nan)) else label
        pooled = label == "mean of the stations"
        color = "black" if pooled else sequence(len(found.stations))[number]
        style = {"ms": 5, "mfc": "none"} if pooled else {"ms": 3}
        marker = markers[number % len(markers)]
        one.plot(part["u_over_us"], part[NORMALIZED], marker, color=color, label=told, **style)
    exact = dilatant_profile()
    curve = exact.table["u_over_us"], exact.table[NORMALIZED]
    one.plot(*curve, color=GRAY, label="dilatant, 1 - (1 - y/h)^1.5")
    for reference in given:
        if reference.abscissa == NORMALIZED:
            for name, line in zip(
                reference.curves, LINES[1:] * len(reference.curves), strict=False
            ):
                values = reference.table[name], reference.table[NORMALIZED]
                one.plot(*values, line, color=GREEN, label=f"{reference.name}: {name}")
    one.set(xlabel="u / u_s", ylabel="y / h above the bed", xlim=(-0.02, 1.15), ylim=(0.0, 1.05))
    legend(one)
    return figure


def hydrograph_figure(found: Survey) -> Figure:
    """Return discharge, its sediment, and the volume that passed, by station and section."""
    three = found.run.case.dimension == 3
    per = "" if three else "\nper meter of width"
    figure, axes = panels(3, sharex=True)
    sections = [probe for probe in found.run.case.probe if isinstance(probe, SectionProbe)]
    curves: list[tuple[str, Table, Any, str]] = [
        (f"x = {x:g} m", _of_station(found.hydrographs, x), color, "-")
        for x, color in zip(found.stations, sequence(len(found.stations)), strict=True)
    ]
    curves += [
        (f"section {probe.name}", found.run.probe(probe.name), color, "--")
        for probe, color in zip(sections, CYCLE * len(sections), strict=False)
    ]
    for label, part, color, line in curves:
        axes[0].plot(part["time"], 1e3 * part["discharge"], line, color=color, label=label)
        axes[1].plot(part["time"], 1e3 * part["sediment_discharge"], line, color=color)
        axes[2].plot(part["time"], 1e3 * part["volume"], line, color=color)
    axes[0].set_ylabel(f"discharge, l/s{per}")
    axes[1].set_ylabel(f"of which grains, l/s{per}")
    axes[2].set(ylabel=f"passed volume, l{per}", xlabel="time, s")
    legend(axes[0])
    return figure


def budget_figure(found: Survey) -> Figure:
    """Return mass by matter and its closure, energies and momentum against time."""
    table, momentum = found.budget, found.momentum
    per = "" if found.run.case.dimension == 3 else " per meter of width"
    figure, (mass, closure, energy, force) = panels(2, 2, height=2.6)
    ways = {"inside": "-", "in": "--", "out": ":", "through_wall": "-."}
    for matter in MATTER:
        for way, line in ways.items():
            values = table[f"mass_{way}_{matter}"]
            if values.any():
                label = f"{matter}, {way.replace('_', ' ')}"
                mass.plot(table["time"], values, line, color=MATTER_COLORS[matter], label=label)
        error = table[f"closure_{matter}"]
        closure.plot(table["time"], error, color=MATTER_COLORS[matter], label=matter)
    names = ("kinetic", "potential", "elastic", "total")
    for name, color in zip(names, (ORANGE, PHASE_COLORS["liquid"], GREEN, "black"), strict=True):
        values = table[f"{name}_energy"]
        change = values - values[:1] if name in ("potential", "total") else values
        told = f"{name}, since the start" if name in ("potential", "total") else name
        if values.any():
            energy.plot(table["time"], change, color=color, label=told)
    force.plot(momentum["time"], momentum["gravity_x"], color=GRAY, label="weight along x")
    force.plot(
        momentum["time"], momentum["resistance_x"], color=ORANGE, label="resistance and flux"
    )
    mass.set_ylabel(f"mass, kg{per}")
    closure.set_ylabel(f"closure error, kg{per}")
    energy.set(ylabel=f"energy, J{per}", xlabel="time, s")
    force.set(ylabel=f"force along x, N{per}", xlabel="time, s")
    for one in (mass, closure, energy, force):
        if one.get_legend_handles_labels()[1]:
            one.legend(loc="best")
    return figure
