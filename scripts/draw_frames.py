"""Draw frames of a two-dimensional run one below the other, into a PNG.

python scripts/draw_frames.py RUN FILE.png --times 0,2.6,4.5 [--by speed] [--window x0,x1,y0,y1]
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
@click.argument("run", type=click.Path(path_type=Path, exists=True))
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--times", required=True, help="Times, s, separated by commas; the nearest frames.")
@click.option("--by", default="kind", show_default=True, help="kind, speed or a point array.")
@click.option("--window", help="x0,x1,y0,y1 in m; everything if left out.")
@click.option("--equal/--stretched", default=True, help="Same scale on both axes.")
def main(run: Path, file: Path, times: str, by: str, window: str | None, equal: bool) -> None:
    """Draw frames of RUN into FILE."""
    frames = read_collection(run / "particles.pvd")
    known = np.array([time for time, _ in frames])
    wanted = [int(np.argmin(np.abs(known - float(t)))) for t in times.split(",")]
    figure, rows = plt.subplots(
        len(wanted), 1, figsize=(12, 1.7 * len(wanted)), squeeze=False, layout="constrained"
    )
    for axes, k in zip(rows[:, 0], wanted, strict=True):
        time, path = frames[k]
        draw(axes, path, by)
        axes.set_title(f"t = {time:.2f} s", fontsize=9, loc="left", pad=2)
        axes.set_ylabel("y (m)")
        axes.set_aspect("equal" if equal else "auto")
        if window:
            x0, x1, y0, y1 = (float(v) for v in window.split(","))
            axes.set_xlim(x0, x1)
            axes.set_ylim(y0, y1)
    rows[-1, 0].set_xlabel("x (m)")
    if by == "kind":
        handles, labels = rows[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=6, markerscale=3)
    figure.savefig(file, dpi=90)
    click.echo(f"wrote {file}")


if __name__ == "__main__":
    main()
