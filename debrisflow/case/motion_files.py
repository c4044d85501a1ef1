"""Motions of obstacles from CSV files, put into the case as tables so that it stands alone."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case.motion import DISPLACEMENTS
from debrisflow.case.problems import Problem
from debrisflow.case.series import UnreadableSeriesError, read_series

WITHOUT_AXIS = (
    "has a column 'angle', but no file says about which axis; write the table into the case, with "
    "'about'"
)


def inline_motions(data: dict[str, object], folder: Path) -> list[Problem]:
    """Replace the names of the files of motions by their contents.

    A file that turns an obstacle about an axis has to be a table of the case instead, since that
    alone says where the axis is.

    Parameters
    ----------
    data : dict
        The case as read from TOML; changed in place.
    folder : Path
        Folder of the case file, in which the names are looked up.

    Returns
    -------
    list of Problem
        What kept files from being read; then their names stay where they were.
    """
    problems = []
    entries = data.get("obstacle")
    for k, entry in enumerate(entries if isinstance(entries, list) else []):
        name = entry.get("motion") if isinstance(entry, dict) else None
        if not isinstance(entry, dict) or not isinstance(name, str):
            continue
        key = f"obstacle.{k}.motion"
        try:
            motion = read_series(folder / name, ("time",), DISPLACEMENTS)
            if "angle" in motion:
                problems.append(Problem(key, WITHOUT_AXIS, name))
            else:
                entry["motion"] = motion
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            problems.append(Problem(key, f"cannot be read: {reason}", name))
        except UnreadableSeriesError as error:
            problems.append(Problem(key, str(error), name))
    return problems
