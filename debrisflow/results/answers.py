"""The table of answers: what a report on a run states, each with its unit and its meaning."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.state import PHASES
from debrisflow.results.fronts import arrival
from debrisflow.results.stations import VOLUME, flow_probes
from debrisflow.results.survey import Survey
from debrisflow.run.history import PER_WIDTH
from debrisflow.run.tables import Table, rows_where

Floats = NDArray[np.float64]


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
EXTENT = {2: ("length", "m"), 3: ("area", "m2")}


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
    bound = f"; {flow.bound}" if flow.bound else ""
    farthest = f"greatest x of the front (99.5 % of what flows){bound}"
    return [
        Answer("last_frame_time", _at(front["time"], -1), "s", "up to which the run was measured"),
        Answer("moving_share_end", _at(front["moving_share"], -1), "-", "of the volume, then"),
        Answer(
            "rest_time", found.rest_time, "s", "from which on less than 1 % of the volume moves"
        ),
        Answer("front_farthest", flow.toe, "m", farthest),
        Answer("front_farthest_time", flow.time, "s", "when it was there"),
        Answer("front_speed_greatest", _greatest(speeds), "m/s", "of the front, between frames"),
        Answer("runout_length", flow.runout, "m", f"from the source to there, along x{bound}"),
        Answer("fall_height", flow.fall, "m", "H, vertical, from the top of the source to there"),
        Answer(
            "travel_distance", flow.travel, "m", f"L, horizontal, from the source to there{bound}"
        ),
        Answer("equivalent_friction", flow.equivalent_friction, "-", f"H / L{bound}"),
    ]


def _arrivals(found: Survey) -> list[Answer]:
    history = found.run.history
    present = [name for name in PHASES if not np.isnan(history[f"front_{name}"]).all()]
    rows = []
    for x in found.stations:
        for phase in ("all", *(present if len(present) > 1 else ())):
            name = f"arrival_at_{x:g}_m" if phase == "all" else f"{phase}_arrival_at_{x:g}_m"
            when = arrival(history["time"], history[f"front_{phase}"], x)
            meaning = f"when the front ({phase}) first came to x = {x:g} m"
            rows.append(Answer(name, when, "s", meaning))
    return rows


def _extent(found: Survey) -> list[Answer]:
    maxima, grid = found.run.maxima, found.deposits[-1].grid
    reached = ~np.isnan(maxima["arrival_time"])
    noun, unit = EXTENT[found.run.case.dimension]
    return [
        Answer(
            f"affected_{noun}",
            float(grid.area[reached].sum()),
            unit,
            "where it was ever more than half a spacing deeper than at first",
        ),
        Answer("depth_greatest", _greatest(maxima["maximal_depth"]), "m", "flow height, ever"),
        Answer("speed_greatest", _greatest(maxima["maximal_speed"]), "m/s", "depth mean, ever"),
        Answer(
            "momentum_flux_greatest",
            _greatest(maxima["maximal_momentum_flux"]),
            "N/m",
            "integral of density times speed squared over the depth, ever",
        ),
    ]


def _deposit(found: Survey) -> list[Answer]:
    last, case = found.deposits[-1], found.run.case
    noun, unit = EXTENT[case.dimension]
    volume = VOLUME[case.dimension]
    when = f"at t = {last.time:g} s"
    bed = f"with the pores of a packed bed, {when}"
    return [
        Answer(f"deposit_{noun}", last.area, unit, f"covered by what lies at rest {when}"),
        Answer("deposit_volume", last.volume, volume, f"of its particles, with pores, {when}"),
        Answer("deposit_sediment_volume", last.sediment_volume, volume, f"of grains, {when}"),
        Answer(
            "deposit_height_greatest",
            _greatest(last.table["deposit_height"]),
            "m",
            f"over the fixed floor {when}",
        ),
        Answer(
            "deposit_gradient",
            last.gradient(case.gravity.fall),
            "degree",
            f"by which its surface falls along x, of the nearest straight line, {when}",
        ),
        Answer("eroded_volume", last.erosion, volume, f"lost where the bed lost, {bed}"),
        Answer("deposited_volume", last.deposition, volume, f"gained where it gained, {bed}"),
    ]


def _sections(found: Survey) -> list[Answer]:
    rows, case = [], found.run.case
    for probe in flow_probes(case):
        table = found.run.probe(probe.name)
        where = f"{probe.type} at {probe.where()} m"
        rows += _flow_figures(probe.name, table, where, case.dimension)
        passed = table["time"][table["volume"] > 0.0]
        first = float(passed[0]) if passed.size else np.nan
        meaning = "first sample with more gone through than back"
        rows.append(Answer(f"{probe.name}_arrival", first, "s", meaning))
    return rows


def _stations(found: Survey) -> list[Answer]:
    rows, table = [], found.hydrographs
    for x in found.stations:
        part = rows_where(table, table["station"] == x)
        where = f"at x = {x:g} m, from the frames"
        rows += _flow_figures(f"at_{x:g}_m", part, where, found.run.case.dimension)
    return rows


def _flow_figures(name: str, table: Table, where: str, dimension: int) -> list[Answer]:
    volume = VOLUME[dimension]
    rate = {"": table["discharge"], "sediment_": table["sediment_discharge"]}
    total = {"": table["volume"], "sediment_": table["sediment_volume"]}
    rate["water_"], total["water_"] = (part[""] - part["sediment_"] for part in (rate, total))
    peak = int(np.argmax(rate[""])) if rate[""].size else -1
    rows = [Answer(f"{name}_peak_time", _at(table["time"], peak), "s", f"of all, {where}")]
    for matter, meaning in (("", "in all"), ("sediment_", "of grains"), ("water_", "of water")):
        told = f"{meaning}, {where}"
        greatest = _greatest(rate[matter])
        rows += [
            Answer(f"{name}_{matter}discharge_peak", greatest, f"{volume}/s", f"greatest {told}"),
            Answer(f"{name}_{matter}volume", _at(total[matter], -1), volume, f"passed {told}"),
        ]
    return rows


def _at(values: Floats, row: int) -> float:
    return float(values[row]) if values.size else np.nan


def _greatest(values: Floats) -> float:
    return float(np.max(values)) if values.size else np.nan


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
    bounced = found.run.summary.get("bounced_share")
    if bounced is not None:
        rows.append(Answer("bounced_share", bounced, "-", "of the particles, off walls in a step"))
    return rows
