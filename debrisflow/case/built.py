"""What is built of the lengths that a case asks for: walls and fills lie on the lattice.

The inner walls of the space, the extents of fills and the section of the supply become multiples
of the spacing, nearest to what is asked; what touches a wall as asked touches it as built.  Boxes
of wall keep their places where walls are surfaces.  Building what is built changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil, floor, inf, isfinite
from typing import Any, NamedTuple, TypeVar

from debrisflow.case.bodies import PolygonObstacle
from debrisflow.case.fields import Interval, Table
from debrisflow.case.problems import locate, named, unit_of
from debrisflow.case.regions import TOLERANCE, bed_end, least_period, section_of_supply
from debrisflow.case.resolved import ResolvedCase
from debrisflow.case.shapes import Channel3D, Geometry, Tank, Tank3D
from debrisflow.case.tables import Inflow, Particles
from debrisflow.case.terrain import Terrain
from debrisflow.case.terrain_built import built_terrain

DIGITS = 12  # significant ones of a length that is built, so that it reads as people write it
LARGEST_MISFIT = 0.1  # of a length, between what is asked and what is built
MUST_STAND = ("length", "width", "height", "bed_thickness", "weir_height")
EXTENTS = ("x", "y", "z", "across")
PLACES = ("bed_start", "bed_end", "runout_start")
_Shape = TypeVar("_Shape", bound=Table)
Planes = list[tuple[float, float]]  # along an axis, m: where walls are asked for, and built


class Rounded(NamedTuple):
    """A number of a case that is built otherwise than asked.

    Attributes
    ----------
    key : str
    asked, built : float
    unit : str
        With a blank before it.
    whole : float
        Of which the difference is told as a share: of the ends of an extent its length, else what
        is asked.
    """

    key: str
    asked: float
    built: float
    unit: str
    whole: float

    def __str__(self) -> str:
        """Return a row of the table that a check prints."""
        asked, built = (f"{value:.6g}{self.unit}" for value in (self.asked, self.built))
        share = (self.built - self.asked) / self.whole
        return f"{self.key:<22} {asked:>15} {built:>15} {share:>+11.1%}"


HEAD = f"{'built to the spacing':<22} {'asked':>15} {'built':>15} {'difference':>11}"


def as_built(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of the tables of a case that are built otherwise, as they are built.

    Parameters
    ----------
    tables : mapping of str to table
        By name; nothing is built without ``geometry`` and ``particles``.
    """
    if not {"geometry", "particles"} <= set(tables):
        return {}
    asked, particles = tables["geometry"], tables["particles"]
    if isinstance(asked, Terrain):
        ground = built_terrain(asked, particles, tables.get("release", ()))
        return {} if ground == asked else {"geometry": ground}
    shape = _geometry(asked, particles)
    both = {
        axis: list(zip(places, walls_along(shape, particles)[axis], strict=True))
        for axis, places in walls_along(asked, particles).items()
    }
    are_surfaces = getattr(tables.get("scheme"), "form", "stable") == "stable"
    found: dict[str, Any] = {"geometry": shape}
    if "fill" in tables:
        found["fill"] = tuple(_extents(part, both, particles, True) for part in tables["fill"])
    if "obstacle" in tables:
        found["obstacle"] = tuple(
            _corners(body, both, particles)
            if isinstance(body, PolygonObstacle)
            else _extents(body, both, particles, not are_surfaces)
            for body in tables["obstacle"]
        )
    if tables.get("inflow") is not None:
        found["inflow"] = _inflow(tables["inflow"], both, asked, shape, particles)
    return {name: table for name, table in found.items() if table != tables[name]}


def roundings(case: ResolvedCase) -> list[Rounded]:
    """Return the numbers of a case that are built otherwise than asked, in the order of the file.

    None of a case that is read back from a run.
    """
    if case.asked is None or isinstance(case.geometry, Terrain):
        return []
    return [
        row._replace(key=named(row.key, dict(case)))
        for name in ("geometry", "obstacle", "fill", "inflow")
        for row in _differences(name, getattr(case.asked, name), getattr(case, name))
    ]


def _differences(key: str, asked: Any, built: Any, whole: float | None = None) -> Iterator[Rounded]:
    if isinstance(asked, Table):
        for name, value in asked:
            length = value[1] - value[0] if name in EXTENTS and isinstance(value, tuple) else None
            yield from _differences(f"{key}.{name}", value, getattr(built, name), length)
    elif isinstance(asked, tuple):
        for k, (one, other) in enumerate(zip(asked, built, strict=True)):
            yield from _differences(f"{key}.{k}", one, other, whole)
    elif isinstance(asked, float) and abs(built - asked) > 1e-9 * abs(asked):
        unit = unit_of(locate(key.split(".")).field)
        yield Rounded(key, asked, built, unit, whole or asked)


def on_lattice(length: float, spacing: float) -> float:
    """Return the multiple of the spacing that is nearest to a length, m; halves are rounded up.

    Examples
    --------
    >>> on_lattice(0.146, 0.01), on_lattice(0.25, 0.1), on_lattice(0.3, 0.1)
    (0.15, 0.3, 0.3)
    """
    count = length / spacing
    if not isfinite(count):
        return length
    whole = floor(count + 0.5 + TOLERANCE)
    return length if abs(count - whole) <= TOLERANCE else _multiple(whole, spacing)


def _multiple(count: int, spacing: float) -> float:
    return float(f"{count * spacing:.{DIGITS}g}")


