"""Figures that runs of all kinds have: of sections and budgets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes import AnyProbe
from debrisflow.case.probes.dam import DamProbe
from debrisflow.particles.maxima import has_risen
from debrisflow.results.measured import Measured
from debrisflow.results.stations import VOLUME, flow_probes
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


def sections(found: Measured) -> list[Answer]:
    """Return what passed the probes that are sections, and when it came."""
    rows, case = [], found.run.case
    for probe in flow_probes(case):
        table = found.run.probe(probe.name)
        where = f"{probe.type} at {_place_of(probe, case)} m"
        rows += _flow_figures(probe.name, table, where, found)
        first = _section_arrival(table, case.particles.spacing)
        rows.append(Answer(f"{probe.name}_arrival", first, "s", SECTION_ARRIVAL))
    return rows


def dams(found: Measured) -> list[Answer]:
    """Return what structures held back and what came over them, by the probes of dams."""
    rows = []
    for probe in found.run.case.probe:
        if not isinstance(probe, DamProbe):
            continue
        table, name, dam = found.run.probe(probe.name), probe.name, f"the dam '{probe.wall}'"
        held = at(table["trapped_volume"], -1)
        over = at(table["overtopped_volume"], -1)
        first = at(table["overtopping_time"], -1)
        rows += [
            Answer(f"{name}_overtopping_time", first, "s", f"when the first came over {dam}"),
            Answer(f"{name}_trapped_volume", held, "m3", f"held back by {dam} at the end"),
            Answer(f"{name}_overtopped_volume", over, "m3", f"came over {dam}"),
        ]
    return rows


def _place_of(probe: AnyProbe, case: ResolvedCase) -> str:
    """Return where a probe is in words, on a terrain in coordinates of the map."""
    return (probe.moved(case.terrain.origin) if case.is_terrain else probe).where()


def _section_arrival(table: Table, spacing: float) -> float:
    """Return the first sample at which a flow has come to a section, s; nan if none has."""
    arrived = table["volume"] > 0.0
    if table["depth"].size and table["depth"][0] > 0.0:
        arrived &= has_risen(table["depth"], table["depth"][0], spacing)
    return float(table["time"][arrived][0]) if arrived.any() else np.nan


def _flow_figures(name: str, table: Table, where: str, found: Measured) -> list[Answer]:
    volume = VOLUME[found.run.case.dimension]
    rate = {"": table["discharge"], "sediment_": table["sediment_discharge"]}
    total = {"": table["volume"], "sediment_": table["sediment_volume"]}
    rate["water_"], total["water_"] = (part[""] - part["sediment_"] for part in (rate, total))
    peak = int(np.argmax(rate[""])) if rate[""].size else -1
    rows = [Answer(f"{name}_peak_time", at(table["time"], peak), "s", f"of all, {where}")]
    kinds = [("", "in all")]
    if found.has_grains:
        kinds += [("sediment_", "of grains"), ("water_", "of water")]
    for matter, meaning in kinds:
        told = f"{meaning}, {where}"
        peak_rate = greatest(rate[matter])
        rows += [
            Answer(f"{name}_{matter}discharge_peak", peak_rate, f"{volume}/s", f"greatest {told}"),
            Answer(f"{name}_{matter}volume", at(total[matter], -1), volume, f"passed {told}"),
        ]
    return rows


def at(values: Floats, row: int) -> float:
    """Return a row of a column; nan of an empty one."""
    return float(values[row]) if values.size else np.nan


def greatest(values: Floats) -> float:
    """Return the greatest value of a column; nan of an empty one."""
    return float(np.max(values)) if values.size else np.nan


def budgets(found: Measured) -> list[Answer]:
    """Return masses with the error of their balance, and energies."""
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
            value = at(table[f"mass_{way}_{matter}"], -1)
            rows.append(Answer(f"mass_{way}_{matter}", value, kilogram, f"{matter}, {meaning}"))
        closure = float(np.abs(table[f"closure_{matter}"]).max())
        rows.append(
            Answer(f"mass_closure_{matter}", closure, kilogram, "greatest error of its balance")
        )
    kinetic = table["kinetic_energy"]
    rows.append(Answer("kinetic_energy_greatest", float(kinetic.max()), joule, "of all matter"))
    rows.append(Answer("kinetic_energy_end", at(kinetic, -1), joule, "of all matter, at the end"))
    bounced = found.run.summary.get("bounced_share")
    if bounced is not None:
        rows.append(Answer("bounced_share", bounced, "-", "of the particles, off walls in a step"))
    return rows
