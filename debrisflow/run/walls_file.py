"""The surfaces of the walls, for ParaView and pyvista."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.run.vtu import write_mesh
from debrisflow.space.scene import scene_of, section_lines

if TYPE_CHECKING:
    import pyvista

WALLS = "walls.vtp"
OF_THE_SPACE = -1


def write_walls(path: Path, case: ResolvedCase) -> None:
    """Write floor, walls and obstacles as polygons, in two dimensions as lines, in a VTP file.

    The array ``obstacle`` is -1 for the walls of the space and counts the obstacles from 0, in the
    order of the case.

    Parameters
    ----------
    path : Path
    case : ResolvedCase
    """
    write_mesh(path, _polygons(case) if case.dimension == 3 else _lines(case))


def _lines(case: ResolvedCase) -> pyvista.PolyData:
    import pyvista

    lines = section_lines(case)
    corners = np.pad(np.concatenate(lines), ((0, 0), (0, 1)))
    mesh = pyvista.PolyData(corners, lines=_cells([len(line) for line in lines]))
    mesh.cell_data["obstacle"] = np.full(len(lines), OF_THE_SPACE, dtype=np.int32)
    return mesh


def _cells(sizes: list[int]) -> NDArray[np.int64]:
    """Return cells as VTK lists them, the number of corners before these, of corners in a row."""
    first = np.cumsum([0, *sizes[:-1]])
    return np.concatenate(
        [np.append(size, np.arange(size) + start) for size, start in zip(sizes, first, strict=True)]
    )


def _polygons(case: ResolvedCase) -> pyvista.PolyData:
    import pyvista

    scene = scene_of(case, case.geometry.height)
    faces = [*scene.floor, *scene.behind, *scene.before]
    number = [OF_THE_SPACE] * len(faces)
    for k, body in enumerate(scene.obstacles):
        faces += list(body)
        number += [k] * len(body)
    corners = np.concatenate(faces)
    mesh = pyvista.PolyData(corners, faces=_cells([len(face) for face in faces]))
    mesh.cell_data["obstacle"] = np.array(number, dtype=np.int32)
    return mesh
