"""The images of a probe on a grid as arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from debrisflow.case.probes.grid import GridProbe
from debrisflow.errors import OutputError
from debrisflow.results.frames import read_mesh
from debrisflow.run.tables import Table
from debrisflow.run.vtu import read_collection

FIELDS = ("velocity", "pressure", "concentration", "wet")


def read_grid(listing: Path, probe: GridProbe, spacing: float) -> Table:
    """Return the samples of a probe on a grid.

    Parameters
    ----------
    listing : Path
        The PVD of its images.
    probe : GridProbe
    spacing : float, m

    Returns
    -------
    dict
        ``time``, (n,), ``x``, ``y`` and in three dimensions ``z``, and the fields, arrays of
        float64 whose axes are time, x, y, z, of the velocity then its three components.

    Raises
    ------
    OutputError
        If a file is missing or damaged.
    """
    if not listing.is_file():
        raise OutputError(f"{listing} is missing")
    images = read_collection(listing)
    step, counts = probe.distance(spacing), probe.counts(spacing)
    table = {"time": np.array([time for time, _ in images])}
    for (axis, (low, _)), count in zip(probe.extents(), counts, strict=True):
        table[axis] = low + step * np.arange(count)
    for name in FIELDS:
        table[name] = np.zeros((len(images), *counts, *([3] if name == "velocity" else [])))
    for number, (_, file) in enumerate(images):
        image = read_mesh(file)
        for name in FIELDS:
            try:
                values = np.asarray(image.point_data[name])
                # x is the fastest in the file
                shape = (*reversed(counts), *values.shape[1:])
                axes = (*reversed(range(len(counts))), *range(len(counts), len(shape)))
                table[name][number] = values.reshape(shape).transpose(axes)
            except (KeyError, ValueError) as error:
                raise OutputError(f"{file} is damaged: it is no image of this probe") from error
    return table
