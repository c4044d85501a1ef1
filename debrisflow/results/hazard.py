"""Maps of hazard classes from the layers of a run, and their areas."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import (
    EmptyRasterError,
    Raster,
    UnreadableRasterError,
    has_rasterio,
    read_raster,
    write_raster,
)
from debrisflow.case.vectors import write_polygons
from debrisflow.errors import OutputError, steers
from debrisflow.results.hazard_classes import Classes
from debrisflow.results.layers import read_layer
from debrisflow.run.atomic import replaced_files
from debrisflow.run.layer_styles import DOCTYPE, palette
from debrisflow.run.layers import ENDINGS, polygons_of
from debrisflow.run.names import POSTPROCESS
from debrisflow.run.own_files import must_be_own
from debrisflow.run.reading import text_of, xml_of
from debrisflow.run.tables import write_table

LINE = 100  # letters
COLOR = re.compile("#[0-9a-fA-F]{6}")
ORDER, SOURCE = "; classes from the worst on", "source: "  # in the head of a table
COLUMNS = ("class", "number", "cells", "area", "share")


class ClassArea(NamedTuple):
    """How much of the map a class takes.

    Attributes
    ----------
    name : str
    number : int
        In the raster.
    cells : int
    area : float, m2
        In plan.
    share : float
        Of all cells that the flow reaches.
    """

    name: str
    number: int
    cells: int
    area: float
    share: float


class HazardMap(NamedTuple):
    """A map of classes.

    Attributes
    ----------
    classes : Classes
    raster : Raster
        Numbers of classes; nan where there is none.
    areas : list of ClassArea
        From the worst class on.
    """

    classes: Classes
    raster: Raster
    areas: list[ClassArea]


def hazard_map(run: Path, classes: Classes) -> HazardMap:
    """Return the map of classes of a run.

    Parameters
    ----------
    run : Path
        Its folder.
    classes : Classes

    Raises
    ------
    OutputError
        If the run lacks a layer that the classes need.
    """
    must_be_own(run)
    depth = read_layer(run, "peak_depth")
    reached: NDArray[np.bool_] = np.isfinite(depth.values)
    layers = {name: read_layer(run, name).values for name in classes.layers}
    numbers = classes.classified(reached, layers)
    return HazardMap(
        classes, Raster(depth.grid, numbers), _areas(classes, numbers, reached, depth.grid.cell)
    )


def _areas(
    classes: Classes, numbers: NDArray[np.float64], reached: NDArray[np.bool_], cell: float
) -> list[ClassArea]:
    all_cells, found = max(int(reached.sum()), 1), []
    for place, one in enumerate(classes.classes):
        cells = int((numbers == classes.number(place)).sum())
        area, share = cells * cell**2, cells / all_cells
        found.append(ClassArea(one.name, classes.number(place), cells, area, share))
    return found


def write_hazard(run: Path, found: HazardMap) -> list[Path]:
    """Write a map of classes: raster and style, polygons, table of areas; return the files.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    folder, classes = run / POSTPROCESS, found.classes
    name = f"class_{classes.name}"
    with replaced_files(folder) as unfinished:
        ending = ENDINGS[0] if has_rasterio() else ENDINGS[1]
        write_raster(unfinished / f"{name}.{ending}", found.raster, _tags(classes))
        entries = [(classes.number(k), c.name, c.color) for k, c in enumerate(classes.classes)]
        (unfinished / f"{name}.qml").write_text(palette(entries), encoding="utf-8")
        _write_polygons(unfinished / f"{name}.geojson", found)
        head = (
            f"{classes.title}{ORDER}",
            f"{SOURCE}{classes.source}",
            "number: of the class in the raster",
            "area: m2, in plan",
            "share: of the area that the flow reaches",
        )
        write_table(unfinished / f"{name}.csv", COLUMNS, head, found.areas)
        return [folder / file.name for file in sorted(unfinished.iterdir())]


def _tags(classes: Classes) -> dict[str, str]:
    numbers = [f"{classes.number(k)} {one.name}" for k, one in enumerate(classes.classes)]
    return {"title": classes.title, "classes": "; ".join(numbers), "source": classes.source}


def _write_polygons(path: Path, found: HazardMap) -> None:
    grid = found.raster.grid
    shapes: list[Any] = []
    names: list[str] = []
    numbers: list[int] = []
    for area in found.areas:
        parts = polygons_of(grid, found.raster.values == area.number)
        shapes += parts
        names += [area.name] * len(parts)
        numbers += [area.number] * len(parts)
    attributes: dict[str, list[Any]] = {
        "class": names,
        "number": numbers,
        "area_m2": [one.area for one in shapes],
    }
    write_polygons(path, shapes, attributes, grid.crs)


class ClassMap(NamedTuple):
    """A map of classes that was written.

    Attributes
    ----------
    raster : Raster
        Numbers of classes; nan where there is none.
    title, source : str
    names, colors : tuple of str
        Of the classes, from number 1 on.
    """

    raster: Raster
    title: str
    source: str
    names: tuple[str, ...]
    colors: tuple[str, ...]


def class_names(run: Path) -> list[str]:
    """Return the names of the maps of classes that were written for a run, ``class_NAME``."""
    return sorted(file.stem for file in (run / POSTPROCESS).glob("class_*.qml"))


def read_class_map(run: Path, name: str) -> ClassMap:
    """Return a map of classes by its name.

    Raises
    ------
    OutputError
        If a file is missing or damaged.
    """
    stem = run / POSTPROCESS / name
    rasters = [Path(f"{stem}.{ending}") for ending in ENDINGS]
    raster = next((file for file in rasters if file.is_file()), rasters[0])
    style, table = Path(f"{stem}.qml"), Path(f"{stem}.csv")  # a name may have a dot
    names, colors = _palette(style)
    head = text_of(table).splitlines()[:2]
    if len(head) < 2 or any(map(steers, head)):
        raise OutputError(f"{table} is damaged: its head lacks title and source")
    try:
        values = _class_values(raster)
    except UnreadableRasterError as error:
        raise OutputError(f"{raster} {error}") from error
    title, source = (line.removeprefix("# ") for line in head)
    return ClassMap(values, title.removesuffix(ORDER), source.removeprefix(SOURCE), names, colors)


def _palette(file: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and colors of classes, from number 1 on, of a style for GIS programs."""
    found = {
        entry.get("value", ""): (entry.get("label", ""), entry.get("color", ""))
        for entry in xml_of(file, DOCTYPE).iter("paletteEntry")
    }
    entries = [found.get(str(number), ("", "")) for number in range(1, len(found) + 1)]
    if not entries or any(
        not name or steers(name) or not COLOR.fullmatch(color) for name, color in entries
    ):
        raise OutputError(f"{file} is damaged: its classes lack names, or colors such as #d4006a")
    names, colors = zip(*entries, strict=True)
    return names, colors


def _class_values(file: Path) -> Raster:
    """Return the raster of a map of classes; all nan if the flow reached no cell."""
    try:
        return read_raster(file)
    except EmptyRasterError as empty:
        return empty.raster


def area_lines(found: HazardMap) -> list[str]:
    """Return the areas as lines of a table."""
    width = max(len(area.name) for area in found.areas)
    lines = [found.classes.title, f"{'class':<{width}}  number  cells       area, m2   share"]
    lines += [
        f"{a.name:<{width}}  {a.number:6d}  {a.cells:5d}  {a.area:13,.0f}  {100 * a.share:5.1f} %"
        for a in found.areas
    ]
    return [*lines, *textwrap.wrap(f"source: {found.classes.source}", LINE)]
