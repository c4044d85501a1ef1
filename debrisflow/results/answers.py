"""The table of answers: what a report on a run states, each with its unit and its meaning."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.probes.dam import DamProbe
from debrisflow.particles.maxima import has_risen
from debrisflow.results.fronts import PHASE_WORDS
from debrisflow.results.stations import VOLUME, flow_probes
from debrisflow.results.survey import Survey
from debrisflow.run.history import PER_WIDTH
from debrisflow.run.tables import Table

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
SECTION_ARRIVAL = (
    "first sample with more gone through than back, and, where fluid was, half a spacing deeper"
)
EXTENT = {2: ("length", "m"), 3: ("area", "m2")}


def answers(found: Survey) -> list[Answer]:
    """Return the figures of a run."""
    return [row for rows in answers_by_heading(found).values() for row in rows]


def answers_by_heading(found: Survey) -> dict[str, list[Answer]]:
    """Return the figures of a run by the headings under which they stand in a report."""
    return {
        "Run-out" if found.mobilities else "Motion": [*_motion(found), *_runout(found)],
        "Extent": _extent(found),
        "Deposit and erosion": _deposit(found) if found.has_grains else [],
        "Sections": _sections(found),
        "Dams": _dams(found),
        "Budgets": _budgets(found),
    }


def _motion(found: Survey) -> list[Answer]:
    front = found.fronts
    rows = [
        Answer("last_frame_time", _at(front["time"], -1), "s", "up to which the run was measured"),
        Answer("moving_share_end", _at(front["moving_share"], -1), "-", "of the volume, then"),
        Answer(
            "rest_time", found.rest_time, "s", "from which on less than 1 % of the volume moves"
        ),
    ]
    if not found.mobilities:
        rows.append(_front_speed(found, "all", "front_speed_greatest"))
    return rows


def _front_speed(found: Survey, phase: str, name: str) -> Answer:
    speeds = found.fronts[f"speed_{phase}"]
    whose = "" if phase == "all" else f" of the {PHASE_WORDS[phase]}"
    greatest = _greatest(speeds[~np.isnan(speeds)])
    return Answer(name, greatest, "m/s", f"of the front{whose}, between frames")


def _runout(found: Survey) -> list[Answer]:
    """Return how far what flows came: the headline, and the water where that is beside it."""
    rows = []
    for phase, flow in found.mobilities.items():
        name = "" if phase == found.headline else f"{PHASE_WORDS[phase]}_"
        whose = "" if phase == "all" else f" of the {PHASE_WORDS[phase]}"
        bound = f"; {flow.bound}" if flow.bound else ""
        farthest = f"greatest x of the front{whose} (99.5 % of what flows){bound}"
        rows += [
            Answer(f"{name}front_farthest", flow.toe, "m", farthest),
            Answer(f"{name}front_farthest_time", flow.time, "s", "when it was there"),
            _front_speed(found, phase, f"{name}front_speed_greatest"),
            Answer(
                f"{name}runout_length",
                flow.runout,
                "m",
                f"from the source to the farthest front{whose}, along x{bound}",
            ),
            Answer(
                f"{name}fall_height",
                flow.fall,
                "m",
                "H, vertical, from the top of the source to there",
            ),
            Answer(
                f"{name}travel_distance",
                flow.travel,
                "m",
                f"L, horizontal, from the source to there{bound}",
            ),
            Answer(f"{name}equivalent_friction", flow.equivalent_friction, "-", f"H / L{bound}"),
        ]
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
        rows += _flow_figures(probe.name, table, where, found)
        first = _section_arrival(table, case.particles.spacing)
        rows.append(Answer(f"{probe.name}_arrival", first, "s", SECTION_ARRIVAL))
    return rows


def _dams(found: Survey) -> list[Answer]:
    rows = []
    for probe in found.run.case.probe:
        if not isinstance(probe, DamProbe):
            continue
        table, name, dam = found.run.probe(probe.name), probe.name, f"the dam '{probe.wall}'"
        held = _at(table["trapped_volume"], -1)
        over = _at(table["overtopped_volume"], -1)
        first = _at(table["overtopping_time"], -1)
        rows += [
            Answer(f"{name}_overtopping_time", first, "s", f"when the first came over {dam}"),
            Answer(f"{name}_trapped_volume", held, "m3", f"held back by {dam} at the end"),
            Answer(f"{name}_overtopped_volume", over, "m3", f"came over {dam}"),
        ]
    return rows


def _section_arrival(table: Table, spacing: float) -> float:
    """Return the first sample at which a flow has come to a section, s; nan if none has."""
    arrived = table["volume"] > 0.0
    if table["depth"].size and table["depth"][0] > 0.0:
        arrived &= has_risen(table["depth"], table["depth"][0], spacing)
    return float(table["time"][arrived][0]) if arrived.any() else np.nan


def _flow_figures(name: str, table: Table, where: str, found: Survey) -> list[Answer]:
    volume = VOLUME[found.run.case.dimension]
    rate = {"": table["discharge"], "sediment_": table["sediment_discharge"]}
    total = {"": table["volume"], "sediment_": table["sediment_volume"]}
    rate["water_"], total["water_"] = (part[""] - part["sediment_"] for part in (rate, total))
    peak = int(np.argmax(rate[""])) if rate[""].size else -1
    rows = [Answer(f"{name}_peak_time", _at(table["time"], peak), "s", f"of all, {where}")]
    kinds = [("", "in all")]
    if found.has_grains:
        kinds += [("sediment_", "of grains"), ("water_", "of water")]
    for matter, meaning in kinds:
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
    for matter in ("water", "sediment") if found.has_grains else ("water",):
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
