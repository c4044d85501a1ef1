"""Draw what runs in three dimensions, made now, do beside experiments.

python scripts/draw_validation.py marin|fronts|heap|flume|slab|st_helens FILE.png

``flume`` takes half an hour, ``marin`` about ten minutes, ``heap`` about eight, ``fronts`` and
``slab`` about five, ``st_helens`` an hour.
"""

from __future__ import annotations

import sys
from pathlib import Path

import click
import matplotlib as mpl

sys.path.insert(0, str(Path(__file__).parents[1]))

from debrisflow.results.references import read_reference
from debrisflow.validation.dam_breaks import dam_break, dam_break3d, spheric
from debrisflow.validation.debris_flows import usgs_flume, voellmy_slab
from debrisflow.validation.field import st_helens
from debrisflow.validation.granular import heap3d

mpl.use("Agg")
from matplotlib import pyplot as plt

# colors of Okabe & Ito, which color-blind readers can tell apart
COLORS = ("#56b4e9", "#d55e00", "#009e73")
PANELS = ("h4", "h3", "h2", "h1", "p1", "p2", "p3", "p4")
HEAP_TIMES = {"at the start": 0.0, "0.1 s": 0.1, "0.2 s": 0.2, "at rest": None}
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
            ours = run.series[f"reaction_{name}" if is_pressure else name]
            axes.plot(run.series["time"], unit * ours, color, lw=0.8, label=label)
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
    shares = {"height_ratios": [ratio + 0.2 for ratio in runs]}
    figure, panels = plt.subplots(
        len(runs), 1, figsize=(8, 8.5), gridspec_kw=shares, layout="constrained"
    )
    for axes, (ratio, run) in zip(panels, runs.items(), strict=True):
        for color, (label, time) in zip(("0.7", *COLORS), HEAP_TIMES.items(), strict=True):
            x, height = run.outline(time)
            x, height = x[height > 0.0] / heap3d.LENGTH, height[height > 0.0] / heap3d.LENGTH
            axes.plot(x, height, color, lw=1.0, label=label)
        axes.axvline(1.0 + heap3d.lube(ratio), color="k", ls="--", lw=0.8, label="measured end")
        axes.set_title(f"a = {ratio}", fontsize=9, loc="left", pad=2)
        axes.set(ylabel="z / L0", xlim=(0.0, 4.5), ylim=(0.0, ratio + 0.1), aspect="equal")
    panels[-1].legend(fontsize=8, loc="upper right")
    panels[-1].set_xlabel("x / L0")
    figure.savefig(file, dpi=80)


def draw_flume(runs: dict[float, dict[str, usgs_flume.Series]], file: Path) -> None:
    """Draw depths of runs of the flume, by their spacing, m, over the measured ones."""
    table = read_reference(usgs_flume.CASES / "data" / usgs_flume.TABLES["sgm"])
    figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), sharey=True, layout="constrained")
    for axes, curve in zip(panels, table.curves, strict=True):
        probe, time = curve.split(".")[0], table.table["time"] - usgs_flume.GATE
        low, high = table.band(curve)
        axes.fill_between(time, low, high, color="0.85", label="± one standard deviation")
        axes.plot(time, table.table[curve], "k", lw=0.9, label="measured, mean of releases")
        for color, (spacing, run) in zip(COLORS, runs.items(), strict=False):
            axes.plot(*run[probe], color, lw=0.9, label=f"d0 = {1000 * spacing:.0f} mm")
        axes.set_title(f"{probe[1:]} m from the gate", fontsize=9, loc="left", pad=2)
        axes.set(xlabel="t since the gate is open (s)", xlim=(0.0, 20.0), ylim=(0.0, 0.36))
        axes.set_xticks([0, 5, 10, 15, 20])
    panels[0].set_ylabel("depth (m)")
    panels[-1].legend(fontsize=8)
    figure.savefig(file, dpi=80)


def draw_slab(runs: dict[int, voellmy_slab.Runout], file: Path) -> None:
    """Draw the run-out of slabs over the number of their rows."""
    figure, axes = plt.subplots(figsize=(5, 3.6), layout="constrained")
    rows, finest = list(runs), runs[max(runs)]
    axes.fill_between(rows, 0.9 * finest.front, 1.1 * finest.front, color="0.9", label="± 10 %")
    axes.plot(rows, [run.front for run in runs.values()], "o-", color=COLORS[1], label="front")
    middles = [run.middle for run in runs.values()]
    axes.plot(rows, middles, "s--", color=COLORS[0], label="half of the volume")
    axes.set(xscale="log", xlabel="rows of particles over the slab")
    axes.set_ylabel("run-out behind the bend (m)")
    axes.set(xticks=rows, xticklabels=rows, ylim=(0.0, None))
    axes.minorticks_off()
    axes.legend(fontsize=8)
    figure.savefig(file, dpi=80)


def draw_st_helens(runs: dict[float, st_helens.Runout], file: Path) -> None:
    """Draw the run-out of the landslide over the rows of particles in its depth."""
    figure, axes = plt.subplots(figsize=(5, 3.6), layout="constrained")
    rows = [st_helens.DEPTH / spacing for spacing in runs]
    scores = [run.score for run in runs.values()]
    observed = scores[0]["reach_observed"]
    axes.fill_between(rows, 0.9 * observed, 1.1 * observed, color="0.9", label="observed ± 10 %")
    axes.plot(rows, [s["reach_simulated"] for s in scores], "o-", color=COLORS[1], label="computed")
    axes.set(xscale="log", xlabel="rows of particles over a flow of 4 m", ylim=(0.0, None))
    axes.set_ylabel("run-out in a straight line (m)")
    axes.set(
        xticks=rows,
        xticklabels=[f"{row:.2g}\n(d0 = {d0:g} m)" for d0, row in zip(runs, rows, strict=True)],
    )
    axes.minorticks_off()
    axes.legend(fontsize=8, loc="lower right")
    figure.savefig(file, dpi=80)


@click.command()
@click.argument(
    "what", type=click.Choice(["marin", "fronts", "heap", "flume", "slab", "st_helens"])
)
@click.argument("file", type=click.Path(path_type=Path))
def main(what: str, file: Path) -> None:
    """Draw WHAT into FILE."""
    if what == "marin":
        draw_marin({d0: spheric.run(d0, 6.0) for d0 in spheric.SPACINGS}, file)
    elif what == "heap":
        draw_heap({a: heap3d.run(a, across=n) for a, n in heap3d.ACROSS.items()}, file)
    elif what == "flume":
        changes = {d0: (f"particles.spacing={d0}", "time.end=20") for d0 in usgs_flume.SPACINGS}
        draw_flume({d0: usgs_flume.depths(change) for d0, change in changes.items()}, file)
    elif what == "slab":
        draw_slab({rows: voellmy_slab.run(rows) for rows in voellmy_slab.ROWS}, file)
    elif what == "st_helens":
        changes = {d0: st_helens.of_spacing(d0) for d0 in st_helens.SPACINGS}
        draw_st_helens({d0: st_helens.run(change) for d0, change in changes.items()}, file)
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