def enough(length: float, spacing: float) -> float:
    """Return the greatest spacing, m, not above a given one, of which a length is a multiple."""
    return length / max(ceil(length / spacing - TOLERANCE), 1)


def _geometry(shape: Geometry, particles: Particles) -> Geometry:
    """Return a space whose walls lie on the lattice."""
    d0, found = particles.spacing, {}
    for name in (*MUST_STAND, *PLACES):
        asked = getattr(shape, name, None)
        if asked is None:
            continue
        found[name] = on_lattice(asked, d0)
        if name in MUST_STAND and asked > 0.0 and found[name] < 0.5 * d0:
            found[name] = d0
    if shape.periodic:
        name = "width" if isinstance(shape, Tank3D) else "length"
        least = least_period(particles)
        if found[name] < least <= getattr(shape, name):
            found[name] = _multiple(ceil(least / d0 - TOLERANCE), d0)
    return _changed(shape, found)


def walls_along(shape: Geometry, particles: Particles) -> dict[str, list[float]]:
    """Return where along each axis there are walls, m."""
    if isinstance(shape, Terrain):
        return {}
    if isinstance(shape, Tank):
        return {"x": [0.0, shape.length], "y": [0.0, shape.height]}
    if isinstance(shape, Tank3D):
        return {"x": [0.0, shape.length], "y": [0.0, shape.width], "z": [0.0, shape.height]}
    along, up = [0.0, shape.length], [0.0, shape.height]
    if shape.bed_thickness > 0.0:
        along.append(shape.bed_start)
        up.append(-shape.bed_thickness)
    if shape.weir_height > 0.0:
        up.append(shape.weir_height)
    if shape.bed_thickness > 0.0 or shape.weir_height > 0.0:
        along.append(bed_end(shape, particles))
    if shape.runout_start is not None:
        along.append(shape.runout_start)
    if isinstance(shape, Channel3D):
        return {"x": along, "y": [0.0, shape.width], "z": up}
    return {"x": along, "y": up}


def _extents(
    part: _Shape, walls: Mapping[str, Planes], particles: Particles, follows: bool
) -> _Shape:
    """Return a fill or an obstacle whose extents along the axes are built."""
    found = {}
    for axis, planes in walls.items():
        extent = getattr(part, axis, None)
        if isinstance(extent, tuple):
            build = _cells if follows else _between_walls
            found[axis] = build(extent, planes, particles.spacing)
    return _changed(part, found)


def _corners(
    polygon: PolygonObstacle, walls: Mapping[str, Planes], particles: Particles
) -> PolygonObstacle:
    """Return a polygon whose corners at walls are at these as built."""
    corners = tuple(
        tuple(
            _beside(at, at, planes, particles.spacing)
            for at, planes in zip(corner, walls.values(), strict=False)
        )
        for corner in polygon.corners
    )
    return _changed(polygon, {"corners": corners})


def _cells(extent: Interval, planes: Planes, d0: float) -> Interval:
    """Return an extent of whole cells, one at least."""
    start, end = (_beside(at, on_lattice(at, d0), planes, d0) for at in extent)
    if extent[0] >= extent[1] or end - start > 0.5 * d0:
        return start, end
    if 0.5 * (extent[0] + extent[1]) < start:
        return on_lattice(start - d0, d0), start
    return start, on_lattice(start + d0, d0)


def _between_walls(extent: Interval, planes: Planes, d0: float) -> Interval:
    """Return the extent of a body whose ends are where they are asked, and at walls with these.

    A thin body at a wall goes with it as a whole.
    """
    start, end = (_beside(at, at, planes, d0) for at in extent)
    length = extent[1] - extent[0]
    if abs(end - start - length) > LARGEST_MISFIT * length:
        if end == extent[1]:
            end = start + length
        elif start == extent[0]:
            start = end - length
    return start, end


def _beside(asked: float, place: float, planes: Planes, d0: float) -> float:
    """Return a place on that side of every wall on which it is asked; on a wall if it is there."""
    for wall, built in planes:
        if abs(asked - wall) <= TOLERANCE * d0:
            return asked if abs(asked - built) <= TOLERANCE * d0 else built
    lower = max((built for wall, built in planes if wall < asked), default=-inf)
    upper = min((built for wall, built in planes if wall > asked), default=inf)
    return min(max(place, lower), upper)


def _inflow(
    inflow: Inflow,
    walls: Mapping[str, Planes],
    asked: Geometry,
    shape: Geometry,
    particles: Particles,
) -> Inflow:
    """Return a supply through whole cells, which brings what is asked: its velocity follows."""
    d0 = particles.spacing
    found: dict[str, Any] = {"depth": max(on_lattice(inflow.depth, d0), d0)}
    if abs(found["depth"] - inflow.depth) <= TOLERANCE * d0:
        found["depth"] = inflow.depth
    if inflow.across is not None and isinstance(shape, Channel3D):
        found["across"] = _cells(inflow.across, walls["y"], d0)
    built = _changed(inflow, found)
    before, after = section_of_supply(inflow, asked), section_of_supply(built, shape)
    if inflow.velocity is None or abs(after - before) <= TOLERANCE * before or after <= 0.0:
        return built
    discharge = inflow.discharge or inflow.velocity * before
    return _changed(built, {"discharge": discharge, "velocity": discharge / after})


def _changed(table: _Shape, found: Mapping[str, Any]) -> _Shape:
    """Return a table with other values; the same where none differs."""
    differs = {name: value for name, value in found.items() if value != getattr(table, name)}
    return table.model_copy(update=differs) if differs else table
