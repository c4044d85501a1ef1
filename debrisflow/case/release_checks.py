"""Checks of the releases on a terrain: amount, place and material."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from math import cos, radians, sin
from pathlib import Path

import numpy as np
import shapely

from debrisflow.case.hydrograph import faults_of
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.rasters import Raster, read_raster
from debrisflow.case.released import (
    area,
    depth_at,
    depths,
    direction_down,
    entering_depth,
    greatest_depth,
    length_of,
    outline,
    volume,
)
from debrisflow.case.releases import (
    AnyRelease,
    HydrographRelease,
    PolygonRelease,
    RasterRelease,
    Segment,
)
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import Geometry
from debrisflow.case.tables import Particles
from debrisflow.case.terrain_checks import file_name
from debrisflow.case.words import format_extent

Releases = tuple[AnyRelease, ...]

DEEPEST = 100.0  # m, of a release
CELLS_TO_NODATA = 10  # of the DEM, from a release
FEWEST_PARTICLES = 30  # of a release
FEWEST_SPACINGS = 3  # of a line over which a flow enters
ALONG = 60.0  # degrees off the normal of a line, from which on a flow hardly crosses it
OVERLAP = 1e-3  # of the smaller of two releases


def amounts_given(release: Releases) -> Problems:
    """Check that a mass has a depth or a volume, and that depths of a raster have one sign."""
    for k, part in enumerate(release):
        if isinstance(part, PolygonRelease):
            if part.depth is None and part.volume is None:
                yield Problem(f"release.{k}", "give its depth or its volume")
            elif part.depth is not None and part.volume is not None:
                message = f"release.{k}.depth is given as well; leave one of them out"
                yield Problem(f"release.{k}.volume", message, part.volume)
        elif isinstance(part, RasterRelease):
            values = read_raster(Path(part.file)).values
            least, most = float(np.nanmin(values)), float(np.nanmax(values))
            if least < 0.0 < most:
                message = (
                    f"has depths of both signs, {least:.4g} to {most:.4g} m; give only the "
                    "depths that are released"
                )
                yield Problem(f"release.{k}.file", message, file_name(part.file))
            elif least == most == 0.0:
                yield Problem(f"release.{k}.file", "has no depth but 0", file_name(part.file))


def hydrographs_in_order(release: Releases) -> Problems:
    """Check that the hydrographs of releases are in order and last for some time."""
    for k, part in enumerate(release):
        if not isinstance(part, HydrographRelease) or isinstance(part.hydrograph, str):
            continue
        key, graph = f"release.{k}.hydrograph", part.hydrograph
        yield from faults_of(graph, key)
        if graph.time and graph.time[0] < 0.0:
            message = "must be 0: the times of a release count from its start on"
            yield Problem(f"{key}.time.0", message, graph.time[0])
        if len(graph.time) == 1:
            message = "must have two times at least: that at which it begins, and that of its end"
            yield Problem(f"{key}.time", message, graph.time)


def lines_long(release: Releases, particles: Particles) -> Problems:
    """Check that a line over which a flow enters is some spacings long."""
    for k, line in _lines(release):
        length, least = length_of(line), FEWEST_SPACINGS * particles.spacing
        if length < least:
            message = (
                f"{length:.3g} m long; must be at least {FEWEST_SPACINGS} spacings, {least:g} m"
            )
            yield Problem(f"release.{k}.line", message, line)


def _lines(release: Releases) -> Iterator[tuple[int, Segment]]:
    for k, part in enumerate(release):
        if isinstance(part, HydrographRelease) and not isinstance(part.line, str):
            yield k, part.line


def releases_on_ground(geometry: Geometry, release: Releases) -> Problems:
    """Check that releases lie on the part of the DEM that is computed, far enough from gaps."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    levels, space = geometry.levels, shapely.box(*geometry.crop)
    for k, part in enumerate(release):
        shape = _shape_of(part)
        key, value = _where(f"release.{k}", part)
        inside = shapely.box(*shape.bounds).within(space) or shape.within(space)
        if not inside:
            how = "partly" if shape.intersects(space) else "wholly"
            message = (
                f"lies {how} outside the terrain: it reaches over {format_extent(shape.bounds)}, "
                f"the terrain over {format_extent(geometry.crop)}"
            )
            yield Problem(key, message, value)
        elif (gap := _distance_to_gap(shape, levels)) is not None:
            where = "lies on cells" if gap <= 0.5 else f"lies {gap:.2g} cells from one"
            message = (
                f"{where} of the DEM without data; there must be at least {CELLS_TO_NODATA} cells "
                "with data around it: fill the gap, or take another DEM"
            )
            yield Problem(key, message, value)


def _where(key: str, part: AnyRelease) -> tuple[str, object]:
    """Return the key and the value that say where a release is."""
    name = "line" if isinstance(part, HydrographRelease) else "file"
    if isinstance(part, PolygonRelease) and part.file is None:
        name = "corners"
    value = getattr(part, name)
    return f"{key}.{name}", file_name(value) if isinstance(value, str) else value


def _shape_of(part: AnyRelease) -> shapely.Geometry:
    """Return what a release covers on the map; of a raster the middles of its cells."""
    if isinstance(part, HydrographRelease):
        return shapely.LineString(part.line)
    if isinstance(part, PolygonRelease):
        return outline(part)
    raster = depths(part)
    grid = raster.grid
    rows, columns = np.nonzero(raster.values)
    x = grid.west + (columns + 0.5) * grid.cell
    y = grid.north - (rows + 0.5) * grid.cell
    return shapely.MultiPoint(np.stack([x, y], axis=1))


