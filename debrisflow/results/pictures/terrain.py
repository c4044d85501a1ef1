"""The flow on a terrain in perspective: the relief with its shades, and particles on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyvista
from matplotlib.axes import Axes
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results.frames import Frame
from debrisflow.results.maps.furniture import round_length
from debrisflow.results.maps.part import part_around
from debrisflow.results.maps.relief import contours, hillshade
from debrisflow.results.pictures.coloring import Scale
from debrisflow.results.pictures.panels import FINER, FREE, HALO, LINE, Pixels
from debrisflow.results.pictures.sheet import SMALL
from debrisflow.results.pictures.views import OPENING, Camera, PerspectiveView
from debrisflow.space.scene import Scene

Floats = NDArray[np.float64]
ASPECTS = (0.4, 2.5)  # the least and the greatest extent to the north over that to the east
BESIDE, ABOVE = 0.5, 0.9  # of the eye, beside the direction of the flow and over the ground
BAR_SHARE = 0.25  # of the width of the terrain
NORTH_SHARE, NORTH_INSIDE = 0.12, 0.04
WORD_BEYOND = 6.0  # points from the end of a line
LIFT = 0.002  # of the extent of a terrain
TINT = np.array([255.0, 250.0, 240.0])  # of a bright slope: not the gray of water or walls
QUARTERS = (
    "east",
    "north-east",
    "north",
    "north-west",
    "west",
    "south-west",
    "south",
    "south-east",
)


class Path(NamedTuple):
    """Where the flow has been.

    Attributes
    ----------
    touched : (rows, columns) bool array
        Cells of the terrain, the northernmost row first.
    direction : (2,) array
        Unit vector in plan from the first particles to the last ones.
    """

    touched: NDArray[np.bool_]
    direction: Floats


def terrain_mesh(terrain: Raster) -> pyvista.StructuredGrid:
    """Return a terrain as a surface through the middles of its cells.

    Its points have the color ``shade``, (n, 3) uint8.  Cells without a level, and those beside
    them, are left out.

    Parameters
    ----------
    terrain : Raster
        In the coordinates of the particles.

    Examples
    --------
    >>> grid = MapGrid(0.0, 0.0, 2.0, 3, 2)
    >>> mesh = terrain_mesh(Raster(grid, np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])))
    >>> mesh.n_points, mesh.bounds[:4]
    (6, (1.0, 5.0, 1.0, 3.0))
    """
    grid, level = terrain.grid, terrain.plan
    x = grid.west + grid.cell * (np.arange(grid.columns) + 0.5)
    y = grid.south + grid.cell * (np.arange(grid.rows) + 0.5)
    known = np.isfinite(level)
    filled = np.where(known, level, np.nanmin(level))
    mesh = pyvista.StructuredGrid(*np.broadcast_arrays(x[:, None], y[None, :]), filled)
    shade = np.nan_to_num(hillshade(terrain), nan=1.0)
    plan = shade[::-1].T
    mesh["shade"] = (plan.ravel(order="F")[:, None] * TINT).astype(np.uint8)
    mesh.hide_points(np.flatnonzero(~known.ravel(order="F")))
    return mesh


def contour_lines(mesh: pyvista.StructuredGrid, levels: Floats) -> pyvista.PolyData:
    """Return lines of equal level on a terrain."""
    points = np.asarray(mesh.points)
    lines = mesh.contour(isosurfaces=levels.tolist(), scalars=points[:, 2])
    if lines.n_points:  # lifted, so that the surface does not cover them here and there
        lines.points[:, 2] += LIFT * float(np.ptp(points[:, :2]))
    return lines


def path_of(grid: MapGrid, frames: Sequence[Frame]) -> Path:
    """Return where the fluid of some frames is on the cells of a grid."""
    touched = np.zeros(grid.shape, dtype=bool)
    middles = []
    for frame in frames:
        x, y = frame.position[frame.fluid][:, :2].T
        column = np.floor((x - grid.west) / grid.cell).astype(int)
        row = np.floor((grid.north - y) / grid.cell).astype(int)
        inside = (column >= 0) & (row >= 0) & (column < grid.columns) & (row < grid.rows)
        touched[row[inside], column[inside]] = True
        if inside.any():
            middles.append(np.array([x[inside].mean(), y[inside].mean()]))
    way = middles[-1] - middles[0] if middles else np.zeros(2)
    length = float(np.linalg.norm(way))
    return Path(touched, way / length if length > 0.0 else np.array([0.0, -1.0]))


class TerrainPanels:
    """Particles on a terrain, seen from downstream so that the whole way of the flow shows.

    Parameters
    ----------
    terrain : Raster
        In the coordinates of the particles.
    scene : Scene
        Whose obstacles are shown.
    frames : sequence of Frame
        Whose particles must be seen.
    spacing : float, m
        Of the particles.
    """

    name = "perspective"
    room = 0.35

    def __init__(
        self, terrain: Raster, scene: Scene, frames: Sequence[Frame], spacing: float
    ) -> None:
        path = path_of(terrain.grid, frames)
        shown = terrain.cropped(*part_around(terrain.grid, path.touched, ASPECTS))
        self.grid, self.spacing = shown.grid, spacing
        self.scene = scene._replace(floor=[], behind=[], before=[])
        self.ground, found = terrain_mesh(shown), contours(shown)
        self.lines = contour_lines(self.ground, np.sort(np.concatenate(found[1:])))
        aside = np.array([path.direction[1], -path.direction[0]])
        flat = path.direction + BESIDE * aside
        flat /= np.linalg.norm(flat)
        corners = np.asarray(self.ground.points, dtype=float)
        up = np.array([0.0, 0.0, 1.0])
        self.camera = Camera.on(corners, np.array([*flat, ABOVE]), up, FREE)
        seen = self.camera.seen(corners)
        width, height = (seen.max(axis=0) - seen.min(axis=0)) / (1.0 - 2.0 * FREE)
        self.aspect = float((height + 0.04 * width) / width)
        eighth = round(float(np.arctan2(flat[1], flat[0])) / (0.25 * np.pi)) % 8
        self.remark = f"seen from the {QUARTERS[eighth]}, contours each {found.interval:g} m"
        self._view: PerspectiveView | None = None

    def draw(self, axes: Axes, frame: Frame, scale: Scale, pixels: Pixels) -> None:
        """Draw a frame into empty axes."""
        fine = (FINER * pixels[0], FINER * pixels[1])
        if self._view is None or self._view.pixels != fine:
            self.close()
            self._view = PerspectiveView(self.scene, self.camera, fine, self.spacing)
            self._view.add_ground(self.ground, self.lines)
        image = self._view.picture(frame.position, scale.colors(frame))
        half = float(np.tan(np.radians(0.5 * OPENING)))
        right, up = (half * side / max(pixels) for side in pixels)
        axes.imshow(image, extent=(-right, right, -up, up), aspect="auto")
        axes.set_axis_off()
        self._draw_bar_and_north(axes)

    def _draw_bar_and_north(self, axes: Axes) -> None:
        """Draw a length and the north on the ground at the corner that is nearest to the eye."""
        points = np.asarray(self.ground.points, dtype=float)
        low, high = points.min(axis=0)[:2], points.max(axis=0)[:2]
        size = float((high - low).max())
        is_low = np.abs(low - self.camera.position[:2]) < np.abs(high - self.camera.position[:2])
        corner, inward = np.where(is_low, low, high), np.where(is_low, 1.0, -1.0)
        level = float(points[np.argmin(np.linalg.norm(points[:, :2] - corner, axis=1)), 2])
        length = round_length(BAR_SHARE * size)
        start, along = np.array([*corner, level]), np.array([inward[0] * length, 0.0, 0.0])
        self._arrow(axes, np.array([start, start + along]), f"{length:g} m", "-")
        north = np.array([0.0, NORTH_SHARE * size, 0.0])
        foot = start + NORTH_INSIDE * size * np.array([*inward, 0.0])
        foot -= north if inward[1] < 0.0 else 0.0
        self._arrow(axes, np.array([foot, foot + north]), "N", "->")

    def _arrow(self, axes: Axes, ends: Floats, word: str, style: str) -> None:
        """Draw a line between two places of space, and a word at its end."""
        start, end = self.camera.seen(ends)
        how = {"arrowstyle": style, "color": LINE, "linewidth": 1.3, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", end, start, arrowprops=how)
        way = (end - start) / np.linalg.norm(end - start)
        axes.annotate(
            word,
            end,
            xytext=tuple(WORD_BEYOND * way),
            textcoords="offset points",
            ha="center" if style == "->" else "left",
            va="center",
            fontsize=SMALL,
            path_effects=HALO,
        )

    def close(self) -> None:
        """Give the memory of the pictures back."""
        if self._view is not None:
            self._view.close()
