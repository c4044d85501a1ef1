"""Which boxes are near a particle, and the pairs of particles that thin ones keep apart."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from debrisflow._jit import allocating_kernel, kernel, loop
from debrisflow.neighbors.boxes import Boxes, distance_to, place_in
from debrisflow.neighbors.pairs import BLOCK, separation

Floats = NDArray[np.float64]


class Nearby(NamedTuple):
    """The boxes that each particle is near: ``box[start[i] : start[i + 1]]`` of particle i.

    Attributes
    ----------
    start : (n + 1,) int64 array
    box : (pairs,) int32 array
    """

    start: NDArray[np.int64]
    box: NDArray[np.int32]


@allocating_kernel
def _count_near(first, last, position, boxes, reach, count):
    here = np.empty(3)
    for i in range(first, last):
        count[i] = 0
        for b in range(boxes.is_floor.size):
            place_in(b, position[i, 0], position[i, 1], position[i, 2], boxes, here)
            count[i] += 1 if distance_to(b, here, boxes) < reach else 0


@loop
def _count_all_near(position, boxes, reach, count):
    for block in prange((count.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, count.size)
        _count_near(first, last, position, boxes, reach, count)


@allocating_kernel
def _list_near(first, last, position, boxes, reach, start, box):
    here = np.empty(3)
    for i in range(first, last):
        place = start[i]
        for b in range(boxes.is_floor.size):
            place_in(b, position[i, 0], position[i, 1], position[i, 2], boxes, here)
            if distance_to(b, here, boxes) < reach:
                box[place] = b
                place += 1


@loop
def _list_all_near(position, boxes, reach, start, box):
    n = start.size - 1
    for block in prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, n)
        _list_near(first, last, position, boxes, reach, start, box)


def near_boxes(position: Floats, boxes: Boxes, reach: float) -> Nearby:
    """Return which boxes each particle, (n, 3) array, m, is nearer to than a reach, m, or in."""
    start = np.zeros(len(position) + 1, dtype=np.int64)
    _count_all_near(position, boxes, reach, start[1:])
    np.cumsum(start, out=start)
    box = np.empty(start[-1], dtype=np.int32)
    _list_all_near(position, boxes, reach, start, box)
    return Nearby(start, box)


@kernel
def crosses(b, dx, dy, dz, boxes, here):
    """Return whether the way from a place, in the coordinates of a box, by d passes through it."""
    first, last = 0.0, 1.0
    for k in range(3):
        a = boxes.axes[b, k]
        step = a[0] * dx + a[1] * dy + a[2] * dz
        low, high = boxes.lower[b, k] - here[k], boxes.upper[b, k] - here[k]
        if step == 0.0:
            if low >= 0.0 or high <= 0.0:
                return False
        else:
            enters, leaves = min(low / step, high / step), max(low / step, high / step)
            first, last = max(first, enters), min(last, leaves)
    return first < last


@kernel
def _is_cut(i, j, position, period, boxes, here):
    """Return whether a thin box stands between particles i and j."""
    dx, dy, dz = separation(i, j, position, position, period)
    for b in range(boxes.is_floor.size):
        if boxes.is_thin[b, 0] or boxes.is_thin[b, 1] or boxes.is_thin[b, 2]:
            place_in(b, position[i, 0], position[i, 1], position[i, 2], boxes, here)
            if crosses(b, dx, dy, dz, boxes, here):
                return True
    return False


@allocating_kernel
def _cut_pairs(first, last, position, row, period, boxes, index, count):
    here = np.empty(3)
    for i in range(first, last):
        if row[i] < 0:
            continue
        kept = 0
        for k in range(count[i]):
            j = index[i, k]
            if row[j] < 0 or not _is_cut(i, j, position, period, boxes, here):
                index[i, kept] = j
                kept += 1
        count[i] = kept


@loop
def cut_pairs(position, row, period, boxes, index, count):
    """Take from the lists the pairs between which a thin box stands, in place.

    Only what has a row can be near one; the others keep their lists.
    """
    for block in prange((count.size + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, count.size)
        _cut_pairs(first, last, position, row, period, boxes, index, count)
