"""What a panel of a page shows: the side, the plan with the deposit, or the perspective."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.record import Kind
from debrisflow.results.deposition import deposition
from debrisflow.results.frames import Frame
from debrisflow.results.pictures.coloring import Scale
from debrisflow.results.pictures.sheet import SMALL, panel_width
from debrisflow.results.pictures.views import (
    OPENING,
    Camera,
    PerspectiveView,
    SectionView,
    Tiles,
    Window,
)
from debrisflow.space.floor import floor_bend, floor_level, height_over_floor
from debrisflow.space.plan_grid import Grid, floor_length, plan, wrapped
from debrisflow.space.scene import (
    closed_ends,
    edges_across,
    faces_with_images,
    floor_profile,
    has_sides,
    head_walls,
    scene_of,
    section_lines,
    trajectories,
)

Floats = NDArray[np.float64]
Pixels = tuple[int, int]
MARGIN = 2.0  # spacings around the space
FINER = 2  # pixels of VTK a pixel of the page, along each axis: smooth edges
LOWEST_PANEL = 1.7  # cm; a flatter panel is stretched upward
STRETCHES = (1, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50)
# from what is seen to the eye: along the flow, across, and against gravity
TOWARD_EYE = (0.45, -1.0, 0.75)
FREE = 0.03  # share of a perspective that is left free at each side
ROUND_STEPS = [1, 2, 2.5, 5, 10]
LINE, SOLID = "#333333", "#9a9a9a"
SLACK = 0.1  # spacings by which a contour is lower than its label
APART = 11.0  # points between the labels of contours
HALO: list[AbstractPathEffect] = [withStroke(linewidth=1.6, foreground="white")]
# Share of the particles of a frame that may be above what a picture shows, drops
DROPS = 0.001


class Panels(Protocol):
    """A way to see the frames of a run."""

    name: str
    aspect: float
    room: float
    remark: str

    def draw(self, axes: Axes, frame: Frame, scale: Scale, pixels: Pixels) -> None:
        """Draw a frame into empty axes whose size in pixels is given."""

    def close(self) -> None:
        """Give the memory of the pictures back."""


class Extent(NamedTuple):
    """How far the flow of some frames reaches up, without drops, m.

    Attributes
    ----------
    top : float
        Along the upward axis, a run-out straightened.
    depth : float
        Over the floor.
    """

    top: float
    depth: float


def extent_of(case: ResolvedCase, frame: Frame) -> Extent:
    """Return how far the flow of a frame reaches up."""
    up, d0 = case.dimension - 1, case.particles.spacing
    position = wrapped(case, frame.position[frame.fluid])
    if not len(position):
        return Extent(d0, d0)
    x, level = position[:, 0], position[:, up]
    inside = (x > 0.0) & (x < floor_length(case))
    height = height_over_floor(case, x, level, x)[inside]
    share, level = 1.0 - DROPS, straightened(case, x, level)
    depth = float(np.quantile(height, share)) if height.size else 0.0
    return Extent(float(np.quantile(level, share)) + 0.5 * d0, max(depth, 0.0) + 0.5 * d0)


def highest(extents: Sequence[Extent]) -> Extent:
    """Return the extent of all frames together."""
    return Extent(*np.max(extents, axis=0).tolist())


def straightened(case: ResolvedCase, x: Floats, level: Floats) -> Floats:
    """Return levels as if a run-out went on without its bend: heights along its normal, m.

    Parameters
    ----------
    case : ResolvedCase
    x, level : (n,) array, m
    """
    bend = floor_bend(case, x)
    start = getattr(case.geometry, "runout_start", None) or 0.0
    straight: Floats = (level - np.tan(bend) * (x - start)) * np.cos(bend)
    return straight


def side_window(case: ResolvedCase, extent: Extent) -> Window:
    """Return what a side view shows: the floor with its ends, and the flow."""
    margin = MARGIN * case.particles.spacing
    level = straight_profile(case)[:, 1]
    bottom, top = level.min(), max(extent.top, level.max())
    free = max(margin, 0.08 * (top - bottom))
    return Window(-margin, floor_length(case) + margin, bottom - margin, top + free)


def straight_profile(case: ResolvedCase) -> Floats:
    """Return the corners of the floor, a run-out straightened, (n, 2) array, m."""
    x, level = np.array(floor_profile(case)).T
    return np.column_stack([x, straightened(case, x, level)])


class SidePanels:
    """Particles from the side, the nearest in front; heights stretched where a flume is flat.

    Parameters
    ----------
    case : ResolvedCase
    window : Window
    """

    name = "side"
    room = 1.55

    def __init__(self, case: ResolvedCase, window: Window) -> None:
        self.case, self.window = case, window
        natural = panel_width(self.room) * window.height / window.width
        enough = (s for s in STRETCHES if s * natural >= LOWEST_PANEL)
        self.stretch = next(enough, STRETCHES[-1])
        self.aspect = self.stretch * window.height / window.width
        remarks = [f"heights stretched {self.stretch} times"] if self.stretch > 1 else []
        bend = getattr(case.geometry, "runout_start", None)
        if bend is not None:
            remarks.append(f"floor beyond its bend at x = {bend:g} m drawn straight")
        self.bend, self.remark = bend, ", ".join(remarks)
        self._view: SectionView | None = None

    def draw(self, axes: Axes, frame: Frame, scale: Scale, pixels: Pixels) -> None:
        """Draw a frame into empty axes."""
        up = self.case.dimension - 1
        self._view = _fresh(self._view, self.window, pixels, self.case)
        position = wrapped(self.case, frame.position)
        depth = position[:, 1] if up == 2 else np.zeros(len(position))
        solid = (frame.kind == Kind.WALL) | (frame.kind == Kind.DUMMY)
        x, level = position[:, 0], straightened(self.case, position[:, 0], position[:, up])
        tiles = Tiles(x, level, depth, scale.colors(frame), solid)
        _show(axes, self._view.picture(tiles), self.window)
        word = f"{'xyz'[up]} (m)" if self.bend is None else "height (m)"
        axes.set_ylabel(word, fontsize=SMALL, labelpad=2)
        if self.bend is not None:
            axes.axvline(self.bend, color=LINE, linewidth=0.7, linestyle=":")
        if not solid.any():
            self._draw_surroundings(axes, frame.time)

    def _draw_surroundings(self, axes: Axes, time: float) -> None:
        up = self.case.dimension - 1
        x, level = straight_profile(self.case).T
        axes.plot(x, level, color=LINE, linewidth=0.9)
        axes.fill_between(x, level, self.window.bottom, color=SOLID, linewidth=0.0)
        ends = [np.array([(x, 0.0), (x, self.window.top)]) for x in closed_ends(self.case)]
        for line in section_lines(self.case)[1:] if up == 1 else ends:
            axes.plot(*line.T, color=LINE, linewidth=0.9, scaley=False)
        faces = []
        for face in (face for body in faces_with_images(self.case, time) for face in body):
            x, level = face[:, 0], straightened(self.case, face[:, 0], face[:, up])
            faces.append(np.column_stack([x, level]))
        axes.add_collection(
            PolyCollection(
                faces,
                facecolors=SOLID,
                edgecolors=SOLID,
                linewidths=0.5,
                alpha=1.0 if up == 1 else 0.6,  # in three dimensions particles stand behind
            )
        )

    def close(self) -> None:
        """Give the memory of the pictures back."""
        if self._view is not None:
            self._view.close()


class PlanPanels:
    """Particles from above with contours of the deposit height, in true proportions.

    Parameters
    ----------
    case : ResolvedCase
    frames : sequence of Frame
        From whose deposits the contours are chosen.
    """

    name = "plan"
    room = 1.55

    def __init__(self, case: ResolvedCase, frames: Sequence[Frame]) -> None:
        self.case, self.grid = case, plan(case)
        margin = MARGIN * case.particles.spacing
        front, back = self.grid.across[[0, -1]]
        self.window = Window(-margin, floor_length(case) + margin, front - margin, back + margin)
        self.aspect = self.window.height / self.window.width
        self._view: SectionView | None = None
        greatest = max(self.deposit(frame).max(initial=0.0) for frame in frames)
        self.in_centimeters = greatest >= 0.02
        self.levels = self._levels(float(greatest))
        unit = "cm" if self.in_centimeters else "mm"
        drawn = f"contours: height of the deposit in {unit}"
        self.remark = drawn if self.levels.size else ""

    def _levels(self, greatest: float) -> Floats:
        """Return heights of contours, m; none below a spacing, which a single layer has."""
        per_meter = 100.0 if self.in_centimeters else 1000.0
        levels = ticks(0.0, greatest * per_meter) / per_meter
        return levels[(levels < greatest) & (levels > self.case.particles.spacing)]

    def deposit(self, frame: Frame) -> Floats:
        """Return the deposit height over each cell of the plan, (n,) array, m."""
        return deposition(self.case, frame).table["deposit_height"]

    def draw(self, axes: Axes, frame: Frame, scale: Scale, pixels: Pixels) -> None:
        """Draw a frame into empty axes."""
        self._view = _fresh(self._view, self.window, pixels, self.case)
        position = wrapped(self.case, frame.position)
        disks = np.zeros(len(position), dtype=bool)
        x, y, z = position.T
        tiles = Tiles(x, y, -z, scale.colors(frame), disks)
        _show(axes, self._view.picture(tiles), self.window)
        axes.set_ylabel("y (m)", fontsize=SMALL, labelpad=2)
        self._draw_surroundings(axes, frame.time)
        if self.levels.size and frame.time > 0.0:  # what is there at the start is no deposit yet
            self._draw_contours(axes, self.deposit(frame))

    def _draw_contours(self, axes: Axes, deposit: Floats) -> None:
        if not deposit.max(initial=0.0) > self.levels[0]:
            return
        # from wall to wall: the middle of the last cell tells of its edge too
        height = np.pad(over_grid(self.grid, deposit), 1, mode="edge")
        x, y = (
            np.concatenate([edges[:1], 0.5 * (edges[:-1] + edges[1:]), edges[-1:]])
            for edges in (self.grid.along, self.grid.across)
        )
        table = np.ma.masked_invalid(height.T)
        # a bed just as high as a level would have a line around each cell
        drawn = self.levels - SLACK * self.case.particles.spacing
        lines = axes.contour(x, y, table, drawn, colors="black", linewidths=0.7)
        lines.set_path_effects(HALO)
        per_meter = 100.0 if self.in_centimeters else 1000.0
        named = zip(lines.levels, self.levels, strict=True)
        words = {line: f"{level * per_meter:g}" for line, level in named}
        kept: list[Floats] = []
        for label in axes.clabel(lines, fmt=words, fontsize=SMALL - 0.5, inline=False):
            place = np.asarray(axes.transData.transform(label.get_position()))
            apart = APART * axes.figure.dpi / 72.0
            if all(np.linalg.norm(place - other) > apart for other in kept):
                kept.append(place)
                label.set(path_effects=HALO, rotation=0.0)
            else:
                label.remove()

    def _draw_surroundings(self, axes: Axes, time: float) -> None:
        for (x0, y0), (x1, y1) in plan_outlines(self.case):
            axes.plot([x0, x1], [y0, y1], color=LINE, linewidth=0.9)
        axes.add_collection(
            PolyCollection(
                plan_obstacles(self.case, time), facecolors=SOLID, edgecolors=SOLID, linewidths=0.3
            )
        )

    def close(self) -> None:
        """Give the memory of the pictures back."""
        if self._view is not None:
            self._view.close()


def ticks(start: float, end: float) -> Floats:
    """Return four to six round numbers between two.

    Examples
    --------
    >>> ticks(0.0, 4.0)
    array([0., 1., 2., 3., 4.])
    """
    found = np.asarray(MaxNLocator(5, steps=ROUND_STEPS).tick_values(start, end))
    inside: Floats = found[(found >= start) & (found <= end)]
    return inside


def over_grid(grid: Grid, values: Floats) -> Floats:
    """Return the values of cells as a table along x and across; nan where there is no cell."""
    table = np.full(grid.number.shape, np.nan)
    table[grid.number >= 0] = values[grid.number[grid.number >= 0]]
    return table


def plan_outlines(case: ResolvedCase) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Return the lines of walls as seen from above, each by its two ends, (x, y) in m."""
    xs = sorted({x for x, _ in floor_profile(case)})
    lines = []
    for start, end in pairwise(xs):
        middle = 0.5 * (start + end)
        if has_sides(case, middle):
            lines += [((start, y), (end, y)) for y in edges_across(case, middle)]
    for x in closed_ends(case):
        front, back = edges_across(case, x)
        lines.append(((x, front), (x, back)))
    return lines + [((x, y0), (x, y1)) for x, y0, y1 in head_walls(case)]


