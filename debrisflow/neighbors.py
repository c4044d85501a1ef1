"""Neighbor lists: who is within the influence radius, kept over several steps by a skin."""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import kernel, loop

Floats = NDArray[np.float64]
SKIN = 0.4
AXES = (0, 2, 1)  # cells that follow along y follow in memory, in two dimensions and in three
PIECE = 128
FINE = 4


class Grid:
    """Cells as wide as the list radius or a little wider, over all particles.

    Along y, in which cells follow each other in memory, they are a quarter as wide where the domain
    does not repeat along it: the particles within reach of a cell then stand in rows that are a
    fourth shorter.

    Attributes
    ----------
    lower : (3,) float64 array, m
    width : (3,) float64 array, m
    shape : (3,) int64 array
    periodic : (3,) bool array
    reach : int
        Cells along y that the radius spans.
    """

    def __init__(self, position: Floats, radius: float, period: Floats) -> None:
        self.periodic = period > 0.0
        columns = position.T if len(position) else np.zeros((3, 1))
        lower = np.array([column.min() for column in columns])
        upper = np.array([column.max() for column in columns])
        extent = np.where(self.periodic, period, upper - lower)
        self.lower = np.where(self.periodic, 0.0, lower)
        self.reach = 1 if self.periodic[1] else FINE
        least = np.array([radius, radius / self.reach, radius])
        self.shape = np.maximum(1, np.floor(extent / least).astype(np.int64))
        self.width = np.where(
            self.periodic, extent / self.shape, np.maximum(extent / self.shape, least)
        )

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return int(self.shape.prod())


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
def append_near(i, here, sorted_position, order, lower, upper, period, reach2, near, row, count):
    """Append the particles of ``order[lower:upper]`` within reach of ``here`` to a row.

    Distances first, which vectorizes, then the list; the last place of the row takes what does not
    count, which spares a branch.  Twice as fast as one loop.
    """
    last = row.size - 1
    for first in range(lower, upper, PIECE):
        size = min(upper - first, PIECE)
        xs = sorted_position[0, first : first + size]
        ys = sorted_position[1, first : first + size]
        zs = sorted_position[2, first : first + size]
        for k in range(size):
            dx = xs[k] - here[0]
            dy = ys[k] - here[1]
            dz = zs[k] - here[2]
            dx -= period[0] * np.rint(dx * period[3])
            dy -= period[1] * np.rint(dy * period[4])
            dz -= period[2] * np.rint(dz * period[5])
            near[k] = dx * dx + dy * dy + dz * dz < reach2
        for k in range(size):
            j = order[first + k]
            row[min(count, last)] = j
            count += near[k] & np.int8(j != i)
    return count


