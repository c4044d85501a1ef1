"""The plots of a run, one file each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from debrisflow.results.plots.curves import (
    budget_figure,
    front_figure,
    hydrograph_figure,
    normalized_figure,
    profile_figure,
)
from debrisflow.results.plots.fields import grid_figure, line_figure
from debrisflow.results.plots.maps import deposit_figure, maxima_figure
from debrisflow.results.plots.probes import curves_to_draw, probe_figure
from debrisflow.results.plots.style import caption, save, styled
from debrisflow.results.probe_curves import told_span
from debrisflow.results.references import Distance, Reference
from debrisflow.results.survey import Survey

DESCRIPTIONS = {
    "front": "How far the flow has reached, by phase, and the speed of its front.",
    "profiles": "Means over the height at the stations.",
    "normalized_profiles": (
        "Velocity over that at the surface, with the profile of grains that collide, and "
        "concentration, above the bed."
    ),
    "hydrographs": "What went through the stations and sections.",
    "probes": "Samples of the probes, their running means, and the extremes of single steps.",
    "lines": "Speed and pressure along the lines of probes, over the time; gray where it is dry.",
    "grids": "Speed and pressure on the grids of probes, at the last time; gray where it is dry.",
    "deposit": "Height of what lies at rest, and of the flow.",
    "maxima": "Greatest depth and speed, and when the flow arrived.",
    "budget": "Mass by matter and the error of its balance, energies, and forces along x.",
}


def draw(
    found: Survey, given: Sequence[Reference], measured: Sequence[Distance], target: Path
) -> list[Path]:
    """Draw all plots of a run into a folder and return their files."""
    start, end = found.window
    mean = f"mean over {start:g} to {end:g} s"
    source = [caption(found.run)]
    with styled():
        figures = {
            "front": ("Front of what flows", front_figure(found, given)),
            "profiles": (f"Profiles over the height, {mean}", profile_figure(found, given)),
            "normalized_profiles": (
                f"Velocity and concentration above the bed, {mean}",
                normalized_figure(found, given, measured),
            ),
            "hydrographs": ("Discharge and passed volume", hydrograph_figure(found)),
            "deposit": ("Deposit", deposit_figure(found, given)),
            "maxima": ("Greatest values since the start", maxima_figure(found)),
            "budget": ("Budgets of mass, energy and momentum", budget_figure(found)),
        }
        if curves := curves_to_draw(found, given):
            span = told_span(found.smoothing)
            figures["probes"] = (
                f"Probes: samples, and means over {span}",
                probe_figure(curves, given),
            )
        if (lines := line_figure(found.run)) is not None:
            figures["lines"] = ("Probes along lines, over the time", lines)
        if (grids := grid_figure(found.run)) is not None:
            figures["grids"] = ("Probes on grids, at the last time", grids)
        return [
            save(figure, target / f"{name}.png", title, source)
            for name, (title, figure) in figures.items()
        ]
