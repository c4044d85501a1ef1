"""The table of a terrain: the ground of a digital elevation model."""

from __future__ import annotations

from math import ceil, floor
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Strict

from debrisflow.case.fields import NONE, Point, Table, quantity
from debrisflow.case.rasters import MapGrid, Raster, read_raster
from debrisflow.case.vectors import Polygons, read_polygons

ON_BORDER = 1e-6  # of a cell, within which a place is on its border
Box = Annotated[tuple[float, float, float, float], Strict(False)]


class Terrain(Table):
    """The ground of a digital elevation model (DEM); x is east, y is north and z is up.

    All edges are open: what passes them leaves the computation.  Places of obstacles and probes are
    coordinates of the map, and levels those of the DEM, unless ``origin`` is given; releases and
    zones are always on the map.
    """

    type: Literal["terrain"]
    dem: str = quantity(
        NONE,
        "elevation model in meters, looked for beside the case: an ESRI ASCII grid, or with the "
        "extra 'terrain' GeoTIFF",
    )
    crop: Box | str | None = quantity(
        "m",
        "part that is computed: its west, south, east and north border, or a file of polygons that "
        "it is to hold; all of the DEM if left out",
        None,
    )
    cell: float | None = quantity(
        "m",
        "cell of the smooth surface through the DEM, a multiple of the cell of the DEM; the least "
        "that is three spacings or more if left out",
        None,
        gt=0,
    )
    upper_level: float | None = quantity(
        "m",
        "elevation at which the computed space ends; 50 spacings, and at least 20 m, above the "
        "highest ground if left out",
        None,
    )
    origin: Point | None = quantity(
        "m",
        "place on the map, the south-west corner of what is computed, and elevation from which x, "
        "y, z are measured; found, with an elevation below all ground, if left out",
        None,
    )

    @property
    def periodic(self) -> bool:
        """Whether the space repeats, which a terrain never does."""
        return False

    @property
    def levels(self) -> Raster:
        """The levels of the DEM, m, of the part that is computed."""
        raster = read_raster(Path(self.dem))
        box = self.crop
        if isinstance(box, str):
            box = cells_around(bounds(read_polygons(Path(box))), raster.grid)
        return raster if box is None else raster.cropped(*box)

    @property
    def box(self) -> Box:
        """West, south, east and north border of the cells that are computed, m."""
        grid = self.levels.grid
        return grid.west, grid.south, grid.east, grid.north

    @property
    def length(self) -> float:
        """Extent along x, m."""
        return round(self.box[2] - self.box[0], 6)

    @property
    def width(self) -> float:
        """Extent along y, m."""
        return round(self.box[3] - self.box[1], 6)


def bounds(polygons: Polygons) -> Box:
    """Return the box around polygons: west, south, east and north border, m."""
    west, south, east, north = zip(*(shape.bounds for shape in polygons.shapes), strict=True)
    return min(west), min(south), max(east), max(north)


def cells_around(box: Box, grid: MapGrid) -> Box:
    """Return the borders of the cells of a grid that hold a box, m.

    A box that reaches over the edge of the grid by less than half a cell is cut there.

    Examples
    --------
    >>> grid = MapGrid(100.0, 0.0, 10.0, columns=5, rows=4)
    >>> cells_around((114.0, 20.0, 121.0, 43.0), grid)
    (110.0, 20.0, 130.0, 40.0)
    """
    found = []
    for start, count, low, high in (
        (grid.west, grid.columns, box[0], box[2]),
        (grid.south, grid.rows, box[1], box[3]),
    ):
        first, last = (low - start) / grid.cell, (high - start) / grid.cell
        first = floor(first + ON_BORDER) if first >= 0.0 else round(first)
        last = ceil(last - ON_BORDER) if last <= count else round(last)
        found.append((start + first * grid.cell, start + last * grid.cell))
    (west, east), (south, north) = found
    return west, south, east, north
