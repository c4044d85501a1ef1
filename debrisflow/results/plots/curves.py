"""Plots against time and over the height: fronts, hydrographs, budgets, profiles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

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
    SKY,
    labelled,
    panels,
    sequence,
)
from debrisflow.results.references import (
    NORMALIZED,
    POOLED,
    Distance,
    Reference,
    dilatant_profile,
    is_velocity,
)
from debrisflow.results.survey import Survey
from debrisflow.run.tables import Table, rows_where

Floats = NDArray[np.float64]
PHASE_WORDS = {"liquid": "water", "sediment": "sediment", "mixture": "mixture", "all": "all"}
NORMALIZED_LABELS = {"u_over_us": "u / u_s", "concentration": "concentration"}
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
        style: Any = {"color": PHASE_COLORS[name], "label": PHASE_WORDS[name]}
        place.plot(table["time"], table[f"front_{name}"], **style)
        place.plot(table["time"], table[f"outer_front_{name}"], ":", color=style["color"])
        speed.plot(table["time"], table[f"speed_{name}"], **style)
    if present:
        place.plot([], [], "-", color="black", label="99.5 % of the volume")
        place.plot([], [], ":", color="black", label="99.9 %")
    history = found.run.history
    known = [(arrival(history["time"], history["front_all"], x), x) for x in found.stations]
    if known := [(when, x) for when, x in known if not np.isnan(when)]:
        place.plot(
            *zip(*known, strict=True), "o", ms=3, color="black", label="arrival at a station"
        )
    for reference in given:
        if reference.abscissa == "time":
            shown = [name for name in reference.curves if name in table]
            for name, line in zip(shown, LINES, strict=False):
                axes = speed if name.startswith("speed") else place
                draw_reference(axes, reference, name, f"{reference.name}: {name}", GREEN, line)
    place.set_ylabel("front x, m")
    speed.set(xlabel="time, s", ylabel="speed of the front, m/s")
    legend(place, speed)
    return figure


def draw_reference(
    axes: Axes, reference: Reference, name: str, label: str, color: str, line: str = "--"
) -> None:
    """Draw a curve of a reference over its abscissa, and its band."""
    x, values = reference.table[reference.abscissa], reference.table[name]
    known, band = ~np.isnan(values), reference.band(name)
    axes.plot(x[known], values[known], line, color=color, label=label)
    if band is not None:
        axes.fill_between(x, *band, color=color, alpha=0.15, linewidth=0.0)


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
    words = labelled([f"x = {x:g} m" for x in places])
    for (name, label), one in zip(PROFILE_LABELS.items(), axes, strict=False):
        if name == "granular_temperature" and not found.mean_profiles[name].any():
            one.text(0.5, 0.5, "no collision stress", transform=one.transAxes, ha="center", c=GRAY)
            one.set_xlabel(label)
            one.set_xticks([])
            continue
        for x, word, color in zip(places, words, sequence(len(places)), strict=True):
            part = rows_where(found.mean_profiles, found.mean_profiles["station"] == x)
            one.plot(part[name], part[up], ".-", ms=3, color=color, label=word)
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


def normalized_figure(
    found: Survey, given: Sequence[Reference], measured: Sequence[Distance]
) -> Figure:
    """Return u/u_s and C against y/h by station, with the dilatant profile and the distances."""
    figure, axes = panels(1, 2, height=3.6, sharey=True)
    velocity, concentration = axes
    profiles, places = found.mean_profiles, found.stations
    rms = {row.ours: row.rms for row in measured if row.reference == "dilatant"}
    words = labelled([_with_rms(f"x = {x:g} m", rms) for x in places])
    markers = "osv^D<>ph*" * len(places)
    for x, word, color, marker in zip(places, words, sequence(len(places)), markers, strict=False):
        part = rows_where(profiles, profiles["station"] == x)
        for one, name in zip(axes, NORMALIZED_LABELS, strict=True):
            one.plot(part[name], part[NORMALIZED], marker, ms=3, color=color, label=word)
    if found.chosen and len(places) > 1:
        part, word = found.pooled_profile, _with_rms(POOLED, rms)
        values = part["u_over_us"], part[NORMALIZED]
        velocity.plot(*values, "s", ms=6, mfc="none", color="black")
        concentration.plot([], [], "s", ms=6, mfc="none", color="black", label=word)
    exact = dilatant_profile().table
    velocity.plot(exact["u_over_us"], exact[NORMALIZED], color=GRAY)
    concentration.plot([], [], color=GRAY, label="dilatant, 1 - (1 - y/h)^1.5")
    for reference in given:
        if reference.abscissa == NORMALIZED:
            _draw_normalized(found, reference, velocity, concentration)
    for one, label in zip(axes, NORMALIZED_LABELS.values(), strict=True):
        one.set(xlabel=label, xlim=(-0.02, 1.05), ylim=(0.0, 1.05))
    velocity.set_ylabel("y / h above the bed")
    legend(concentration)
    return figure


def _draw_normalized(
    found: Survey, reference: Reference, velocity: Axes, concentration: Axes
) -> None:
    """Draw curves over y/h where they belong, with their names in the legend of the last axes."""
    for name, line in zip(reference.curves, LINES[1:] * len(reference.curves), strict=False):
        values = reference.table[name], reference.table[NORMALIZED]
        style: Any = {"linestyle": line, "color": GREEN, "label": f"{reference.name}: {name}"}
        if is_velocity(found, name):
            velocity.plot(*values, **style)
            concentration.plot([], [], **style)
        elif name == "concentration":
            concentration.plot(*values, **style)


def _with_rms(label: str, rms: dict[str, float]) -> str:
    found = rms.get(label, np.nan)
    return f"{label}: rms {found:.3f}" if np.isfinite(found) else label


def hydrograph_figure(found: Survey) -> Figure:
    """Return discharge, its sediment, and the volume that passed, by station and section."""
    three = found.run.case.dimension == 3
    per = "" if three else "\nper meter of width"
    figure, axes = panels(3, sharex=True)
    sections = stations.flow_probes(found.run.case)
    table, places = found.hydrographs, found.stations
    words = labelled([f"x = {x:g} m" for x in places])
    curves: list[tuple[str, Table, Any, str]] = [
        (word, rows_where(table, table["station"] == x), color, "-")
        for x, word, color in zip(places, words, sequence(len(places)), strict=True)
    ]
    curves += [
        (f"{probe.type} {probe.name}", found.run.probe(probe.name), color, "--")
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
    """Return mass by matter, energies and forces along x against time.

    Energy that goes in and out with mass is not known, so that its total is drawn without such.
    """
    table, momentum = found.budget, found.momentum
    per = "" if found.run.case.dimension == 3 else "\nper meter of width"
    figure, (mass, energy, force) = panels(3, sharex=True)
    ways = {"inside": "-", "in": "--", "out": ":", "through_wall": "-."}
    crossing = any(table[f"mass_{way}_{one}"].any() for way in ("in", "out") for one in MATTER)
    for matter, color in MATTER_COLORS.items():
        for way, line in ways.items():
            values = table[f"mass_{way}_{matter}"]
            if values.any():
                label = f"{matter}, {way.replace('_', ' ')}"
                mass.plot(table["time"], values, line, color=color, label=label)
    names = ("kinetic", "elastic") if crossing else ("kinetic", "elastic", "potential", "total")
    for name, color in zip(names, (ORANGE, GREEN, SKY, "black"), strict=False):
        values = table[f"{name}_energy"]
        is_change = name in ("potential", "total")
        told = f"{name}, since the start" if is_change else name
        if values.any():
            energy.plot(table["time"], values - is_change * values[:1], color=color, label=told)
    force.plot(momentum["time"], momentum["gravity_x"], color=GRAY, label="weight along x")
    force.plot(
        momentum["time"], momentum["resistance_x"], color=ORANGE, label="resistance and flux"
    )
    worst = [float(np.abs(table[f"closure_{one}"]).max(initial=0.0)) for one in MATTER]
    mass.set_title(f"greatest error of the balance: {max(worst):.2g} kg", loc="left")
    mass.set_ylabel(f"mass, kg{per}")
    energy.set_ylabel(f"energy, J{per}")
    force.set(ylabel=f"force along x, N{per}", xlabel="time, s")
    legend(mass, energy, force)
    return figure
