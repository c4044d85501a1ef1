"""Draw what runs in three dimensions, made now, do beside experiments.

python scripts/draw_validation.py marin|fronts|heap FILE.png

``marin`` takes about ten minutes, ``fronts`` and ``heap`` about five.
"""

from __future__ import annotations

import sys
from pathlib import Path

import click
import matplotlib as mpl

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.validation import dam_break, dam_break3d, heap3d, spheric

mpl.use("Agg")
from matplotlib import pyplot as plt

# colors of Okabe & Ito, which color-blind readers can tell apart
COLORS = ("#56b4e9", "#d55e00", "#009e73")
PANELS = ("h4", "h3", "h2", "h1", "p1", "p2", "p3", "p4")
HEAP_TIMES = (0.0, 0.1, 0.2, 3.0)  # s
LARGEST_PRESSURE = 14.0  # kPa, of the panels


def draw_marin(runs: dict[float, spheric.Marin], file: Path) -> None:
    """Draw levels and pressures of runs, by their spacing, m, over the measured ones."""
    measured = spheric.experiment()
    figure, grid = plt.subplots(2, 4, figsize=(12, 5), layout="constrained")
    end = min(run.series["time"][-1] for run in runs.values())
    for axes, name in zip(grid.flat, PANELS, strict=True):
        is_pressure = name in spheric.PRESSURES
        unit = 1e-3 if is_pressure else 1.0
        axes.plot(measured["time"], unit * measured[name], "k", lw=0.9, label="measured")
        for color, (spacing, run) in zip(COLORS, runs.items(), strict=False):
            label = f"d0 = {1000 * spacing:.0f} mm"
            axes.plot(run.series["time"], unit * run.series[name], color, lw=0.8, label=label)
        axes.set_title(name.upper(), fontsize=9, loc="left", pad=2)
        axes.set_ylabel("pressure (kPa)" if is_pressure else "water level (m)")
        axes.set_ylim(0.0, LARGEST_PRESSURE if is_pressure else 0.6)
        axes.set_xlim(0.0, 2.0 if is_pressure else end)
    for axes in grid[-1]:
        axes.set_xlabel("t (s)")
    grid[0, 0].legend(fontsize=8)
    figure.savefig(file, dpi=80)


def draw_fronts(runs: dict[int, dict[int, dam_break.DamBreak]], file: Path) -> None:
    """Draw fronts of runs, by n^2 and the particles across a, over the measured ones."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for axes, (ratio, found) in zip(panels, runs.items(), strict=True):
        for color, (across, run) in zip(COLORS, found.items(), strict=True):
            z = run.front / dam_break.WIDTH
            axes.plot(run.scaled_time, z, color, lw=1.0, label=f"d0 = a/{across}")
        t, z = dam_break.reference_table(run.experiment.front).T
        axes.plot(t, z, "ko", ms=3, label="measured")
        axes.set_title(f"n² = {ratio}", fontsize=9, loc="left", pad=2)
        axes.set(xlabel="T", ylabel="Z", xlim=(0.0, 3.5), ylim=(1.0, 5.5))
        axes.legend(fontsize=8)
    figure.savefig(file, dpi=80)


def draw_heap(runs: dict[float, heap3d.Heap], file: Path) -> None:
    """Draw outlines of heaps, by their a, over time, and the run-out of the experiments."""
    figure, panels = plt.subplots(len(runs), 1, figsize=(8, 7), layout="constrained")
    for axes, (ratio, run) in zip(panels, runs.items(), strict=True):
        for color, time in zip(("0.7", *COLORS), HEAP_TIMES, strict=True):
            x, height = run.outline(time)
            axes.plot(x / heap3d.LENGTH, height / heap3d.LENGTH, color, lw=1.0, label=f"{time} s")
        axes.axvline(1.0 + heap3d.lube(ratio), color="k", ls="--", lw=0.8, label="measured end")
        axes.set_title(f"a = {ratio}", fontsize=9, loc="left", pad=2)
        axes.set(ylabel="z / L0", xlim=(0.0, 4.5), aspect="equal")
    panels[0].legend(fontsize=7, loc="upper right")
    panels[-1].set_xlabel("x / L0")
    figure.savefig(file, dpi=80)


@click.command()
@click.argument("what", type=click.Choice(["marin", "fronts", "heap"]))
@click.argument("file", type=click.Path(path_type=Path))
def main(what: str, file: Path) -> None:
    """Draw WHAT into FILE."""
    if what == "marin":
        draw_marin({d0: spheric.run(d0, 6.0) for d0 in spheric.SPACINGS}, file)
    elif what == "heap":
        draw_heap({ratio: heap3d.run(ratio) for ratio in (0.5, 1.0, 2.0)}, file)
    else:
        draw_fronts(
            {
                experiment.ratio: {n: dam_break3d.run(n, experiment) for n in spacings}
                for experiment, spacings in dam_break3d.SPACINGS.items()
            },
            file,
        )
    click.echo(f"wrote {file}")


if __name__ == "__main__":
    main()
