"""Tables and plots of a run, written into its folder ``postprocess``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from debrisflow.results import (
    probe_curves,
    references,
    shared_answers,
    station_figures,
    stations,
    terrain_survey,
)
from debrisflow.results.answers import answers
from debrisflow.results.budgets import budget_head, momentum_head
from debrisflow.results.deposition import deposit_head, deposit_table
from debrisflow.results.fronts import HEAD as FRONT_HEAD
from debrisflow.results.plots import draw
from debrisflow.results.references import (
    DILATANT,
    Distance,
    Reference,
    distances_to_all,
    format_distance,
)
from debrisflow.results.shared_answers import Answer
from debrisflow.results.survey import AnySurvey, Survey
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.run.atomic import made
from debrisflow.run.names import POSTPROCESS
from debrisflow.run.tables import Row, Table, write_table

TOLD = {
    "moving_share_end",
    "front_farthest",
    "reach",
    "affected_area",
    "runout_length",
    "equivalent_friction",
    "water_front_farthest",
    "water_runout_length",
    "deposit_volume",
    "eroded_volume",
    "volume_released",
    "volume_left",
}
_Table = tuple[str, Sequence[str], Table]
NO_RUNOUT = "no run-out: there was fluid over the whole length from the start"


def postprocess(found: AnySurvey, given: Sequence[Reference] = ()) -> tuple[list[Path], list[str]]:
    """Write the tables and plots of a survey.

    Parameters
    ----------
    found : Survey or TerrainSurvey
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
    target = made(found.run.folder / POSTPROCESS)
    rows, measured = answers(found), distances_to_all(found, given)
    files = _write_tables(found, measured, rows, target)
    return [*files, *draw(found, given, measured, target)], _summary_lines(found, rows, measured)


def _summary_lines(
    found: AnySurvey, rows: Sequence[Answer], measured: Sequence[Distance]
) -> list[str]:
    """Return run-out, arrivals, stations and distances as lines."""
    lines = [] if found.mobility is not None else [NO_RUNOUT]
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
    if isinstance(found, Survey):
        volume = stations.VOLUME[found.run.case.dimension]
        lines += station_figures.table_lines(found.station_figures, volume)
    lines += [format_distance(one) for one in measured if one.points or one.reference != DILATANT]
    return lines


def _write_tables(
    found: AnySurvey, measured: list[Distance], rows: list[Answer], target: Path
) -> list[Path]:
    start, end = found.window
    inside = stations.is_within(found.fronts["time"], found.window)
    window: dict[str, object] = {"frames": int(inside.sum()), "start": start, "end": end}
    written = (
        _tables_of_terrain(found)
        if isinstance(found, TerrainSurvey)
        else _tables_along(found, window)
    )
    paths = []
    for name, head, table in written:
        paths.append(target / f"{name}.csv")
        values = ([float(v) for v in row] for row in zip(*table.values(), strict=True))
        write_table(paths[-1], list(table), head, values)
    tables: list[tuple[str, Sequence[str], Sequence[str], Sequence[Row]]] = [
        ("distances", references.COLUMNS, references.HEAD, measured),
        ("answers", shared_answers.COLUMNS, shared_answers.HEAD, rows),
    ]
    if found.probe_curves:
        span = {"span": probe_curves.format_span(found.smoothing)}
        head = _filled(probe_curves.HEAD, span | window)
        tables.append(("probes", probe_curves.COLUMNS, head, found.probe_figures))
    for name, columns, head, lines in tables:
        paths.append(target / f"{name}.csv")
        write_table(paths[-1], columns, head, lines)
    return paths


def _tables_along(found: Survey, window: dict[str, object]) -> list[_Table]:
    """Return the tables of a run in a tank or a channel, with names and heads."""
    case, dimension = found.run.case, found.run.case.dimension
    words: dict[str, object] = {
        "up": stations.UP[dimension],
        "across": stations.ACROSS[dimension],
        "volume": stations.VOLUME[dimension],
        "width": " over its wetted width" if dimension == 3 else "",
    }
    return [
        ("front", FRONT_HEAD, found.fronts),
        ("profiles", _filled(stations.PROFILES_HEAD, words), found.profiles),
        ("mean_profiles", _filled(stations.MEAN_HEAD, words | window), found.mean_profiles),
        ("hydrographs", _filled(stations.HYDROGRAPH_HEAD, words), found.hydrographs),
        ("stations", _filled(station_figures.HEAD, words), found.station_figures),
        ("deposit_profile", deposit_head(dimension), deposit_table(case, found.deposits)),
        ("budget", budget_head(dimension), found.budget),
        ("momentum", momentum_head(dimension), found.momentum),
    ]


def _tables_of_terrain(found: TerrainSurvey) -> list[_Table]:
    """Return the tables of a run on a terrain, with names and heads."""
    return [
        ("front", terrain_survey.FRONT_HEAD, found.fronts),
        ("path", terrain_survey.PATH_HEAD, found.profile),
        ("budget", budget_head(found.run.case.dimension), found.budget),
    ]


def _filled(head: Iterable[str], words: Mapping[str, object]) -> list[str]:
    return [line.format(**words) for line in head]
