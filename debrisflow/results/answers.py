"""The table of answers: what a report on a run states, each with its unit and its meaning."""

from __future__ import annotations

import numpy as np

from debrisflow.results.fronts import PHASE_WORDS
from debrisflow.results.shared_answers import Answer, at, budgets, dams, greatest, sections
from debrisflow.results.stations import VOLUME
from debrisflow.results.survey import AnySurvey, Survey
from debrisflow.results.terrain_answers import terrain_answers
from debrisflow.results.terrain_survey import TerrainSurvey

EXTENT = {2: ("length", "m"), 3: ("area", "m2")}


def answers(found: AnySurvey) -> list[Answer]:
    """Return the figures of a run."""
    return [row for rows in answers_by_heading(found).values() for row in rows]


def answers_by_heading(found: AnySurvey) -> dict[str, list[Answer]]:
    """Return the figures of a run by the headings under which they stand in a report."""
    if isinstance(found, TerrainSurvey):
        return terrain_answers(found)
    return {
        "Run-out" if found.mobilities else "Motion": [*_motion(found), *_runout(found)],
        "Extent": _extent(found),
        "Deposit and erosion": _deposit(found) if found.has_grains else [],
        "Sections": sections(found),
        "Dams": dams(found),
        "Budgets": budgets(found),
    }


def _motion(found: Survey) -> list[Answer]:
    front = found.fronts
    rows = [
        Answer("last_frame_time", at(front["time"], -1), "s", "up to which the run was measured"),
        Answer("moving_share_end", at(front["moving_share"], -1), "-", "of the volume, then"),
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
    fastest = greatest(speeds[~np.isnan(speeds)])
    return Answer(name, fastest, "m/s", f"of the front{whose}, between frames")


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
        Answer("depth_greatest", greatest(maxima["maximal_depth"]), "m", "flow height, ever"),
        Answer("speed_greatest", greatest(maxima["maximal_speed"]), "m/s", "depth mean, ever"),
        Answer(
            "momentum_flux_greatest",
            greatest(maxima["maximal_momentum_flux"]),
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
            greatest(last.table["deposit_height"]),
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
