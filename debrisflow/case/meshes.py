"""The mesh files that a case names: found beside it, read, and refused if they enclose nothing."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case.problems import Problem
from debrisflow.case.triangles import UnreadableSurfaceError, open_edges, read_surface

TABLES = ("obstacle", "fill")


def find_meshes(data: dict[str, object], folder: Path) -> dict[str, list[Problem]]:
    """Replace the names of mesh files by absolute paths, so that a run finds them again.

    A run keeps the path and not the triangles: it can be resumed as long as the mesh is at that
    place, unchanged.

    Parameters
    ----------
    data : dict
        The case as read from TOML; changed in place.
    folder : Path
        Folder of the case file, in which the names are looked up.

    Returns
    -------
    dict of str to list of Problem
        What is wrong with the files that a table names, by the name of the table.
    """
    problems: dict[str, list[Problem]] = {}
    for name in TABLES:
        entries = data.get(name)
        for k, entry in enumerate(entries if isinstance(entries, list) else []):
            if not isinstance(entry, dict) or entry.get("type") != "mesh":
                continue
            file = entry.get("file")
            if not isinstance(file, str):
                continue
            path = (folder / file).absolute()
            wrong = _unusable(path)
            if wrong:
                problems.setdefault(name, []).append(Problem(f"{name}.{k}.file", wrong, file))
            else:
                entry["file"] = str(path)
    return problems


def _unusable(path: Path) -> str | None:
    """Return what keeps a file from standing for a body, None if nothing does."""
    try:
        edges = open_edges(read_surface(path))
    except UnreadableSurfaceError as error:
        return str(error)
    if edges:
        return (
            f"is not closed: {edges} edges bound an odd number of triangles; close its holes, "
            "and give a terrain sides and a base"
        )
    return None
