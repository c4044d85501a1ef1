"""What a person is told when the operating system refuses to write: what happened, what to do."""

from __future__ import annotations

import errno
import shutil
from contextlib import suppress
from pathlib import Path

from debrisflow.errors import OutputError

FULL = 2**20  # bytes; libraries that say only that they failed have met a full disk below this
RESUME = "a run then goes on with: debrisflow resume RUN"
SAYS = {
    errno.ENOSPC: "no space is left on the disk",
    errno.EDQUOT: "the quota of disk space is used up",
    errno.EROFS: "the disk is read-only",
    errno.EACCES: "permission is denied",
}
REMEDIES = {
    errno.ENOSPC: f"free some; {RESUME}",
    errno.EDQUOT: f"remove files or ask for more; {RESUME}",
    errno.EROFS: f"make it writable; {RESUME}",
}


def refused(path: Path, error: OSError) -> OutputError:
    """Return the error that tells why a file or folder cannot be written.

    Parameters
    ----------
    path : Path
    error : OSError
        Libraries give some without a number, by which a full disk is told from what is free.

    Examples
    --------
    >>> print(refused(Path("run/case.toml"), OSError(errno.EACCES, "Permission denied")))
    cannot write run/case.toml: permission is denied
    """
    parent = path.parent
    if error.errno in (errno.ENOENT, errno.ESTALE, None) and not parent.is_dir():
        return removed(parent)
    number, free = error.errno, _free(parent)
    if number is None and free is not None and free < FULL:
        number = errno.ENOSPC
    says = SAYS.get(number or 0, error.strerror or str(error) or "the operating system refuses")
    if number == errno.ENOSPC and free is not None:
        from debrisflow.case.memory import size  # status, which needs none of it, is to be quick

        says += f" ({size(free)} are free)"
    remedy = REMEDIES.get(number or 0)
    return OutputError(f"cannot write {path}: {says}" + (f"; {remedy}" if remedy else ""))


def removed(path: Path) -> OutputError:
    """Return the error that tells of a file or folder which is no more where a run writes it."""
    return OutputError(
        f"cannot write: {path} was removed or moved during writing; put it back and go on with: "
        "debrisflow resume RUN, or start the run again with: debrisflow run"
    )


def _free(folder: Path) -> int | None:
    """Return the free space of the nearest folder that exists, bytes."""
    for one in (folder, *folder.absolute().parents):
        with suppress(OSError):
            return shutil.disk_usage(one).free
    return None
