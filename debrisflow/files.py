"""Files that a case names, which nobody vouches for: regular ones of a bounded size.

A pipe or a device could be read without end; a file that is too large is refused before it is read.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from errno import EFBIG, EINVAL
from io import BufferedReader
from pathlib import Path
from stat import S_ISDIR, S_ISREG

MOST_TEXT = 64_000_000  # bytes, of a table, a list of classes or a file of polygons
MOST_BINARY = 4_000_000_000  # bytes, of a mesh or a raster
AT_ONCE = getattr(os, "O_NONBLOCK", 0)  # a pipe without a writer is opened without waiting


def regular(path: Path, most: int = MOST_TEXT) -> os.stat_result:
    """Return the state of a file that can be read as a whole.

    Raises
    ------
    OSError
        If there is none, it is a folder, a pipe or a device, or it has more bytes than ``most``.
    """
    try:
        state = path.stat()
    except ValueError as error:  # of a null character
        raise OSError(EINVAL, "its name cannot be that of a file") from error
    return _checked(state, most)


def _checked(state: os.stat_result, most: int) -> os.stat_result:
    if S_ISDIR(state.st_mode):
        raise OSError(EINVAL, "is a directory")
    if not S_ISREG(state.st_mode):
        raise OSError(EINVAL, "is a pipe or a device and no file")
    if state.st_size > most:
        raise OSError(EFBIG, f"has {state.st_size:,} bytes, more than the {most:,} allowed")
    return state


def opened(path: Path, most: int = MOST_TEXT) -> BufferedReader:
    """Open a file for reading; errors as those of :func:`regular`."""
    regular(path, most)
    # no with statement, as ruff wants: the caller closes it
    file = open(path, "rb", opener=lambda name, flags: os.open(name, flags | AT_ONCE))  # noqa: SIM115
    try:
        _checked(os.fstat(file.fileno()), most)  # of what was opened, if it was exchanged meanwhile
    except OSError:
        file.close()
        raise
    return file


def expect_regular_beside(path: Path, after: Sequence[str], instead: Sequence[str]) -> None:
    """Refuse a file whose companions, which a library reads too, are no files.

    Parameters
    ----------
    path : Path
    after, instead : sequence of str
        Endings of the companions, after the name and in the place of its ending.

    Raises
    ------
    OSError
    """
    names = [path.name + ending for ending in after] + [path.stem + ending for ending in instead]
    for beside in (path.with_name(name) for name in names):
        if os.path.lexists(beside):
            try:
                regular(beside, MOST_BINARY)
            except OSError as error:
                raise OSError(EINVAL, f"{beside.name} beside it: {error.strerror}") from error


def text_of(path: Path, most: int = MOST_TEXT) -> str:
    """Return the text of a file in UTF-8, without the mark at its head that some editors write.

    Raises
    ------
    OSError
        As :func:`regular`.
    UnicodeDecodeError
        If it is not UTF-8.
    """
    with opened(path, most) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(EFBIG, f"has more than the {most:,} bytes allowed")
    return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
