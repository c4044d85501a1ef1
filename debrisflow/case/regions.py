"""What fills, bed and obstacles cover, as far as the case file and its meshes tell."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise
from math import prod, radians, tan
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from debrisflow.case.bodies import BoxObstacle, MeshFill, MeshObstacle, PolygonObstacle
from debrisflow.case.resolved import MappedTerrain, ResolvedTerrain
from debrisflow.case.shapes import (
    Channel3D,
    ChannelShape,
    Geometry,
    Tank,
    Tank3D,
    is_three_dimensional,
)
from debrisflow.case.tables import AnyFill, AnyObstacle, Bed, Block, Gravity, Inflow, Particles
from debrisflow.case.terrain import Terrain
from debrisflow.case.triangles import Surface, cells_inside, read_surface
from debrisflow.case.words import place

WEIR_SPACINGS = 4
# Share of a spacing by which a length may miss a multiple of it, for round-off in decimals.
TOLERANCE = 1e-6
# The same for a mesh, whose file may hold no more than seven digits.
MESH_SLACK = 1e-3
# Spacings by which a wall on the lattice may lie beside the place that is asked.
WALL_SHIFT = 0.5
# Cells of the box around a mesh up to which it is drawn at the door, within a gigabyte.
MOST_CELLS = 2e7


class Region(NamedTuple):
    """An upright rectangle or box, m: its lower and upper end along each axis."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @property
    def volume(self) -> float:
        """Area, m2, or volume, m3; 0 where an interval is turned around."""
        return prod(max(b - a, 0.0) for a, b in zip(self.lower, self.upper, strict=True))

    def overlap(self, other: Region) -> Region:
        """Return what two regions share; its volume is 0 if that is nothing."""
        return Region(
            tuple(map(max, self.lower, other.lower)), tuple(map(min, self.upper, other.upper))
        )

    def shrunk(self, margin: float) -> Region:
        """Return the region less a margin on every side."""
        return Region(tuple(a + margin for a in self.lower), tuple(b - margin for b in self.upper))

    def holds(self, other: Region) -> bool:
        """Tell whether the other region lies within this one."""
        return self.overlap(other) == other

    def __str__(self) -> str:
        """Return the extents as in a case file."""
        ends = zip("xyz", self.lower, self.upper, strict=False)
        return ", ".join(f"{axis} = [{place(a)}, {place(b)}] m" for axis, a, b in ends)


def bed_end(geometry: ChannelShape, particles: Particles) -> float:
    """Return the x at which the recess ends, m: given, or a weir before the run-out or the end."""
    if geometry.bed_end is not None:
        return geometry.bed_end
    if geometry.periodic:
        return geometry.length
    end = geometry.length if geometry.runout_start is None else geometry.runout_start
    # Rounded to picometers so that 7 - 4 * 0.02 is written as 6.92.
    return round(end - WEIR_SPACINGS * particles.spacing, 12)


def least_period(particles: Particles) -> float:
    """Return the least length over which a space may repeat, m, so that it does not see itself."""
    return 3 * (particles.effective_radius + 1) * particles.spacing


def runout_rise(geometry: ChannelShape, gravity: Gravity) -> float:
    """Return the level of the far end of a run-out, m; 0 without one."""
    if geometry.runout_start is None:
        return 0.0
    bend = gravity.fall - radians(geometry.runout_slope)
    return (geometry.length - geometry.runout_start) * tan(bend)


def recess(geometry: Geometry, particles: Particles) -> Region | None:
    """Return the recess of a channel, None where there is none."""
    if not isinstance(geometry, ChannelShape) or geometry.bed_thickness == 0:
        return None
    end = bed_end(geometry, particles)
    return _across(Region((geometry.bed_start, -geometry.bed_thickness), (end, 0.0)), geometry)


def _across(section: Region, geometry: ChannelShape) -> Region:
    """Return a rectangle of the section along a channel, in three dimensions over its width."""
    if not isinstance(geometry, Channel3D):
        return section
    (start, bottom), (end, top) = section.lower, section.upper
    return Region((start, 0.0, bottom), (end, geometry.width, top))


def extent_across(inflow: Inflow, geometry: Channel3D) -> tuple[float, float]:
    """Return the extent of a supply along y, m: given, or the whole width."""
    return inflow.across or (0.0, geometry.width)


