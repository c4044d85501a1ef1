"""Closed surfaces of triangles: read, checked, cut into cells of a lattice; the nearest point.

Readers and VTK are imported by what needs them, since most cases have no mesh.
"""

from __future__ import annotations

import importlib
import re
import warnings
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.files import opened, regular

Floats = NDArray[np.float64]
Cells = NDArray[np.int64]
FORMATS = ("stl", "obj", "ply")
MOST_BYTES = 1_000_000_000
FARTHEST = 1.0e9  # in the lengths of a file
MOST_TRIED = 2.0e6  # columns of cells under triangles that are looked at together
LONGEST_HEAD, MOST_DIGITS = 65_536, 12  # bytes of a PLY file, digits of its counts

# Vertices nearer than this share of the size of a mesh are one: an STL file repeats each vertex in
# every triangle, in text with rounded digits.
SAME_VERTEX = 1.0e-6
# Share of a spacing by which the lines through the cells are moved, so that none runs along an
# edge of a mesh that is drawn on the lattice.
ASIDE = (1.0e-6, 0.7e-6)


class UnreadableSurfaceError(ValueError):
    """Why a file gives no surface, in words that follow its name."""


class Surface(NamedTuple):
    """A surface of triangles.

    Attributes
    ----------
    corners : (n, 3, 3) float64 array, m
        The three corners of each triangle.
    """

    corners: Floats

    @property
    def lower(self) -> Floats:
        """Lower corner of the box around the surface, m."""
        lowest: Floats = self.corners.min(axis=(0, 1))
        return lowest

    @property
    def upper(self) -> Floats:
        """Upper corner of the box around the surface, m."""
        highest: Floats = self.corners.max(axis=(0, 1))
        return highest

    @property
    def volume(self) -> float:
        """Enclosed volume, m3, where the triangles turn the same way."""
        a, b, c = np.moveaxis(self.corners - self.lower, 1, 0)
        return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0

    @property
    def area(self) -> float:
        """Area of the triangles, m2."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def placed(self, scale: float, offset: tuple[float, float, float]) -> Surface:
        """Return the surface scaled, and then moved by an offset, m."""
        return Surface(self.corners * scale + np.array(offset))


def read_surface(path: Path) -> Surface:
    """Return the surface of an STL, OBJ or PLY file, in the lengths of the file.

    Raises
    ------
    UnreadableSurfaceError
        If there is no such file, it is of another kind, or it holds no triangles.
    """
    try:
        changed = regular(path, MOST_BYTES).st_mtime_ns
        return _read(path, changed)
    except OSError as error:
        raise UnreadableSurfaceError(
            f"cannot be read: {(error.strerror or str(error)).lower()}"
        ) from error


@lru_cache(maxsize=8)
def _read(path: Path, changed: int) -> Surface:
    """Read a file that was changed at a time; the checks ask for the same one again and again."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise UnreadableSurfaceError("must be an STL, OBJ or PLY file: .stl, .obj or .ply")
    if kind == "ply":
        _expect_counts_of_ply(path)
    try:
        # meshio takes the letters of an STL file in text for a number of triangles, and warns
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = importlib.import_module(f"meshio.{kind}").read(str(path))
        points = np.asarray(mesh.points, dtype=float)
        faces = [np.zeros((0, 3), dtype=int)]
        for block in mesh.cells:
            if block.type == "triangle":
                faces.append(block.data)
            elif block.type == "quad":
                faces += [block.data[:, [0, 1, 2]], block.data[:, [0, 2, 3]]]
        face = np.concatenate(faces)
        if face.size and face.min() < 0:  # of OBJ, which counts from the end, as meshio does not
            raise IndexError
        corners = points[face]
    except Exception as error:  # the readers meet a broken file with whatever they stumble over
        raise UnreadableSurfaceError(f"is not a readable {kind.upper()} file") from error
    if not len(corners):
        raise UnreadableSurfaceError("holds no triangles")
    if corners.shape[2] != 3 or not np.all(np.isfinite(corners)):
        raise UnreadableSurfaceError("has vertices that are not three finite numbers")
    if np.abs(corners).max() > FARTHEST:
        raise UnreadableSurfaceError(f"has vertices beyond {FARTHEST:g}, which are no lengths")
    return Surface(corners)


def _expect_counts_of_ply(path: Path) -> None:
    """Refuse a PLY file whose head does not end, or promises more than the file can hold."""
    with opened(path, MOST_BYTES) as file:
        head = file.read(LONGEST_HEAD)
    end = re.search(rb"^[ \t]*end_header[ \t\r]*$", head, re.MULTILINE)
    if end is None:
        raise UnreadableSurfaceError("is not a readable PLY file: its head has no end")
    counts = re.findall(
        rb"^[ \t]*element[ \t]+\w+[ \t]+([0-9]+)", head[: end.start()], re.MULTILINE
    )
    if any(len(count) > MOST_DIGITS for count in counts) or (
        sum(map(int, counts)) > path.stat().st_size
    ):
        raise UnreadableSurfaceError(
            "promises more vertices and faces than it can hold; it may be cut short"
        )