def plan_obstacles(case: ResolvedCase, time: float) -> list[Floats]:
    """Return the faces of obstacles as seen from above at a time, s, (n, 2) arrays, m.

    What is over the side walls, as a gate that has been drawn, is left out.
    """
    top = case.geometry.height
    bodies = [body for body in faces_with_images(case, time) if body[..., 2].min() < top]
    return [face[:, :2] for body in bodies for face in body]


class PerspectivePanels:
    """Particles between floor, walls and obstacles, upright against gravity.

    Parameters
    ----------
    case : ResolvedCase
    extent : Extent
        Walls are shown as high as the flow, if they are higher.
    """

    name = "perspective"
    room = 0.35
    remark = ""

    def __init__(self, case: ResolvedCase, extent: Extent) -> None:
        self.case = case
        self.scene = scene_of(case, 1.2 * extent.depth)
        along, upward = -np.array(case.gravity.components)
        up = np.array([along, 0.0, upward])
        up = up / np.linalg.norm(up) if up.any() else np.array([0.0, 0.0, 1.0])
        level = np.array([up[2], 0.0, -up[0]])
        toward = TOWARD_EYE[0] * level + TOWARD_EYE[1] * np.array([0.0, 1.0, 0.0])
        corners = self.scene.corners
        self.camera = Camera.on(corners, toward + TOWARD_EYE[2] * up, up, FREE)
        seen = self.camera.seen(corners)
        width, height = (seen.max(axis=0) - seen.min(axis=0)) / (1.0 - 2.0 * FREE)
        self.aspect = float((height + 0.06 * width) / width)
        self._view: PerspectiveView | None = None

    def draw(self, axes: Axes, frame: Frame, scale: Scale, pixels: Pixels) -> None:
        """Draw a frame into empty axes."""
        fine = (FINER * pixels[0], FINER * pixels[1])
        if self._view is None or self._view.pixels != fine:
            self.close()
            spacing = self.case.particles.spacing
            self._view = PerspectiveView(self.scene, self.camera, fine, spacing)
        if trajectories(self.case):
            self._view.show_obstacles(faces_with_images(self.case, frame.time))
        position = wrapped(self.case, frame.position)
        image = self._view.picture(position, scale.colors(frame))
        half = float(np.tan(np.radians(0.5 * OPENING)))
        longer = max(pixels)
        right, up = (half * side / longer for side in pixels)
        axes.imshow(image, extent=(-right, right, -up, up), aspect="auto")
        axes.set_axis_off()
        self._draw_distances(axes)

    def _draw_distances(self, axes: Axes) -> None:
        """Write x along the nearer edge of the floor."""
        length = floor_length(self.case)
        marks = ticks(0.0, length)
        front = np.array([edges_across(self.case, x + 1e-9)[0] for x in marks])
        level = floor_level(self.case, marks)
        foot = self.camera.seen(np.column_stack([marks, front, level]))
        for (x, y), mark in zip(foot, marks, strict=True):
            word = f"x = {mark:g} m" if mark == marks[-1] else f"{mark:g}"
            axes.annotate(
                word,
                (x, y),
                xytext=(-3, -3),
                textcoords="offset points",
                ha="right",
                va="top",
                fontsize=SMALL - 1.0,
                path_effects=HALO,
            )

    def close(self) -> None:
        """Give the memory of the pictures back."""
        if self._view is not None:
            self._view.close()


def _fresh(
    view: SectionView | None, window: Window, pixels: Pixels, case: ResolvedCase
) -> SectionView:
    """Return a section that fits the pixels: the one there is, or a new one."""
    fine = (FINER * pixels[0], FINER * pixels[1])
    if view is not None and view.pixels == fine:
        return view
    if view is not None:
        view.close()
    return SectionView(window, fine, case.particles.spacing)


def _show(axes: Axes, image: NDArray[np.uint8], window: Window) -> None:
    axes.imshow(image, extent=window, aspect="auto")
    axes.set_xlim(window.left, window.right)
    axes.set_ylim(window.bottom, window.top)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=ROUND_STEPS))
