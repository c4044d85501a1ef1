"""The surfaces of the walls, for ParaView and pyvista."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.run.vtu import write_mesh
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.scene import obstacle_faces, scene_of, section_lines, trajectories

if TYPE_CHECKING:
    import pyvista

Floats = NDArray[np.float64]
WALLS = "walls.vtp"
OBSTACLES = "obstacles.pvd"
OF_THE_SPACE = -1


def write_walls(path: Path, case: ResolvedCase) -> None:
    """Write floor, walls and obstacles that stand as polygons, in a VTP file.

    In two dimensions walls are lines.  The array ``obstacle`` is -1 for the walls of the space and
    counts the obstacles from 0, in the order of the case.

    Parameters
    ----------
    path : Path
    case : ResolvedCase
    """
    moving = {number - len(WALL_NAMES) for number in trajectories(case)}
    bodies = {k: body for k, body in enumerate(obstacle_faces(case)) if k not in moving}
    space: list[Floats] = []
    if case.dimension == 3:
        scene = scene_of(case, case.geometry.height)
        space = [*scene.floor, *scene.behind, *scene.before]
    lines = section_lines(case) if case.dimension == 2 else []
    write_mesh(path, _mesh(lines, space, bodies))


def write_obstacles(path: Path, case: ResolvedCase, time: float) -> None:
    """Write the obstacles that move, where they are at a time, s, as :func:`write_walls` does."""
    moving = {number - len(WALL_NAMES) for number in trajectories(case)}
    bodies = {k: body for k, body in enumerate(obstacle_faces(case, time)) if k in moving}
    write_mesh(path, _mesh([], [], bodies))


def _cells(sizes: list[int], start: int = 0) -> NDArray[np.int64]:
    """Return cells as VTK lists them, the number of corners before these, of corners in a row."""
    first = start + np.cumsum([0, *sizes[:-1]])
    return np.concatenate(
        [np.append(size, np.arange(size) + begin) for size, begin in zip(sizes, first, strict=True)]
    )


def _mesh(lines: list[Floats], space: list[Floats], bodies: dict[int, Floats]) -> pyvista.PolyData:
    """Return lines, polygons of the space, and the faces of obstacles by their numbers."""
    import pyvista

    faces, number = list(space), [OF_THE_SPACE] * (len(lines) + len(space))
    for k, body in bodies.items():
        faces += list(body)
        number += [k] * len(body)
    lines = [np.pad(line, ((0, 0), (0, 3 - line.shape[1]))) for line in lines]
    first = sum(map(len, lines))
    mesh = pyvista.PolyData()
    if lines or faces:
        mesh.points = np.concatenate([*lines, *faces])
    if lines:
        mesh.lines = _cells([len(line) for line in lines])
    if faces:
        mesh.faces = _cells([len(face) for face in faces], first)
    mesh.cell_data["obstacle"] = np.array(number, dtype=np.int32)
    return mesh