@kernel
def list_at(
    i,
    itself,
    position,
    sorted_position,
    order,
    start,
    cell,
    shape,
    reach,
    periodic,
    period,
    reach2,
    listed,
):
    """Write the particles within reach of particle i into a list and return how many there are.

    The particle ``itself`` is left out.  A number greater than the length less one says that the
    list overflowed.
    """
    count = 0
    near = np.empty(PIECE, dtype=np.int8)
    here = (position[i, 0], position[i, 1], position[i, 2])
    lengths = (period[0], period[1], period[2], *_inverse(period))
    cy = cell[i] % shape[1]
    cz = (cell[i] // shape[1]) % shape[2]
    cx = cell[i] // (shape[1] * shape[2])
    for a in range(cx - 1, cx + 2):
        if (a < 0 or a >= shape[0]) and not periodic[0]:
            continue
        for c in range(cz - 1, cz + 2):
            if (c < 0 or c >= shape[2]) and not periodic[2]:
                continue
            column = ((a % shape[0]) * shape[2] + c % shape[2]) * shape[1]
            cells = 3 if periodic[1] else 1
            for b in range(cells):
                if periodic[1]:
                    lower = column + (cy - 1 + b) % shape[1]
                    upper = lower + 1
                else:
                    lower = column + max(cy - reach, 0)
                    upper = column + min(cy + reach + 1, shape[1])
                count = append_near(
                    itself,
                    here,
                    sorted_position,
                    order,
                    start[lower],
                    start[upper],
                    lengths,
                    reach2,
                    near,
                    listed,
                    count,
                )
    return count


@kernel
def _inverse(period):
    """Return the inverse of each period, 0 where there is none."""
    return (
        1.0 / period[0] if period[0] > 0.0 else 0.0,
        1.0 / period[1] if period[1] > 0.0 else 0.0,
        1.0 / period[2] if period[2] > 0.0 else 0.0,
    )


@loop
def _list(
    position,
    sorted_position,
    order,
    start,
    cell,
    shape,
    reach,
    periodic,
    period,
    reach2,
    index,
    count,
):
    for i in prange(count.size):
        count[i] = list_at(
            i,
            i,
            position,
            sorted_position,
            order,
            start,
            cell,
            shape,
            reach,
            periodic,
            period,
            reach2,
            index[i],
        )


@loop
def _list_near_crowds(
    position,
    sorted_position,
    order,
    start,
    cell,
    row,
    shape,
    reach,
    periodic,
    period,
    reach2,
    index,
    count,
):
    for i in prange(count.size):
        count[i] = 0
        if row[i] >= 0:
            count[i] = list_at(
                i,
                -1,
                position,
                sorted_position,
                order,
                start,
                cell,
                shape,
                reach,
                periodic,
                period,
                reach2,
                index[row[i]],
            )


@loop
def _find_crowds(start, shape, reach, periodic, crowd):
    """Write which cells have a point in them or in the cells around them."""
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


class _Sorted:
    """Points sorted into the cells of a grid."""

    def __init__(self, position: Floats, radius: float, period: Floats) -> None:
        self.period, self.radius = period, radius
        self.grid = Grid(position, radius, period)
        self.cell = self.cells_of(position)
        self.order = np.empty(self.cell.size, dtype=np.int32)
        self.start = np.empty(self.grid.cell_count + 1, dtype=np.int64)
        _sort_by_cell(self.cell, self.start, self.order)
        self.position = np.ascontiguousarray(position[self.order].T)

    def cells_of(self, position: Floats) -> NDArray[np.int32]:
        grid, cell = self.grid, np.empty(position.shape[0], dtype=np.int32)
        _cell_of(position, grid.lower, grid.width, grid.shape, grid.periodic, cell)
        return cell

    def lists(self, position: Floats, cell: NDArray[np.int32]) -> tuple[object, ...]:
        """Return what the kernels that list the points near positions in given cells need."""
        return position, self.position, self.order, self.start, cell

    def space(self) -> tuple[object, ...]:
        """Return shape and period of the cells and the squared radius."""
        grid = self.grid
        return grid.shape, grid.reach, grid.periodic, self.period, self.radius**2


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
        points = _Sorted(position, self.radius, self.period)
        if self.count.size != rows:
            self.index = np.zeros((rows, self.index.shape[1]), dtype=np.int32)
            self.count = np.zeros(rows, dtype=np.int32)
        while True:
            _list(*points.lists(position, points.cell), *points.space(), self.index, self.count)
            most = int(self.count.max(initial=0))
            if most < self.index.shape[1]:
                break
            self.index = np.zeros((rows, most + most // 8 + 2), dtype=np.int32)
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
        self._points = _Sorted(points, effective_radius + skin * spacing, period)
        grid = self._points.grid
        self._crowd = np.empty(grid.cell_count, dtype=np.bool_)
        _find_crowds(self._points.start, grid.shape, grid.reach, grid.periodic, self._crowd)
        self.index = np.zeros((0, 8), dtype=np.int32)
        self.row = np.zeros(0, dtype=np.int32)
        self.count = np.zeros(0, dtype=np.int32)

    def set_skin(self, skin: float) -> None:
        """Choose the skin of the lists that are built from now on, in spacings."""
        self._points.radius = self._effective_radius + skin * self._spacing

    def build(self, position: Floats) -> None:
        """Build the list of all given particles."""
        points, width = self._points, self.index.shape[1]
        cell = points.cells_of(position)
        has_row = self._crowd[cell]
        rows = int(np.count_nonzero(has_row))
        self.row = np.where(has_row, np.cumsum(has_row) - 1, -1).astype(np.int32)
        if self.index.shape[0] < rows:
            self.index = np.zeros((rows, width), dtype=np.int32)
        self.count = np.zeros(len(position), dtype=np.int32)
        lists, space = points.lists(position, cell), points.space()
        while True:
            _list_near_crowds(*lists, self.row, *space, self.index, self.count)
            most = int(self.count.max(initial=0))
            if most < self.index.shape[1]:
                break
            self.index = np.zeros((rows, most + most // 8 + 2), dtype=np.int32)


def order_by_cell(position: Floats, width: float) -> NDArray[np.int64]:
    """Return the order that puts neighbors in space near each other in memory."""
    if position.size == 0:
        return np.zeros(0, dtype=np.int64)
    cell = np.floor((position - position.min(axis=0)) / width).astype(np.int64)
    return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))
