"""Writes the maps that a study asks for: rasters with styles, pictures, convergence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from debrisflow import __version__
from debrisflow.case.rasters import MapGrid, Raster, has_rasterio, write_raster
from debrisflow.results.maps.looks import LOOKS
from debrisflow.results.reader import open_run
from debrisflow.run.atomic import made, replaced_files
from debrisflow.run.layer_styles import pseudocolors, style
from debrisflow.run.layers import ENDINGS, LAYERS
from debrisflow.study.designs import is_sample as of_sample
from debrisflow.study.maps.convergence import FIRST, convergence, write_convergence
from debrisflow.study.maps.pictures import LIMITS, PROBABILITY, StudyMap, draw_study_maps
from debrisflow.study.maps.shares import (
    expect_members,
    known_on,
    quantiles,
    shares_arrived,
    shares_over,
)
from debrisflow.study.names import ARRIVAL
from debrisflow.study.tables import Map, Saltelli, Study

HAIR = 1e-7  # of a share


def write_maps(
    study: Study,
    folders: Sequence[Path],
    grid: MapGrid,
    target: Path,
    is_sample: bool | None = None,
) -> list[Path]:
    """Write the maps that a study asks for into a folder, and return the files.

    Parameters
    ----------
    study : Study
    folders : sequence of Path
        Of finished members, in the order of the design.
    grid : MapGrid
        See :func:`debrisflow.study.maps.grid.grid_of`.
    target : Path
        Made if it does not exist.
    is_sample : bool, optional
        Whether the members are drawn from the distributions of the parameters, so that shares of
        them are probabilities; if left out that depends on the design.

    Raises
    ------
    OutputError
        If there is no member, one lacks a layer, or the folder cannot be written.
    """
    if is_sample is None:
        is_sample = of_sample(study.design)
    is_independent = is_sample and not isinstance(study.design, Saltelli)
    if not any((wanted.exceeds or wanted.before or wanted.quantiles) for wanted in study.map):
        return []
    expect_members(folders)
    case = open_run(folders[0]).case
    least = case.output.layer_depth
    maps = [one for wanted in study.map for one in _maps(wanted, folders, grid, is_sample, least)]
    known = known_on(folders, grid)
    maps = [one._replace(values=np.where(known, one.values, np.nan)) for one in maps]
    made(target, is_deep=True)
    with replaced_files(target) as unfinished:
        for one in maps:
            _write(one, grid, _tags(one, study, len(folders)), unfinished)
        draw_study_maps(
            maps, folders, grid, case, study.title, is_sample, is_independent, unfinished
        )
        if is_independent and len(folders) > FIRST:
            _write_convergence(study, folders, grid, least, unfinished)
        return [target / file.name for file in sorted(unfinished.iterdir())]


def _maps(
    wanted: Map, folders: Sequence[Path], grid: MapGrid, is_sample: bool, least: float
) -> Iterator[StudyMap]:
    """Yield the maps of an entry, without regard to where there is a terrain.

    A threshold below the least depth, m, that is told from dry gives the map of that, and its
    title says so.
    """
    layer, count = wanted.layer, f"{len(folders)} members"
    unit, what = LAYERS[layer].unit, _lowered(LOOKS[layer].title)
    begin = "Probability that the" if is_sample else "Share of members whose"
    if wanted.exceeds:
        found = shares_over(folders, grid, layer, wanted.exceeds)
        for threshold, values in zip(wanted.exceeds, found, strict=True):
            mapped = max(threshold, least) if layer == "peak_depth" else threshold
            title = f"{begin} {what} exceeds {mapped:g} {LOOKS[layer].unit}; {count}"
            yield StudyMap(over_name(layer, threshold), title, layer, True, values)
    if wanted.before:
        found = shares_arrived(folders, grid, wanted.before)
        for time, values in zip(wanted.before, found, strict=True):
            title = f"{begin} flow arrives within {time:g} {unit}; {count}"
            yield StudyMap(f"{ARRIVAL}_before_{time:g}{unit}", title, layer, True, values)
    if wanted.quantiles:
        found = quantiles(folders, grid, layer, wanted.quantiles)
        for share, values in zip(wanted.quantiles, found, strict=True):
            percent = f"{100.0 * share:g} % of {count}"
            title = (
                f"Time by which the flow of {percent} has arrived"
                if layer == ARRIVAL
                else f"{LOOKS[layer].title} that {percent} do not exceed"
            )
            yield StudyMap(f"{layer}_quantile_{share:g}", title, layer, False, values, share)


def over_name(layer: str, threshold: float) -> str:
    """Return the name of the files of a map of exceedance.

    Examples
    --------
    >>> over_name("peak_depth", 0.5), over_name("peak_speed", 3.0)
    ('peak_depth_over_0.5m', 'peak_speed_over_3m_per_s')
    """
    return f"{layer}_over_{threshold:g}{LAYERS[layer].unit.replace('/', '_per_')}"


def _lowered(title: str) -> str:
    return title[0].lower() + title[1:]


def _write(one: StudyMap, grid: MapGrid, tags: dict[str, str], folder: Path) -> None:
    """Write the raster of a map and its style for QGIS."""
    ending = ENDINGS[0] if has_rasterio() else ENDINGS[1]
    values = np.where(np.isfinite(one.values), one.values, np.nan)  # no data where none arrives
    write_raster(folder / f"{one.name}.{ending}", Raster(grid, values), tags)
    clear = None if one.layer == ARRIVAL else 0.0
    unit = LAYERS[one.layer].unit
    text = _share_style() if one.is_share else style(one.layer, unit, values, clear)
    (folder / f"{one.name}.qml").write_text(text, encoding="utf-8")


def _share_style() -> str:
    """Return the style of shares of the members, whose zeros are not shown.

    A class of QGIS holds its upper limit, one of the pictures its lower one: the limits are lowered
    by less than shares of members can differ, and more than single precision rounds.
    """
    ends = [0.0, *LIMITS, 1.0]
    items = [
        (high - HAIR if high < 1.0 else high, f"{100.0 * low:g} to {100.0 * high:g} %", color)
        for low, high, color in zip(ends[:-1], ends[1:], PROBABILITY, strict=True)
    ]
    return pseudocolors("DISCRETE", 0.8, 0.0, 1.0, items, 0.0)


def _tags(one: StudyMap, study: Study, members: int) -> dict[str, str]:
    return {
        "name": one.name,
        "unit": "1" if one.is_share else LAYERS[one.layer].unit,
        "meaning": one.title,
        "layer": LAYERS[one.layer].meaning,
        "members": str(members),
        "study": study.title,
        "software": f"debrisflow {__version__}",
    }


def _write_convergence(
    study: Study, folders: Sequence[Path], grid: MapGrid, least: float, folder: Path
) -> None:
    for wanted in study.map:
        for threshold in wanted.exceeds:
            name = over_name(wanted.layer, threshold)
            unit, title = LOOKS[wanted.layer].unit, _lowered(LOOKS[wanted.layer].title)
            mapped = max(threshold, least) if wanted.layer == "peak_depth" else threshold
            write_convergence(
                convergence(folders, grid, wanted.layer, threshold),
                folder / f"{name}_convergence.csv",
                f"Probability that the {title} exceeds {mapped:g} {unit}, by number of members",
            )
