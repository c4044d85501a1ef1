"""The bed from above, cut into cells, over which depth and deposit are measured (NumPy only)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle
from debrisflow.case.resolved import ResolvedTerrain
from debrisflow.case.shapes import is_three_dimensional, plain_of
from debrisflow.space.domain import domain
from debrisflow.space.floor import floor_level, height_over_floor, is_over_floor
from debrisflow.space.ground import ground_of

Floats = NDArray[np.float64]
CELL_WIDTH = 2.0  # spacings
# how tables name the place of a cell, and the words of their heads, by dimension
PLACE = {2: ("x",), 3: ("x", "y")}
PLACE_WORDS = {
    2: "x: m, along the bed; middle of a bin 2 spacings wide",
    3: "x, y: m, along the bed and across; middle of a cell 2 spacings wide",
}
FLOOR_WORDS = {
    2: "the fixed floor (under a bed: the bottom of its recess)",
    3: "the floor, or the top of an obstacle on it",
}


class Grid(NamedTuple):
    """Cells 2 d0 wide along x and, in three dimensions, along y; a last one may be narrower.

    Those of a terrain are those of its DEM that have a level.

    In two dimensions there is one cell across, 1 m wide, so that what is divided by the area of a
    cell is per meter of width.  Cells follow each other along y first.  Beside a channel that opens
    to a plain there are none.

    Attributes
    ----------
    along, across : (m + 1,) float64 array, m
        Edges of the cells.
    number : (m, k) int array
        Which cell is between these edges; -1 where there is none.
    x, y : (n,) float64 array, m
        Centers of the cells.
    area : (n,) float64 array, m2
    obstacle_height : (n,) float64 array, m
        Height by which obstacles raise the floor under the center.
    """

    along: Floats
    across: Floats
    number: NDArray[np.int64]
    x: Floats
    y: Floats
    area: Floats
    obstacle_height: Floats


class Located(NamedTuple):
    """The particles that are above the cells of a grid.

    Attributes
    ----------
    row : (k,) int array
        Which particles they are.
    cell : (k,) int array
        Number of the cell that each is in.
    height : (k,) float64 array, m
        Of its center over the floor under the center of the cell, along the floor's normal.
    """

    row: NDArray[np.int64]
    cell: NDArray[np.int64]
    height: Floats


def floor_length(case: ResolvedCase) -> float:
    """Return the extent of a tank or channel along x, m."""
    return case.geometry.length


def floor_ends(case: ResolvedCase, x: float, y: float) -> tuple[Floats, Floats]:
    """Return the ends of the floor along x and across that a place sees, (1,) or (2,) arrays, m."""
    shape, plain = case.geometry, plain_of(case.geometry)
    first, last = np.zeros(2), np.array([floor_length(case), np.inf])
    if is_three_dimensional(shape):
        last[1] = shape.width
    if plain is not None:
        if x > plain.start:
            first[1], last[1] = plain.front, plain.back
        if not 0.0 <= y <= plain.mouth:
            first[0] = plain.start
    return first[: case.dimension - 1], last[: case.dimension - 1]


def floor_extent(case: ResolvedCase) -> Floats:
    """Return the ends of the floor of three dimensions along x and y, (2, 2) array, m."""
    shape, plain = case.geometry, plain_of(case.geometry)
    if not is_three_dimensional(shape):
        raise TypeError("a floor extends across in three dimensions only")
    across = (plain.front, plain.back) if plain else (0.0, shape.width)
    return np.array([(0.0, floor_length(case)), across])


def wrapped(case: ResolvedCase, position: Floats) -> Floats:
    """Return positions brought back into the first period of a case that repeats, (n, 3), m."""
    period = domain(case).period
    inside = np.array(position, dtype=float)
    for axis in np.flatnonzero(period > 0.0):
        inside[:, axis] = np.mod(inside[:, axis], period[axis])
    return inside


def plan(case: ResolvedCase) -> Grid:
    """Return the cells of a case; of a terrain those of its DEM.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> from debrisflow.case import shapes
    >>> tank = shapes.Tank3D(type="tank3d", length=1.0, width=0.5, height=1.0)
    >>> grid = plan(Case(geometry=tank, obstacle=(), particles=Case(spacing=0.125)))
    >>> grid.x
    array([0.125, 0.125, 0.375, 0.375, 0.625, 0.625, 0.875, 0.875])
    >>> grid.y[:2], grid.area[:2]
    (array([0.125, 0.375]), array([0.0625, 0.0625]))
    """
    shape, d0 = case.geometry, case.particles.spacing
    if isinstance(shape, ResolvedTerrain):
        return _plan_of_terrain(case)
    along = _edges(floor_length(case), d0)
    across = _edges(shape.width, d0) if is_three_dimensional(shape) else np.array([-0.5, 0.5])
    plain = plain_of(shape)
    if plain is not None:
        # cells end at the mouth and at its sides
        start, beside = plain.start, _edges(-plain.front, d0)
        along = np.append(_edges(start, d0)[:-1], start + _edges(floor_length(case) - start, d0))
        across = np.concatenate([-beside[:0:-1], across[:-1], plain.mouth + beside])
    x, y = np.meshgrid(
        *(0.5 * (edges[:-1] + edges[1:]) for edges in (along, across)), indexing="ij"
    )
    floor = is_over_floor(case, x, y)
    number = np.where(floor, np.cumsum(floor).reshape(floor.shape) - 1, -1)
    area = np.outer(np.diff(along), np.diff(across))
    raised = _obstacle_height(case, x[floor], y[floor])
    return Grid(along, across, number, x[floor], y[floor], area[floor], raised)


def _plan_of_terrain(case: ResolvedCase) -> Grid:
    ground = ground_of(case)
    cell, shape = ground.grid.cell, ground.given.shape
    along, across = (np.arange(count + 1) * cell for count in shape)
    known = np.isfinite(ground.given)
    number = np.where(known, np.cumsum(known).reshape(shape) - 1, -1)
    x, y = np.meshgrid(*(edges[:-1] + 0.5 * cell for edges in (along, across)), indexing="ij")
    count = int(known.sum())
    return Grid(
        along, across, number, x[known], y[known], np.full(count, cell * cell), np.zeros(count)
    )


def cell_level(case: ResolvedCase, grid: Grid) -> Floats:
    """Return the level of the floor under the center of each cell, or of an obstacle's top, m."""
    return floor_level(case, grid.x, grid.y) + grid.obstacle_height


