"""Plots of a calibration: posterior, misfits run by run, the emulator against the runs."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from debrisflow.results.plots.style import BLUE, GRAY, GREEN, ORANGE, RED, WIDTH, save, styled
from debrisflow.run.atomic import made
from debrisflow.study.calibration.parameter_space import shares_of
from debrisflow.study.calibration.result import CalibrationResult

Floats = NDArray[np.float64]
BINS = 40
LEVELS = {0.9: 0.25, 0.5: 0.6}  # opacity of areas that hold a share of the posterior
TALLEST = 7.0  # inch, of the plot of all pairs
COLUMNS = 3
KINDS = {"design": ("o", GRAY), "improvement": ("D", BLUE), "predictive": ("x", ORANGE)}


def write_plots(found: CalibrationResult, target: Path) -> list[Path]:
    """Draw the plots of a calibration into a folder, and return the files.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    made(target, is_deep=True)
    with styled():
        return [
            save(_posterior(found), target / "posterior.png", *_words_of_posterior(found)),
            save(_misfits(found), target / "misfits.png", *_words_of_misfits(found)),
            save(_emulator(found), target / "emulator.png", *_words_of_emulator(found)),
        ]


def _words_of_posterior(found: CalibrationResult) -> tuple[str, list[str]]:
    return (
        "Parameters after the observations",
        [
            "Diagonal: shares before (dashed) and after (filled), lines at 5, 50 and 95 %. Below: "
            "areas that hold 50 and 90 % of the posterior, the runs it rests on, the best of "
            f"them (cross). {found.posterior.effective:.0f} independent samples."
        ],
    )


def _words_of_misfits(found: CalibrationResult) -> tuple[str, list[str]]:
    return (
        "Misfit of each run",
        [
            "Sum of the squared residuals, each in errors of its observation. The line is the "
            "least so far; about as many as there are residuals "
            f"({len(found.residual_names)}, dotted) is what the errors explain."
        ],
    )


def _words_of_emulator(found: CalibrationResult) -> tuple[str, list[str]]:
    return (
        "Residuals by the emulator against those computed",
        [
            "Each run by an emulator of the others, with 90 % intervals; in errors of the "
            "observation. The gray band is one error wide to both sides: what is within it "
            "matters little to the fit."
        ],
    )


def _posterior(found: CalibrationResult) -> Figure:
    space, count = found.space, len(found.space.names)
    sample = space.values(shares_of(found.posterior.scores))
    best = np.array([found.runs[found.best].values[name] for name in space.names], dtype=float)
    rests_on = [
        [run.values[name] for name in space.names]
        for run, misfit in zip(found.runs, found.misfits, strict=True)
        if run.kind != "predictive" and np.isfinite(misfit)
    ]
    runs = np.array(rests_on, dtype=float)
    pairs = zip(space.laws, space.is_logarithmic, strict=True)
    edges = [_edges(law, has_log) for law, has_log in pairs]
    side = min(WIDTH, 1.5 + 2.0 * count, TALLEST)
    figure = Figure(figsize=(WIDTH, side), layout="constrained")
    axes = figure.subplots(count, count, squeeze=False)
    for i, j in product(range(count), range(count)):
        here = axes[i, j]
        if j > i:
            here.set_axis_off()
            continue
        if i == j:
            _shares(here, sample[:, i], space.laws[i], edges[i])
        else:
            _areas(here, sample[:, [j, i]], edges[j], edges[i])
            here.plot(runs[:, j], runs[:, i], ".", color=GRAY, markersize=3)
            here.plot(best[j], best[i], "x", color=RED, markersize=7, markeredgewidth=1.5)
            _scale(here.yaxis, here.set_yscale, space.is_logarithmic[i])
            here.set_ylim(edges[i][0], edges[i][-1])
        _scale(here.xaxis, here.set_xscale, space.is_logarithmic[j])
        here.set_xlim(edges[j][0], edges[j][-1])
        here.tick_params(which="both", labelbottom=i == count - 1, labelleft=j == 0 and i > 0)
        here.set_xlabel(space.names[j] if i == count - 1 else "")
        here.set_ylabel(space.names[i] if j == 0 and i > 0 else "")
    return figure


