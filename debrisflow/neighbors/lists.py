"""Neighbor lists: who is within the influence radius, kept over several steps by a skin."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.pairs import repeats_of, to_nearest_image

Floats = NDArray[np.float64]
SKIN = 0.4
AXES = (0, 2, 1)  # cells that follow along y follow in memory, in two dimensions and in three
PIECE = 128
FINE = 4


class Cells(NamedTuple):
    """Points sorted into cells as wide as the list radius or a little wider.

    Along y, in which cells follow each other in memory, they are a quarter as wide where the domain
    does not repeat along it: the particles within reach of a cell then stand in rows that are a
    fourth shorter.

    Attributes
    ----------
    position : (3, n) float64 array, m
        Of the points, in the order of their cells.
    order : (n,) int32 array
        Numbers of the points in that order.
    start : (cells + 1,) int64 array
        First point of each cell.
    lower, width : (3,) float64 array, m
    shape : (3,) int64 array
    reach : int
        Cells along y that the radius spans.
    periodic : (3,) bool array
    period : (2, 3) float64 array, m, 1/m, or None
        See :class:`debrisflow.neighbors.pairs.Near`.
    """

    position: Floats
    order: NDArray[np.int32]
    start: NDArray[np.int64]
    lower: Floats
    width: Floats
    shape: NDArray[np.int64]
    reach: int
    periodic: NDArray[np.bool_]
    period: Floats | None


def sort_into_cells(position: Floats, radius: float, period: Floats) -> Cells:
    """Return points, (n, 3) float64 array, m, sorted into cells for a list radius, m."""
    periodic = period > 0.0
    columns = position.T if len(position) else np.zeros((3, 1))
    lower = np.array([column.min() for column in columns])
    upper = np.array([column.max() for column in columns])
    extent = np.where(periodic, period, upper - lower)
    reach = 1 if periodic[1] else FINE
    least = np.array([radius, radius / reach, radius])
    shape = np.maximum(1, np.floor(extent / least).astype(np.int64))
    cells = Cells(
        position=np.zeros((3, 0)),
        order=np.empty(len(position), dtype=np.int32),
        start=np.empty(int(shape.prod()) + 1, dtype=np.int64),
        lower=np.where(periodic, 0.0, lower),
        width=np.where(periodic, extent / shape, np.maximum(extent / shape, least)),
        shape=shape,
        reach=reach,
        periodic=periodic,
        period=repeats_of(period),
    )
    _sort_by_cell(cells_of(position, cells), cells.start, cells.order)
    return cells._replace(position=np.ascontiguousarray(position[cells.order].T))


def cells_of(position: Floats, cells: Cells) -> NDArray[np.int32]:
    """Return the number of the cell of each position; beyond the ends that of the last cell."""
    cell = np.empty(len(position), dtype=np.int32)
    _cell_of(position, cells.lower, cells.width, cells.shape, cells.periodic, cell)
    return cell


@loop
def _cell_of(position, lower, width, shape, periodic, cell):
    for i in prange(position.shape[0]):
        number = 0
        for k in AXES:
            c = np.int64(np.floor((position[i, k] - lower[k]) / width[k]))
            if periodic[k]:
                c %= shape[k]
            number = number * shape[k] + min(max(c, 0), shape[k] - 1)
        cell[i] = number


@kernel
def _sort_by_cell(cell, start, order):
    """Sort by counting: ``order[start[c]:start[c + 1]]`` are the particles of cell c, in order."""
    start[:] = 0
    for i in range(cell.size):
        start[cell[i] + 1] += 1
    for c in range(1, start.size):
        start[c] += start[c - 1]
    for i in range(cell.size):
        order[start[cell[i]]] = i
        start[cell[i]] += 1
    for c in range(start.size - 1, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0


@kernel
def append_near(itself, here, cells, lower, upper, reach2, near, listed, count):
    """Append the points of ``order[lower:upper]`` within reach of ``here`` to a list.

    Distances first, which vectorizes, then the list; the last place of the list takes what does
    not count, which spares a branch.  Twice as fast as one loop.  Indices without a sign need no
    look whether they count from the end.
    """
    last = listed.size - 1
    for first in range(lower, upper, PIECE):
        size = min(upper - first, PIECE)
        xs = cells.position[0, first : first + size]
        ys = cells.position[1, first : first + size]
        zs = cells.position[2, first : first + size]
        for k in range(size):
            dx, dy, dz = xs[k] - here[0], ys[k] - here[1], zs[k] - here[2]
            dx, dy, dz = to_nearest_image(dx, dy, dz, cells.period)
            near[k] = dx * dx + dy * dy + dz * dz < reach2
        for k in range(size):
            j = cells.order[np.uint64(first + k)]
            listed[np.uint64(min(count, last))] = j
            count += near[np.uint64(k)] & np.int8(j != itself)
    return count


@kernel
def list_at(itself, here, cell, cells, reach2, near, listed):
    """Write the points within reach of ``here`` into a list and return how many there are.

    ``cell`` is the cell of here, ``near`` room for a piece of the points.  The point ``itself`` is
    left out.  A number greater than the length less one says that the list overflowed.
    """
    count = np.int64(0)  # a literal would compile append_near once more
    shape, periodic, reach = cells.shape, cells.periodic, cells.reach
    cy = cell % shape[1]
    cz = (cell // shape[1]) % shape[2]
    cx = cell // (shape[1] * shape[2])
    for a in range(cx - 1, cx + 2):
        if (a < 0 or a >= shape[0]) and not periodic[0]:
            continue
        for c in range(cz - 1, cz + 2):
            if (c < 0 or c >= shape[2]) and not periodic[2]:
                continue
            column = ((a % shape[0]) * shape[2] + c % shape[2]) * shape[1]
            for b in range(3 if periodic[1] else 1):
                if periodic[1]:
                    first = column + (cy - 1 + b) % shape[1]
                    end = first + 1
                else:
                    first = column + max(cy - reach, 0)
                    end = column + min(cy + reach + 1, shape[1])
                count = append_near(
                    itself,
                    here,
                    cells,
                    cells.start[first],
                    cells.start[end],
                    reach2,
                    near,
                    listed,
                    count,
                )
    return count


@allocating_kernel
def _list_block(first, last, among, position, cell, row, cells, reach2, index, count):
    near = np.empty(PIECE, dtype=np.int8)
    for i in range(first, last):
        count[i] = 0
        if row[i] >= 0:
            here = (position[i, 0], position[i, 1], position[i, 2])
            itself = np.int64(i) if among else -1  # unsigned and -1 would make a float
            count[i] = list_at(itself, here, cell[i], cells, reach2, near, index[row[i]])


@loop
def _list(among, position, cell, row, cells, reach2, index, count):
    """Write who is near each position: its row of ``index`` and the count; row -1 has none."""
    for block in prange((count.size + PIECE - 1) // PIECE):
        first, last = block * PIECE, min(block * PIECE + PIECE, count.size)
        _list_block(first, last, among, position, cell, row, cells, reach2, index, count)


@loop
def _find_crowds(cells, crowd):
    """Write which cells have a point in them or in the cells around them."""
    shape, periodic, reach, start = cells.shape, cells.periodic, cells.reach, cells.start
    for cell in prange(crowd.size):
        cy = cell % shape[1]
        cz = (cell // shape[1]) % shape[2]
        cx = cell // (shape[1] * shape[2])
        points = 0
        for a in range(cx - 1, cx + 2):
            for c in range(cz - 1, cz + 2):
                for b in range(cy - reach, cy + reach + 1):
                    inside = (
                        (periodic[0] or 0 <= a < shape[0])
                        and (periodic[1] or 0 <= b < shape[1])
                        and (periodic[2] or 0 <= c < shape[2])
                    )
                    if inside:
                        k = ((a % shape[0]) * shape[2] + c % shape[2]) * shape[1] + b % shape[1]
                        points += start[k + 1] - start[k]
        crowd[cell] = points > 0


@kernel
def nearest_image(distance, period):
    """Return a distance along one axis through the nearest image; period 0 does not repeat.

    Examples
    --------
    >>> nearest_image(0.9, 1.0) < 0.0, nearest_image(0.9, 0.0)
    (True, 0.9)
    """
    return distance - period * np.rint(distance / period) if period > 0.0 else distance


@loop
def _largest_displacement(position, reference, period, partial):
    """Write the greatest squared displacement of each block of particles."""
    n = position.shape[0]
    for block in prange(partial.size):
        largest = 0.0
        for i in range(block * n // partial.size, (block + 1) * n // partial.size):
            dx = nearest_image(position[i, 0] - reference[i, 0], period[0])
            dy = nearest_image(position[i, 1] - reference[i, 1], period[1])
            dz = nearest_image(position[i, 2] - reference[i, 2], period[2])
            largest = max(largest, dx * dx + dy * dy + dz * dz)
        partial[block] = largest


def _listed(
    near: tuple[object, ...], index: NDArray[np.int32], count: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Return the filled index: the given one, or a wider one if its rows were too short."""
    while True:
        _list(*near, index, count)
        most = int(count.max(initial=0))
        if most < index.shape[1]:
            return index
        index = np.zeros((len(index), most + most // 8 + 2), dtype=np.int32)


@allocating_kernel
def _group(first, last, index, count, moving, pressed, moving_count, pressed_count):
    kept = np.empty(index.shape[1], dtype=np.int32)
    for i in range(first, last):
        place, rest = 0, 0
        for k in range(count[i]):
            j = index[i, k]
            if j < moving:
                index[i, place] = j
                place += 1
            else:
                kept[rest] = j
                rest += 1
        moving_count[i] = place
        for k in range(rest):
            if kept[k] < pressed:
                index[i, place] = kept[k]
                place += 1
        pressed_count[i] = place - moving_count[i]
        for k in range(rest):
            if kept[k] >= pressed:
                index[i, place] = kept[k]
                place += 1


@loop
def group(index, count, moving, pressed, moving_count, pressed_count):
    """Put the neighbors of each row in order: what moves, walls with a pressure, other walls.

    Within a group they keep their order.

    Parameters
    ----------
    index, count : (rows, capacity), (rows,) int32 array
        Lists of :class:`Neighbors`; changed.
    moving, pressed : int
        Particles before ``moving`` move, those before ``pressed`` carry a pressure.
    moving_count, pressed_count : (rows,) int32 array
        Written: neighbors that move, and walls with a pressure.
    """
    for block in prange((count.size + PIECE - 1) // PIECE):
        first, last = block * PIECE, min(block * PIECE + PIECE, count.size)
        _group(first, last, index, count, moving, pressed, moving_count, pressed_count)


class Neighbors:
    """Neighbors of the first ``rows`` particles, within the influence radius and a skin.

    Row i holds ``index[i, :count[i]]``.  The list is exact for the influence radius as long as no
    particle has moved by half the skin since it was built.

    Parameters
    ----------
    effective_radius, spacing : float
        Influence radius and particle spacing, m.
    period : (3,) float64 array, m
        Period along each axis, 0 where there is none; else at least three list radii.
    skin : float
        Skin in spacings.

    Examples
    --------
    >>> line = np.array([[0.0, 0, 0], [1.0, 0, 0], [3.0, 0, 0]])
    >>> near = Neighbors(1.5, 1.0, np.zeros(3))
    >>> near.build(line, rows=3)
    >>> near.count.tolist(), near.index[0, 0]
    ([1, 1, 0], np.int32(1))
    """

    def __init__(
        self, effective_radius: float, spacing: float, period: Floats, skin: float = SKIN
    ) -> None:
        self._effective_radius, self._spacing = effective_radius, spacing
        self.period = period
        self.index = np.zeros((0, 8), dtype=np.int32)
        self.count = np.zeros(0, dtype=np.int32)
        self._reference = np.zeros((0, 3))
        self.set_skin(skin)

    def set_skin(self, skin: float) -> None:
        """Choose the skin of the lists that are built from now on, in spacings."""
        self.skin = skin * self._spacing
        self.radius = self._effective_radius + self.skin

    def build(self, position: Floats, rows: int) -> None:
        """Build the list of the first ``rows`` particles."""
        cells = sort_into_cells(position, self.radius, self.period)
        if self.count.size != rows:
            self.index = np.zeros((rows, self.index.shape[1]), dtype=np.int32)
            self.count = np.zeros(rows, dtype=np.int32)
        cell, row = cells_of(position, cells), np.arange(rows, dtype=np.int32)
        near = True, position, cell, row, cells, self.radius**2
        self.index = _listed(near, self.index, self.count)
        self._reference = position.copy()

    def is_stale(self, position: Floats, rows: int) -> bool:
        """Say whether a pair may be missing: particles came, went or moved too far."""
        if position.shape != self._reference.shape or rows != self.count.size:
            return True
        partial = np.empty(16)
        _largest_displacement(position, self._reference, self.period, partial)
        return bool(partial.max() > (0.5 * self.skin) ** 2)


class FixedNeighbors:
    """Neighbors of moving particles among points that stay, which are sorted once.

    The neighbors of particle i stand in ``index[row[i], :count[i]]``; what is far from all points
    has no row, -1.  A list is exact as long as the :class:`Neighbors` of the moving particles with
    the same skin.

    Parameters
    ----------
    points : (m, 3) float64 array, m
        At least one.
    effective_radius, spacing, period, skin
        As for :class:`Neighbors`; the skin is the greatest that will be set.

    Examples
    --------
    >>> walls = FixedNeighbors(np.zeros((1, 3)), 1.5, 1.0, np.zeros(3))
    >>> walls.build(np.array([[1.0, 0, 0], [3.0, 0, 0]]))
    >>> walls.count.tolist()
    [1, 0]
    """

    def __init__(
        self,
        points: Floats,
        effective_radius: float,
        spacing: float,
        period: Floats,
        skin: float = SKIN,
    ) -> None:
        self._effective_radius, self._spacing = effective_radius, spacing
        self._cells = sort_into_cells(points, effective_radius + skin * spacing, period)
        repeats = period > 0.0
        self._lower = np.where(repeats, -np.inf, points.min(axis=0))
        self._upper = np.where(repeats, np.inf, points.max(axis=0))
        self._crowd = np.empty(self._cells.start.size - 1, dtype=np.bool_)
        _find_crowds(self._cells, self._crowd)
        self.set_skin(skin)
        self.index = np.zeros((1, 8), dtype=np.int32)  # one row at least, which -1 may stand for
        self.row = np.zeros(0, dtype=np.int32)
        self.count = np.zeros(0, dtype=np.int32)

    def set_skin(self, skin: float) -> None:
        """Choose the skin of the lists that are built from now on, in spacings."""
        self.radius = self._effective_radius + skin * self._spacing

    def build(self, position: Floats) -> None:
        """Build the list of all given particles."""
        cell = cells_of(position, self._cells)
        within = (position >= self._lower - self.radius) & (position <= self._upper + self.radius)
        has_row = self._crowd[cell] & np.all(within, axis=1)
        rows = int(np.count_nonzero(has_row))
        self.row = np.where(has_row, np.cumsum(has_row) - 1, -1).astype(np.int32)
        if self.index.shape[0] < rows:
            self.index = np.zeros((rows, self.index.shape[1]), dtype=np.int32)
        self.count = np.zeros(len(position), dtype=np.int32)
        near = False, position, cell, self.row, self._cells, self.radius**2
        self.index = _listed(near, self.index, self.count)


def order_by_cell(position: Floats, width: float) -> NDArray[np.int64]:
    """Return the order that puts neighbors in space near each other in memory."""
    if position.size == 0:
        return np.zeros(0, dtype=np.int64)
    cell = np.floor((position - position.min(axis=0)) / width).astype(np.int64)
    return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))
