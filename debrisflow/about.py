"""The installation in a few lines: versions, cores, threading layer and cache folder."""

from __future__ import annotations

import platform
import re
from importlib.metadata import PackageNotFoundError, requires, version

from debrisflow import __version__
from debrisflow._jit import CACHE_DIRECTORY, THREADING_LAYER, cores


def about() -> dict[str, str]:
    """Return what a report of a fault should tell, by name."""
    return {
        "debrisflow": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        **{name: installed(name) for name in dependencies()},
        "cores": str(cores()),
        "threading layer": THREADING_LAYER,
        "cache folder": str(CACHE_DIRECTORY),
    }


def dependencies() -> list[str]:
    """Return the packages that this one was installed with, without those of its extras."""
    try:
        wanted = requires("debrisflow") or []
    except PackageNotFoundError:
        return []
    return [re.split(r"[^\w.-]", line)[0] for line in wanted if "extra ==" not in line]


def installed(name: str) -> str:
    """Return the version of an installed package."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