def _edges(law: Any, has_log: bool) -> Floats:
    """Return the edges of bins over all but 1 % of the prior."""
    low, high = law.ppf([0.005, 0.995])
    return np.asarray((np.geomspace if has_log else np.linspace)(low, high, BINS + 1))


def _scale(axis: Axis, set_scale: Callable[[str], None], has_log: bool) -> None:
    if has_log:
        set_scale("log")
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    else:
        axis.set_major_locator(MaxNLocator(4))


def _shares(axes: Axes, sample: Floats, law: Any, edges: Floats) -> None:
    """Draw which share of the sample, and of the prior, is in each bin."""
    counts, _ = np.histogram(sample, edges)
    axes.stairs(counts / len(sample), edges, fill=True, color=BLUE, alpha=0.5)
    axes.stairs(np.diff(law.cdf(edges)), edges, color=GRAY, linestyle="--")
    for value in np.quantile(sample, (0.05, 0.5, 0.95)):
        axes.axvline(value, color=BLUE, linewidth=0.8)
    axes.set_yticks([])


def _areas(axes: Axes, sample: Floats, x_edges: Floats, y_edges: Floats) -> None:
    """Fill the smallest areas that hold a share of the sample."""
    from scipy.ndimage import gaussian_filter

    counts, *_ = np.histogram2d(sample[:, 0], sample[:, 1], [x_edges, y_edges])
    smooth = gaussian_filter(counts, 1.0)
    ordered = np.sort(smooth.ravel())[::-1]
    within = np.cumsum(ordered) / ordered.sum()
    middles = [(edges[1:] + edges[:-1]) / 2.0 for edges in (x_edges, y_edges)]
    for share, opacity in LEVELS.items():
        levels = [float(ordered[np.searchsorted(within, share)]), float(ordered[0]) * 1.001]
        axes.contourf(*middles, smooth.T, levels=levels, colors=[BLUE], alpha=opacity)


def _misfits(found: CalibrationResult) -> Figure:
    figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
    axes = figure.subplots()
    numbers = np.arange(1, len(found.runs) + 1)
    kinds = np.array([run.kind for run in found.runs])
    for kind, (marker, color) in KINDS.items():
        chosen = kinds == kind
        if chosen.any():
            axes.plot(
                numbers[chosen],
                found.misfits[chosen],
                marker,
                color=color,
                markersize=4,
                label=kind,
            )
    searched = kinds != "predictive"
    least = np.fmin.accumulate(found.misfits[searched])
    axes.step(numbers[searched], least, color=GREEN, where="post", label="least so far")
    axes.axhline(len(found.residual_names), color=GRAY, linestyle=":")
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("run")
    axes.set_ylabel("misfit")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend()
    return figure


def _emulator(found: CalibrationResult) -> Figure:
    errors, names = found.left_out, found.residual_names
    rows = -(-len(names) // COLUMNS)
    figure = Figure(figsize=(WIDTH, 2.4 * rows), layout="constrained")
    axes = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for here in axes[len(names) :]:
        here.set_axis_off()
    for k, (here, name) in enumerate(zip(axes, names, strict=False)):
        computed, predicted = errors.computed[:, k], errors.predicted[:, k]
        ends = np.array(
            [min(computed.min(), predicted.min()), max(computed.max(), predicted.max())]
        )
        here.fill_between(ends, ends - 1.0, ends + 1.0, color=GRAY, alpha=0.25, linewidth=0.0)
        here.plot(ends, ends, color=GRAY, linewidth=0.8)
        here.errorbar(
            computed,
            predicted,
            1.645 * errors.deviation[:, k],
            fmt="o",
            color=BLUE,
            markersize=3,
            elinewidth=0.6,
        )
        here.set_title(f"{name}: Q2 = {errors.explained[k]:.2f}, rms {errors.rms[k]:.2g}")
        here.set_xlabel("computed")
        if k % COLUMNS == 0:
            here.set_ylabel("by the emulator")
    return figure
