"""What may happen to the disk under a run: it is full, or the folder is gone."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path


def fill(filler: Path, left: int) -> None:
    """Take all the space of a file system but some bytes."""
    with contextlib.suppress(OSError), filler.open("wb") as file:
        free = shutil.disk_usage(filler.parent).free
        os.posix_fallocate(file.fileno(), 0, max(1, free - left))


def remove(folder: Path) -> None:
    """Remove a folder in which files appear meanwhile."""
    while folder.exists():
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def small_file_system(folder: Path, size: int) -> Iterator[Path | None]:
    """Mount a small file system in memory; None where that is not allowed."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if sys.platform != "linux" or subprocess.run(command, capture_output=True).returncode != 0:
        yield None
        return
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)