def section_of_supply(inflow: Inflow, geometry: Geometry) -> float:
    """Return the area through which a supply comes, m2; in two dimensions its depth, m."""
    if not isinstance(geometry, Channel3D):
        return inflow.depth
    start, end = extent_across(inflow, geometry)
    return inflow.depth * (end - start)


def surface_of(part: MeshFill | MeshObstacle) -> Surface:
    """Return the surface of a mesh where the case puts it."""
    return read_surface(Path(part.file)).placed(part.scale, part.offset)


def covered(part: AnyFill, geometry: Geometry, particles: Particles) -> Region | None:
    """Return what a fill covers, of a mesh the box around it; None where it has no place.

    That is a bed without a recess, or a mesh in two dimensions.  A block in three dimensions that
    states no z covers nothing.
    """
    if isinstance(part, Bed):
        return recess(geometry, particles)
    if isinstance(part, MeshFill):
        return occupied(part) if is_three_dimensional(geometry) else None
    extents = [part.x, part.y]
    if is_three_dimensional(geometry):
        extents.append(part.z or (0.0, 0.0))
    return Region(tuple(e[0] for e in extents), tuple(e[1] for e in extents))


def occupied(part: AnyObstacle | MeshFill) -> Region:
    """Return the extents of an obstacle, or of what a mesh fills."""
    if isinstance(part, MeshFill | MeshObstacle):
        surface = surface_of(part)
        return Region(tuple(surface.lower.tolist()), tuple(surface.upper.tolist()))
    extents = list(part.extents)
    if isinstance(part, BoxObstacle) and part.turn != 0.0:
        extents[:2] = ((min(ends), max(ends)) for ends in zip(*part.corners_in_plan, strict=True))
    return Region(tuple(e[0] for e in extents), tuple(e[1] for e in extents))


def boxes_among(obstacle: Sequence[AnyObstacle], dimension: int) -> list[Region]:
    """Return the extents of the obstacles that are boxes and have the dimension of the space."""
    boxes = [occupied(body) for body in obstacle if isinstance(body, BoxObstacle)]
    return [region for region in boxes if len(region.lower) == dimension]


def lattice_points(mesh: MeshFill | MeshObstacle, particles: Particles) -> NDArray[np.int64] | None:
    """Return the cells whose centers a mesh encloses, None where they are too many.

    Then the check of the memory, which is made before any array, shall speak.
    """
    box = occupied(mesh)
    sides = ((b - a) / particles.spacing for a, b in zip(box.lower, box.upper, strict=True))
    if prod(max(side, 1.0) for side in sides) > MOST_CELLS:  # also of a flat mesh
        return None
    return cells_inside(surface_of(mesh), particles.spacing)


def shared_space(
    bodies: tuple[AnyFill | AnyObstacle, AnyFill | AnyObstacle], both: Region, particles: Particles
) -> Region | None:
    """Return in which region two bodies, whose extents share a region, overlap, or None.

    Meshes overlap where they enclose the center of a cell.
    """
    if both.shrunk(TOLERANCE * particles.spacing).volume <= 0:
        return None
    if any(isinstance(body, PolygonObstacle) for body in bodies):
        one, other = (_outline(body) for body in bodies)
        return _shared_area(one, other, particles)
    turned = [body for body in bodies if isinstance(body, BoxObstacle) and body.turn != 0.0]
    if turned and all(isinstance(body, BoxObstacle) for body in bodies):
        one, other = (_outline(body) for body in bodies)
        return _shared_area(one, other, particles)
    within: list[NDArray[np.int64]] = []
    for mesh in bodies:
        if isinstance(mesh, MeshFill | MeshObstacle):
            cells = lattice_points(mesh, particles)
            if cells is None:
                return None
            center = (cells + 0.5) * particles.spacing
            inside = np.all((center > both.lower) & (center < both.upper), axis=1)
            for box in turned:
                inside &= shapely.contains_xy(_outline(box), center[:, 0], center[:, 1])
            within.append(cells[inside])
    if not within:
        return both
    cells, times = np.unique(np.concatenate(within), axis=0, return_counts=True)
    shared = cells[times == len(within)] * particles.spacing
    if not len(shared):
        return None
    lower, upper = shared.min(axis=0), shared.max(axis=0) + particles.spacing
    return Region(tuple(lower.tolist()), tuple(upper.tolist()))


