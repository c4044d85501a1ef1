"""Draw frames of two-dimensional runs, times one below the other and runs side by side.

python scripts/draw_frames.py RUN... FILE.png --times 0,2.6,4.5 [--by speed] [--window x0,x1,y0,y1]
"""

from __future__ import annotations

from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
import pyvista

from debrisflow.particles import Kind
from debrisflow.vtu import read_collection

mpl.use("Agg")
from matplotlib import pyplot as plt

# colors of Okabe & Ito, which color-blind readers can tell apart
COLORS = {
    Kind.LIQUID: "#56b4e9",
    Kind.SEDIMENT: "#d55e00",
    Kind.MIXTURE: "#e69f00",
    Kind.WALL: "#555555",
    Kind.DUMMY: "#bbbbbb",
    Kind.INFLOW: "#009e73",
}


def draw(axes: plt.Axes, path: Path, by: str) -> None:
    """Draw one particle file, colored by kind or by a point array."""
    frame = pyvista.read(path)
    x, y, _ = frame.points.T
    kind = frame["kind"]
    size = 4.0 if frame.n_points < 20_000 else 0.5
    moving = kind <= Kind.MIXTURE
    for which in Kind:
        rows = (kind == which) & ((by == "kind") | ~moving)
        if rows.any():
            label = which.name.lower()
            axes.scatter(x[rows], y[rows], s=size, c=COLORS[which], lw=0, label=label)
    if by != "kind":
        values = np.linalg.norm(frame["velocity"], axis=1) if by == "speed" else frame[by]
        drawn = axes.scatter(x[moving], y[moving], s=size, c=values[moving], lw=0, cmap="viridis")
        axes.figure.colorbar(drawn, ax=axes, pad=0.01, label=by)


@click.command()
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--times", required=True, help="Times, s, separated by commas; the nearest frames.")
@click.option("--by", default="kind", show_default=True, help="kind, speed or a point array.")
@click.option("--window", help="x0,x1,y0,y1 in m; everything if left out.")
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
    figure, grid = plt.subplots(
        len(wanted),
        len(runs),
        figsize=(12, height * len(wanted)),
        squeeze=False,
        layout="constrained",
    )
    for column, run in zip(grid.T, runs, strict=True):
        frames = read_collection(run / "particles.pvd")
        known = np.array([time for time, _ in frames])
        for axes, moment in zip(column, wanted, strict=True):
            time, path = frames[int(np.argmin(np.abs(known - moment)))]
            draw(axes, path, by)
            name = f"{run.name}, " if len(runs) > 1 else ""
            axes.set_title(f"{name}t = {time:.2f} s", fontsize=9, loc="left", pad=2)
            axes.set_aspect("equal" if equal else "auto")
            if window:
                x0, x1, y0, y1 = (float(v) for v in window.split(","))
                axes.set_xlim(x0, x1)
                axes.set_ylim(y0, y1)
        column[-1].set_xlabel("x (m)")
    for axes in grid[:, 0]:
        axes.set_ylabel("y (m)")
    if by == "kind":
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=6, markerscale=3)
    figure.savefig(file, dpi=90)
    click.echo(f"wrote {file}")


if __name__ == "__main__":
    main()
