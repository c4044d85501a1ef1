"""Checks of a terrain and its zones."""

from __future__ import annotations

from collections.abc import Callable
from math import isclose
from pathlib import Path

import numpy as np
import shapely

from debrisflow.case.problems import Problem, Problems
from debrisflow.case.rasters import read_raster
from debrisflow.case.released import (
    outline,
)
from debrisflow.case.releases import (
    AnyRelease,
    PolygonRelease,
    Zone,
)
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import Geometry
from debrisflow.case.tables import AnyObstacle, AnyScheme, Gravity, Walls
from debrisflow.case.terrain import Terrain
from debrisflow.case.words import either, format_extent, place

Releases = tuple[AnyRelease, ...]
Zones = tuple[Zone, ...]

FEWEST_CELLS = 8  # of a terrain along each side
HIGHEST = 9000.0  # m, above all ground
FLAT = 1e-6  # of the square of the way around a polygon, which encloses nothing below that


def terrain_alone(geometry: Geometry, release: Releases, zone: Zones) -> Problems:
    """Check that releases and zones have a terrain."""
    if isinstance(geometry, Terrain):
        return
    for name, entries in (("release", release), ("zone", zone)):
        if entries:
            message = f"only on a terrain, geometry.type = 'terrain'; a {geometry.type} has none"
            yield Problem(name, message)


def terrain_cropped(geometry: Geometry) -> Problems:
    """Check that the part that is computed lies in the DEM and has some cells."""
    if not isinstance(geometry, Terrain) or isinstance(geometry.crop, str):
        return
    grid = read_raster(Path(geometry.dem)).grid
    if geometry.crop is not None:
        west, south, east, north = geometry.crop
        if west >= east or south >= north:
            message = "must be its west, south, east and north border: west < east, south < north"
            yield Problem("geometry.crop", message, geometry.crop)
            return
        slack = 0.5 * grid.cell
        if min(west - grid.west, south - grid.south, grid.east - east, grid.north - north) < -slack:
            whole = format_extent((grid.west, grid.south, grid.east, grid.north))
            yield Problem("geometry.crop", f"not inside the DEM, {whole}", geometry.crop)
            return
    levels = geometry.levels
    if min(levels.grid.shape) < FEWEST_CELLS:
        message = (
            f"too small: {levels.grid.columns} by {levels.grid.rows} cells of {grid.cell:g} m, "
            f"which must be at least {FEWEST_CELLS} each way"
        )
        key = "geometry.dem" if geometry.crop is None else "geometry.crop"
        value = file_name(geometry.dem) if geometry.crop is None else geometry.crop
        yield Problem(key, message, value)
    elif not np.isfinite(levels.values).any():
        yield Problem("geometry.crop", "the DEM has no data there", geometry.crop)


def terrain_levels(geometry: Geometry) -> Problems:
    """Check that the elevations are plausible in meters."""
    if not isinstance(geometry, Terrain):
        return
    highest = float(np.nanmax(read_raster(Path(geometry.dem)).values))
    if highest > HIGHEST:
        message = (
            f"its highest level is {highest:.6g}, more than any ground in meters; convert feet or "
            "centimeters to meters"
        )
        yield Problem("geometry.dem", message, file_name(geometry.dem))


def terrain_surface(geometry: Geometry) -> Problems:
    """Check that the cells of the smooth surface are whole cells of the DEM."""
    if not isinstance(geometry, Terrain) or geometry.cell is None:
        return
    cell = read_raster(Path(geometry.dem)).grid.cell
    times = round(geometry.cell / cell)
    if times < 1 or not isclose(geometry.cell, times * cell, rel_tol=1e-6):
        message = f"must be a multiple of the cell of the DEM, {cell:g} m"
        yield Problem("geometry.cell", message, geometry.cell)


def releases_given(release: Releases) -> Problems:
    """Check that releases say in one way where they are, and by polygons that enclose."""
    for k, part in enumerate(release):
        if isinstance(part, PolygonRelease):
            yield from _given_once(f"release.{k}", part, ["file", "corners"])


def zones_given(zone: Zones) -> Problems:
    """Check that zones say in one way where they are, and by polygons that enclose."""
    for k, part in enumerate(zone):
        if (part.raster is None) != (part.value is None):
            message = "raster and value belong together; give both or none"
            yield Problem(f"zone.{k}", message)
        yield from _given_once(f"zone.{k}", part, ["file", "corners", "raster"])


