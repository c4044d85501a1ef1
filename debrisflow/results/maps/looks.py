"""How each layer is shown: its title, classes and colors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, to_hex
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FEWEST, MOST = 3, 7  # classes where none are set
ENDS = (0.03, 0.97)  # of a color map: its very ends cannot be told from black and white
HIGH = 99.8  # percentile at the upper end of such classes, so that one cell does not determine it
DEPTHS = (0.25, 0.5, 1.0, 2.0, 4.0)


class Look(NamedTuple):
    """How a layer is shown.

    Attributes
    ----------
    title, unit : str
    colors : str
        A map of matplotlib that is even to the eye and safe for color-blind readers; the darker
        the more dangerous.
    limits : tuple of float
        Between classes, in the unit; the same for all runs, so that maps can be compared.
        Classes of one width if empty.
    is_depth : bool
        Whether values below the threshold of the depth are left out.
    has_lines : bool
        Whether labelled lines are drawn between the classes: isochrones.
    """

    title: str
    unit: str
    colors: str
    limits: tuple[float, ...] = ()
    is_depth: bool = False
    has_lines: bool = False


LOOKS = {
    "peak_depth": Look("Peak flow depth", "m", "viridis_r", DEPTHS, is_depth=True),
    "peak_speed": Look("Peak flow speed", "m/s", "plasma_r", (1.0, 2.0, 5.0, 10.0, 20.0)),
    "peak_momentum_flux": Look(
        "Peak momentum flux h u²", "m³/s²", "inferno_r", (1.0, 3.0, 10.0, 30.0, 100.0)
    ),
    "peak_pressure": Look(
        "Peak dynamic pressure ρ u²", "kPa", "magma_r", (5.0, 10.0, 30.0, 50.0, 100.0)
    ),
    "arrival": Look("Arrival time", "s", "viridis", has_lines=True),
    "duration": Look("Duration of flow", "s", "YlGnBu"),
    "deposit": Look("Deposit thickness", "m", "YlOrBr", DEPTHS, is_depth=True),
    "final_depth": Look("Flow depth at the end", "m", "viridis_r", DEPTHS, is_depth=True),
}
DEPTH = Look("Flow depth", "m", "viridis_r", DEPTHS, is_depth=True)  # at a time


class Scale(NamedTuple):
    """Classes of values and their colors.

    Attributes
    ----------
    bounds : (n + 1,) array
        In the unit of the layer.
    colors : list of str
        As ``#rrggbb``, from the lowest class to the highest; one more than there are intervals if
        some values lie above the last bound.
    """

    bounds: Floats
    colors: list[str]

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
        shades = np.linspace(*ENDS, limits.size + 1)
    else:
        high = float(np.percentile(known, HIGH)) if known.size else least
        bounds = _even(least, high)
        shades = np.linspace(*ENDS, bounds.size - 1)
    count = bounds.size - 1 + bool(limits.size and greatest > bounds[-1])
    colors = [to_hex(color) for color in colormaps[look.colors](shades)]
    return Scale(bounds, colors[:count])


def _even(low: float, high: float) -> Floats:
    """Return round numbers of one distance, the first of them replaced by the low one."""
    if not high > low:
        high = low + 1.0
    locator = MaxNLocator(MOST, steps=[1, 2, 2.5, 5, 10], min_n_ticks=FEWEST)
    ticks = np.asarray(locator.tick_values(low, high))
    inside = ticks[ticks > low + 1e-9 * (high - low)]
    return np.array([low, *inside[: int(np.sum(inside < high)) + 1]])