def locate(case: ResolvedCase, grid: Grid, position: Floats) -> Located:
    """Return which particles are above the cells, in which cell, and how high.

    Parameters
    ----------
    position : (n, 3) array, m
    """
    up = case.dimension - 1
    place = wrapped(case, position)
    x, y = place[:, 0], place[:, 3 - up]
    within = (x >= 0.0) & (x < grid.along[-1]) & (y >= grid.across[0]) & (y < grid.across[-1])
    row = np.flatnonzero(within)
    column = np.searchsorted(grid.along, x[row], side="right") - 1
    cell = grid.number[column, np.searchsorted(grid.across, y[row], side="right") - 1]
    row, cell = row[cell >= 0], cell[cell >= 0]
    height = height_over_floor(case, x[row], place[row, up], grid.x[cell], y[row])
    return Located(row, cell, height - grid.obstacle_height[cell])


def _edges(length: float, d0: float) -> Floats:
    # the last cell of an odd number of spacings is narrower; rounding must not make one of nothing
    return np.append(np.arange(0.0, length - 1e-6 * d0, CELL_WIDTH * d0), length)


def _obstacle_height(case: ResolvedCase, x: Floats, y: Floats) -> Floats:
    """Return the height of the boxes that stand on the floor or on each other, m.

    What hangs over the floor, as a bridge, raises it not: flow passes under it.  Nor does what
    moves, or a mesh.
    """
    d0 = case.particles.spacing
    height = np.zeros_like(x)
    boxes = [p for p in case.obstacle if isinstance(p, BoxObstacle) and p.motion is None]
    for box in sorted(boxes, key=lambda box: box.extents[-1][0]):
        inside, (foot, top) = np.ones(x.size, dtype=bool), box.extents[-1]
        for value, (start, end) in zip((x, y), box.extents[:-1], strict=False):
            place = value + 1e-6 * d0  # centers may lie on the sides
            inside &= (place >= start) & (place < end)
        stands = inside & (height >= foot - 0.5 * d0)
        height[stands] = np.maximum(height[stands], top)
    return height
