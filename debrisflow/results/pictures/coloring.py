"""The colors of particles: by their kind, or by a quantity on a scale that all frames share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from numpy.typing import NDArray

from debrisflow.particles.arrays import COLORED
from debrisflow.particles.record import Kind
from debrisflow.results.frames import Frame, magnitude

Floats = NDArray[np.float64]
Colors = NDArray[np.uint8]
# by Okabe & Ito, distinguishable by color-blind readers; walls are gray
KIND_COLORS = {
    Kind.LIQUID: "#56b4e9",
    Kind.SEDIMENT: "#d55e00",
    Kind.MIXTURE: "#e69f00",
    Kind.WALL: "#8c8c8c",
    Kind.DUMMY: "#8c8c8c",
    Kind.INFLOW: "#009e73",
}
KIND_WORDS = {
    Kind.LIQUID: "water",
    Kind.SEDIMENT: "sediment",
    Kind.MIXTURE: "mixture",
    Kind.INFLOW: "waiting supply",
}
COLOR_MAP = "viridis"
UNKNOWN_SUPPLY = "#cccccc"  # inflow particles have no meaningful values
# Percentiles at the ends of the scale, so that a splash does not determine it
LOW, HIGH = 1.0, 99.0


class Scale(NamedTuple):
    """A quantity and the range of values of its colors; kinds have no range.

    Attributes
    ----------
    by : str
        A key of :data:`debrisflow.particles.arrays.COLORED`.
    low, high : float
        In the unit of the field.
    greatest : float
        Greatest value of the field.
    """

    by: str
    low: float = 0.0
    high: float = 1.0
    greatest: float = 1.0

    @property
    def clipped(self) -> bool:
        """Return whether some values are above the scale."""
        return self.greatest > self.high

    def colors(self, frame: Frame) -> Colors:
        """Return the color of each particle, (n, 3) array of 0 to 255."""
        rgb = np.zeros((frame.kind.size, 3), dtype=np.uint8)
        for kind, color in KIND_COLORS.items():
            rgb[frame.kind == kind] = channels(color)
        if self.by == "kind":
            return rgb
        rgb[frame.kind == Kind.INFLOW] = channels(UNKNOWN_SUPPLY)
        share = (values(frame, self.by)[frame.fluid] - self.low) / (self.high - self.low)
        rgb[frame.fluid] = colormaps[COLOR_MAP](np.clip(share, 0.0, 1.0), bytes=True)[:, :3]
        return rgb


def channels(color: str) -> tuple[int, ...]:
    """Return red, green and blue of a color as ``#rrggbb``.

    Examples
    --------
    >>> channels("#d55e00")
    (213, 94, 0)
    """
    return tuple(bytes.fromhex(color.removeprefix("#")))


def values(frame: Frame, by: str) -> Floats:
    """Return the values of a frame by which it is colored, (n,) array."""
    array = frame.arrays[COLORED[by].name]
    return array if array.ndim == 1 else magnitude(array)


def default_field(frames: Sequence[Frame]) -> str:
    """Return the default coloring: the kind if there are several, else the speed."""
    kinds = {int(kind) for frame in frames for kind in np.unique(frame.kind[frame.fluid])}
    return "kind" if len(kinds) > 1 else "speed"


def scale_of(frames: Sequence[Frame], by: str) -> Scale:
    """Return a scale for all frames: from 0 or below up to the 99th percentile of the values.

    Examples
    --------
    The upper end is rounded up to two digits; what has one value only gets a scale all the same.

    >>> round_up(0.0), round_up(1.234), round_up(870.0)
    (0.0, 1.3, 870.0)
    """
    if by == "kind":
        return Scale(by)
    found = np.concatenate([values(frame, by)[frame.fluid] for frame in frames])
    found = found[np.isfinite(found)]
    low, high = np.percentile(found, [LOW, HIGH]) if found.size else (0.0, 0.0)
    low, high = -round_up(-min(float(low), 0.0)), round_up(max(float(high), 0.0))
    return Scale(by, low, high if high > low else low + 1.0, float(found.max(initial=low)))


def round_up(value: float) -> float:
    """Return the next number of two digits that is not less than a number >= 0."""
    if value == 0.0:
        return 0.0
    step = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(f"{np.ceil(value / step * (1.0 - 1e-12)) * step:.2g}")
