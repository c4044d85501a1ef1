"""Facts about the installation: versions, cores, threading layer and cache folder."""

from __future__ import annotations

import platform
import re
from importlib.metadata import PackageNotFoundError, requires, version

from debrisflow import __version__
from debrisflow._jit import CACHE_DIRECTORIES, THREADING_LAYER, cores

CACHE = str(CACHE_DIRECTORIES[-1]) if CACHE_DIRECTORIES else "none that can be written"
HOW_TO_SHARE = (
    f"The kernels are in {CACHE}.\n"
    "On a node that cannot write there they are used as they are.  To put them elsewhere, set\n"
    "XDG_CACHE_HOME to a folder both for this command and for the runs.  They serve the same\n"
    "installation of debrisflow on processors of the same kind."
)


def about() -> dict[str, str]:
    """Return the facts that a bug report should contain, by name."""
    return {
        "debrisflow": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        **{name: installed(name) for name in dependencies()},
        "cores": str(cores()),
        "threading layer": THREADING_LAYER,
        "cache folder": CACHE,
    }


def dependencies() -> list[str]:
    """Return the names of the packages that this package requires, without its extras."""
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
