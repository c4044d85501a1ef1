"""The same curves and figures of several runs, and the parameters in which they differ."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from debrisflow.errors import OutputError
from debrisflow.results import references
from debrisflow.results.answers import answers, answers_by_heading
from debrisflow.results.parameters import differences
from debrisflow.results.plots.comparison import draw_comparison
from debrisflow.results.plots.terrain import draw_terrain_comparison
from debrisflow.results.references import RUN, Distance, Reference, distances, format_distance
from debrisflow.results.station_figures import COLUMNS, unit_of
from debrisflow.results.stations import VOLUME
from debrisflow.results.survey import AnySurvey, Survey
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.run.atomic import made
from debrisflow.run.tables import Row, write_table

ABSENT = "-"
STATIONS, PROBES, MOST_PRINTED = "Stations", "Probes", 30
VALUES = ("arrival", "peak", "peak_time", "smooth_peak", "impulse", "mean", "deviation")
UNITS = {"arrival": "s", "peak_time": "s", "impulse": "{} s"}


class Comparison(NamedTuple):
    """Several runs beside each other.

    Attributes
    ----------
    names : list of str
        Of the runs, each once.
    differing : list of tuple of str
        Key and value in each run, of the parameters that differ.
    figures : list of tuple
        Heading, quantity, unit, value in each run, of the answers and of the probes that all runs
        have.
    distances : list of (str, Distance)
        Run, and how far it is from a curve of a reference.
    time : float, s
        The last that all runs have reached.
    """

    names: list[str]
    differing: list[tuple[str, ...]]
    figures: list[tuple[str, str, str, list[float]]]
    distances: list[tuple[str, Distance]]
    time: float


def compare(
    found: Sequence[AnySurvey], target: Path, given: Sequence[Reference] = ()
) -> tuple[Comparison, list[Path]]:
    """Compare runs and write tables and plots into a folder.

    Parameters
    ----------
    found : sequence of Survey or TerrainSurvey
        Of two or more runs of the same dimension, all or none of them on a terrain.
    target : Path
    given : sequence of Reference
        Curves to compare all runs with.

    Returns
    -------
    Comparison
    list of Path
        The files.

    Raises
    ------
    OutputError
        If runs of two and of three dimensions meet, or one on a terrain and another, a reference
        fits no table of one of the runs, or the folder cannot be written.
    """
    if len({one.run.case.dimension for one in found}) > 1:
        raise OutputError("runs of two and of three dimensions cannot be compared")
    if len({one.run.case.is_terrain for one in found}) > 1:
        raise OutputError("a run on a terrain cannot be compared with one in a tank or a channel")
    names, found = _names(found), _evenly_smoothed(found)
    rows = differences([one.run.case for one in found])
    differing = [
        (next(part.key for part in row if part), *(part.told if part else ABSENT for part in row))
        for row in rows
        if next(part.key for part in row if part) != "notes"
    ]
    measured = [
        (name, row)
        for reference in given
        for name, one in zip(names, found, strict=True)
        for row in distances(one, reference)
    ]
    time = min(_last(one) for one in found)
    together = Comparison(names, differing, _figures(found), measured, time)
    made(target, is_deep=True)
    files = [target / "parameters.csv", target / "answers.csv"]
    write_table(files[0], ("parameter", *names), ("where the cases differ",), differing)
    write_table(
        files[1],
        ("quantity", "unit", *names),
        ("figures of the runs, each at its own end; nan where a run has none",),
        ([quantity, unit, *values] for _, quantity, unit, values in together.figures),
    )
    if given:
        files.append(target / "distances.csv")
        lines: Iterable[Row] = ((name, *row) for name, row in measured)
        write_table(files[-1], ("run", *references.COLUMNS), references.HEAD, lines)
    titles = [
        f"{key}: " + ", ".join(f"{name} {value}" for name, value in zip(names, values, strict=True))
        for key, *values in differing
    ]
    return together, [*files, *_draw(found, names, given, titles, time, target)]


def _draw(
    found: Sequence[AnySurvey],
    names: Sequence[str],
    given: Sequence[Reference],
    titles: Sequence[str],
    time: float,
    target: Path,
) -> list[Path]:
    """Draw the plots of runs that are all of one kind."""
    on_terrain = [one for one in found if isinstance(one, TerrainSurvey)]
    if on_terrain:
        return draw_terrain_comparison(on_terrain, names, given, titles, target)
    others = [one for one in found if isinstance(one, Survey)]
    return draw_comparison(others, names, given, titles, time, target)


def _last(found: AnySurvey) -> float:
    return float(found.run.times[-1])


def _names(found: Sequence[AnySurvey]) -> list[str]:
    """Return the names of the folders, with the folder above where they are equal."""
    names = [one.run.name for one in found]
    if len(set(names)) == len(names):
        return names
    paths = [one.run.folder.resolve() for one in found]
    names = [f"{path.parent.name}/{path.name}" for path in paths]
    if len(set(names)) == len(names):
        return names
    return [f"{number} {name}" for number, name in enumerate(names, start=1)]


def _figures(found: Sequence[AnySurvey]) -> list[tuple[str, str, str, list[float]]]:
    known = [{row.quantity: row.value for row in answers(one)} for one in found]
    return [
        (heading, row.quantity, row.unit, [values[row.quantity] for values in known])
        for heading, rows in answers_by_heading(found[0]).items()
        for row in rows
        if all(row.quantity in values for values in known)
    ] + [*_stations(found), *_probes(found)]


def _stations(found: Sequence[AnySurvey]) -> list[tuple[str, str, str, list[float]]]:
    """Return the figures of the stations that all runs have."""
    volume = VOLUME[found[0].run.case.dimension]
    rows = []
    known = [one for one in found if isinstance(one, Survey)]
    for x in known[0].stations if known else ():
        if not all(x in one.stations for one in known):
            continue
        for name in COLUMNS[1:]:
            tables = (one.station_figures for one in known)
            values = [float(table[name][table["station"] == x][0]) for table in tables]
            if np.nan_to_num(values).any():
                rows.append((STATIONS, f"at_{x:g}_m_{name}", unit_of(name, volume), values))
    return rows


def _probes(found: Sequence[AnySurvey]) -> list[tuple[str, str, str, list[float]]]:
    """Return the figures of the curves of probes that all runs have."""
    known = [{(row.probe, row.column): row for row in one.probe_figures} for one in found]
    rows = []
    for key, first in known[0].items():
        if not all(key in one for one in known):
            continue
        for name in VALUES:
            values = [float(getattr(one[key], name)) for one in known]
            if not np.isnan(values).all():
                unit = UNITS.get(name, "{}").format(first.unit)
                rows.append((PROBES, f"{'_'.join(key)}_{name}", unit, values))
    return rows


def _evenly_smoothed(found: Sequence[AnySurvey]) -> list[AnySurvey]:
    """Return surveys whose running means go over the same time: the longest of all, if none."""
    spans = [curve.span for one in found for curve in one.probe_curves]
    if not spans or found[0].smoothing is not None:
        return list(found)
    return [replace(one, smoothing=max(spans)) for one in found]


def table_lines(together: Comparison) -> list[str]:
    """Return parameters and figures as lines with columns, and distances to references.

    Of stations the arrivals only, and no long list of probes.
    """
    lines = [(name, *values) for name, *values in together.differing]
    many = sum(heading == PROBES for heading, *_ in together.figures) > MOST_PRINTED
    figures = [
        (f"{name}, {unit}" if unit != ABSENT else name, *map(_format_value, values))
        for heading, name, unit, values in together.figures
        if not (many and heading == PROBES)
        and not (heading == STATIONS and not name.endswith("_arrival"))
        and not np.isnan(values).all()
    ]
    rows = [("", *together.names), *lines, *figures]
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    table = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    return table + [
        format_distance(row._replace(ours=name if row.ours == RUN else f"{name}, {row.ours}"))
        for name, row in together.distances
    ]


def _format_value(value: float) -> str:
    return "nan" if np.isnan(value) else f"{value:.4g}"
