"""Pictures of particles by VTK: sections, which cover a window of two axes, and a perspective."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
import pyvista
from numpy.typing import NDArray

from debrisflow.results.pictures.coloring import Colors
from debrisflow.space.scene import Scene

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
ROUND = 10  # corners of a disk
# Radii, in spacings, of a disk and of a sphere as large as what a particle stands for
DISK, SPHERE = np.sqrt(1.0 / np.pi), np.cbrt(0.75 / np.pi)
OPENING = 24.0  # angle of the camera, degrees; a wide one would distort a flume
FLOOR, WALL, OBSTACLE, EDGE = "#dddddd", "#c9d3da", "#7f7f7f", "#444444"


class Window(NamedTuple):
    """A rectangle of a section, m: its ends to the right and up."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """Return the extent to the right, m."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Return the extent up, m."""
        return self.top - self.bottom


class Tiles(NamedTuple):
    """Particles of a section.

    Attributes
    ----------
    right, up : (n,) array, m
    depth : (n,) array, m
        Distance from the eye, up to a constant: the nearer particle covers the other.
    color : (n, 3) uint8 array
    square : (n,) bool array
        Drawn as a square of one spacing, otherwise as a disk of the same area.
    """

    right: Floats
    up: Floats
    depth: Floats
    color: Colors
    square: NDArray[np.bool_]


class SectionView:
    """A camera that sees a window of a section, stretched to a picture; true to the pixel.

    Parameters
    ----------
    window : Window
    pixels : (int, int)
        Width and height of the picture.
    spacing : float, m
        Of the particles; they are stretched as the picture is.
    """

    def __init__(self, window: Window, pixels: tuple[int, int], spacing: float) -> None:
        self.window, self.pixels, self.spacing = window, pixels, spacing
        self.plotter = pyvista.Plotter(off_screen=True, window_size=pixels, lighting="none")
        width, height = pixels
        self.scale = np.array([width / window.width, height / window.height])
        camera = self.plotter.camera
        self.plotter.enable_parallel_projection()
        camera.focal_point = (0.5 * width, 0.5 * height, 0.0)
        camera.position = (0.5 * width, 0.5 * height, 2.0)
        camera.up, camera.parallel_scale = (0.0, 1.0, 0.0), 0.5 * height
        camera.clipping_range = (0.5, 3.0)

    def picture(self, tiles: Tiles) -> Image:
        """Return the picture of particles, (height, width, 3) array of 0 to 255."""
        away = tiles.depth - (tiles.depth.min() if tiles.depth.size else 0.0)
        nearness = 1.0 - away / (away.max() if away.any() else 1.0)
        center = np.column_stack([tiles.right, tiles.up]) - (self.window.left, self.window.bottom)
        for name, corners, chosen in (
            ("squares", 4, tiles.square),
            ("disks", ROUND, ~tiles.square),
        ):
            self.plotter.remove_actor(name, render=False)
            if chosen.any():
                mesh = self._polygons(corners, center[chosen], nearness[chosen])
                mesh.cell_data["color"] = tiles.color[chosen]
                self.plotter.add_mesh(
                    mesh, name=name, scalars="color", rgb=True, reset_camera=False, render=False
                )
        return _shot(self.plotter)

    def _polygons(self, corners: int, center: Floats, nearness: Floats) -> pyvista.PolyData:
        """Return a regular polygon a particle, in pixels; of 4 corners one whose sides are d0."""
        angle = 2.0 * np.pi * (np.arange(corners) + 0.5) / corners
        reach = np.sqrt(0.5) if corners == 4 else DISK
        spokes = reach * self.spacing * np.column_stack([np.cos(angle), np.sin(angle)])
        points = np.empty((len(center), corners, 3), dtype=np.float32)
        points[:, :, :2] = (center[:, None, :] + spokes) * self.scale
        points[:, :, 2] = nearness[:, None]
        faces = np.arange(len(center) * corners).reshape(-1, corners)
        return pyvista.PolyData.from_regular_faces(points.reshape(-1, 3), faces)

    def close(self) -> None:
        """Give the picture's memory back."""
        self.plotter.close()


