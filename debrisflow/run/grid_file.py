"""The files of a probe on a grid: an image a sample, and a PVD file with their times."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.probes.grid import GridProbe
from debrisflow.run.atomic import UNFINISHED
from debrisflow.run.tables import Row
from debrisflow.run.vtu import Collection, write_mesh

ENDING = "vti"


class GridWriter:
    """Writes ``probes/NAME.pvd`` and ``probes/NAME/NNNNNN.vti``; files there are continued.

    Parameters
    ----------
    folder : Path
        Of the probes.
    probe : GridProbe
        With its step.
    columns : sequence of str
        Names of the columns of a sample.
    """

    def __init__(self, folder: Path, probe: GridProbe, columns: Sequence[str]) -> None:
        self._probe, self._columns = probe, columns
        self._images = Collection(folder / f"{probe.name}.pvd", probe.name, ENDING)

    def write(self, time: float, rows: Iterable[Row]) -> None:
        """Append a sample at a time, s: a row for each point, x the fastest."""
        values = np.asarray(rows, dtype=np.float32)
        self._images.append(time, lambda file: self._write_image(file, values))

    def flush(self) -> None:
        """Do nothing: each image is on the disk when it is complete."""

    def truncate_after(self, time: float) -> None:
        """Remove the images later than a time, s."""
        self._images.drop_after(time)

    def close(self) -> None:
        """Do nothing: each image is complete."""

    def _write_image(self, path: Path, values: NDArray[np.float32]) -> None:
        import pyvista

        step = self._probe.distance(0.0)
        counts = self._probe.counts(step)
        origin = [low for _, (low, _) in self._probe.extents()]
        missing = 3 - len(counts)  # axes beyond two dimensions
        image = pyvista.ImageData(
            dimensions=(*counts, *missing * [1]),
            spacing=(step, step, step),
            origin=(*origin, *missing * [0.0]),
        )
        image.point_data["velocity"] = np.pad(values[:, : len(counts)], ((0, 0), (0, missing)))
        for name, column in zip(self._columns, values.T, strict=True):
            if not name.startswith("velocity"):
                image.point_data[name] = column
        write_mesh(path, image)


def grid_files(folder: Path) -> Iterator[Path]:
    """Yield the files in the folder of the probes that probes on a grid have written."""
    image = re.compile(rf"\d{{6,}}\.{ENDING}({re.escape(UNFINISHED)})?")
    for listing in folder.glob("*.pvd"):
        text = listing.read_text(encoding="utf-8", errors="replace")
        if f'file="{listing.stem}/' in text or "DataSet" not in text:
            yield listing
            yield from (f for f in folder.glob(f"{listing.stem}/*") if image.fullmatch(f.name))
