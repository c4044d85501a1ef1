"""Files for ParaView and pyvista: the particles of a frame, meshes, a PVD file with their times."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import meshio
import numpy as np

from debrisflow.errors import OutputError
from debrisflow.particles.arrays import ARRAYS
from debrisflow.particles.record import Particles
from debrisflow.run.atomic import made, replaced
from debrisflow.run.reading import within, xml_of

if TYPE_CHECKING:
    import pyvista

FOLDER = "vtu"
ENDINGS = (".vtu", ".vtp", ".vti")


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
        array.name: getattr(particles, array.name)[rows].astype(array.storage)
        for array in ARRAYS
        if not array.optional or len(getattr(particles, array.name))
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
        If the file is missing or damaged, or lists what is no file of VTK in a folder beside it.
    """
    try:
        return [_listed(path, one.attrib) for one in xml_of(path).iter("DataSet")]
    except KeyError as error:
        raise OutputError(f"{path} is damaged: an entry has no {error.args[0]}") from error
    except ValueError as error:
        raise OutputError(f"{path} is damaged: {error}") from error


def _listed(path: Path, entry: Mapping[str, str]) -> tuple[float, Path]:
    """Return the time and the file of an entry of a PVD."""
    time, name = float(entry["timestep"]), entry["file"]
    if not math.isfinite(time):
        raise ValueError(f"a time in it is {time}")
    # a run that is continued removes later ones, so these must be its own
    if not name.endswith(ENDINGS):
        raise ValueError(f"it lists {name!r:.200}, which is no file of VTK")
    return time, within(path.parent, name)


def write_collection(path: Path, frames: Iterable[tuple[float, Path]]) -> None:
    """Write a PVD that lists files at times, s; they lie in folders beside it."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for time, file in frames:
        name = file.relative_to(path.parent).as_posix()
        ElementTree.SubElement(
            collection, "DataSet", timestep=repr(float(time)), part="0", file=name
        )
    ElementTree.indent(root)
    with replaced(path) as unfinished:
        ElementTree.ElementTree(root).write(unfinished, encoding="utf-8", xml_declaration=True)


class Collection:
    """A series of files, ``FOLDER/NNNNNN.vtu``, and the PVD beside that folder.

    The PVD lists a file only when it is complete, so that a running run can be opened.

    Parameters
    ----------
    path : Path
        The PVD; one that is there already is continued.
    folder : str
        Name of the folder of the files.
    ending : str
        Of the names of the files.
    """

    def __init__(self, path: Path, folder: str = FOLDER, ending: str = "vtu") -> None:
        self.path, self._folder, self._ending = path, path.parent / folder, ending
        self.frames = read_collection(path) if path.exists() else []
        write_collection(path, self.frames)

    def append(self, time: float, write: Callable[[Path], None]) -> None:
        """Add a file at a time, s; the function writes it."""
        file = made(self._folder) / f"{len(self.frames):06d}.{self._ending}"
        write(file)
        self.frames.append((time, file))
        write_collection(self.path, self.frames)

    def drop_after(self, time: float) -> None:
        """Remove the files later than a time, s."""
        dropped = [file for at, file in self.frames if at > time]
        self.frames = [frame for frame in self.frames if frame[0] <= time]
        write_collection(self.path, self.frames)
        for file in dropped:
            file.unlink(missing_ok=True)


def write_mesh(path: Path, mesh: pyvista.DataSet) -> None:
    """Write a mesh in the XML format of VTK that fits its type."""
    from vtkmodules.vtkIOXML import vtkXMLDataSetWriter

    with replaced(path) as unfinished:
        writer = vtkXMLDataSetWriter()
        writer.SetFileName(str(unfinished))
        writer.SetInputData(mesh)
        if not writer.Write():
            raise OSError("the writer of VTK failed")
