"""How much disk space a run needs, and whether it is there."""

from __future__ import annotations

import logging
import shutil
from contextlib import suppress
from math import ceil
from pathlib import Path

from debrisflow.case import ResolvedCase
from debrisflow.case.memory import size
from debrisflow.errors import OutputError
from debrisflow.run.layers import LAYERS
from debrisflow.run.work import mean_number
from debrisflow.space.ground import ground_of
from debrisflow.space.plan_grid import plan

LOG = logging.getLogger(__name__)
FRAME, FRAME_PARTICLE = 8e3, 60.0  # bytes of a particle file, and for each particle in it
CHECKPOINT, CHECKPOINT_PARTICLE = 1.2e5, 90.0
CHECKPOINTS = 3  # the last two, and one that is being written
LEVEL = 4.0  # bytes of a cell of the terrain
RASTER, WET_CELL = 6e3, 0.4  # of a layer, and for each cell of the map, of which most are dry
ROW = 45.0  # of a table
TABLES = 2e5  # history and probes
UNCERTAINTY = 2.0


def needed(case: ResolvedCase, particles: float) -> float:
    """Return the disk space that a run needs, bytes.

    Particle files, checkpoints, rasters of a map and the deposit, from measured sizes; probes on
    grids come on top.  In three small runs (a flume, a dam, a fan) the files had 0.6 to 0.8 times
    as much.

    Parameters
    ----------
    case : ResolvedCase
    particles : float
        Their mean number.
    """
    output, end = case.output, case.time.end
    frames = times(end, output.interval)
    deposits = times(end, output.deposit_interval or output.interval)
    if case.is_terrain:
        cells = ground_of(case).given.size
        depths = times(end, output.layer_interval) if output.layer_interval else 0
        table = deposits * min(float(cells), 3.0 * particles) * ROW
        maps = cells * LEVEL + (len(LAYERS) + depths) * (RASTER + WET_CELL * cells)
    else:
        table, maps = deposits * plan(case).x.size * ROW, 0.0
    return (
        frames * (FRAME + FRAME_PARTICLE * particles)
        + CHECKPOINTS * (CHECKPOINT + CHECKPOINT_PARTICLE * particles)
        + table
        + maps
        + TABLES
    )


def times(end: float, interval: float) -> int:
    """Return how often something is written until an end, s, with the start."""
    return ceil(end / interval - 1e-9) + 1


def expect_space(case: ResolvedCase, folder: Path, particles: int) -> None:
    """Refuse a run that the disk cannot hold, and warn of one that it may not.

    What the folder holds already counts as written.

    Parameters
    ----------
    case : ResolvedCase
    folder : Path
        Of the run; it may not be there yet.
    particles : int
        Fluid particles now.

    Raises
    ------
    OutputError
        If twice as much as is free is needed, more than the estimate can be wrong by.
    """
    there = next(one for one in (folder, *folder.absolute().parents) if one.exists())
    written = _written(folder)
    need = needed(case, mean_number(case, particles)) - written
    free = shutil.disk_usage(there).free
    told = f"the run needs about {size(need)} of disk space, and {size(free)} are free in {there}"
    if need > UNCERTAINTY * free:
        raise OutputError(
            f"{told}; free some, or start it with a longer output.interval or in another folder"
        )
    if need > free:
        LOG.warning("%s", told)


def _written(folder: Path) -> int:
    """Return the size of the files in a folder, bytes; others may change some meanwhile."""
    found = 0
    for file in folder.rglob("*"):
        with suppress(OSError):
            found += file.stat().st_size
    return found
