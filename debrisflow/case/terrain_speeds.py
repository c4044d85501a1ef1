"""How fast a flow over a terrain may be, before it is computed."""

from __future__ import annotations

from functools import lru_cache
from math import cos, inf, log, radians, sin, sqrt, tan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.friction import (
    CoulombFriction,
    LogFriction,
    ManningFriction,
    VoellmyFriction,
)
from debrisflow.case.rasters import Raster, Stamp, stamp_of
from debrisflow.case.released import (
    area,
    borders,
    entering_depth,
    greatest_depth,
    volume,
)
from debrisflow.case.releases import AnyRelease, HydrographRelease, Zone
from debrisflow.case.tables import Gravity, Wall
from debrisflow.case.terrain import Terrain

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
FREED = 4.0 / 9.0  # depth where a dam has broken, of that behind it
STEEP = 90.0  # percentile of the slopes within reach
LEAST_FRICTION = 0.05  # slope of the longest run-outs on record
KARMAN = 0.41


def expected_speed(
    terrain: Terrain,
    release: tuple[AnyRelease, ...],
    zone: tuple[Zone, ...],
    floor: Wall,
    gravity: Gravity,
) -> float:
    """Return an upper estimate of the speed of the flow down a terrain, m/s.

    It is the speed at which friction holds the flow on a slope that nine tenths of the ground
    within reach do not exceed, by the law that brakes it least; and no more than the drop of the
    energy line allows.  The flow is taken 4/9 as deep as the release.  At least it is the speed
    at which the release collapses under its own depth.

    Notes
    -----
    The reach is what lies below lines that fall from the places of the release by the sliding
    friction.  A flow that gathers in a channel may be deeper than its release, and faster.
    """
    g = -gravity.components[1]
    laws = [floor.friction, *(part.friction for part in zone)]
    fastest = 0.0
    for part in release:
        deepest, depth = _depths(part)
        fastest = max(fastest, sqrt(2.0 * g * deepest))
        share = 1.0 - part.pore_pressure
        lines = [share * _sliding(law) for law in laws]
        drop, slope = _reach(terrain, part, _flattest(part, floor, zone), _stamps(terrain, part))
        held = max(
            _held_speed(law, line, depth, slope, g) for law, line in zip(laws, lines, strict=True)
        )
        fastest = max(fastest, min(held, sqrt(2.0 * g * (drop + deepest))))
    return fastest


def _depths(part: AnyRelease) -> tuple[float, float]:
    """Return the greatest depth of a release and that in motion, m."""
    if isinstance(part, HydrographRelease):
        return entering_depth(part), entering_depth(part)
    return greatest_depth(part), FREED * volume(part) / area(part)


def _sliding(law: object) -> float:
    """Return the coefficient of sliding friction of a law; 0 where it has none."""
    if isinstance(law, CoulombFriction):
        return (1.0 - law.pore_pressure) * tan(radians(law.angle))
    if isinstance(law, VoellmyFriction):
        return (1.0 - law.pore_pressure) * law.coefficient
    return 0.0


def _held_speed(law: object, sliding: float, depth: float, slope: float, g: float) -> float:
    """Return the speed that a law holds on a slope, rad, at a depth, m, in m/s.

    Infinite where no law brakes the flow by its speed.

    Examples
    --------
    >>> law = VoellmyFriction(law="voellmy", coefficient=0.1, turbulence=500.0)
    >>> round(_held_speed(law, 0.1, 1.0, radians(20.0), 9.81), 2)
    11.14
    """
    if isinstance(law, VoellmyFriction):
        return sqrt(max(law.turbulence * depth * (sin(slope) - sliding * cos(slope)), 0.0))
    if isinstance(law, ManningFriction):
        return sqrt(depth ** (4.0 / 3.0) * sin(slope)) / law.coefficient
    if isinstance(law, LogFriction):
        mean = max(log(max(30.0 * depth / law.roughness, 1.0)) - 1.0, 1.0) / KARMAN
        return mean * sqrt(g * depth * sin(slope))
    if isinstance(law, CoulombFriction) and tan(slope) <= sliding:
        return 0.0
    return inf


def within_reach(
    terrain: Terrain, release: tuple[AnyRelease, ...], zone: tuple[Zone, ...], floor: Wall
) -> Bools:
    """Return over which cells of a DEM the flow may come, (rows, columns).

    Those below lines that fall from the places of the releases by the sliding friction.
    """
    levels = terrain.levels
    found = np.zeros(levels.grid.shape, dtype=bool)
    for part in release:
        left = _energy_left(levels, part, _flattest(part, floor, zone))
        if left is not None:
            found |= left > 0.0
    return found


def _flattest(part: AnyRelease, floor: Wall, zone: tuple[Zone, ...]) -> float:
    """Return the least fall of the energy line of a release."""
    laws = [floor.friction, *(one.friction for one in zone)]
    share = 1.0 - part.pore_pressure
    return max(min(share * _sliding(law) for law in laws), LEAST_FRICTION)


def _stamps(terrain: Terrain, part: AnyRelease) -> tuple[Stamp, ...]:
    """Return what tells that the files of a terrain and a release have not changed."""
    names = (terrain.dem, terrain.crop, getattr(part, "file", None))
    return tuple(stamp_of(Path(name)) for name in names if isinstance(name, str))


@lru_cache(maxsize=32)
def _reach(
    terrain: Terrain, part: AnyRelease, line: float, stamps: tuple[Stamp, ...]
) -> tuple[float, float]:
    """Return the greatest drop of the energy line over ground, m, and the steep slope, rad.

    Parameters
    ----------
    terrain : Terrain
    part : release
    line : float
        Fall of the energy line.
    stamps : tuple
        Of their files.
    """
    levels = terrain.levels
    left = _energy_left(levels, part, line)
    if left is None:
        return 0.0, 0.0
    within = left > 0.0
    if not within.any() or min(levels.grid.shape) < 2:
        return 0.0, 0.0
    down, along = np.gradient(levels.values, levels.grid.cell)
    slope = np.arctan(np.hypot(down, along))[within]
    slope = slope[np.isfinite(slope)]
    steep = float(np.percentile(slope, STEEP)) if len(slope) else 0.0
    return float(left[within].max()), steep


def _energy_left(levels: Raster, part: AnyRelease, line: float) -> Floats | None:
    """Return how far the energy line of a release lies over the cells, (rows, columns), m.

    nan where there are no data; None if the release is off the DEM.
    """
    start = _start(levels, part)
    if start is None:
        return None
    grid = levels.grid
    x = grid.west + (np.arange(grid.columns) + 0.5) * grid.cell
    y = grid.north - (np.arange(grid.rows) + 0.5) * grid.cell
    (west, south, east, north), top = start
    beside = np.maximum(np.maximum(west - x, x - east), 0.0)
    beyond = np.maximum(np.maximum(south - y, y - north), 0.0)
    found: Floats = top - line * np.hypot(beside[None, :], beyond[:, None]) - levels.values
    return found


def _start(
    levels: Raster, part: AnyRelease
) -> tuple[tuple[float, float, float, float], float] | None:
    """Return the box around a release, m, and the highest ground in it, m; None off the DEM."""
    box = borders(part)
    if box is None:
        return None
    cell = levels.grid.cell
    around = box[0] - cell, box[1] - cell, box[2] + cell, box[3] + cell
    under = levels.cropped(*around).values
    return (box, float(np.nanmax(under))) if np.isfinite(under).any() else None
