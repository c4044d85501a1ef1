"""A run as a process of the command line, and what can be seen of it in its folder."""

from __future__ import annotations

import contextlib
import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

UNFINISHED = ".unfinished"
CHECKPOINT = "checkpoint.h5"
PATIENCE = 120.0  # s, after which a process hangs
POLL = 0.0005  # s


class LostError(Exception):
    """A run did not do what it must."""


@dataclass
class Process:
    """A run or its continuation, with what was in its folder before."""

    folder: Path
    popen: subprocess.Popen[bytes]
    messages: Path
    mark: int
    before: set[tuple[str, int]]

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended."""
        return self.popen.poll() is not None

    def has_started(self) -> bool:
        """Return whether start-up is over: the line on threads is logged right before it is."""
        with contextlib.suppress(OSError), (self.folder / "run.log").open("rb") as log:
            log.seek(self.mark)
            return b"threads by" in log.read()
        return False

    def has_finished(self) -> bool:
        """Return whether the folder holds all results."""
        with contextlib.suppress(OSError):
            summary = (self.folder / "summary.json").read_text(encoding="utf-8")
            return '"end of the simulated time"' in summary
        return False

    def new_unfinished(self) -> set[str]:
        """Return the names of files that are being written, without those left by earlier kills."""
        return {name for name, _ in unfinished(self.folder) - self.before}

    def is_saving(self) -> bool:
        """Return whether a checkpoint is being written."""
        return CHECKPOINT + UNFINISHED in self.new_unfinished()

    def is_writing_others(self) -> bool:
        """Return whether another file is being written."""
        return bool(self.new_unfinished() - {CHECKPOINT + UNFINISHED})

    def wait_for(self, condition: Callable[[], bool], longest: float = PATIENCE) -> bool:
        """Return whether a condition came about before the process ended."""
        end = monotonic() + longest
        while not condition():
            if self.has_ended or monotonic() > end:
                return False
            sleep(POLL)
        return True

    def wait(self, longest: float = PATIENCE) -> int:
        """Return the exit code; a process that hangs is lost."""
        try:
            return self.popen.wait(longest)
        except subprocess.TimeoutExpired as error:
            self.popen.kill()
            self.popen.wait()
            raise LostError(f"hangs: {self.text()[-500:]}") from error

    def text(self) -> str:
        """Return what the process has printed."""
        return self.messages.read_text(encoding="utf-8", errors="replace")


def unfinished(folder: Path) -> set[tuple[str, int]]:
    """Return names and inodes of the unfinished files in a folder and in those within it."""
    found = set()
    for place in (folder, *(folder / name for name in ("vtu", "layers", "probes", "probes/grid"))):
        with contextlib.suppress(OSError), os.scandir(place) as entries:
            for entry in entries:
                if entry.name.endswith(UNFINISHED):
                    found.add((entry.name, entry.inode()))
    return found
