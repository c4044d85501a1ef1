"""The figures of the stations: when the flow came, how deep it was and what passed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from debrisflow.particles.state import PHASES
from debrisflow.results.fronts import PHASE_WORDS, arrival
from debrisflow.run.tables import Table, rows_where

COLUMNS = (
    "station",
    "arrival",
    *(f"{PHASE_WORDS[phase]}_arrival" for phase in PHASES),
    "greatest_depth",
    "discharge_peak",
    "peak_time",
    "volume",
    "sediment_discharge_peak",
    "sediment_volume",
)
HEAD = (
    "a row for each station; nan where it has no answer",
    "station: m, x along the bed",
    "arrival: s, when the front of all that flows first came there, from history.csv; nan if it",
    "  did not, or started beyond; *_arrival: that of a phase, where there are several",
    "greatest_depth: m, in the frames, as depth in hydrographs.csv",
    "discharge_peak: {volume}/s, greatest in hydrographs.csv, and peak_time: s, when; volume:",
    "  {volume}, net of what passed until the last frame; sediment_*: of the grains in it",
)
KEPT = ("station", "arrival")  # shown even if there is no answer
HEADINGS = {
    "station": "x, m",
    "arrival": "arrival, s",
    **{f"{PHASE_WORDS[phase]}_arrival": f"of {PHASE_WORDS[phase]}, s" for phase in PHASES},
    "greatest_depth": "greatest depth, m",
    "discharge_peak": "peak, {volume}/s",
    "peak_time": "at, s",
    "volume": "passed, {volume}",
    "sediment_discharge_peak": "peak of grains, {volume}/s",
    "sediment_volume": "grains passed, {volume}",
}


def station_figures(
    stations: Sequence[float], phases: Sequence[str], history: Table, hydrographs: Table
) -> Table:
    """Return the columns ``COLUMNS``, a row a station.

    Parameters
    ----------
    stations : sequence of float, m
    phases : sequence of str
        Present in the run; one alone has no arrival of its own.
    history, hydrographs : Table
        As ``history.csv`` and ``hydrographs.csv`` name them.
    """
    several = phases if len(phases) > 1 else ()
    table = {name: np.full(len(stations), np.nan) for name in COLUMNS}
    for row, x in enumerate(stations):
        table["station"][row] = x
        table["arrival"][row] = arrival(history["time"], history["front_all"], x)
        for phase in several:
            front = history[f"front_{phase}"]
            table[f"{PHASE_WORDS[phase]}_arrival"][row] = arrival(history["time"], front, x)
        part = rows_where(hydrographs, hydrographs["station"] == x)
        table["greatest_depth"][row] = part["depth"].max()
        for name in ("", "sediment_"):
            table[f"{name}discharge_peak"][row] = part[f"{name}discharge"].max()
            table[f"{name}volume"][row] = part[f"{name}volume"][-1]
        if table["discharge_peak"][row] > 0.0:
            table["peak_time"][row] = part["time"][np.argmax(part["discharge"])]
    return table


def unit_of(column: str, volume: str) -> str:
    """Return the unit of a column; volumes are in m2 or m3."""
    return heading(column, volume).rpartition(", ")[2]


def heading(column: str, volume: str) -> str:
    """Return short words for a column, with its unit."""
    return HEADINGS[column].format(volume=volume)


def shown_columns(table: Table) -> list[str]:
    """Return the columns that say something: not those that are nan or 0 at all stations."""
    return [name for name, values in table.items() if np.nan_to_num(values).any() or name in KEPT]


def cells(table: Table, volume: str) -> list[list[str]]:
    """Return headings and rows of the columns that say something, as text."""
    names = shown_columns(table)
    rows = ([figure(table[name][k]) for name in names] for k in range(table["station"].size))
    return [[heading(name, volume) for name in names], *rows]


def table_lines(table: Table, volume: str) -> list[str]:
    """Return them as lines with columns."""
    rows = cells(table, volume)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    ]


def figure(value: float) -> str:
    """Return a figure as text: none where there is no answer."""
    return "none" if np.isnan(value) else f"{value:.4g}"