def _given_once(key: str, part: PolygonRelease | Zone, ways: list[str]) -> Problems:
    given = [name for name in ways if getattr(part, name) is not None]
    if not given:
        yield Problem(key, f"does not say where it is: give {either(ways)}")
    for name in given[1:]:
        yield Problem(f"{key}.{name}", f"{key}.{given[0]} is given as well; leave one out")
    if part.corners is not None and (fault := _fault_of(part.corners)):
        yield Problem(f"{key}.corners", fault)


def _fault_of(corners: tuple[tuple[float, float], ...]) -> str:
    """Return what is wrong with the corners of a polygon; empty if nothing is."""
    shape = shapely.Polygon(corners)
    if shape.convex_hull.area <= FLAT * shape.length**2:
        return "encloses nothing: its corners lie on a line"
    if not shape.is_valid:
        _, _, where = shapely.is_valid_reason(shape).partition("[")
        return f"its sides cross or touch at ({where.rstrip(']').replace(' ', ', ')}) m"
    return ""


def zones_on_ground(geometry: Geometry, zone: Zones) -> Problems:
    """Check that zones lie on the terrain, at least in part."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    for k, part in enumerate(zone):
        if part.raster is not None:
            known = np.unique(read_raster(Path(part.raster)).values)
            known = known[np.isfinite(known)]
            if part.value not in known:
                some = ", ".join(f"{value:g}" for value in known[:8])
                more = ", ..." if len(known) > 8 else ""
                message = f"no cell of the raster has it; they have {some}{more}"
                yield Problem(f"zone.{k}.value", message, part.value)
        elif not outline(part).intersects(shapely.box(*geometry.crop)):
            key = f"zone.{k}." + ("corners" if part.file is None else "file")
            message = f"lies outside the terrain, {format_extent(geometry.crop)}"
            yield Problem(key, message, part.corners if part.file is None else file_name(part.file))


def zones_named(zone: Zones, obstacle: tuple[AnyObstacle, ...]) -> Problems:
    """Check that each zone has a name of its own, which no wall and no obstacle has."""
    known = dict.fromkeys(Walls.model_fields, "a wall")
    known |= {body.name: f"obstacle.{k}" for k, body in enumerate(obstacle)}
    for k, part in enumerate(zone):
        if part.name in known:
            message = f"is the name of {known[part.name]}; choose another one"
            yield Problem(f"zone.{k}.name", message, part.name)
        known.setdefault(part.name, f"zone.{k}")


def gravity_upright(geometry: Geometry, gravity: Gravity) -> Problems:
    """Check that gravity is along z where the slopes are those of the ground."""
    if not isinstance(geometry, Terrain) or gravity.components[0] == 0.0:
        return
    name = "slope" if gravity.vector is None else "vector"
    message = "a terrain has its own slopes, and z is upright; " + (
        "leave it out" if name == "slope" else "the first number must be 0"
    )
    yield Problem(f"gravity.{name}", message, getattr(gravity, name))


def terrain_of_surfaces(geometry: Geometry, scheme: AnyScheme) -> Problems:
    """Check that a terrain is not combined with walls of particles."""
    if isinstance(geometry, Terrain) and scheme.form == "study":
        message = "walls of particles are flat; on a terrain use 'stable'"
        yield Problem("scheme.form", message, scheme.form)


def terrain_origin(geometry: Geometry) -> Problems:
    """Check that lengths are measured from the corner of what is computed, and from below."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    west, south, _, _ = geometry.crop
    x, y, level = geometry.origin
    slack = 1e-3 * geometry.cell
    if abs(x - west) > slack or abs(y - south) > slack:
        message = (
            "its first two numbers must be the south-west corner of what is computed, "
            f"({place(west)}, {place(south)}); crop the DEM there"
        )
        yield Problem("geometry.origin", message, geometry.origin)
    lowest, highest = (float(end(geometry.levels.values)) for end in (np.nanmin, np.nanmax))
    if level >= lowest:
        message = f"its third number must be below the lowest ground, {lowest:.6g} m"
        yield Problem("geometry.origin", message, geometry.origin)
    if geometry.upper_level <= highest:
        message = f"must be above the highest ground, {highest:.6g} m"
        yield Problem("geometry.upper_level", message, geometry.upper_level)


def file_name(path: str) -> str:
    """Return the name of a file, which the case holds by its absolute path."""
    return Path(path).name


AS_ASKED: tuple[Callable[..., Problems], ...] = (
    terrain_alone,
    terrain_cropped,
    terrain_levels,
    terrain_surface,
    releases_given,
    zones_given,
)
CHECKS: tuple[Callable[..., Problems], ...] = (
    gravity_upright,
    terrain_of_surfaces,
    terrain_origin,
    zones_on_ground,
    zones_named,
)
