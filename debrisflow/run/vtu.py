"""Particle files for ParaView and pyvista: a VTU file a frame, and a PVD file with their times."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np

from debrisflow.errors import OutputError
from debrisflow.particles.arrays import ARRAYS
from debrisflow.particles.record import Particles
from debrisflow.run.atomic import replaced

FOLDER = "vtu"


def write_particles(path: Path, particles: Particles, rows: slice = slice(None)) -> None:
    """Write particles as vertex cells of a binary VTU compressed by zlib.

    The arrays are those of :data:`debrisflow.particles.arrays.ARRAYS`.  Positions are float64,
    since terrain may lie far from its origin.

    Parameters
    ----------
    path : Path
    particles : Particles
    rows : slice, optional
        Which particles; all by default.
    """
    position = particles.position[rows]
    data = {
        array.name: getattr(particles, array.name)[rows].astype(array.storage) for array in ARRAYS
    }
    vertices = np.arange(len(position))[:, None]
    mesh = meshio.Mesh(position, [("vertex", vertices)], point_data=data)
    with replaced(path) as unfinished:
        meshio.vtu.write(unfinished, mesh, binary=True, compression="zlib")


def read_collection(path: Path) -> list[tuple[float, Path]]:
    """Return times, s, and files of the frames that a PVD lists, in its order.

    Raises
    ------
    OutputError
        If the file is damaged.
    """
    try:
        sets = ElementTree.parse(path).iter("DataSet")
        return [(float(s.attrib["timestep"]), path.parent / s.attrib["file"]) for s in sets]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise OutputError(f"{path} is damaged: {error}") from error


class Collection:
    """The frames of a run: ``vtu/NNNNNN.vtu`` and the PVD beside that folder.

    The PVD lists a frame only when its file is complete, so that a running run can be opened.

    Parameters
    ----------
    path : Path
        The PVD; one that is there already is continued.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.frames = read_collection(path) if path.exists() else []
        self._write()

    def append(self, time: float, particles: Particles, rows: slice = slice(None)) -> None:
        """Write a frame at a time, s; of some rows only, if they are given."""
        file = self.path.parent / FOLDER / f"{len(self.frames):06d}.vtu"
        write_particles(file, particles, rows)
        self.frames.append((time, file))
        self._write()

    def drop_after(self, time: float) -> None:
        """Remove the frames later than a time, s."""
        dropped = [file for at, file in self.frames if at > time]
        self.frames = [frame for frame in self.frames if frame[0] <= time]
        self._write()
        for file in dropped:
            file.unlink(missing_ok=True)

    def _write(self) -> None:
        root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
        collection = ElementTree.SubElement(root, "Collection")
        for time, file in self.frames:
            name = f"{FOLDER}/{file.name}"
            ElementTree.SubElement(
                collection, "DataSet", timestep=repr(float(time)), part="0", file=name
            )
        ElementTree.indent(root)
        with replaced(self.path) as unfinished:
            ElementTree.ElementTree(root).write(unfinished, encoding="utf-8", xml_declaration=True)
