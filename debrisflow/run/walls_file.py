"""The surfaces of the walls of three dimensions, for ParaView and pyvista."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import OutputError
from debrisflow.run.atomic import replaced
from debrisflow.space.scene import scene_of

WALLS = "walls.vtp"
OF_THE_SPACE = -1


def write_walls(path: Path, case: ResolvedCase) -> None:
    """Write floor, walls and obstacles as polygons, in a VTP file.

    The array ``obstacle`` is -1 for the walls of the space and counts the obstacles from 0, in the
    order of the case.

    Parameters
    ----------
    path : Path
    case : ResolvedCase
        In three dimensions.
    """
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    scene = scene_of(case, case.geometry.height)
    faces = [*scene.floor, *scene.behind, *scene.before]
    number = [OF_THE_SPACE] * len(faces)
    for k, body in enumerate(scene.obstacles):
        faces += list(body)
        number += [k] * len(body)
    corners = np.concatenate(faces)
    sizes = [len(face) for face in faces]
    first = np.cumsum([0, *sizes[:-1]])
    cells = [
        np.append(size, np.arange(size) + start) for size, start in zip(sizes, first, strict=True)
    ]
    mesh = pyvista.PolyData(corners, faces=np.concatenate(cells))
    mesh.cell_data["obstacle"] = np.array(number, dtype=np.int32)
    with replaced(path) as unfinished:
        writer = vtkXMLPolyDataWriter()
        writer.SetFileName(str(unfinished))
        writer.SetInputData(mesh)
        if not writer.Write():
            raise OutputError(f"cannot write {path}: no space is left, or the folder is read-only")
