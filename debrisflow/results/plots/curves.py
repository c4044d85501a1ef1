"""Plots against time and over the height: fronts, hydrographs, budgets, profiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow.results import stations
from debrisflow.results.budgets import MATTER
from debrisflow.results.fronts import NAMES, PHASE_WORDS
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
NORMALIZED_LABELS = {"u_over_us": "u / u_s", "concentration": "concentration"}
PROFILE_LABELS = {
    "velocity": "velocity, m/s",
    "concentration": "concentration",
    "density": "density, kg/m³",
    "shear_rate": "shear rate, 1/s",
    "granular_temperature": "granular temperature, m²/s²",
}
OF_GRAINS = {"concentration", "density", "granular_temperature"}


def front_figure(found: Survey, given: Sequence[Reference]) -> Figure | None:
    """Return front against time by phase, and its speed; None if nothing came forward."""
    table = found.fronts
    present = [name for name in NAMES if not np.isnan(table[f"front_{name}"]).all()]
    if not present and all(one.abscissa != "time" for one in given):
        return None
    if len(present) == 2:
        present = ["all"]  # one phase is all
    figure, (place, speed) = panels(2, sharex=True)
    for name in present:
        style: Any = {"color": PHASE_COLORS[name], "label": PHASE_WORDS[name]}
        place.plot(table["time"], table[f"front_{name}"], **style)
        place.plot(table["time"], table[f"outer_front_{name}"], ":", color=style["color"])
        speed.plot(table["time"], table[f"speed_{name}"], **style)
    if present:
        place.plot([], [], "-", color="black", label="99.5 % of the volume")
        place.plot([], [], ":", color="black", label="99.9 %")
    arrivals = found.station_figures
    known = ~np.isnan(arrivals["arrival"])
    if known.any():
        when, x = arrivals["arrival"][known], arrivals["station"][known]
        place.plot(when, x, "o", ms=3, color="black", label="arrival at a station")
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
    axes: Axes,
    reference: Reference,
    name: str,
    label: str,
    color: str,
    line: str = "--",
    swapped: bool = False,
) -> None:
    """Draw a curve of a reference over its abscissa, and its band; swapped against it."""
    x, values = reference.table[reference.abscissa], reference.table[name]
    known, band = ~np.isnan(values), reference.band(name)
    curve = (values[known], x[known]) if swapped else (x[known], values[known])
    axes.plot(*curve, line, color=color, label=label)
    if band is not None:
        fill = axes.fill_betweenx if swapped else axes.fill_between
        fill(x, *band, color=color, alpha=0.15, linewidth=0.0)


def legend(*axes: Axes) -> None:
    """Put a legend beside each of some axes that have curves with names."""
    for one in axes:
        if one.get_legend_handles_labels()[1]:
            one.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
        else:
            one.text(0.5, 0.5, "nothing to show", transform=one.transAxes, ha="center", color=GRAY)


def profile_figure(found: Survey, given: Sequence[Reference]) -> Figure | None:
    """Return the quantities that are not 0 everywhere by height; None without particles.

    Velocity and shear rate, and of what holds grains concentration, density and granular
    temperature.
    """
    up, profiles = stations.UP[found.run.case.dimension], found.mean_profiles
    shown = [name for name in PROFILE_LABELS if np.nan_to_num(profiles[name]).any()]
    if not found.has_grains:
        shown = [name for name in shown if name not in OF_GRAINS]
    if not shown:
        return None
    figure, axes = panels(-(-(len(shown) + 1) // 3), 3, height=2.9, sharey=True)
    places = np.unique(profiles["station"])
    words = labelled([f"x = {x:g} m" for x in places])
    for name, one in zip(shown, axes, strict=False):
        for x, word, color in zip(places, words, sequence(len(places)), strict=True):
            part = rows_where(profiles, profiles["station"] == x)
            one.plot(part[name], part[up], ".-", ms=3, color=color, label=word)
        for reference in given:
            if reference.abscissa == up and name in reference.curves:
                values = reference.table[name], reference.table[up]
                one.plot(*values, "k--", label=reference.name)
        one.set_xlabel(PROFILE_LABELS[name])
    for one in axes[::3]:
        one.set_ylabel("height over the floor, m")
    for one in axes[len(shown) :]:
        one.axis("off")
    axes[len(shown)].legend(*axes[0].get_legend_handles_labels(), loc="upper left")
    return figure


def normalized_figure(
    found: Survey, given: Sequence[Reference], measured: Sequence[Distance]
) -> Figure | None:
    """Return u/u_s against y/h by station; None where nothing flows in the window.

    Of what holds grains the concentration too, with the dilatant profile and the distances.
    """
    profiles, places = found.mean_profiles, found.stations
    if not np.isfinite(profiles["u_over_us"]).any():
        return None
    names = [name for name in NORMALIZED_LABELS if found.has_grains or name not in OF_GRAINS]
    figure, axes = panels(1, len(names), height=3.6, sharey=True)
    velocity, last = axes[0], axes[-1]
    rms = {row.ours: row.rms for row in measured if row.reference == "dilatant"}
    words = labelled([_with_rms(f"x = {x:g} m", rms) for x in places])
    markers = "osv^D<>ph*" * len(places)
    for x, word, color, marker in zip(places, words, sequence(len(places)), markers, strict=False):
        part = rows_where(profiles, profiles["station"] == x)
        for one, name in zip(axes, names, strict=True):
            one.plot(part[name], part[NORMALIZED], marker, ms=3, color=color, label=word)
    if found.chosen and len(places) > 1:
        part, word = found.pooled_profile, _with_rms(POOLED, rms)
        values = part["u_over_us"], part[NORMALIZED]
        velocity.plot(*values, "s", ms=6, mfc="none", color="black")
        last.plot([], [], "s", ms=6, mfc="none", color="black", label=word)
    if found.has_grains:
        exact, word = dilatant_profile().table, "dilatant, 1 - (1 - y/h)^1.5"
        velocity.plot(exact["u_over_us"], exact[NORMALIZED], color=GRAY)
        last.plot([], [], color=GRAY, label=word)
    for reference in given:
        if reference.abscissa == NORMALIZED:
            _draw_normalized(found, reference, dict(zip(names, axes, strict=True)), last)
    for one, name in zip(axes, names, strict=True):
        one.set(xlabel=NORMALIZED_LABELS[name], xlim=(-0.02, 1.05), ylim=(0.0, 1.05))
    velocity.set_ylabel("y / h above the bed")
    legend(last)
    return figure


def _draw_normalized(
    found: Survey, reference: Reference, axes: Mapping[str, Axes], last: Axes
) -> None:
    """Draw curves over y/h where they belong, with their names in the legend of the last axes."""
    for name, line in zip(reference.curves, LINES[1:] * len(reference.curves), strict=False):
        values = reference.table[name], reference.table[NORMALIZED]
        style: Any = {"linestyle": line, "color": GREEN}
        own = axes.get("u_over_us" if is_velocity(found, name) else name)
        if own is not None:
            own.plot(*values, **style)
            last.plot([], [], label=f"{reference.name}: {name}", **style)


def _with_rms(label: str, rms: dict[str, float]) -> str:
    found = rms.get(label, np.nan)
    return f"{label}: rms {found:.3f}" if np.isfinite(found) else label


def hydrograph_figure(found: Survey) -> Figure | None:
    """Return discharge, that of the grains, and the volume that passed, by station and section.

    None where nothing passes.
    """
    per = "" if found.run.case.dimension == 3 else "\nper meter of width"
    curves = _hydrographs(found)
    panels_of = {
        "discharge": f"discharge, l/s{per}",
        "sediment_discharge": f"of which grains, l/s{per}",
        "volume": f"passed volume, l{per}",
    }
    shown = [
        name for name in panels_of if any(np.nan_to_num(part[name]).any() for _, part, *_ in curves)
    ]
    if not shown:
        return None
    figure, axes = panels(len(shown), sharex=True)
    for name, one in zip(shown, axes, strict=True):
        for label, part, color, line in curves:
            one.plot(part["time"], 1e3 * part[name], line, color=color, label=label)
        one.set_ylabel(panels_of[name])
    axes[-1].set_xlabel("time, s")
    legend(axes[0])
    return figure


def _hydrographs(found: Survey) -> list[tuple[str, Table, Any, str]]:
    """Return label, table, color and line of the stations and of the sections."""
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
    return curves


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
    if momentum["gravity_x"].any():
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
