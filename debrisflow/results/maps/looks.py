"""How each layer is shown: its title, classes and colors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from debrisflow.run.layer_styles import DEPTH as DEPTHS
from debrisflow.run.layer_styles import LIMITS, VIRIDIS, colors_of, palette_of

Floats = NDArray[np.float64]
FEWEST, MOST = 3, 6  # classes where none are set


class Look(NamedTuple):
    """How a layer is shown.

    Attributes
    ----------
    title, unit : str
    palette : sequence of str
        Colors of seven classes, the darker the more dangerous.
    limits : sequence of float
        Between classes, in the unit; the same for all runs, so that maps can be compared.
        Classes of one width if empty.
    is_depth : bool
        Whether values below the threshold of the depth are left out.
    has_lines : bool
        Whether labelled lines are drawn between the classes: isochrones.
    outlined : float or None
        Value from which cells are within a thick line, in the unit.
    """

    title: str
    unit: str
    palette: Sequence[str]
    limits: Sequence[float] = ()
    is_depth: bool = False
    has_lines: bool = False
    outlined: float | None = None


def _look(name: str, title: str, unit: str, is_depth: bool = False) -> Look:
    return Look(title, unit, palette_of(name), LIMITS[name], is_depth)


# classes of times are those of the run: lines of the arrival are to be evenly spaced
LOOKS = {
    "peak_depth": _look("peak_depth", "Peak flow depth", "m", is_depth=True),
    "peak_speed": _look("peak_speed", "Peak flow speed", "m/s"),
    "peak_momentum_flux": _look("peak_momentum_flux", "Peak momentum flux h u²", "m³/s²"),
    "peak_pressure": _look("peak_pressure", "Peak dynamic pressure ρ u²", "kPa"),
    "arrival": Look("Arrival time", "s", palette_of("arrival"), has_lines=True),
    "duration": Look("Duration of flow", "s", palette_of("duration")),
    "deposit": _look("deposit", "Deposit thickness", "m", is_depth=True),
    "final_depth": _look("final_depth", "Flow depth at the end", "m", is_depth=True),
}
DEPTH = Look("Flow depth", "m", VIRIDIS, DEPTHS, is_depth=True)  # at a time


class Scale(NamedTuple):
    """Classes of values and their colors.

    Attributes
    ----------
    bounds : (n + 1,) array
        In the unit of the layer.
    colors : sequence of str
        As ``#rrggbb``, from the lowest class to the highest; one more than there are intervals if
        some values lie above the last bound.
    names : sequence of str
        Of the classes, where these are none of numbers.
    """

    bounds: Floats
    colors: Sequence[str]
    names: Sequence[str] = ()

    @property
    def is_open(self) -> bool:
        """Return whether there is a class above the last bound."""
        return len(self.colors) == self.bounds.size

    @property
    def map_and_norm(self) -> tuple[Colormap, BoundaryNorm]:
        """Return what matplotlib colors values by."""
        count = self.bounds.size - 1
        colors = ListedColormap(self.colors[:count]).with_extremes(over=self.colors[-1])
        return colors, BoundaryNorm(self.bounds, count)


def scale_of(look: Look, values: Floats, least: float) -> Scale:
    """Return the classes of the values of a layer, those that occur and the lower ones.

    Parameters
    ----------
    look : Look
    values : array
        nan where there is none.
    least : float
        Lower end of the first class.

    Examples
    --------
    >>> scale_of(LOOKS["peak_depth"], np.array([0.1, 1.7]), 0.05).bounds.tolist()
    [0.05, 0.25, 0.5, 1.0, 2.0]
    >>> scale_of(LOOKS["peak_depth"], np.array([0.1, 9.0]), 0.05).is_open
    True
    >>> scale_of(LOOKS["arrival"], np.array([0.0, 47.0]), 0.0).bounds.tolist()
    [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]
    """
    known = values[np.isfinite(values)]
    greatest = float(known.max(initial=least))
    limits = np.array([limit for limit in look.limits if limit > least])
    if limits.size and greatest > limits[0]:
        bounds = np.array([least, *limits[: int(np.sum(limits < greatest)) + 1]])
        colors = colors_of(look.palette, limits.size + 1)
    else:
        bounds = _even(least, greatest)
        colors = colors_of(look.palette, bounds.size - 1)
    count = bounds.size - 1 + bool(limits.size and greatest > bounds[-1])
    return Scale(bounds, colors[:count])


def _even(low: float, high: float) -> Floats:
    """Return round numbers of one distance, the first of them replaced by the low one."""
    if not high > low:
        high = low + 1.0
    locator = MaxNLocator(MOST, steps=[1, 2, 2.5, 5, 10], min_n_ticks=FEWEST)
    ticks = np.asarray(locator.tick_values(low, high))
    inside = ticks[ticks > low + 1e-9 * (high - low)]
    return np.array([low, *inside[: int(np.sum(inside < high)) + 1]])
