"""Pictures of the maps of a study, over the relief of its terrain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow import __version__
from debrisflow.case import ResolvedCase
from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results.fonts import writable
from debrisflow.results.layers import layer_file
from debrisflow.results.maps.layers import Layer
from debrisflow.results.maps.looks import LOOKS, Look, Scale, scale_of
from debrisflow.results.maps.part import part_around
from debrisflow.results.maps.pictures import DPI
from debrisflow.results.maps.sheet import Ground, Text, draw_map, styled
from debrisflow.results.maps.structures import structures
from debrisflow.results.words import Words
from debrisflow.run.layers import WHILE_DEEP
from debrisflow.study.maps.grid import layer_on, terrain_on
from debrisflow.study.maps.shares import ROUNDING, rank
from debrisflow.study.names import ARRIVAL

Floats = NDArray[np.float64]
LIMITS = (0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95)
"""Between the classes of a probability."""
# YlOrRd of ColorBrewer, even in lightness: for readers who cannot tell red from green too
PROBABILITY = (
    "#ffffcc", "#ffeda0", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#b10026",
)  # fmt: skip
PERCENT = 100.0
BEYOND = 10  # members that lie beyond a quantile which is well known


class StudyMap(NamedTuple):
    """A map over the members of a study.

    Attributes
    ----------
    name : str
        Of its files, without an ending.
    title : str
    layer : str
        That it is made of.
    is_share : bool
        Whether its values are shares of the members, else values of the layer.
    values : (rows, columns) float64 array
        The northernmost row first; 0 where no member has the layer, of the arrival inf; nan off
        the terrain.
    quantile : float or None
        Share of the members that do not exceed the values, of a map of quantiles.
    """

    name: str
    title: str
    layer: str
    is_share: bool
    values: Floats
    quantile: float | None = None

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Return the cells that have a value to be shown."""
        if self.layer == ARRIVAL and not self.is_share:
            return np.isfinite(self.values)
        return self.values > 0.0


def draw_study_maps(
    maps: Sequence[StudyMap],
    folders: Sequence[Path],
    grid: MapGrid,
    case: ResolvedCase,
    title: str,
    is_sample: bool,
    is_independent: bool,
    target: Path,
) -> None:
    """Draw maps, all of them of the part that any member reaches, as PNG files.

    Terrain and obstacles are those of the first member; releases are shown of all.

    Parameters
    ----------
    maps : sequence of StudyMap
    folders : sequence of Path
        Of the members.
    grid : MapGrid
    case : ResolvedCase
        Of the first member.
    title : str
        Of the study.
    is_sample : bool
        Whether shares of the members are probabilities.
    is_independent : bool
        Whether members are also drawn independently, so that these have a standard error.
    target : Path
        Folder of the pictures.

    Raises
    ------
    OutputError
        If the folder of a member lacks a layer.
    """
    terrain, release, words = terrain_on(folders[0], grid), _released(folders, grid), Words()
    touched = np.any([np.isfinite(release), *(one.reached for one in maps)], axis=0)
    part = part_around(grid, touched)
    ground = Ground(
        terrain.cropped(*part), Raster(grid, release).cropped(*part).values, structures(case)
    )
    least = case.output.layer_depth
    with styled(words):
        for one in maps:
            shown = np.where(one.reached, one.values, np.nan)
            values = Raster(grid, shown).cropped(*part).values
            worth = _worth(one, len(folders), is_sample, is_independent)
            lines = tuple(_source(one, grid, len(folders), least, worth))
            text = Text(one.title, title if writable(title) else "-", lines)
            layer = _share(one, values, is_sample) if one.is_share else _amount(one, values, least)
            figure: Figure = draw_map(ground, layer, text, words)
            made_by = {"Software": "debrisflow"}
            figure.savefig(target / f"{one.name}.png", dpi=DPI, format="png", metadata=made_by)


def _released(folders: Sequence[Path], grid: MapGrid) -> Floats:
    """Return the greatest depth that any member releases, m, nan where none does."""
    depth = np.zeros(grid.shape)
    for folder in folders:
        if layer_file(folder, "release") is not None:
            np.maximum(depth, layer_on(folder, grid, "release"), out=depth)
    return np.where(depth > 0.0, depth, np.nan)


def _share(one: StudyMap, values: Floats, is_sample: bool) -> Layer:
    """Return a share of the members as it is shown, in percent."""
    title = "Probability" if is_sample else "Share of members"
    look = Look(title, "%", PROBABILITY, outlined=PERCENT * 0.5)
    bounds = PERCENT * np.array([0.0, *LIMITS, 1.0])
    return Layer(one.name, look, PERCENT * values, Scale(bounds, PROBABILITY))


def _amount(one: StudyMap, values: Floats, threshold: float) -> Layer:
    """Return a value of the layer as it is shown; depths from a threshold on, m."""
    look = LOOKS[one.layer]
    least = threshold if look.is_depth else 0.0
    shown = np.where(values >= least, values, np.nan)
    return Layer(one.name, look, shown, scale_of(look, shown, least))


def _source(one: StudyMap, grid: MapGrid, members: int, least: float, worth: str) -> Iterator[str]:
    """Yield the lines below a map."""
    yield (
        f"{members} members on cells of {grid.cell:g} m; terrain and obstacles of the first of "
        f"them. debrisflow {__version__}."
    )
    yield worth
    if one.layer == "peak_depth" or one.layer in WHILE_DEEP:
        yield f"A member reaches a cell where its depth exceeds {least:g} m."


def _worth(one: StudyMap, members: int, is_sample: bool, is_independent: bool) -> str:
    """Say what a share of the members, or a quantile of them, is worth."""
    if one.quantile is not None:
        return place_in_order(one.quantile, members)
    counted = "Each member counts the same; cells where the share is 0 are not shown."
    if not is_sample:
        return (
            f"{counted} The members are not drawn from the distributions of the parameters: their "
            "share is no probability."
        )
    if not is_independent:
        return counted
    error = PERCENT * 0.5 / np.sqrt(members)
    return (
        f"{counted} Of as many members drawn at random the standard error is up to {error:.2g} "
        "percentage points."
    )


def place_in_order(share: float, members: int) -> str:
    """Say which of the members a quantile is, and how many it needs if there are fewer.

    Examples
    --------
    >>> place_in_order(0.5, 64)
    'In each cell the value of member 32 of 64 in increasing order.'
    >>> place_in_order(0.95, 64).partition(". ")[2]
    'Beyond it lie 3 of them; this share needs at least 200 members.'
    """
    place = rank(share, members)
    ordered = f"In each cell the value of member {place} of {members} in increasing order"
    enough = ceil(BEYOND / min(share, 1.0 - share) - ROUNDING)
    if members >= enough:
        return f"{ordered}."
    wanted = f"this share needs at least {enough} members."
    beyond = members - place if share >= 0.5 else place - 1
    if beyond == 0:
        return f"{ordered}, the {'greatest' if share >= 0.5 else 'least'} of them; {wanted}"
    return f"{ordered}. Beyond it lie {beyond} of them; {wanted}"
