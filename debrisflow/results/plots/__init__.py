"""The plots of a run, one file each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from debrisflow.results.plots.curves import (
    budget_figure,
    front_figure,
    hydrograph_figure,
    normalized_figure,
    profile_figure,
)
from debrisflow.results.plots.fields import grid_figure, line_figure
from debrisflow.results.plots.maps import deposit_figure, flow_figure, maxima_figure
from debrisflow.results.plots.probes import curves_to_draw, probe_figure
from debrisflow.results.plots.style import caption, save, styled
from debrisflow.results.plots.terrain import terrain_figures
from debrisflow.results.probe_curves import format_span
from debrisflow.results.references import Distance, Reference
from debrisflow.results.survey import AnySurvey, Survey
from debrisflow.results.terrain_survey import TerrainSurvey

DESCRIPTIONS = {
    "front": "How far the flow has reached, by phase, and the speed of its front.",
    "profiles": "Means over the height at the stations.",
    "normalized_profiles": (
        "Velocity over that at the surface, and where there are grains their concentration and the "
        "profile of grains that collide, above the bed."
    ),
    "hydrographs": "What went through the stations and sections.",
    "probes": "Samples of the probes, their running means, and the extremes of single steps.",
    "lines": "Speed and pressure along the lines of probes, over the time; gray where it is dry.",
    "grids": "Speed and pressure on the grids of probes, at the last time; gray where it is dry.",
    "deposit": "Height of what lies at rest, and of the flow.",
    "flow": "Height of the flow at the start, at chosen times and at the end.",
    "maxima": "Greatest depth and speed, and when the flow arrived.",
    "budget": "Mass by matter and the error of its balance, energies, and forces along x.",
}
ON_TERRAIN = {
    "front": "How far the flow has reached, its speed and the area that it has covered.",
    "path": "Terrain, greatest values, arrival and width along the flow path.",
    "ledger": "Where what was released is, in time.",
    "hydrographs": "What went through the sections.",
    "budget": "Mass by matter and the error of its balance, and energies.",
}


def draw(
    found: AnySurvey, given: Sequence[Reference], measured: Sequence[Distance], target: Path
) -> list[Path]:
    """Draw the plots of a run in which there is something to see, and return their files.

    Those of an earlier time in which there no longer is are removed.
    """
    with styled():
        figures = _figures(found, given, measured)
        source = [caption(found.run)]
        files = [
            save(figure, target / f"{name}.png", title, source)
            for name, (title, figure) in figures.items()
            if figure is not None
        ]
    for name in DESCRIPTIONS | ON_TERRAIN:
        file = target / f"{name}.png"
        if file not in files:
            file.unlink(missing_ok=True)
    return files


def _figures(
    found: AnySurvey, given: Sequence[Reference], measured: Sequence[Distance]
) -> dict[str, tuple[str, Figure | None]]:
    """Return title and figure by name; None where there is nothing to show."""
    if isinstance(found, TerrainSurvey):
        figures = terrain_figures(found, given)
    else:
        figures = _figures_along(found, given, measured)
    if curves := curves_to_draw(found, given):
        span = format_span(found.smoothing)
        title = f"Probes: samples, and means over {span}"
        figures["probes"] = (title, probe_figure(curves, given))
    figures["lines"] = ("Probes along lines, over the time", line_figure(found.run))
    figures["grids"] = ("Probes on grids, at the last time", grid_figure(found.run))
    return figures


def _figures_along(
    found: Survey, given: Sequence[Reference], measured: Sequence[Distance]
) -> dict[str, tuple[str, Figure | None]]:
    """Return those of a run in a tank or a channel."""
    start, end = found.window
    mean = f"mean over {start:g} to {end:g} s"
    above = "Velocity and concentration" if found.has_grains else "Velocity"
    figures = {
        "front": ("Front of what flows", front_figure(found, given)),
        "profiles": (f"Profiles over the height, {mean}", profile_figure(found, given)),
        "normalized_profiles": (
            f"{above} above the bed, {mean}",
            normalized_figure(found, given, measured),
        ),
        "hydrographs": ("Discharge and passed volume", hydrograph_figure(found)),
    }
    if found.has_grains:
        figures["deposit"] = ("Deposit", deposit_figure(found, given))
    else:
        figures["flow"] = ("Height of the flow", flow_figure(found, given))
    figures["maxima"] = ("Greatest values since the start", maxima_figure(found))
    figures["budget"] = ("Budgets of mass, energy and momentum", budget_figure(found))
    return figures
