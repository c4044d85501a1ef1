"""Writes files so that they are complete or absent, even after a crash during writing."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from debrisflow.errors import OutputError

UNFINISHED = ".unfinished"


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a temporary name beside a path; at the end the file written there replaces the path.

    The folder is created if it does not exist.  If the block raises, the path is unchanged.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    unfinished = path.with_name(path.name + UNFINISHED)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield unfinished
        os.replace(unfinished, path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)
