"""Checks of a terrain, its zones and what is set free on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import cos, isclose, radians, sin
from pathlib import Path

import numpy as np
import shapely

from debrisflow.case.hydrograph import faults_of
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.rasters import Raster, read_raster
from debrisflow.case.released import (
    area,
    depths,
    direction_down,
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
    Zone,
)
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import Geometry
from debrisflow.case.tables import AnyObstacle, AnyScheme, Gravity, Particles, Walls
from debrisflow.case.terrain import Box, Terrain
from debrisflow.case.words import either, place

Releases = tuple[AnyRelease, ...]
Zones = tuple[Zone, ...]

FEWEST_CELLS = 8  # of a terrain along each side
HIGHEST = 9000.0  # m, above all ground
DEEPEST = 100.0  # m, of a release
CELLS_TO_NODATA = 10  # of the DEM, from a release
FEWEST_PARTICLES = 30  # of a release
FEWEST_SPACINGS = 3  # of a line over which a flow enters
ALONG = 60.0  # degrees off the normal of a line, from which on a flow hardly crosses it
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
            message = (
                f"not inside the DEM, {_as_words((grid.west, grid.south, grid.east, grid.north))}"
            )
            yield Problem("geometry.crop", message, geometry.crop)
            return
    levels = geometry.levels
    if min(levels.grid.shape) < FEWEST_CELLS:
        message = (
            f"too small: {levels.grid.columns} by {levels.grid.rows} cells of {grid.cell:g} m, "
            f"which must be at least {FEWEST_CELLS} each way"
        )
        key = "geometry.dem" if geometry.crop is None else "geometry.crop"
        value = _name(geometry.dem) if geometry.crop is None else geometry.crop
        yield Problem(key, message, value)
    elif not np.isfinite(levels.values).any():
        yield Problem("geometry.crop", "the DEM has no data there", geometry.crop)


def terrain_levels(geometry: Geometry) -> Problems:
    """Check that the ground is as high as ground can be, in meters."""
    if not isinstance(geometry, Terrain):
        return
    highest = float(np.nanmax(read_raster(Path(geometry.dem)).values))
    if highest > HIGHEST:
        message = (
            f"its highest level is {highest:.6g}, more than any ground in meters; convert feet or "
            "centimeters to meters"
        )
        yield Problem("geometry.dem", message, _name(geometry.dem))


def terrain_surface(geometry: Geometry) -> Problems:
    """Check that the cells of the smooth surface are whole cells of the DEM."""
    if not isinstance(geometry, Terrain) or geometry.cell is None:
        return
    cell = read_raster(Path(geometry.dem)).grid.cell
    times = round(geometry.cell / cell)
    if times < 1 or not isclose(geometry.cell, times * cell, rel_tol=1e-6):
        message = f"must be a multiple of the cell of the DEM, {cell:g} m"
        yield Problem("geometry.cell", message, geometry.cell)


def shapes_given(release: Releases, zone: Zones) -> Problems:
    """Check that releases and zones say in one way where they are, and by polygons that enclose."""
    places: list[tuple[str, PolygonRelease | Zone]] = [
        (f"release.{k}", part) for k, part in enumerate(release) if isinstance(part, PolygonRelease)
    ]
    places += [(f"zone.{k}", part) for k, part in enumerate(zone)]
    for key, part in places:
        ways = ["file", "corners"]
        if isinstance(part, Zone):
            ways.append("raster")
            if (part.raster is None) != (part.value is None):
                yield Problem(key, "raster and value belong together; give both or none")
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
                    f"has depths of both signs, {least:.4g} to {most:.4g} m; leave only what is "
                    "set free"
                )
                yield Problem(f"release.{k}.file", message, _name(part.file))
            elif least == most == 0.0:
                yield Problem(f"release.{k}.file", "has no depth but 0", _name(part.file))


def hydrographs_in_order(release: Releases) -> Problems:
    """Check that the hydrographs of releases are in order and last for some time."""
    for k, part in enumerate(release):
        if not isinstance(part, HydrographRelease) or isinstance(part.hydrograph, str):
            continue
        key, graph = f"release.{k}.hydrograph", part.hydrograph
        yield from faults_of(graph, key)
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
                f"lies {how} outside the terrain: it reaches over {_as_words(shape.bounds)}, the "
                f"terrain over {_as_words(geometry.crop)}"
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
    return f"{key}.{name}", _name(value) if isinstance(value, str) else value


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
    """Check that a release is no elevation, and makes enough particles to be a flow."""
    if not isinstance(geometry, ResolvedTerrain):
        return
    for k, part in enumerate(release):
        if not isinstance(part, HydrographRelease) and (found := greatest_depth(part)) > DEEPEST:
            name = "depth" if isinstance(part, PolygonRelease) and part.depth else "volume"
            key = f"release.{k}." + ("file" if isinstance(part, RasterRelease) else name)
            message = (
                f"{found:.4g} m deep over {area(part):.4g} m2, more than {DEEPEST:g} m; a depth is "
                "measured from the ground, and is no elevation"
            )
            value = getattr(part, key.rpartition(".")[2])
            yield Problem(key, message, _name(value) if isinstance(value, str) else value)
            continue
        count = volume(part) / particles.spacing**3
        if count < FEWEST_PARTICLES:
            message = (
                f"too small: {volume(part):.3g} m3 make {count:.0f} particles, which must be at "
                f"least {FEWEST_PARTICLES}; particles.spacing = "
                f"{(volume(part) / FEWEST_PARTICLES) ** (1 / 3):.2g} would do"
            )
            yield Problem(f"release.{k}", message)


def water_without_grains(release: Releases) -> Problems:
    """Check that no concentration is given for water."""
    for k, part in enumerate(release):
        if not isinstance(part, HydrographRelease) and part.material == "water":
            for name in ("concentration", "pore_pressure"):
                if was_set(part, name):
                    message = "has no effect on the material 'water', only on 'mixture'"
                    yield Problem(f"release.{k}.{name}", message, getattr(part, name))


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
                message = "missing: the ground does not fall across the line; say to where it flows"
                yield Problem(key, message + " (degree)")
            continue
        (a, b), (c, d) = line
        east, north = sin(radians(part.direction)), cos(radians(part.direction))
        across = abs(east * (d - b) - north * (c - a)) / length_of(line)
        if across < cos(radians(ALONG)):
            message = (
                f"along the line rather than across it; within {ALONG:g} degrees of its normal is "
                "meant, clockwise from north"
            )
            yield Problem(key, message, part.direction)


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
            message = f"lies outside the terrain, {_as_words(geometry.crop)}"
            yield Problem(key, message, part.corners if part.file is None else _name(part.file))


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
    """Check that a terrain is not asked to be a wall of particles."""
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


def _name(path: str) -> str:
    """Return the name of a file, which the case holds by its absolute path."""
    return Path(path).name


def _as_words(box: Box | tuple[float, ...]) -> str:
    west, south, east, north = box
    return f"x = [{place(west)}, {place(east)}], y = [{place(south)}, {place(north)}] m"


AS_ASKED: tuple[Callable[..., Problems], ...] = (
    terrain_alone,
    terrain_cropped,
    terrain_levels,
    terrain_surface,
    shapes_given,
    amounts_given,
    hydrographs_in_order,
    lines_long,
)
CHECKS: tuple[Callable[..., Problems], ...] = (
    gravity_upright,
    terrain_of_surfaces,
    terrain_origin,
    releases_on_ground,
    releases_sized,
    water_without_grains,
    flows_across_line,
    zones_on_ground,
    zones_named,
)
