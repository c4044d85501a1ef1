"""Write the elevation model of ``cases/channelled_fan.toml``: a torrent that opens to a fan.

    python scripts/fan_dem.py

With x from the apex of the fan down the valley and y across, in meters: above the apex the axis of
the torrent winds by ``15 sin(2 pi x / 160)``, more gently towards the apex, and falls by 14
degrees.  Its channel is 5 m wide at the bed, 2.5 m deep, with banks of 45 degrees; behind the banks
the slopes of the valley rise by 30 degrees.  The fan is a cone that falls by 9 degrees at the apex
and less with the distance r from it,

    z = Z (exp(-r / L) - 1),  Z = L tan(9 deg),  L = 350 m,

on which the channel grows shallow with exp(-r / 30 m), and old lobes and swales are 0.4 m high.
Valley and fan pass into each other over some 40 m.
"""

from __future__ import annotations

from math import pi, radians, tan
from pathlib import Path

import numpy as np

from debrisflow.case.rasters import MapGrid, Raster, write_raster

PATH = Path(__file__).parent.parent / "cases" / "data" / "channelled_fan.asc"
GRID = MapGrid(west=38_000.0, south=-64_000.0, cell=2.0, columns=210, rows=120)
APEX = 170.0  # m from the western border
UPPER, LOWER, SIDES = (tan(radians(angle)) for angle in (14.0, 9.0, 30.0))
LENGTH, FADES, PASSES = 350.0, 30.0, 10.0  # m
BED, DEPTH = 5.0, 2.5  # m, width and depth of the channel
LOBES = 0.4  # m
LEVEL = 300.0  # m, of the apex


def axis(x: np.ndarray) -> np.ndarray:
    """Return the y of the axis of the torrent, m."""
    return 15.0 * np.sin(2.0 * pi * x / 160.0) * (1.0 - np.exp(np.minimum(x, 0.0) / 60.0))


def level(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the elevation at a distance from the apex along and across the valley, m."""
    beside, distance = np.abs(y - axis(x)), np.hypot(x, y)
    banks = 0.5 * BED + DEPTH
    valley = -UPPER * x + SIDES * np.maximum(beside - banks - 3.0, 0.0)
    fan = LOWER * LENGTH * (np.exp(-distance / LENGTH) - 1.0)
    fan += LOBES * np.sin(x / 13.0 + 1.3 * np.sin(y / 17.0)) * np.cos(y / 11.0 - x / 37.0)
    share = 1.0 / (1.0 + np.exp(np.clip(x / PASSES, -50.0, 50.0)))
    cut = DEPTH * np.clip((banks - beside) / DEPTH, 0.0, 1.0)
    cut *= np.where(x < 0.0, 1.0, np.exp(-distance / FADES))
    return LEVEL + share * valley + (1.0 - share) * fan - cut


def main() -> None:
    """Write the grid."""
    columns, rows = np.arange(GRID.columns), np.arange(GRID.rows)
    x = (columns + 0.5) * GRID.cell - APEX
    y = (0.5 * GRID.rows - rows - 0.5) * GRID.cell
    values = level(*np.meshgrid(x, y))
    PATH.parent.mkdir(exist_ok=True)
    write_raster(PATH, Raster(GRID, np.round(values, 2)))


if __name__ == "__main__":
    main()
