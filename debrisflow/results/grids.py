"""The images of a probe on a grid as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from debrisflow.case.probes.grid import GridProbe
from debrisflow.errors import OutputError
from debrisflow.results.vtk_file import read_points
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
    images = read_collection(listing)
    step, counts = probe.distance(spacing), probe.counts(spacing)
    table = {"time": np.array([time for time, _ in images])}
    for (axis, (low, _)), count in zip(probe.extents(), counts, strict=True):
        table[axis] = low + step * np.arange(count)
    # an image is read before memory is taken for all, so that the files bound it
    read = [_image(file, counts) for _, file in images]
    for name in FIELDS:
        ends = [3] if name == "velocity" else []
        table[name] = np.zeros((len(images), *counts, *ends))
        for number, image in enumerate(read):
            table[name][number] = image[name]
    return table


def _image(file: Path, counts: Sequence[int]) -> Table:
    """Return the fields of an image, whose axes are x, y, z and those of their components."""
    arrays, found = read_points(file, math.prod(counts)).arrays, {}
    for name in FIELDS:
        values = arrays.get(name)
        components = (3,) if name == "velocity" else ()
        if values is None or values.shape[1:] != components:
            raise OutputError(f"{file} is damaged: it is no image of this probe")
        # x is the fastest in the file
        shape = (*reversed(counts), *components)
        axes = (*reversed(range(len(counts))), *range(len(counts), len(shape)))
        found[name] = values.reshape(shape).transpose(axes)
    return found
