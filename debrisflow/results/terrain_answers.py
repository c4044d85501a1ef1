"""The figures that a report on a terrain run states."""

from __future__ import annotations

from math import atan, degrees

import numpy as np

from debrisflow.results.shared_answers import Answer, at, budgets, dams, greatest, sections
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.results.words import Words
from debrisflow.run.ledger import PLACES
from debrisflow.run.measures import particle_volume

PEAKS = (
    ("depth_greatest", "peak_depth", "m", "along the vertical"),
    ("speed_greatest", "peak_speed", "m/s", "mean over the depth"),
    ("momentum_flux_greatest", "peak_momentum_flux", "m3/s2", "depth times speed squared"),
    ("pressure_greatest", "peak_pressure", "kPa", "density times speed squared"),
)
PLACE_WORDS = {
    "moving": "on the terrain at the end, faster than output.rest_speed",
    "at_rest": "on the terrain at the end, slower than that",
    "left": "over an edge of the DEM or the top of the space, or onto cells without a level",
    "through_ground": "through the ground or an obstacle",
}


def terrain_answers(found: TerrainSurvey, words: Words | None = None) -> dict[str, list[Answer]]:
    """Return the figures of a run on a terrain by their headings.

    Parameters
    ----------
    found : TerrainSurvey
    words : Words, optional
        In which the meanings are written; English if left out.
    """
    words = words or Words()
    return {
        "Run-out": _runout(found, words),
        "Extent": _extent(found, words),
        "Deposit": _deposit(found, words),
        "Sections": sections(found),
        "Dams": dams(found),
        "Ledger": _ledger(found, words),
        "Budgets": budgets(found),
    }


def _runout(found: TerrainSurvey, words: Words) -> list[Answer]:
    flow, front = found.mobility, found.fronts
    bound = f"; {words(flow.bound)}" if flow.bound else ""
    slope, speed = flow.equivalent_friction, front["front_speed"]
    along = "in plan, from the middle of the first release down the flow path to the cell {place}"
    straight = "in plan, from the middle of the first release straight to the farthest cell"
    return [
        Answer("last_time", at(front["time"], -1), "s", words("up to which the run was measured")),
        Answer(
            "moving_share_end",
            at(front["moving_share"], -1),
            "-",
            words("of the volume on the terrain, then"),
        ),
        Answer(
            "rest_time",
            found.rest_time,
            "s",
            words("from which on less than 1 % of the volume moves"),
        ),
        Answer(
            "runout_length", flow.runout, "m", words(along, place=_coordinates(flow.toe)) + bound
        ),
        Answer("reach", flow.reach, "m", words(straight) + bound),
        Answer(
            "travel_distance",
            flow.travel,
            "m",
            words("L, horizontal, from the highest released cell to the farthest reached one")
            + bound,
        ),
        Answer("fall_height", flow.fall, "m", words("H, between these cells")),
        Answer("equivalent_friction", slope, "-", "H / L"),
        Answer("travel_angle", degrees(atan(slope)), "degree", words("of that slope")),
        Answer(
            "front_speed_greatest",
            greatest(speed[~np.isnan(speed)]),
            "m/s",
            words("of the front along the flow path, over two output intervals"),
        ),
    ]


def _extent(found: TerrainSurvey, words: Words) -> list[Answer]:
    least, arrival = found.run.case.output.layer_depth, found.layers["arrival"]
    area = float(np.count_nonzero(found.reached)) * found.grid.cell**2
    rows = [
        Answer(
            "affected_area",
            area,
            "m2",
            words("in plan, where the depth exceeded {least} m", least=f"{least:g}"),
        )
    ]
    for name, layer, unit, meaning in PEAKS:
        value, place = found.peak(layer)
        meaning_text = words(
            "{meaning}, ever, in the cell {place}",
            meaning=words(meaning),
            place=_coordinates(place),
        )
        rows.append(Answer(name, value, unit, meaning_text))
    last = greatest(arrival[np.isfinite(arrival)])
    return [*rows, Answer("arrival_latest", last, "s", words("of a cell"))]


def _coordinates(place: tuple[float, float]) -> str:
    """Return a place on the map, east and north, m."""
    return f"({place[0]:.1f}, {place[1]:.1f})"


def _deposit(found: TerrainSurvey, words: Words) -> list[Answer]:
    depth, cell = np.nan_to_num(found.layers["deposit"]), found.grid.cell**2
    output, thickest = found.run.case.output, found.peak("deposit")
    slow = words(
        "slower than {speed} m/s at the end, thicker than {least} m",
        speed=f"{output.rest_speed:g}",
        least=f"{output.layer_depth:g}",
    )
    where = words("in the cell {place}", place=_coordinates(thickest.place))
    return [
        Answer("deposit_area", float(np.count_nonzero(depth)) * cell, "m2", slow),
        Answer("deposit_volume", float(depth.sum()) * cell, "m3", slow),
        Answer("deposit_height_greatest", float(depth.max()), "m", where),
    ]


def _ledger(found: TerrainSurvey, words: Words) -> list[Answer]:
    table, volume = found.run.ledger, particle_volume(found.run.case)
    rows = [
        Answer(
            "volume_released",
            at(table["released"], -1) * volume,
            "m3",
            words("with pores, of the particles"),
        )
    ]
    for place in PLACES:
        value = at(table[place], -1) * volume
        rows.append(Answer(f"volume_{place}", value, "m3", words(PLACE_WORDS[place])))
    meaning_text = words("particles by which it fails to add up at any time")
    return [*rows, Answer("ledger_error", found.ledger_error, "-", meaning_text)]
