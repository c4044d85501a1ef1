"""Numba's options, cache folder and threads, decided once.

``kernel`` compiles a function, ``loop`` one with parallel ``prange`` loops.  The cache folder is
named after a digest of the package's sources, because Numba keeps a caller's old machine code when
only a function that it calls, in another file, has changed.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import sys
import tempfile
from pathlib import Path

import numba


def _cache_directory() -> Path:
    """Return a writable folder whose name changes with the package's sources."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    for base in (Path(home), Path(tempfile.gettempdir())):
        folder = base / "debrisflow" / f"kernels-{digest.hexdigest()[:16]}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="debrisflow-kernels-"))


def _threading_layer() -> str:
    """Return "tbb" where its library can be loaded, else the layer that comes with Numba.

    The wheel puts the library where the loader does not look, so it is loaded here by its path.
    A parallel region costs 1 to 2 microseconds with TBB and 100 with Numba's own layer.
    """
    for name in ("lib/libtbb.so.12", "lib/libtbb.12.dylib", "Library/bin/tbb12.dll"):
        library = Path(sys.prefix) / name
        if library.exists():
            try:
                ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
            except OSError:
                continue
            return "tbb"
    return "workqueue"


CACHE_DIRECTORY = _cache_directory()
THREADING_LAYER = _threading_layer()
numba.config.CACHE_DIR = str(CACHE_DIRECTORY)
numba.config.THREADING_LAYER = THREADING_LAYER

# Sums may be reassociated, the same way on every run; NaN stays detectable by comparisons, not by
# np.isfinite, which these flags make true.
_MATH = {"reassoc", "contract", "arcp", "nsz"}

OPTIONS = {"error_model": "numpy", "fastmath": _MATH}
"""Of Numba, for whatever is compiled."""

kernel = numba.njit(cache=True, **OPTIONS)
loop = numba.njit(cache=True, parallel=True, **OPTIONS)


def set_threads(count: int) -> int:
    """Use ``count`` threads, or as many as there are, and return how many are used."""
    count = max(1, min(count, numba.config.NUMBA_NUM_THREADS))
    numba.set_num_threads(count)
    return count


def cores() -> int:
    """Return the number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS and Windows
        return os.cpu_count() or 1
