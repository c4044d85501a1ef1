"""The tables of releases on a terrain and of zones of friction."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Strict

from debrisflow.case.fields import NAME_PATTERN, NONE, Series, Table, Vector, quantity
from debrisflow.case.friction import Friction
from debrisflow.case.materials import pore_pressure_decay, pore_pressure_share

DISCHARGE = "m2/s or m3/s"  # in two or in three dimensions
POLYGONS = (
    "file of polygons, looked for beside the case: GeoJSON, or with the extra 'terrain' GeoPackage "
    "or Shapefile; instead of corners"
)
Corners = Annotated[tuple[Vector, ...], Strict(False), Field(min_length=3)]
Segment = Annotated[tuple[Vector, Vector], Strict(False)]


class Hydrograph(Table):
    """A supply that changes with time; linear between the rows."""

    time: Series = quantity("s", "times, increasing")
    discharge: Series = quantity(
        DISCHARGE, "discharge of sediment and water, in two dimensions per unit width"
    )
    concentration: Series = quantity(NONE, "volumetric sediment concentration of the supply")


def _name() -> Any:
    return quantity(NONE, "name by which messages refer to it", None, pattern=NAME_PATTERN)


def _start() -> Any:
    return quantity("s", "time of the release", 0.0, ge=0)


class Mass(Table):
    """Fields that all released masses share."""

    name: str | None = _name()
    place: Literal["on-terrain", "in-terrain"] = quantity(
        NONE,
        "on-terrain: placed on the ground of the DEM; in-terrain: taken out of it, so that the "
        "ground there is lower by the depth of the release from t = 0 on",
        "on-terrain",
    )
    start: float = _start()
    material: Literal["water", "mixture"] = quantity(
        NONE, "water; mixture (one kind of particle for sediment and water)", "mixture"
    )
    concentration: float | None = quantity(
        NONE,
        "volumetric sediment concentration of a mixture; mixture.concentration if left out",
        None,
        ge=0,
        lt=1,
    )
    velocity: Vector = quantity(
        "m/s", "initial velocity to the east and to the north; it follows the ground", (0.0, 0.0)
    )
    pore_pressure: float = pore_pressure_share()
    pore_pressure_time: float | None = pore_pressure_decay()


class PolygonRelease(Mass):
    """A mass of even depth over polygons on the map."""

    type: Literal["polygon"]
    file: str | None = quantity(NONE, POLYGONS, None)
    corners: Corners | None = quantity(
        "m", "corners on the map (easting, northing), one after the other around it", None
    )
    depth: float | None = quantity("m", "depth, measured vertically; instead of volume", None, gt=0)
    volume: float | None = quantity(
        "m3", "volume of all polygons of the file together; instead of depth", None, gt=0
    )


class RasterRelease(Mass):
    """A mass whose depth is that of a raster; cells without data have none."""

    type: Literal["raster"]
    file: str = quantity(
        NONE,
        "raster of the depth, m, measured vertically, looked for beside the case; a scar, whose "
        "depths are all negative, is taken for its size",
    )


class HydrographRelease(Table):
    """A flow over a straight line on the map; its depth follows from discharge and velocity."""

    name: str | None = _name()
    type: Literal["hydrograph"]
    line: Segment | str = quantity(
        "m",
        "two points on the map (easting, northing), or a file with one line of two points: "
        "GeoJSON, or with the extra 'terrain' GeoPackage or Shapefile",
    )
    direction: float | None = quantity(
        "degree",
        "to which it flows, clockwise from north; across the line and down the slope if left out",
        None,
        ge=-360,
        le=360,
    )
    hydrograph: Hydrograph | str = quantity(
        NONE,
        "table, or a CSV file beside the case with the columns time, discharge, concentration; its "
        "times count from start on",
    )
    velocity: float = quantity("m/s", "velocity at which it enters", gt=0)
    start: float = _start()
    pore_pressure: float = pore_pressure_share()
    pore_pressure_time: float | None = pore_pressure_decay()


AnyRelease = PolygonRelease | RasterRelease | HydrographRelease


class Zone(Table):
    """A part of the ground with a friction of its own; where zones overlap the later one counts."""

    name: str = quantity(
        NONE, "name of the zone, by which probes refer to it", pattern=NAME_PATTERN
    )
    file: str | None = quantity(NONE, POLYGONS, None)
    corners: Corners | None = quantity(
        "m", "corners on the map (easting, northing), one after the other around it", None
    )
    raster: str | None = quantity(
        NONE, "raster of classes, looked for beside the case; instead of file and corners", None
    )
    value: float | None = quantity(NONE, "class of the cells of the raster that are meant", None)
    friction: Friction = quantity(NONE, "law of the friction along the ground")
