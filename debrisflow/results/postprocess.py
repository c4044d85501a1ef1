"""Tables and plots of a run, written into its folder ``postprocess``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from debrisflow.results import answers as figures
from debrisflow.results import probe_curves, references, stations
from debrisflow.results.answers import Answer
from debrisflow.results.budgets import budget_head, momentum_head
from debrisflow.results.deposition import deposit_head, deposit_table
from debrisflow.results.fronts import HEAD as FRONT_HEAD
from debrisflow.results.plots import draw
from debrisflow.results.references import DILATANT, Distance, Reference, distances_to_all
from debrisflow.results.survey import Survey
from debrisflow.run.folder import POSTPROCESS
from debrisflow.run.tables import Row, Table, write_table

TOLD = (
    "moving_share_end",
    "front_farthest",
    "equivalent_friction",
    "deposit_volume",
    "eroded_volume",
)


def postprocess(found: Survey, given: Sequence[Reference] = ()) -> tuple[list[Path], list[str]]:
    """Write the tables and plots of a survey.

    Parameters
    ----------
    found : Survey
    given : sequence of Reference
        Curves to compare with, beside the dilatant profile.

    Returns
    -------
    list of Path
        The files.
    list of str
        What of the answers is told at once.

    Raises
    ------
    OutputError
        If the folder cannot be written, or a reference fits no table of the run.
    """
    target = found.run.folder / POSTPROCESS
    rows, measured = figures.answers(found), distances_to_all(found, given)
    files = _write_tables(found, measured, rows, target)
    return [*files, *draw(found, given, measured, target)], _told(rows, measured)


def _told(rows: Sequence[Answer], measured: Sequence[Distance]) -> list[str]:
    """Return arrivals, run-out and distances as lines."""
    lines = []
    for row in rows:
        if row.quantity.endswith("_arrival"):
            when = (
                "nothing has passed"
                if np.isnan(row.value)
                else f"first passed by t = {row.value:g} s"
            )
            lines.append(f"section {row.quantity.removesuffix('_arrival')}: {when}")
        elif row.quantity in TOLD and not np.isnan(row.value):
            lines.append(f"{row.quantity} = {row.value:.4g} {row.unit}: {row.meaning}")
    lines += [_told_distance(one) for one in measured if one.points or one.reference != DILATANT]
    return lines


def _told_distance(one: Distance) -> str:
    """Return the distance of a curve as a line."""
    curve = f"distance to {one.reference}, {one.curve}, {one.ours}: "
    if not one.points:
        return curve + "the run has no points within its range"
    shift = band = ""
    if one.shift == 0.0:
        shift = "; moving the run in time brings it no nearer"
    elif not np.isnan(one.shift):
        shift = f"; {one.shifted_rms:.3g} if the run is moved by {one.shift:+.3g} s"
    if not np.isnan(one.in_band):
        band = f"; {one.in_band:.0%} of the points within the band"
    share = "" if np.isnan(one.share) else f" ({one.share:.1%} of the reference's range)"
    return f"{curve}rms {one.rms:.3g}{share} at {one.points} points{shift}{band}"


def _write_tables(
    found: Survey, measured: list[Distance], rows: list[Answer], target: Path
) -> list[Path]:
    case, dimension = found.run.case, found.run.case.dimension
    words = {
        "up": stations.UP[dimension],
        "across": stations.ACROSS[dimension],
        "volume": stations.VOLUME[dimension],
        "width": " over its wetted width" if dimension == 3 else "",
    }
    start, end = found.window
    inside = stations.is_within(found.fronts["time"], found.window)
    window: dict[str, object] = {"frames": int(inside.sum()), "start": start, "end": end}
    written: list[tuple[str, Sequence[str], Table]] = [
        ("front", FRONT_HEAD, found.fronts),
        ("profiles", _filled(stations.PROFILES_HEAD, words), found.profiles),
        ("mean_profiles", _filled(stations.MEAN_HEAD, words | window), found.mean_profiles),
        ("hydrographs", _filled(stations.HYDROGRAPH_HEAD, words), found.hydrographs),
        ("deposit_profile", deposit_head(dimension), deposit_table(case, found.deposits)),
        ("budget", budget_head(dimension), found.budget),
        ("momentum", momentum_head(dimension), found.momentum),
    ]
    paths = []
    for name, head, table in written:
        paths.append(target / f"{name}.csv")
        values = ([float(v) for v in row] for row in zip(*table.values(), strict=True))
        write_table(paths[-1], list(table), head, values)
    tables: list[tuple[str, Sequence[str], Sequence[str], Sequence[Row]]] = [
        ("distances", references.COLUMNS, references.HEAD, measured),
        ("answers", figures.COLUMNS, figures.HEAD, rows),
    ]
    if found.probe_curves:
        span = {"span": probe_curves.told_span(found.smoothing)}
        head = _filled(probe_curves.HEAD, span | window)
        tables.append(("probes", probe_curves.COLUMNS, head, found.probe_figures))
    for name, columns, head, lines in tables:
        paths.append(target / f"{name}.csv")
        write_table(paths[-1], columns, head, lines)
    return paths


def _filled(head: Iterable[str], words: Mapping[str, object]) -> list[str]:
    return [line.format(**words) for line in head]