def _distance_to_gap(shape: shapely.Geometry, levels: Raster) -> float | None:
    """Return how far the next cell without data is, in cells; None if that is far enough."""
    cell = levels.grid.cell
    west, south, east, north = shape.bounds
    reach = (CELLS_TO_NODATA + 1) * cell
    near = levels.cropped(west - reach, south - reach, east + reach, north + reach)
    rows, columns = np.nonzero(np.isnan(near.values))
    if not len(rows):
        return None
    x = near.grid.west + (columns + 0.5) * cell
    y = near.grid.north - (rows + 0.5) * cell
    shapely.prepare(shape)
    least = float(shapely.distance(shape, shapely.points(x, y)).min()) / cell
    return least if least < CELLS_TO_NODATA else None


def releases_sized(geometry: Geometry, release: Releases, particles: Particles) -> Problems:
    """Check that depths are not elevations, and that a release has enough particles."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    for k, part in enumerate(release):
        if isinstance(part, HydrographRelease):
            if (found := entering_depth(part)) > DEEPEST:
                message = (
                    f"the flow would enter {found:.4g} m deep at its peak; give a greater velocity "
                    "or a longer line, and discharges in m3/s"
                )
                yield Problem(f"release.{k}.velocity", message, part.velocity)
        elif (found := greatest_depth(part)) > DEEPEST:
            name = "depth" if isinstance(part, PolygonRelease) and part.depth else "volume"
            key = f"release.{k}." + ("file" if isinstance(part, RasterRelease) else name)
            message = (
                f"{found:.4g} m deep over {area(part):.4g} m2, more than {DEEPEST:g} m; a depth is "
                "measured from the ground, and is no elevation"
            )
            value = getattr(part, key.rpartition(".")[2])
            yield Problem(key, message, file_name(value) if isinstance(value, str) else value)
            continue
        count = volume(part) / particles.spacing**3
        if count < FEWEST_PARTICLES:
            message = (
                f"too small: {volume(part):.3g} m3 make {count:.0f} particles, which must be at "
                f"least {FEWEST_PARTICLES}; particles.spacing = "
                f"{(volume(part) / FEWEST_PARTICLES) ** (1 / 3):.2g} would do"
            )
            yield Problem(f"release.{k}", message)


def releases_apart(geometry: Geometry, release: Releases) -> Problems:
    """Check that no two masses are released at the same place and time."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    masses = [
        (k, part) for k, part in enumerate(release) if not isinstance(part, HydrographRelease)
    ]
    for (k, one), (m, other) in combinations(masses, 2):
        if one.start != other.start:
            continue
        shared = _shared_area(one, other)
        if shared > OVERLAP * min(area(one), area(other)):
            message = (
                f"overlaps release.{k} over {shared:.3g} m2 at the same time; cut it out of one of "
                "them, or give both as one raster"
            )
            key, value = _where(f"release.{m}", other)
            yield Problem(key, message, value)


def _shared_area(
    one: PolygonRelease | RasterRelease, other: PolygonRelease | RasterRelease
) -> float:
    """Return the area that two masses share, m2."""
    if isinstance(one, PolygonRelease) and isinstance(other, PolygonRelease):
        return float(outline(one).intersection(outline(other)).area)
    if isinstance(one, PolygonRelease):
        one, other = other, one
    middles = shapely.get_coordinates(_shape_of(one))
    shared = np.count_nonzero(depth_at(other, middles[:, 0], middles[:, 1]))
    return float(shared / len(middles) * area(one))


def water_without_grains(release: Releases) -> Problems:
    """Check that no concentration is given for water."""
    for k, part in enumerate(release):
        if isinstance(part, HydrographRelease) or part.material != "water":
            continue
        if was_set(part, "concentration"):
            message = "has no effect on the material 'water', only on 'mixture'"
            yield Problem(f"release.{k}.concentration", message, part.concentration)


def flows_across_line(geometry: Geometry, release: Releases) -> Problems:
    """Check that a flow that enters over a line has a direction, which crosses it."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    for k, line in _lines(release):
        part = release[k]
        on_ground = shapely.LineString(line).within(shapely.box(*geometry.crop))
        if not isinstance(part, HydrographRelease) or not on_ground:
            continue
        key = f"release.{k}.direction"
        if part.direction is None:
            if direction_down(line, geometry.levels) is None:
                message = (
                    "missing: the ground does not fall across the line; give the direction of the "
                    "flow (degree)"
                )
                yield Problem(key, message)
            continue
        (a, b), (c, d) = line
        east, north = sin(radians(part.direction)), cos(radians(part.direction))
        across = abs(east * (d - b) - north * (c - a)) / length_of(line)
        if across < cos(radians(ALONG)):
            message = (
                f"runs along the line rather than across it; it must be within {ALONG:g} degrees "
                "of the normal of the line, clockwise from north"
            )
            yield Problem(key, message, part.direction)


AS_ASKED: tuple[Callable[..., Problems], ...] = (
    amounts_given,
    hydrographs_in_order,
    lines_long,
)
CHECKS: tuple[Callable[..., Problems], ...] = (
    releases_on_ground,
    releases_sized,
    releases_apart,
    water_without_grains,
    flows_across_line,
)
