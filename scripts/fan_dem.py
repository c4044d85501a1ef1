"""Write the elevation model of ``cases/channelled_fan.toml``: a torrent that opens to a fan.

    python scripts/fan_dem.py

Along the middle line y = 0, x from the apex of the fan, the surface falls by 14 degrees above the
apex; on the fan, by 8 degrees at the apex and less with the distance r from it,

    z = Z (exp(-r / L) - 1),  Z = L tan(8 deg),

with L = 400 m.  Above the apex the slopes of the valley rise by 30 degrees from the banks of the
channel, which is 6 m wide at its bed, 3 m deep and has banks of 45 degrees; on the fan it grows
shallow with exp(-r / 60 m).  A regular roughness of 0.1 m keeps it from being a drawing board.
"""

from __future__ import annotations

from math import radians, tan
from pathlib import Path

import numpy as np

from debrisflow.case.rasters import MapGrid, Raster, write_raster

PATH = Path(__file__).parent.parent / "cases" / "data" / "channelled_fan.asc"
GRID = MapGrid(west=38_000.0, south=-64_000.0, cell=2.0, columns=180, rows=100)
APEX = 140.0  # m from the western border
UPPER, LOWER, SIDES = (tan(radians(angle)) for angle in (14.0, 8.0, 30.0))
LENGTH, FADES = 400.0, 60.0  # m
BED, DEPTH = 6.0, 3.0  # m, width and depth of the channel
LEVEL = 300.0  # m, of the apex


def level(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the elevation at a distance from the apex along and across the valley, m."""
    distance, beside = np.hypot(x, y), np.abs(y)
    banks = 0.5 * BED + DEPTH
    valley = -UPPER * x + SIDES * np.maximum(beside - banks - 4.0, 0.0)
    fan = LOWER * LENGTH * (np.exp(-distance / LENGTH) - 1.0)
    surface = np.where(x < 0.0, valley, fan)
    cut = np.clip((banks - beside) / DEPTH, 0.0, 1.0) * DEPTH
    cut *= np.where(x < 0.0, 1.0, np.exp(-distance / FADES))
    rough = 0.1 * np.sin(x / 3.1) * np.cos(y / 4.3)
    return LEVEL + surface - cut + rough


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
