"""The lock by which one process at a time writes into the folder of a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from debrisflow.errors import OutputError
from debrisflow.run.names import LOCK
from debrisflow.run.refusals import refused

PATIENCE = 1.0  # s, for a process that only looks whether there is a run


class LockedError(OutputError):
    """Another process runs in a folder."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other processes from running in a folder, which is made if it does not exist.

    The operating system takes the lock from a process that ends, however it ends.

    Raises
    ------
    LockedError
        If another process runs there.
    OutputError
        If the folder cannot be written.
    """
    lock = FileLock(folder / LOCK, timeout=PATIENCE)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except Timeout as error:
        raise LockedError(
            f"another process is writing into {folder}; watch it with: debrisflow status {folder}"
        ) from error
    except OSError as error:
        raise refused(folder, error) from error
    except NotImplementedError as error:
        raise OutputError(f"cannot write into {folder}: {error}") from error
    try:
        yield
    finally:
        with suppress(OSError):  # Windows keeps a file that is open
            (folder / LOCK).unlink()
        lock.release()


def is_locked(folder: Path) -> bool | None:
    """Return whether a process is running in a folder; None where that cannot be found out."""
    if not (folder / LOCK).exists():
        return False
    lock = FileLock(folder / LOCK, timeout=0.0)
    try:
        lock.acquire()
    except Timeout:
        return True
    except (OSError, NotImplementedError):
        return None
    lock.release()
    return False