def open_edges(surface: Surface) -> int:
    """Return how many edges bound an odd number of triangles; a closed surface has none.

    Examples
    --------
    >>> corner = np.vstack([np.zeros(3), np.eye(3)])
    >>> sides = corner[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    >>> open_edges(Surface(sides)), open_edges(Surface(sides[:3]))
    (0, 3)
    """
    size = float(np.max(surface.upper - surface.lower)) or 1.0
    places = np.rint((surface.corners.reshape(-1, 3) - surface.lower) / (SAME_VERTEX * size))
    _, vertex = np.unique(places, axis=0, return_inverse=True)
    triangles = np.sort(vertex.reshape(-1, 3), axis=1)
    triangles = triangles[np.all(np.diff(triangles, axis=1) > 0, axis=1)]
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]])
    _, times = np.unique(edges, axis=0, return_counts=True)
    return int(np.count_nonzero(times % 2))


def cells_inside(surface: Surface, spacing: float) -> Cells:
    """Return the cells of the lattice whose centers a closed surface encloses.

    A vertical line through each column of cells enters and leaves the body in turn, so that it
    does not matter which way the triangles turn.

    Parameters
    ----------
    surface : Surface
    spacing : float, m

    Returns
    -------
    (n, 3) int64 array
        Cell k reaches from k to k + 1 spacings along each axis.
    """
    column, height = _crossings_by_parts(surface.corners / spacing)
    order = np.lexsort((height, *column.T))
    column, height = column[order], height[order]
    begins = np.ones(len(column), dtype=bool)
    begins[1:] = np.any(np.diff(column, axis=0) != 0, axis=1)
    first = np.flatnonzero(begins)
    rank = np.arange(len(column)) - np.repeat(first, np.diff(first, append=len(column)))
    enters = np.flatnonzero((rank % 2 == 0) & ~np.append(begins[1:], True))
    bottom = np.ceil(height[enters] - 0.5).astype(np.int64)
    count = np.maximum(np.ceil(height[enters + 1] - 0.5).astype(np.int64) - bottom, 0)
    up = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.column_stack(
        [np.repeat(column[enters], count, axis=0), np.repeat(bottom, count) + up]
    )


def _crossings_by_parts(corners: Floats) -> tuple[Cells, Floats]:
    """Return the crossings of all triangles, found for a part of them at a time.

    That bounds the memory where many triangles lie over each other.
    """
    size = np.ptp(corners[:, :, :2], axis=1) + 1.0
    part = np.cumsum(size[:, 0] * size[:, 1]) // MOST_TRIED
    borders = np.flatnonzero(np.diff(part)) + 1
    found = [_crossings(some) for some in np.split(corners, borders)]
    columns, heights = zip(*found, strict=True)
    return np.concatenate(columns), np.concatenate(heights)


def _crossings(corners: Floats) -> tuple[Cells, Floats]:
    """Return columns of cells, (n, 2), and the heights at which triangles cross their middle.

    Lengths are in spacings.
    """
    flat = corners[:, :, :2] - 0.5 - np.array(ASIDE)
    lowest = np.ceil(flat.min(axis=1)).astype(np.int64)
    counts = np.maximum(np.floor(flat.max(axis=1)).astype(np.int64) - lowest + 1, 0)
    tried = counts[:, 0] * counts[:, 1]
    triangle = np.repeat(np.arange(len(corners)), tried)
    number = np.arange(tried.sum()) - np.repeat(np.cumsum(tried) - tried, tried)
    column = lowest[triangle] + np.column_stack(np.divmod(number, counts[triangle, 1]))
    spokes = flat[triangle] - column[:, None, :]
    # twice the areas between the line and the sides opposite to the corners
    ends = np.roll(spokes, -1, axis=1), np.roll(spokes, -2, axis=1)
    area = ends[0][:, :, 0] * ends[1][:, :, 1] - ends[0][:, :, 1] * ends[1][:, :, 0]
    met = np.all(area > 0.0, axis=1) | np.all(area < 0.0, axis=1)
    area, triangle = area[met], triangle[met]
    height = np.sum(area * corners[triangle, :, 2], axis=1) / np.sum(area, axis=1)
    return column[met], height


def nearest_points(surface: Surface, position: Floats) -> tuple[Floats, Floats]:
    """Return the point of a surface that is nearest to each position, and the normal there.

    Parameters
    ----------
    surface : Surface
    position : (n, 3) float64 array, m

    Returns
    -------
    nearest : (n, 3) float64 array, m
    normal : (n, 3) float64 array
        Unit normal of its triangle, on the side from which the corners turn to the left.
    """
    import pyvista

    corners = surface.corners
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    mesh = pyvista.PolyData.from_regular_faces(corners.reshape(-1, 3), faces)
    triangle, nearest = mesh.find_closest_cell(position, return_closest_point=True)
    a, b, c = np.moveaxis(corners[np.atleast_1d(triangle)], 1, 0)
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    normal: Floats = across / np.where(length > 0.0, length, 1.0)
    return np.asarray(nearest, dtype=float).reshape(-1, 3), normal
