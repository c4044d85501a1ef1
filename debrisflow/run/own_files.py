"""The files of a run folder lie within it: links that lead out of it are refused."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from debrisflow.errors import OutputError
from debrisflow.run.atomic import UNFINISHED
from debrisflow.run.folder import MOVING, RESULTS
from debrisflow.run.layers import FOLDER as LAYERS
from debrisflow.run.names import LOCK, MAPS, PICTURES, POSTPROCESS, PROBES
from debrisflow.run.vtu import FOLDER

FOLDERS = (FOLDER, MOVING, LAYERS, PROBES, POSTPROCESS, PICTURES, MAPS)


def must_be_own(folder: Path) -> None:
    """Refuse a run folder in which a file of the run is no regular file or a link out of it.

    What is read would come from elsewhere, into a report perhaps, and what is written would go
    there.  Files that no command reads or writes do not count.

    Raises
    ------
    OutputError
    """
    root = os.path.realpath(folder)
    for entry in _entries(folder):
        try:
            mode = os.lstat(entry).st_mode
        except OSError:
            continue  # gone since, or none of this name
        target = entry
        if stat.S_ISLNK(mode):
            target = os.path.realpath(entry)
            if os.path.commonpath([root, target]) != root:
                raise OutputError(
                    f"{entry} is a link out of the folder of its run; replace it by what it leads "
                    "to if you trust that"
                )
            mode = os.stat(target).st_mode if os.path.exists(target) else 0
        if mode and not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            raise OutputError(f"{entry} is no regular file, and so none of a run; remove it")


def _entries(folder: Path) -> Iterator[str]:
    """Yield the paths that a run or a command may have written, whether they are there or not."""
    for name in (*RESULTS, LOCK):
        yield os.path.join(folder, name)
        yield os.path.join(folder, name + UNFINISHED)
    for name in FOLDERS:
        top = os.path.join(folder, name)
        yield top
        for place, folders, files in os.walk(top):  # goes into no link
            yield from (os.path.join(place, one) for one in (*folders, *files))
