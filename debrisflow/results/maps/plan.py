"""The picture of a case on a terrain before it runs."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, radians, sin
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from debrisflow import __version__
from debrisflow.case import ResolvedCase
from debrisflow.case.coverage import depth_on, holds_middles
from debrisflow.case.probes import AnyProbe
from debrisflow.case.rasters import MapGrid, raster_of_plan
from debrisflow.case.released import length_of, outline, volume
from debrisflow.case.releases import PolygonRelease
from debrisflow.case.resolved import ResolvedHydrographRelease, ResolvedRelease
from debrisflow.errors import OutputError
from debrisflow.results.fonts import wrapped, writable
from debrisflow.results.maps.furniture import HALO, INK, draw_frame, draw_scale_and_north
from debrisflow.results.maps.relief import Contours
from debrisflow.results.maps.sheet import (
    CONTOUR,
    RELEASE,
    Text,
    draw_legend,
    draw_relief,
    draw_structure,
    figure_of,
    styled,
)
from debrisflow.results.maps.sheet import outline as edges_of
from debrisflow.results.maps.structures import structures
from debrisflow.results.words import Words
from debrisflow.run.atomic import made, replaced
from debrisflow.run.ground_forecast import format_volume

Floats = NDArray[np.float64]
DPI = 200
FLOW_IN, PROBE = "#0072b2", "#111111"
ZONES = ("#e69f00", "#009e73", "#56b4e9", "#cc79a7", "#f0e442", "#d55e00")
FAINT = 0.35  # opacity of an area
LETTERS = 20  # of a line of the key
ARROW = 0.06  # of the shorter side of the map, at least


PLACES = {"on-terrain": "put on the terrain", "in-terrain": "taken out of the terrain"}


class _Place(NamedTuple):
    """Where a probe stands: points on the map, m, one or the two ends of a line."""

    name: str
    points: Floats


def draw_case(case: ResolvedCase, path: Path) -> Path:
    """Draw terrain, releases, zones, obstacles and probes of a case, and return the picture.

    Raises
    ------
    OutputError
        If the case is on no terrain, or the file cannot be written.
    """
    if not case.is_terrain:
        raise OutputError("a picture of the case is drawn on a terrain only, and this has none")
    if path.suffix.lower() != ".png":
        raise OutputError(f"{path}: the picture is a PNG; call it {path.with_suffix('.png').name}")
    made(path.parent, is_deep=True)
    words = Words()
    with styled(words):
        figure = _figure(case, words)
        with replaced(path) as unfinished:
            made_by = {"Software": "debrisflow"}
            figure.savefig(unfinished, dpi=DPI, format="png", metadata=made_by)
    return path


def _figure(case: ResolvedCase, words: Words) -> Figure:
    terrain = case.terrain.levels
    grid = terrain.grid
    title = case.title if writable(case.title) else "-"
    text = Text("Terrain and releases", title, (_source(case), *_release_lines(case)))
    figure, axes, size = figure_of(grid, text)
    levels = draw_relief(axes, terrain)
    handles = [*_draw_zones(axes, case), *_draw_releases(axes, case)]
    rings = structures(case)
    for name, lines in rings.items():
        draw_structure(axes, name, lines)
    places = list(probe_places(case))
    for place in places:
        _draw_probe(axes, place)
    draw_frame(axes, grid, words)
    draw_scale_and_north(axes, grid, size, _covered(case, grid), words)
    if rings:
        handles.append(Patch(facecolor="white", edgecolor=INK, label="obstacle"))
    if places:
        handles.append(Line2D([], [], color=PROBE, marker="+", linewidth=1.0, label="probe"))
    _draw_key(figure, axes, handles, levels)
    return figure


def _source(case: ResolvedCase) -> str:
    grid = case.terrain.levels.grid
    return (
        f"DEM {Path(case.terrain.dem).name}, cells of {grid.cell:g} m; smooth surface of "
        f"{case.terrain.cell:g} m; particles of {case.particles.spacing:g} m. "
        f"debrisflow {__version__}."
    )


def _release_lines(case: ResolvedCase) -> Iterator[str]:
    """Yield a line for each release: kind, volume and time."""
    for number, part in enumerate(case.release):
        name = _name(part, number)
        start = f" from t = {part.start:g} s" if part.start > 0.0 else ""
        if isinstance(part, ResolvedHydrographRelease):
            how = f"up to {max(part.hydrograph.discharge):g} m³/s at {part.velocity:g} m/s"
            how += f" over {length_of(part.line):.3g} m"
        else:
            how = PLACES[part.place]
        yield f"{name}: {format_volume(volume(part))} m³, {how}{start}."


def _name(part: ResolvedRelease, number: int) -> str:
    name = part.name or f"release {number}"
    return name if writable(name) else f"release {number}"


def _draw_zones(axes: Axes, case: ResolvedCase) -> list[Artist]:
    """Draw the zones of friction, the later over the earlier, and return their signs."""
    grid = case.terrain.levels.grid
    handles: list[Artist] = []
    for zone, color in zip(case.zone, ZONES * len(case.zone), strict=False):
        inside = raster_of_plan(grid, holds_middles(zone, grid).astype(float)).values > 0.0
        _draw_cells(axes, grid, inside, color)
        name = zone.name if writable(zone.name) else "-"
        label = "\n".join(wrapped(f"zone {name}: {zone.friction.law}", LETTERS))
        handles.append(Patch(facecolor=color, alpha=FAINT + 0.2, edgecolor=INK, label=label))
    return handles


def _draw_releases(axes: Axes, case: ResolvedCase) -> list[Artist]:
    """Draw masses and lines of hydrographs, and return the signs of those that there are."""
    grid = case.terrain.levels.grid
    found: dict[str, Artist] = {}
    for number, part in enumerate(case.release):
        if isinstance(part, ResolvedHydrographRelease):
            _draw_line(axes, part, _name(part, number))
            found["hydrograph"] = Line2D([], [], color=FLOW_IN, linewidth=2.0, label="hydrograph")
            continue
        if isinstance(part, PolygonRelease):
            for shape in shapely.get_parts(outline(part)):
                for ring in (shape.exterior, *shape.interiors):
                    axes.plot(*np.asarray(ring.coords).T, color=RELEASE, linewidth=1.4, zorder=6)
        inside = raster_of_plan(grid, depth_on(part, grid)).values > 0.0
        _draw_cells(axes, grid, inside, RELEASE)
        if not isinstance(part, PolygonRelease):
            for edge in edges_of(grid, inside):
                axes.plot(*edge.T, color=RELEASE, linewidth=1.4, zorder=6)
        rows, columns = np.nonzero(inside)
        east = grid.west + (columns.max() + 1) * grid.cell
        _write(axes, (east, grid.north - rows.mean() * grid.cell), _name(part, number))
        found["mass"] = Patch(facecolor=RELEASE, alpha=FAINT, edgecolor=RELEASE, label="release")
    return list(found.values())


def _draw_cells(axes: Axes, grid: MapGrid, inside: NDArray[np.bool_], color: str) -> None:
    """Fill some cells with a faint color."""
    axes.imshow(
        np.ma.masked_equal(inside, False), cmap=ListedColormap([color]), alpha=FAINT, zorder=3,
        extent=(grid.west, grid.east, grid.south, grid.north), interpolation="nearest",
    )  # fmt: skip


def _draw_line(axes: Axes, part: ResolvedHydrographRelease, name: str) -> None:
    """Draw the line of a hydrograph with an arrow along the flow."""
    ends, grid = np.array(part.line), (*axes.get_xlim(), *axes.get_ylim())
    middle, bearing = ends.mean(axis=0), radians(part.direction)
    long = max(ARROW * min(grid[1] - grid[0], grid[3] - grid[2]), 0.5 * length_of(part.line))
    tip = middle + long * np.array([sin(bearing), cos(bearing)])
    axes.plot(*ends.T, color=FLOW_IN, linewidth=2.2, solid_capstyle="butt", zorder=7)
    arrow = {"arrowstyle": "-|>", "color": FLOW_IN, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, middle, arrowprops=arrow, zorder=7)
    _write(axes, tuple(ends[ends[:, 1].argmax()]), name)


def _draw_probe(axes: Axes, place: _Place) -> None:
    style = "+" if len(place.points) == 1 else "-"
    axes.plot(*place.points.T, style, color=PROBE, linewidth=1.0, markersize=6, zorder=8)
    _write(axes, tuple(place.points[-1]), place.name)


def _write(axes: Axes, place: tuple[float, ...], name: str) -> None:
    """Write a name beside a place on the map."""
    if writable(name):
        axes.annotate(
            name, (place[0], place[1]), xytext=(3, 3), textcoords="offset points", fontsize=6.5,
            path_effects=HALO, zorder=9, annotation_clip=True,
        )  # fmt: skip


def probe_places(case: ResolvedCase) -> Iterator[_Place]:
    """Yield the places of the probes of a case that have one in plan."""
    origin = np.array(case.terrain.origin[:2])
    for probe in case.probe:
        points = _points_of(probe, case.terrain.width)
        if points is not None:
            yield _Place(probe.name, origin + points)


def _points_of(probe: AnyProbe, width: float) -> Floats | None:
    """Return the place of a probe from the origin, (1 or more, 2) array, m; None without one."""
    start, end = getattr(probe, "start", None), getattr(probe, "end", None)
    if start is not None and end is not None:
        return np.array([start[:2], end[:2]], dtype=float)
    x, y = getattr(probe, "x", None), getattr(probe, "y", None)
    if isinstance(x, tuple) and isinstance(y, tuple):
        (west, east), (south, north) = x, y
        corners = [(west, south), (east, south), (east, north), (west, north), (west, south)]
        return np.array(corners, dtype=float)
    if isinstance(x, float):
        return np.array([(x, 0.0), (x, width)] if y is None else [(x, y)], dtype=float)
    return None


def _covered(case: ResolvedCase, grid: MapGrid) -> NDArray[np.bool_]:
    """Return the cells that scale and north arrow should leave free, (rows, columns)."""
    covered = np.zeros((grid.columns, grid.rows))
    for part in case.release:
        if isinstance(part, ResolvedHydrographRelease):
            for east, north in part.line:
                column = min(int((east - grid.west) / grid.cell), grid.columns - 1)
                covered[column, min(int((north - grid.south) / grid.cell), grid.rows - 1)] = 1.0
        else:
            covered += depth_on(part, grid)
    return raster_of_plan(grid, covered).values > 0.0


def _draw_key(figure: Figure, axes: Axes, handles: list[Artist], levels: Contours) -> None:
    left, bottom, width, height = axes.get_position().bounds
    contour = f"contours each\n{levels.interval:g} m"
    handles.append(Line2D([], [], color=CONTOUR, linewidth=0.7, label=contour))
    whole, _ = figure.get_size_inches()
    draw_legend(figure, handles, (left + width + 0.1 / whole, bottom + height), "upper left")