class Camera(NamedTuple):
    """A place to look from, and where to look.

    Attributes
    ----------
    position, focus : (3,) float64 array, m
    right, up, back : (3,) float64 array
        Unit vectors of the picture; back points to the eye.
    """

    position: Floats
    focus: Floats
    right: Floats
    up: Floats
    back: Floats

    def seen(self, points: Floats) -> Floats:
        """Return where points appear, (n, 2) tangents of the angles to the right and up."""
        ray = points - self.position
        distance = -(ray @ self.back)[:, None]
        return np.column_stack([ray @ self.right, ray @ self.up]) / distance

    @classmethod
    def on(cls, corners: Floats, toward: Floats, upward: Floats, margin: float) -> Self:
        """Return the camera that sees all corners, the widest extent over its whole angle.

        Parameters
        ----------
        corners : (n, 3) array, m
        toward : (3,) array
            Direction from what is seen to the eye.
        upward : (3,) array
        margin : float
            Share of the angle left free on each side.
        """
        back = toward / np.linalg.norm(toward)
        right = np.cross(upward, back)
        right /= np.linalg.norm(right)
        up = np.cross(back, right)
        half = np.tan(np.radians(0.5 * OPENING)) * (1.0 - 2.0 * margin)
        focus = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        distance = float(np.linalg.norm(corners - focus, axis=1).max()) / half
        # what is near looks larger, so that the middle and the distance are found by trial
        for _ in range(30):
            camera = cls(focus + distance * back, focus, right, up, back)
            seen = camera.seen(corners)
            middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
            focus = focus + distance * (middle[0] * right + middle[1] * up)
            extent = 0.5 * float((seen.max(axis=0) - seen.min(axis=0)).max())
            distance *= extent / half
        return cls(focus + distance * back, focus, right, up, back)


class PerspectiveView:
    """A camera that sees floor, walls and obstacles, and the particles among them.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    pixels : (int, int)
        Width and height of the picture.
    spacing : float, m
        Of the particles.
    """

    def __init__(
        self, scene: Scene, camera: Camera, pixels: tuple[int, int], spacing: float
    ) -> None:
        self.pixels, self.spacing = pixels, spacing
        self.plotter = pyvista.Plotter(off_screen=True, window_size=pixels)
        self._add_surfaces(scene)
        view = self.plotter.camera
        view.position, view.focal_point, view.up = camera.position, camera.focus, camera.up
        # VTK's angle is that of the height, ours that of the longer side
        half = np.tan(np.radians(0.5 * OPENING)) * pixels[1] / max(pixels)
        view.view_angle = float(2.0 * np.degrees(np.arctan(half)))
        self.plotter.renderer.ResetCameraClippingRange()

    def picture(self, position: Floats, color: Colors) -> Image:
        """Return the picture of particles, (height, width, 3) array of 0 to 255."""
        self.plotter.remove_actor("particles", render=False)
        if len(position):
            points = pyvista.PolyData(position)
            points["color"] = color
            actor = self.plotter.add_mesh(
                points,
                name="particles",
                style="points_gaussian",
                render_points_as_spheres=True,
                emissive=False,
                ambient=0.6,  # so much that the colors stay those of the key
                diffuse=0.5,
                scalars="color",
                rgb=True,
                reset_camera=False,
                render=False,
            )
            actor.mapper.scale_factor = SPHERE * self.spacing
        return _shot(self.plotter)

    def add_ground(self, ground: pyvista.StructuredGrid, lines: pyvista.PolyData) -> None:
        """Show a terrain whose points have the color ``shade``, and lines on it."""
        known = {"lighting": False, "reset_camera": False, "render": False}
        self.plotter.add_mesh(ground, scalars="shade", rgb=True, **known)
        if lines.n_cells:
            self.plotter.add_mesh(lines, color=EDGE, line_width=2, opacity=0.5, **known)
        self.plotter.renderer.ResetCameraClippingRange()

    def close(self) -> None:
        """Give the picture's memory back."""
        self.plotter.close()

    def _add_surfaces(self, scene: Scene) -> None:
        for rectangles, color, opacity in (
            (scene.floor, FLOOR, 1.0),
            (scene.behind, WALL, 0.6),
            (scene.before, WALL, 0.0),
        ):
            if not rectangles:
                continue
            surface = _surface(np.stack(rectangles))
            if opacity > 0.0:
                self.plotter.add_mesh(surface, color=color, opacity=opacity, lighting=False)
            self.plotter.add_mesh(surface.extract_all_edges(), color=EDGE, line_width=2)
        self.show_obstacles(scene.obstacles)

    def show_obstacles(self, obstacles: list[Floats]) -> None:
        """Show the faces of obstacles, (n, 3 or 4, 3) arrays, m, instead of those shown before."""
        for k, faces in enumerate(obstacles):
            surface = _surface(faces).clean()
            self.plotter.add_mesh(
                surface,
                name=f"obstacle {k}",
                color=OBSTACLE,
                ambient=0.5,
                diffuse=0.6,
                reset_camera=False,
                render=False,
            )
            edges = surface.extract_feature_edges(30.0)
            if edges.n_cells:
                self.plotter.add_mesh(
                    edges,
                    name=f"edges {k}",
                    color=EDGE,
                    line_width=2,
                    reset_camera=False,
                    render=False,
                )


def _surface(faces: Floats) -> pyvista.PolyData:
    numbers = np.arange(faces.shape[0] * faces.shape[1]).reshape(faces.shape[:2])
    return pyvista.PolyData.from_regular_faces(faces.reshape(-1, 3), numbers)


def _shot(plotter: pyvista.Plotter) -> Image:
    # pictures are made larger and reduced, which smooths edges; twice takes 3 times as long
    plotter.render_window.SetMultiSamples(0)
    plotter.render()
    return np.asarray(plotter.screenshot(return_img=True))
