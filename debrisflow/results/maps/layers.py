"""The layers of a run as maps show them: cut to the flow, without what is below the threshold."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import Raster, raster_of_plan
from debrisflow.errors import OutputError
from debrisflow.results.hazard import ClassMap, class_names, read_class_map
from debrisflow.results.layers import layer_file, read_layer
from debrisflow.results.maps.looks import DEPTH, LOOKS, Look, Scale, scale_of
from debrisflow.results.maps.part import SHEET, coarsened, part_around
from debrisflow.results.reader import Run
from debrisflow.run.layers import FOLDER, FRAME, FRAME_TIMES
from debrisflow.run.tables import read_table
from debrisflow.space.ground import ground_of

Floats = NDArray[np.float64]
MOST_FRAMES = 10**9
REDUCED: dict[str, Callable[..., Floats]] = {"arrival": np.fmin.reduce, "terrain": np.mean}


class Layer(NamedTuple):
    """A layer over the part of the map that is shown.

    Attributes
    ----------
    name : str
    look : Look
    values : (rows, columns) float64 array
        The northernmost row first; nan where it is not shown.
    scale : Scale
        Its classes; the first begins at the threshold of a depth.
    source : str
        Of the thresholds of a map of classes.
    """

    name: str
    look: Look
    values: Floats
    scale: Scale
    source: str = ""


class Layers:
    """The layers that the folder of a run holds.

    Parameters
    ----------
    run : Run
    aspects : (float, float)
        The least and the greatest height over width of the part that is shown.
    most_cells : float
        Of that part; of more, blocks of cells become one: the greatest value of the flow and its
        first arrival, the mean of the terrain.

    Attributes
    ----------
    threshold : float, m
        Depth below which a cell counts as not reached.

    Raises
    ------
    OutputError
        If the terrain is not among them.
    """

    def __init__(
        self, run: Run, aspects: tuple[float, float] = SHEET, most_cells: float = np.inf
    ) -> None:
        self._folder, self._aspects, self._most = run.folder, aspects, most_cells
        self.threshold = run.case.output.layer_depth
        if not has_layers(run):
            raise OutputError(
                f"{run.folder} has no layers to draw: {FOLDER}/ lacks the terrain, which only a "
                "run on a terrain writes"
            )

    @cached_property
    def terrain(self) -> Raster:
        """The elevation, m, over the part that is shown."""
        return self._cropped("terrain", self._whole("terrain"))

    @cached_property
    def release(self) -> Floats | None:
        """The depth of what is released, m, nan where nothing is; None if not known."""
        if layer_file(self._folder, "release") is None:
            return None
        values = self._cropped("release", self._whole("release")).values
        return np.where(values > 0.0, values, np.nan)

    @property
    def names(self) -> list[str]:
        """Names of the layers that can be shown, those of classes last."""
        known = [name for name in LOOKS if layer_file(self._folder, name) is not None]
        return known + class_names(self._folder)

    def layer(self, name: str) -> Layer:
        """Return a layer over the part that is shown.

        Raises
        ------
        OutputError
            If there is none of this name, or its file is damaged.
        """
        if name not in self.names:
            there = ", ".join(self.names) or "none"
            raise OutputError(f"{self._folder} has no layer '{name}' to show; there are: {there}")
        if name not in LOOKS:
            return self._classes(name, read_class_map(self._folder, name))
        return self._shown(name, LOOKS[name])

    @cached_property
    def frames(self) -> list[tuple[float, str]]:
        """Times, s, and names of the depths at times, if the run kept any."""
        listing = self._folder / FOLDER / FRAME_TIMES
        if not listing.is_file():
            return []
        table = read_table(listing, needed=("time", "frame"))
        time, frame = table["time"], table["frame"]
        if not (
            np.isfinite(time).all()
            and np.all(np.diff(time) >= 0.0)
            and np.all((frame >= 0.0) & (frame < MOST_FRAMES) & (np.floor(frame) == frame))
        ):
            raise OutputError(f"{listing} is damaged: its times or numbers are none of frames")
        named = [
            (float(time), f"{FRAME}_{int(number):06d}")
            for time, number in zip(table["time"], table["frame"], strict=True)
        ]
        return [one for one in named if layer_file(self._folder, one[1]) is not None]

    def frame(self, name: str) -> Layer:
        """Return the depth at a time by its name."""
        return self._shown(name, DEPTH)

    def _shown(self, name: str, look: Look) -> Layer:
        least = self.threshold if look.is_depth else 0.0
        values = self._cropped(name, self._whole(name)).values
        shown = np.where(values >= least, values, np.nan)
        return Layer(name, look, shown, scale_of(look, shown, least))

    def _classes(self, name: str, found: ClassMap) -> Layer:
        values = self._cropped(name, found.raster).values
        bounds = np.arange(0.5, len(found.names) + 1.0)
        scale = Scale(bounds, found.colors, found.names)
        return Layer(name, Look(found.title, "", found.colors), values, scale, found.source)

    @cached_property
    def _part(self) -> tuple[float, float, float, float]:
        """West, south, east and north of the part that is shown, m."""
        touched = np.zeros(self._whole("terrain").grid.shape, dtype=bool)
        for name in ("peak_depth", "release"):
            if layer_file(self._folder, name) is not None:
                touched |= self._whole(name).values >= self.threshold
        return part_around(self._whole("terrain").grid, touched, self._aspects)

    def _whole(self, name: str) -> Raster:
        return read_layer(self._folder, name)

    def _cropped(self, name: str, raster: Raster) -> Raster:
        if raster.grid[:5] != self._whole("terrain").grid[:5]:
            raise OutputError(
                f"{self._folder}: the layer '{name}' is not on the grid of the terrain"
            )
        part = raster.cropped(*self._part)
        factor = int(np.ceil(np.sqrt(part.values.size / self._most)))
        return coarsened(part, factor, REDUCED.get(name, np.fmax.reduce))


def has_layers(run: Run) -> bool:
    """Return whether a run has left layers of a map."""
    return layer_file(run.folder, "terrain") is not None


def terrain_around(run: Run) -> Raster:
    """Return the ground of a run on the cells of its DEM, in the coordinates of its particles.

    It is the smooth surface over which they run, without what was taken out of the terrain.
    """
    ground = ground_of(run.case)
    grid = ground.grid._replace(west=0.0, south=0.0)
    x, y = (grid.cell * (np.arange(count) + 0.5) for count in (grid.columns, grid.rows))
    level = ground.surface.level(*np.meshgrid(x, y, indexing="ij"))
    return raster_of_plan(grid, np.where(np.isfinite(ground.given), level, np.nan))
