"""Whether a study has enough members for its maps: how these change as members are added."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid
from debrisflow.results.plots.style import BLUE, GRAY, ORANGE, RED, panels, save, styled
from debrisflow.run.tables import write_table
from debrisflow.study.maps.shares import layers_on

Floats = NDArray[np.float64]
FIRST = 4  # members of the first subset
SURE = 0.05  # chance that a cell of this probability was missed by all members
HEAD = (
    "maps of the first members of the study, each subset of twice as many as the one before",
    "changes and errors are over the cells that any member of the study reaches with this value",
    "greatest_change, mean_change: of the probability, from the subset before",
    "greatest_error, mean_error: standard error of the probability, sqrt(p (1 - p) / members), if",
    "  members are drawn at random; usually less if they fill the ranges evenly",
    "area_half, area_tenth: m2, in plan, of a probability of at least 0.5 and 0.1",
    "unseen: probability, at 95 % confidence, up to which a cell may be reached that no member has",
    "  reached, 1 - 0.05^(1 / members); about 3 / members",
    "the subsets tell something only if the members are in random order, or a Sobol sequence",
)

LABELS = {
    "greatest_change": "greatest change",
    "mean_change": "mean change",
    "greatest_error": "greatest standard error",
    "mean_error": "mean standard error",
    "unseen": "not excluded where none reached",
    "area_half": "of probability 0.5 and more",
    "area_tenth": "of probability 0.1 and more",
}
CAPTION = (
    "Changes of the probability from one subset of the members to the next, over the "
    "cells that any member reaches with this value. Standard error: sqrt(p (1 - p) / members), of "
    "members drawn at random."
)


class Subset(NamedTuple):
    """The map of the first members of a study."""

    members: int
    greatest_change: float
    mean_change: float
    greatest_error: float
    mean_error: float
    area_half: float
    area_tenth: float
    unseen: float


def sizes_of(count: int) -> list[int]:
    """Return numbers of members, each twice the one before, the last of them all.

    Examples
    --------
    >>> sizes_of(20), sizes_of(16), sizes_of(3)
    ([4, 8, 16, 20], [4, 8, 16], [3])
    """
    doubled = [FIRST << k for k in range(count.bit_length()) if FIRST << k < count]
    return [*doubled, count]


def convergence(
    folders: Sequence[Path], grid: MapGrid, layer: str, threshold: float
) -> list[Subset]:
    """Return how the probability of exceedance changes as members are added in their order.

    Parameters
    ----------
    folders : sequence of Path
        Of finished members.
    grid : MapGrid
    layer : str
    threshold : float
        In the unit of the layer.

    Raises
    ------
    OutputError
        If there is no member, or one lacks the layer.
    """
    wanted, counts = sizes_of(len(folders)), []
    count = np.zeros(grid.shape, dtype=np.int32)
    for number, values in enumerate(layers_on(folders, grid, layer), 1):
        count += values > threshold
        if number in wanted:
            counts.append(count.copy())
    reached = count > 0
    found: list[Subset] = []
    before = None
    for number, count in zip(wanted, counts, strict=True):
        share = count[reached] / number
        found.append(_subset(number, share, before, grid.cell**2))
        before = share
    return found


def _subset(number: int, share: Floats, before: Floats | None, area: float) -> Subset:
    change = np.full_like(share, np.nan) if before is None else np.abs(share - before)
    error = np.sqrt(share * (1.0 - share) / number)
    nothing = np.zeros(1)  # stands for the cells where none is reached
    change, error = (values if share.size else nothing for values in (change, error))
    return Subset(
        members=number,
        greatest_change=float(change.max()),
        mean_change=float(change.mean()),
        greatest_error=float(error.max()),
        mean_error=float(error.mean()),
        area_half=float(np.sum(share >= 0.5)) * area,
        area_tenth=float(np.sum(share >= 0.1)) * area,
        unseen=1.0 - SURE ** (1.0 / number),
    )


def write_convergence(subsets: Sequence[Subset], path: Path, title: str) -> list[Path]:
    """Write the subsets as a table and as a picture beside it, and return the files.

    Parameters
    ----------
    subsets : sequence of Subset
    path : Path
        Of the table, ``NAME.csv``.
    title : str
        Of the picture.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    write_table(path, Subset._fields, HEAD, subsets)
    with styled():
        figure, (left, right) = panels(1, 2, height=3.6)
        table = np.array(subsets, dtype=float)
        members = table[:, 0]
        columns = {name: table[:, k] for k, name in enumerate(Subset._fields)}
        for name, color, style in (
            ("greatest_change", RED, "o-"),
            ("mean_change", BLUE, "o-"),
            ("greatest_error", RED, "--"),
            ("mean_error", BLUE, "--"),
            ("unseen", GRAY, ":"),
        ):
            left.plot(members, columns[name], style, color=color, label=LABELS[name], markersize=4)
        for name, color in (("area_tenth", ORANGE), ("area_half", BLUE)):
            right.plot(members, columns[name], "o-", color=color, label=LABELS[name], markersize=4)
        for axes, label in ((left, "probability"), (right, "area, m²")):
            axes.set_xscale("log", base=2)
            axes.set_xticks(members, [f"{number:g}" for number in members])
            axes.set(xlabel="members", ylabel=label)
            axes.set_ylim(bottom=0.0)
            axes.minorticks_off()
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), frameon=False)
        picture = save(figure, path.with_suffix(".png"), title, [CAPTION])
    return [path, picture]