def area_left(region: Region, bodies: Sequence[Region | PolygonObstacle]) -> float:
    """Return the area of a region in two dimensions outside of bodies, m2."""
    holes = [
        _outline(body)
        if isinstance(body, PolygonObstacle)
        else shapely.box(*body.lower, *body.upper)
        for body in bodies
    ]
    space = shapely.box(*region.lower, *region.upper)
    return float(space.difference(shapely.union_all(holes)).area)


def _outline(body: AnyFill | AnyObstacle) -> shapely.Polygon:
    """Return a body of two dimensions, or a box as seen from above, as a polygon."""
    if isinstance(body, PolygonObstacle):
        return shapely.Polygon(body.corners)
    if isinstance(body, BoxObstacle):
        return shapely.Polygon(body.corners_in_plan)
    if isinstance(body, Block):
        return shapely.box(body.x[0], body.y[0], body.x[1], body.y[1])
    raise TypeError(f"a {body.type} has no outline")


def _shared_area(
    one: shapely.Polygon, other: shapely.Polygon, particles: Particles
) -> Region | None:
    """Return the box around what two polygons share, None where they only touch."""
    shared = one.intersection(other)
    if shared.area <= TOLERANCE * particles.spacing**2:
        return None
    x0, y0, x1, y1 = shared.bounds
    return Region((x0, y0), (x1, y1))


def volume_left(regions: Sequence[Region], holes: Sequence[Region]) -> float:
    """Return the area, m2, or volume, m3, of regions together, without holes.

    Examples
    --------
    >>> square, half = Region((0.0, 0.0), (2.0, 2.0)), Region((1.0, 0.0), (3.0, 2.0))
    >>> volume_left([square, half], []), volume_left([square], [half])
    (6.0, 2.0)
    """
    if not regions:
        return 0.0
    ends = np.array([(region.lower, region.upper) for region in (*regions, *holes)])
    cuts = [np.unique(ends[:, :, axis]) for axis in range(ends.shape[2])]
    sides = _cells_between(cuts[1:])
    total = 0.0
    for start, end in pairwise(cuts[0]):  # a slab at a time, which bounds the memory
        inside = np.zeros(sides.shape, dtype=bool)
        for k in np.flatnonzero((ends[:, 0, 0] <= start) & (ends[:, 1, 0] >= end)):
            found = zip(cuts[1:], *ends[k, :, 1:], strict=True)
            inside[tuple(slice(*np.searchsorted(cut, (a, b))) for cut, a, b in found)] = k < len(
                regions
            )
        total += float((end - start) * sides[inside].sum())
    return total


def _cells_between(cuts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the areas, or lengths, of the cells between cuts along one or two axes."""
    return reduce(np.multiply.outer, [np.diff(cut) for cut in cuts])


def open_space(geometry: Geometry, particles: Particles) -> list[Region]:
    """Return the regions in which a fill or an obstacle may lie, each on its own.

    A block over the weir starts at its crest; one that also fills the recess stays between its
    steps.
    """
    if isinstance(geometry, Terrain):
        return [_extents_of(geometry)] if isinstance(geometry, ResolvedTerrain) else []
    if isinstance(geometry, Tank3D):
        return [Region((0.0, 0.0, 0.0), (geometry.length, geometry.width, geometry.height))]
    if isinstance(geometry, Tank):
        return [Region((0.0, 0.0), (geometry.length, geometry.height))]
    crest = 0.0 if geometry.periodic else geometry.weir_height
    end = bed_end(geometry, particles) if crest > 0 else geometry.length
    spaces = [
        _across(Region((0.0, 0.0), (end, geometry.height)), geometry),
        _across(Region((0.0, crest), (geometry.length, geometry.height)), geometry),
    ]
    hollow = recess(geometry, particles)
    if hollow is not None:
        spaces.append(Region(hollow.lower, (*hollow.upper[:-1], geometry.height)))
    return spaces


def _extents_of(terrain: ResolvedTerrain) -> Region:
    """Return the space over a terrain, on the map where its lengths are."""
    if isinstance(terrain, MappedTerrain):
        west, south, east, north = terrain.crop
        return Region((west, south, terrain.origin[2]), (east, north, terrain.upper_level))
    return Region((0.0, 0.0, 0.0), (terrain.length, terrain.width, terrain.height))
