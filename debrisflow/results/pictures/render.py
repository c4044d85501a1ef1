"""Pictures and an animation of the particles of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pyvista
from matplotlib.axes import Axes
from numpy.typing import NDArray
from PIL import Image

from debrisflow.errors import OutputError
from debrisflow.particles.record import Kind
from debrisflow.results.fonts import writable
from debrisflow.results.frames import Frame, read_frame
from debrisflow.results.maps.layers import terrain_around
from debrisflow.results.parameters import format_length
from debrisflow.results.pictures.coloring import (
    KIND_COLORS,
    KIND_WORDS,
    Scale,
    default_field,
    scale_of,
)
from debrisflow.results.pictures.offscreen import require_offscreen
from debrisflow.results.pictures.panels import (
    Panels,
    PerspectivePanels,
    PlanPanels,
    SidePanels,
    extent_of,
    highest,
    side_window,
)
from debrisflow.results.pictures.sheet import TEXT, Sheet, layout
from debrisflow.results.pictures.terrain import TerrainPanels
from debrisflow.results.pictures.views import Window
from debrisflow.results.reader import BAR, Run, open_run
from debrisflow.run.atomic import made, replaced
from debrisflow.run.bar import bar
from debrisflow.run.names import PICTURES
from debrisflow.space.scene import scene_of

PANELS = 6
OF_GRAINS = ("concentration", "granular_temperature")
MOST_FRAMES = 100  # of an animation
DOTS, DOTS_OF_ANIMATION = 250, 140  # per inch of a page's width
SHORTEST, LONGEST, AT_END = 40, 250, 1500  # ms that a frame of an animation stands
COLORS = 256  # of a GIF


def render(
    folder: Path,
    by: str | None = None,
    times: Sequence[float] | None = None,
    view: Sequence[float] | None = None,
) -> list[Path]:
    """Draw the frames of a run into its folder ``render``.

    In two dimensions a page of panels from the side and their animation; in three a page in
    perspective and its animation, a page of the plan with the deposit, a page from the side.  On a
    terrain that in perspective alone, with the relief; ``debrisflow maps`` draws the plan.

    Parameters
    ----------
    folder : Path
        Of a finished or running run.
    by : str, optional
        What the colors say: ``kind`` or one of the fields of
        :mod:`debrisflow.results.pictures.coloring`; if left out the kind where there are several
        kinds, else the speed.
    times : sequence of float, optional
        Of the panels, s: the nearest frames; six evenly spread ones if left out.
    view : sequence of four float, optional
        Ends of x and of y that are shown, m, in two dimensions; all if left out.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    OutputError
        If the folder holds no frames or none at such times, a frame is missing or damaged, the
        colors are of grains and there are none, or nothing can be rendered here.
    """
    run = open_run(folder)
    if view is not None and run.case.dimension == 3:
        raise OutputError("a view of a part is for runs in two dimensions, and this one has three")
    known = run.times
    chosen = run.nearest(np.linspace(known[0], known[-1], PANELS) if times is None else times)
    moving = np.unique(np.linspace(0, len(run.files) - 1, MOST_FRAMES).round().astype(int))
    require_offscreen()
    with pyvista.vtk_verbosity("off"):  # VTK tells that there is no screen
        frames = [shown(run, number) for number in bar(chosen, desc="reading:", bar_format=BAR)]
        if by in OF_GRAINS and not any(
            frame.sediment_fraction[frame.fluid].any() for frame in frames
        ):
            raise OutputError(
                f"{folder} holds no grains at these times, so that {by} is 0 everywhere: color by "
                "another quantity"
            )
        by = by or default_field(frames)
        painter = Painter(run, scale_of(frames, by), kinds_of(frames))
        views = views_of(run, frames, moving, view)
        return [
            file for one in views for file in _write(painter, one, frames, moving, by, views[0])
        ]


def _write(
    painter: Painter,
    view: Panels,
    frames: Sequence[Frame],
    moving: NDArray[np.int64],
    by: str,
    animated: Panels,
) -> list[Path]:
    """Write the page of a view, and the animation of one of them, and return their files."""
    page = painter.page(view, frames)
    files = [made(painter.run.folder / PICTURES) / f"{view.name}_{by}.png"]
    with replaced(files[0]) as unfinished:
        page.save(unfinished, format="PNG", dpi=(DOTS, DOTS))
    if view is animated:
        files.append(files[0].with_suffix(".gif"))
        painter.animate(view, moving, files[1])
    view.close()
    return files


def shown(run: Run, number: int) -> Frame:
    """Return the particles of a frame that are drawn.

    In three dimensions without the waiting supply, which would stand before the end of the flume.
    """
    frame = read_frame(*run.files[number])
    return frame.of(frame.kind != Kind.INFLOW) if run.case.dimension == 3 else frame


def kinds_of(frames: Iterable[Frame]) -> set[int]:
    """Return which kinds of particles are in some frames."""
    return {int(kind) for frame in frames for kind in np.unique(frame.kind)}


def views_of(
    run: Run, frames: Sequence[Frame], moving: NDArray[np.int64], part: Sequence[float] | None
) -> list[Panels]:
    """Return the ways to see a run, the animated one first."""
    case = run.case
    if case.is_terrain:
        scene = scene_of(case, 0.0)
        return [TerrainPanels(terrain_around(run), scene, frames, case.particles.spacing)]
    extents = [extent_of(case, frame) for frame in frames]
    if case.dimension == 3:
        extent = highest(extents)
        side = SidePanels(case, side_window(case, extent))
        return [PerspectivePanels(case, extent), PlanPanels(case, frames), side]
    if part is not None:
        return [SidePanels(case, Window(*part))]
    read = bar(moving, desc="finding the highest flow:", bar_format=BAR)
    extents += [extent_of(case, shown(run, number)) for number in read]
    return [SidePanels(case, side_window(case, highest(extents)))]


class Painter:
    """Pages and animations of one run in one scale of colors.

    Parameters
    ----------
    run : Run
    scale : Scale
    kinds : set of int
        Of the particles, for the legend.
    """

    def __init__(self, run: Run, scale: Scale, kinds: set[int]) -> None:
        self.run, self.scale, self.kinds = run, scale, kinds
        least = float(np.diff(run.times).min(initial=1.0))
        self.decimals = max(2, int(np.ceil(-np.log10(max(least, 1e-6)))))

    def sheet(self, view: Panels, panels: int, dots: int) -> Sheet:
        """Return a page with its heading and the key of the colors."""
        case = self.run.case
        facts = [f"run {self.run.name}", f"particles of {format_length(case.particles.spacing)}"]
        if abs(case.gravity.fall) > 1e-9:
            facts.append(f"x falls by {np.degrees(case.gravity.fall):.3g}°")
        facts += [view.remark] if view.remark else []
        title = case.title if writable(case.title) else self.run.name
        plan = layout(panels, view.aspect, view.room)
        sheet = Sheet(panels, plan, dots, (title, ", ".join(facts)))
        if self.scale.by == "kind":
            sheet.add_kinds(self.legend())
        else:
            sheet.add_scale(self.scale)
        return sheet

    def legend(self) -> dict[str, str]:
        """Return a word for each color of the kinds that are shown."""
        words = {KIND_COLORS[kind]: word for kind, word in KIND_WORDS.items() if kind in self.kinds}
        if Kind.WALL in self.kinds:
            words[KIND_COLORS[Kind.WALL]] = "walls"
        return words

    def fill(self, axes: Axes, sheet: Sheet, view: Panels, frame: Frame) -> None:
        """Draw a frame and its time into axes."""
        view.draw(axes, frame, self.scale, sheet.pixels)
        time = f"t = {frame.time:.{self.decimals}f} s"
        axes.set_title(time, fontsize=TEXT, loc="left", pad=2)

    def page(self, view: Panels, frames: Sequence[Frame]) -> Image.Image:
        """Return a page with a panel a frame."""
        sheet = self.sheet(view, len(frames), DOTS)
        for number, frame in enumerate(bar(frames, desc=f"{view.name}, panels:", bar_format=BAR)):
            axes = sheet.panel(number)
            self.fill(axes, sheet, view, frame)
            sheet.label(axes, number)
        return Image.fromarray(sheet.image())

    def animate(self, view: Panels, numbers: NDArray[np.int64], file: Path) -> None:
        """Write an animation of some frames."""
        sheet = self.sheet(view, 1, DOTS_OF_ANIMATION)
        axes = sheet.panel(0)
        pictures: list[Image.Image] = []
        for number in bar(numbers, desc=f"{view.name}, animation:", bar_format=BAR):
            axes.clear()
            self.fill(axes, sheet, view, shown(self.run, number))
            sheet.label(axes, 0)
            pictures.append(Image.fromarray(sheet.image()))
        times = self.run.times[numbers]
        stands = np.clip(1000.0 * np.diff(times), SHORTEST, LONGEST)
        with replaced(file) as unfinished:
            write_animation(unfinished, pictures, [*stands.round().astype(int).tolist(), AT_END])


def write_animation(file: Path, pictures: Sequence[Image.Image], stands: list[int]) -> None:
    """Write pictures as a GIF that repeats; all have one palette, so that nothing flickers.

    Parameters
    ----------
    file : Path
    pictures : sequence of Image
    stands : list of int
        How long each stands, ms.
    """
    # the colors of first, middle and last frame
    samples = [pictures[k] for k in (0, len(pictures) // 2, -1)]
    palette = Image.fromarray(np.vstack([np.asarray(sample) for sample in samples]))
    palette = palette.quantize(COLORS, method=Image.Quantize.MEDIANCUT)
    first, *rest = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    first.save(file, format="GIF", save_all=True, append_images=rest, duration=stands, loop=0)
