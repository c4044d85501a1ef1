"""The table of answers: what a report on a run states, each with its unit and its meaning."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from debrisflow.case.probes import SectionProbe
from debrisflow.history import PER_WIDTH
from debrisflow.results.fronts import arrival
from debrisflow.results.survey import Survey
from debrisflow.series import Table


class Answer(NamedTuple):
    """One figure.

    Attributes
    ----------
    quantity : str
    value : float
        nan where the run has no answer.
    unit : str
    meaning : str
    """

    quantity: str
    value: float
    unit: str
    meaning: str


COLUMNS = Answer._fields
HEAD = ("figures of the run; nan where it gives no answer",)
REST_SHARE = 0.01


def answers(found: Survey) -> list[Answer]:
    """Return the figures of a run."""
    return [row for rows in answers_by_heading(found).values() for row in rows]


def answers_by_heading(found: Survey) -> dict[str, list[Answer]]:
    """Return the figures of a run by the headings under which they stand in a report."""
    return {
        "Run-out": _runout(found),
        "Arrival of the front": _arrivals(found),
        "Extent": _extent(found),
        "Deposit and erosion": _deposit(found),
        "Sections": _sections(found),
        "Stations": _stations(found),
        "Budgets": _budgets(found),
    }


def _runout(found: Survey) -> list[Answer]:
    flow, front = found.mobility, found.fronts
    speeds = front["speed_all"][~np.isnan(front["speed_all"])]
    return [
        Answer("front_farthest", flow.toe, "m", "greatest x of the front (99.5 % of what flows)"),
        Answer("front_farthest_time", flow.time, "s", "when it was there"),
        Answer(
            "front_speed_greatest",
            float(speeds.max(initial=0.0)) if speeds.size else np.nan,
            "m/s",
            "of the front, between frames",
        ),
        Answer("runout_length", flow.runout, "m", "from the source to the farthest front, along x"),
        Answer("fall_height", flow.fall, "m", "H, vertical, from the top of the source to there"),
        Answer("travel_distance", flow.travel, "m", "L, horizontal, from the source to there"),
        Answer("equivalent_friction", flow.equivalent_friction, "-", "H / L"),
    ]


def _arrivals(found: Survey) -> list[Answer]:
    history = found.run.history
    return [
        Answer(
            f"arrival_at_{x:g}_m",
            arrival(history["time"], history["front_all"], x),
            "s",
            f"when the front first reached x = {x:g} m",
        )
        for x in found.stations
    ]


def _extent(found: Survey) -> list[Answer]:
    maxima, grid = found.run.maxima, found.deposits[-1].grid
    reached = ~np.isnan(maxima["arrival_time"])
    area = "m2" if found.run.case.dimension == 3 else "m"
    return [
        Answer(
            "affected_area",
            float(grid.area[reached].sum()),
            area,
            "where it was ever more than half a spacing deeper than at first",
        ),
        Answer("depth_greatest", float(maxima["maximal_depth"].max()), "m", "flow height, ever"),
        Answer("speed_greatest", float(maxima["maximal_speed"].max()), "m/s", "depth mean, ever"),
        Answer(
            "momentum_flux_greatest",
            float(maxima["maximal_momentum_flux"].max()),
            "N/m",
            "integral of density times speed squared over the depth, ever",
        ),
    ]


def _deposit(found: Survey) -> list[Answer]:
    last, case = found.deposits[-1], found.run.case
    area, volume = ("m2", "m3") if case.dimension == 3 else ("m", "m2")
    height = last.table["deposit_height"]
    when = f"at t = {last.time:g} s"
    return [
        Answer("deposit_area", last.area, area, f"covered by what lies at rest {when}"),
        Answer(
            "deposit_volume", last.volume, volume, "of the particles of the deposit, with pores"
        ),
        Answer("deposit_height_greatest", float(height.max()), "m", f"over the fixed floor {when}"),
        Answer(
            "deposit_gradient",
            last.gradient(case.gravity.fall),
            "degree",
            "by which the surface of the deposit falls along x, of the nearest straight line",
        ),
        Answer("eroded_volume", last.erosion, volume, "between the initial bed and the deposit"),
        Answer("deposited_volume", last.deposition, volume, "between deposit and initial bed"),
    ]


def _sections(found: Survey) -> list[Answer]:
    rows, case = [], found.run.case
    for probe in case.probe:
        if isinstance(probe, SectionProbe):
            table = found.run.probe(probe.name)
            rows += _flow_figures(
                probe.name, table, f"section at x = {probe.x:g} m", case.dimension
            )
            passed = table["time"][table["volume"] > 0.0]
            first = float(passed[0]) if passed.size else np.nan
            meaning = "first sample with more gone through than back"
            rows.append(Answer(f"{probe.name}_arrival", first, "s", meaning))
    return rows


def _stations(found: Survey) -> list[Answer]:
    rows, table = [], found.hydrographs
    for x in found.stations:
        here = table["station"] == x
        part = {name: values[here] for name, values in table.items()}
        where = f"at x = {x:g} m, from the frames"
        rows += _flow_figures(f"at_{x:g}_m", part, where, found.run.case.dimension)
    return rows


def _flow_figures(name: str, table: Table, where: str, dimension: int) -> list[Answer]:
    volume = "m3" if dimension == 3 else "m2"
    grains, rate = table["sediment_volume"], table["discharge"]
    total = table["volume"]
    peak = int(np.argmax(rate)) if rate.size else -1
    return [
        Answer(f"{name}_discharge_peak", _at(rate, peak), f"{volume}/s", f"greatest, {where}"),
        Answer(f"{name}_discharge_peak_time", _at(table["time"], peak), "s", f"of it, {where}"),
        Answer(
            f"{name}_sediment_discharge_peak",
            float(table["sediment_discharge"].max()) if rate.size else np.nan,
            f"{volume}/s",
            f"of grains, {where}",
        ),
        Answer(f"{name}_volume", _at(total, -1), volume, f"passed in all, {where}"),
        Answer(f"{name}_sediment_volume", _at(grains, -1), volume, f"of grains, {where}"),
        Answer(f"{name}_water_volume", _at(total - grains, -1), volume, f"of water, {where}"),
    ]


def _at(values: np.ndarray, row: int) -> float:
    return float(values[row]) if values.size else np.nan


def _budgets(found: Survey) -> list[Answer]:
    table, case = found.budget, found.run.case
    if table["time"].size == 0:
        return []
    per = PER_WIDTH[case.dimension]
    kilogram, joule = f"kg{per}", f"J{per}"
    rows = []
    for matter in ("water", "sediment"):
        for way, meaning in (
            ("in", "came in"),
            ("out", "left"),
            ("inside", "inside at the end"),
            ("through_wall", "lost through walls"),
        ):
            value = _at(table[f"mass_{way}_{matter}"], -1)
            rows.append(Answer(f"mass_{way}_{matter}", value, kilogram, f"{matter}, {meaning}"))
        closure = float(np.abs(table[f"closure_{matter}"]).max())
        rows.append(
            Answer(f"mass_closure_{matter}", closure, kilogram, "greatest error of its balance")
        )
    kinetic = table["kinetic_energy"]
    rows.append(Answer("kinetic_energy_greatest", float(kinetic.max()), joule, "of all matter"))
    rows.append(Answer("kinetic_energy_end", _at(kinetic, -1), joule, "of all matter, at the end"))
    return rows
