"""The free surface of the fluid: a line in two dimensions, triangles in three; it may overturn."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import pyvista
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from debrisflow.case import ResolvedCase
from debrisflow.errors import OutputError
from debrisflow.particles.record import Kind
from debrisflow.results.frames import Frame
from debrisflow.space.domain import domain

Floats = NDArray[np.float64]
NODES_A_SPACING = 2
REACH = 2.0  # spacings, of the smoothing
POWER = 3
# integral of (1 - r^2)^3 over the unit disk and the unit ball
INTEGRAL = {2: np.pi / 4.0, 3: 64.0 * np.pi / 315.0}
HALF = 0.5
LEAST_OPEN = 0.1  # share of a place that is no wall, below which its share of matter is not raised
MOST_NODES = 200_000_000


class Surface(NamedTuple):
    """A free surface.

    Attributes
    ----------
    points : (n, 3) float64 array, m
    cells : (m, 2) or (m, 3) int array
        The points of each piece of the line, or of each triangle.
    """

    points: Floats
    cells: NDArray[np.int64]

    @property
    def mesh(self) -> pyvista.PolyData:
        """Return the surface for VTK."""
        if len(self.cells) == 0:
            return pyvista.PolyData()
        size = self.cells.shape[1]
        listed = np.column_stack([np.full(len(self.cells), size), self.cells]).ravel()
        return pyvista.PolyData(self.points, **{"lines" if size == 2 else "faces": listed})


class _Nodes(NamedTuple):
    """A grid of nodes: the first along each axis, in steps, and their numbers; one step, m."""

    first: NDArray[np.int64]
    counts: NDArray[np.int64]
    step: float


def free_surface(frame: Frame, case: ResolvedCase, walls: Floats) -> Surface:
    """Return where the smoothed share of matter falls to one half.

    The share at a place is ``F / (1 - S)``, with the share F of matter and S of walls around it,
    ``sum d0^D w(r)`` over the particles with ``w ~ (1 - (r / R)^2)^3`` and R two spacings.  Walls
    are left out by the division, so that the surface meets them as it would go on in them; there it
    ends, at S = 1/2.  On a grid of half a spacing the surface is found between nodes.

    Gaps less than about a spacing wide are closed, and drops of fewer than four particles are left
    out.  A surface around a body of fluid with a radius of five spacings lies a tenth of a spacing
    too far inside.

    Parameters
    ----------
    frame : Frame
    case : ResolvedCase
    walls : (n, 3) float64 array, m
        The places of the particles by which the walls of the case are drawn.

    Raises
    ------
    OutputError
        If the grid would be too large.
    """
    axes = case.dimension
    matter = frame.position[frame.fluid | (frame.kind == Kind.INFLOW)]
    if len(matter) == 0:
        return _nothing(axes)
    nodes = _nodes_around(matter, case)
    filled = _share(matter, nodes, case)
    solid = _share(walls, nodes, case)
    # in steps from the first node: VTK makes points of single precision, too coarse far from 0
    image = pyvista.ImageData(dimensions=(*nodes.counts, 1)[:3])
    image["share"] = (filled / np.maximum(1.0 - solid, LEAST_OPEN)).ravel(order="F")
    whole = image.contour([HALF], scalars="share", compute_normals=False)
    if whole.n_points == 0:
        return _nothing(axes)
    place = np.asarray(whole.points)[:, :axes].T
    whole["solid"] = map_coordinates(solid, place, order=1, mode="nearest")
    clipped = whole.clip_scalar(scalars="solid", value=HALF)
    points = np.zeros((clipped.n_points, 3))
    points[:, :axes] = nodes.step * (nodes.first + np.asarray(clipped.points)[:, :axes])
    listed = clipped.lines if axes == 2 else clipped.triangulate().faces
    return Surface(points, np.asarray(listed, dtype=np.int64).reshape(-1, 1 + axes)[:, 1:])


def _nothing(axes: int) -> Surface:
    return Surface(np.zeros((0, 3)), np.zeros((0, axes), dtype=np.int64))


def _nodes_around(matter: Floats, case: ResolvedCase) -> _Nodes:
    """Return the nodes around the matter, in the space if it ends openly or repeats."""
    axes, step = case.dimension, case.particles.spacing / NODES_A_SPACING
    reach = 1 + int(np.ceil(REACH * NODES_A_SPACING))
    first = np.floor(matter[:, :axes].min(axis=0) / step).astype(np.int64) - reach
    last = np.ceil(matter[:, :axes].max(axis=0) / step).astype(np.int64) + reach
    period = domain(case).period[:axes]
    if case.inflow is not None:
        first[0] = max(first[0], 0)  # supply waits before it
    first[period > 0.0] = 0
    last[period > 0.0] = np.rint(period[period > 0.0] / step).astype(np.int64)
    counts = np.maximum(last - first + 1, 2)
    if np.prod(counts, dtype=float) > MOST_NODES:
        needed = np.prod(counts, dtype=float)
        raise OutputError(
            f"the surface needs a grid of {needed:.2g} nodes half a spacing apart around all that "
            f"flows, at most {MOST_NODES:.2g}; the particle files can be contoured in ParaView"
        )
    return _Nodes(first, counts, step)


def _share(position: Floats, nodes: _Nodes, case: ResolvedCase) -> Floats:
    """Return the share of the space around each node that particles fill."""
    axes = case.dimension
    reach = int(REACH * NODES_A_SPACING)  # in steps
    place = _with_images(position, case)[:, :axes] / nodes.step - nodes.first
    place = place[np.all((place > -reach) & (place < nodes.counts - 1 + reach), axis=1)]
    base = np.floor(place).astype(np.int64)
    field = np.zeros(nodes.counts + 4 * reach)  # with a margin, so that no node needs a check
    strides = np.array(field.strides) // field.itemsize
    span = np.arange(1 - reach, reach + 1)
    square = [((base[:, k, None] + span - place[:, k, None]) / reach) ** 2 for k in range(axes)]
    number = (base + 2 * reach) @ strides
    for offset in product(range(span.size), repeat=axes):
        near = np.ones(len(place))
        for part, k in zip(square, offset, strict=True):
            near -= part[:, k]
        row = np.flatnonzero(near > 0.0)
        np.add.at(field.reshape(-1), number[row] + span[list(offset)] @ strides, near[row] ** POWER)
    inner = tuple(slice(2 * reach, 2 * reach + count) for count in nodes.counts)
    scale = (NODES_A_SPACING / reach) ** axes / INTEGRAL[axes]
    return np.asarray(scale * field[inner])


def _with_images(position: Floats, case: ResolvedCase) -> Floats:
    """Return positions in the first period, and their images beside it."""
    place, period = position, domain(case).period
    for axis in np.flatnonzero(period > 0.0):
        place = place.copy()
        place[:, axis] = np.mod(place[:, axis], period[axis])
        shifted = [place + k * period[axis] * np.eye(3)[axis] for k in (-1, 0, 1)]
        place = np.concatenate(shifted)
    return place
