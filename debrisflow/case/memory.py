"""The memory that this machine has, and how numbers of bytes are written."""

from __future__ import annotations

import os
from pathlib import Path


def available_memory() -> float | None:
    """Return the memory, in bytes, that can be had now, None where it cannot be told."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * int(line.split()[1])
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def size(count: float) -> str:
    """Return a number of bytes as people write it.

    Examples
    --------
    >>> size(3.2e7), size(5e9)
    ('32 MB', '5.0 GB')
    """
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"
