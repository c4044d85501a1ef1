"""Draw frames of runs, times one below the other and runs side by side.

Of runs in three dimensions each frame is drawn twice, from above and from the side, with the
outlines of tank and obstacles.

python scripts/draw_frames.py RUN... FILE.png --times 0,2.6,4.5 [--by speed] [--window x0,x1,y0,y1]
"""

from __future__ import annotations

from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
import pyvista

from debrisflow.case import load_case, tables
from debrisflow.case.bodies import BoxObstacle
from debrisflow.case.fields import Interval
from debrisflow.case.regions import recess, runout_rise, surface_of
from debrisflow.case.shapes import Channel3D, is_three_dimensional, plain_edges
from debrisflow.output import CASE, FRAMES
from debrisflow.particles import Kind
from debrisflow.vtu import read_collection

mpl.use("Agg")
from matplotlib import pyplot as plt

Box = tuple[Interval, Interval, Interval]
# axes that are drawn to the right and up
ABOVE, SIDE = [0, 1], [0, 2]
# colors of Okabe & Ito, which color-blind readers can tell apart
COLORS = {
    Kind.LIQUID: "#56b4e9",
    Kind.SEDIMENT: "#d55e00",
    Kind.MIXTURE: "#e69f00",
    Kind.WALL: "#555555",
    Kind.DUMMY: "#bbbbbb",
    Kind.INFLOW: "#009e73",
}


def draw(axes: plt.Axes, path: Path, by: str, view: list[int]) -> None:
    """Draw one particle file, colored by kind or by a point array, as seen along the third axis."""
    frame = pyvista.read(path)
    # what is nearer to the eye comes last and covers the rest; in two dimensions nothing does
    nearness = frame.points[:, 2] if view == ABOVE else -frame.points[:, 1]
    order = np.argsort(nearness, kind="stable")
    x, y = frame.points[order][:, view].T
    kind = frame["kind"][order]
    size = 4.0 if frame.n_points < 20_000 else 0.5
    moving = kind <= Kind.MIXTURE
    for which in Kind:
        rows = (kind == which) & ((by == "kind") | ~moving)
        if rows.any():
            label = which.name.lower()
            axes.scatter(x[rows], y[rows], s=size, c=COLORS[which], lw=0, label=label)
    if by != "kind":
        values = np.linalg.norm(frame["velocity"], axis=1) if by == "speed" else frame[by]
        values = values[order][moving]
        drawn = axes.scatter(x[moving], y[moving], s=size, c=values, lw=0, cmap="viridis")
        axes.figure.colorbar(drawn, ax=axes, pad=0.01, label=by)


def outline(axes: plt.Axes, case: tables.Case, view: list[int]) -> None:
    """Draw the edges of a space in three dimensions, of its boxes and of its meshes' triangles."""
    boxes = spaces(axes, case, view)
    for obstacle in case.obstacle:
        if isinstance(obstacle, BoxObstacle):
            boxes.append((obstacle.x, obstacle.y, obstacle.z))
            continue
        for corners in surface_of(obstacle).corners:
            triangle = corners[[0, 1, 2, 0]][:, view]
            axes.plot(*triangle.T, color=COLORS[Kind.WALL], linewidth=0.3)
    for box in boxes:
        (left, right), (lower, upper) = (box[axis] for axis in view)
        edges = plt.Rectangle((left, lower), right - left, upper - lower)
        edges.set(fill=False, edgecolor=COLORS[Kind.WALL], linewidth=1.0)
        axes.add_patch(edges)


def spaces(axes: plt.Axes, case: tables.Case, view: list[int]) -> list[Box]:
    """Return tank or flume, its recess and its run-out as boxes; from the side draw a run-out."""
    shape = case.geometry
    assert is_three_dimensional(shape)
    start = shape.runout_start if isinstance(shape, Channel3D) else None
    end = shape.length if start is None else start
    boxes: list[Box] = [((0.0, end), (0.0, shape.width), (0.0, shape.height))]
    hollow = recess(shape, case.particles)
    if hollow is not None:
        x, y, z = zip(hollow.lower, hollow.upper, strict=True)
        boxes.append((x, y, z))
    if isinstance(shape, Channel3D) and start is not None:
        rise, across = runout_rise(shape, case.gravity), plain_edges(shape) or (0.0, shape.width)
        if view == ABOVE:
            boxes.append(((start, shape.length), across, (0.0, rise)))
        else:
            axes.plot([start, shape.length], [0.0, rise], color=COLORS[Kind.WALL], linewidth=1.0)
    return boxes


@click.command()
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--times", required=True, help="Times, s, separated by commas; the nearest frames.")
@click.option("--by", default="kind", show_default=True, help="kind, speed or a point array.")
@click.option("--window", help="x0,x1,y0,y1 in m, of every panel; all if left out.")
@click.option("--equal/--stretched", default=True, help="Same scale on both axes.")
@click.option("--height", default=1.7, show_default=True, help="Height of a frame, inches.")
def main(
    runs: tuple[Path, ...],
    file: Path,
    times: str,
    by: str,
    window: str | None,
    equal: bool,
    height: float,
) -> None:
    """Draw frames of RUNS into FILE."""
    wanted = [float(t) for t in times.split(",")]
    cases = [load_case(run / CASE) for run in runs]
    views = [ABOVE, SIDE] if any(case.dimension == 3 for case in cases) else [ABOVE]
    figure, grid = plt.subplots(
        len(wanted),
        len(runs) * len(views),
        figsize=(12, height * len(wanted)),
        squeeze=False,
        layout="constrained",
    )
    of_run = np.split(grid, len(runs), axis=1)
    for panels, run, case in zip(of_run, runs, cases, strict=True):
        frames = read_collection(run / FRAMES)
        known = np.array([time for time, _ in frames])
        for row, moment in zip(panels, wanted, strict=True):
            time, path = frames[int(np.argmin(np.abs(known - moment)))]
            name = f"{run.name}, " if len(runs) > 1 else ""
            row[0].set_title(f"{name}t = {time:.2f} s", fontsize=9, loc="left", pad=2)
            for axes, view in zip(row, views, strict=True):
                draw(axes, path, by, view)
                if case.dimension == 3:
                    outline(axes, case, view)
                axes.set_aspect("equal" if equal else "auto")
                if len(views) > 1 or run is runs[0]:
                    axes.set_ylabel(f"{'xyz'[view[1]]} (m)")
                if window:
                    x0, x1, y0, y1 = (float(v) for v in window.split(","))
                    axes.set_xlim(x0, x1)
                    axes.set_ylim(y0, y1)
    for axes in grid[-1]:
        axes.set_xlabel("x (m)")
    if by == "kind":
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=6, markerscale=3)
    figure.savefig(file, dpi=90)
    click.echo(f"wrote {file}")


if __name__ == "__main__":
    main()
