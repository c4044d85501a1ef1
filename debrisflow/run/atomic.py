"""Files that stand in a folder whole or not at all, also after a crash while one is written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from debrisflow.errors import OutputError

UNFINISHED = ".unfinished"


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Yield a name beside a path to write to; what was written takes the path's place at the end.

    The folder is made if need be.  If the block raises, the path keeps what it held before.

    Raises
    ------
    OutputError
        Where the system refuses to write.
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
