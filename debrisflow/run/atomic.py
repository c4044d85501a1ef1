"""Writes files so that they are complete or absent, even after a crash during writing."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from debrisflow.run.refusals import refused

UNFINISHED = ".unfinished"


@contextmanager
def replaced(path: Path, is_flushed: bool = True) -> Iterator[Path]:
    """Yield a temporary name beside a path; at the end the file written there replaces the path.

    Its folder must be there: that of a run which was removed is not made again.  If the block
    raises, the path is unchanged.

    Parameters
    ----------
    path : Path
    is_flushed : bool
        Whether the file is to outlive a loss of power too, for which the disk is waited for.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    unfinished = path.with_name(path.name + UNFINISHED)
    try:
        yield unfinished
        if is_flushed:
            flush(unfinished)
        os.replace(unfinished, path)
    except OSError as error:
        raise refused(path, error) from error
    finally:
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)


@contextmanager
def replaced_files(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder within a folder; at the end the files written there move into it.

    For writers that choose a format by the ending of a name or write several files.  The folder is
    made if it does not exist, that in which it lies must.  If the block raises, its files are
    unchanged.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    unfinished = folder / f"new{UNFINISHED}"
    try:
        shutil.rmtree(unfinished, ignore_errors=True)  # what a killed run has left there
        made(folder)
        unfinished.mkdir(exist_ok=True)
        yield unfinished
        files = sorted(unfinished.iterdir())
        for file in files:
            flush(file)
        for file in files:
            os.replace(file, folder / file.name)
    except OSError as error:
        raise refused(folder, error) from error
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def made(folder: Path, is_deep: bool = False) -> Path:
    """Return a folder, made if it does not exist.

    Parameters
    ----------
    folder : Path
    is_deep : bool
        Make those in which it lies too; within a run they must be there, or the run was removed.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    try:
        folder.mkdir(parents=is_deep, exist_ok=True)
    except OSError as error:
        raise refused(folder, error) from error
    return folder


def flush(file: Path) -> None:
    """Bring a file to the disk; else, after a loss of power, an empty one may have its new name."""
    descriptor = os.open(file, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
