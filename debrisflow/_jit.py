"""Numba's options, cache folder and threads, decided once.

``loop`` compiles a function with parallel ``prange`` loops, ``kernel`` one that becomes part of
such a loop, and ``allocating_kernel`` one of these that makes arrays.  The cache folder is named
after a digest of the sources that machine code depends on, because a caller's machine code is old
too when only a function that it calls, in another file, has changed.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from time import perf_counter
from typing import Any

import llvmlite
import numba
import numpy
from llvmlite.binding import get_host_cpu_name, set_option
from numba.core import event
from numba.core.codegen import JITCodeLibrary

from debrisflow._kernel_cache import KernelCache, places

PACKAGE = Path(__file__).parent
_IMPORTS = re.compile(
    r"^[ \t]*from[ \t]+(debrisflow[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)"
    r"|^[ \t]*import[ \t]+(debrisflow[\w.]*)",
    re.MULTILINE,
)


def kernel_sources() -> list[Path]:
    """Return the files whose change can alter machine code, in the order of their paths.

    Machine code comes from the functions that the three decorators compile, and these can
    refer only to what their own file defines or imports.  So the files are those that import one
    of them, and all that they import from the package, directly or not.
    """
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found: set[Path] = set()
    waiting = [path for path, text in texts.items() if _defines_kernels(text)]
    waiting.append(Path(__file__))
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(texts[path])
    return sorted(found)


def _defines_kernels(text: str) -> bool:
    return any(
        source == __name__ and re.search(r"\b(allocating_kernel|kernel|loop)\b", names)
        for source, names, _ in _IMPORTS.findall(text)
    )


def _imported(text: str) -> Iterable[Path]:
    """Yield the files of the package that a source imports, with the packages that hold them."""
    for source, names, module in _IMPORTS.findall(text):
        dotted = [source, *(f"{source}.{name}" for name in re.findall(r"\w+", names)), module]
        for parts in (name.split(".")[1:] for name in dotted if name):
            for depth in range(len(parts) + 1):
                yield from _files_of(PACKAGE.joinpath(*parts[:depth]))


def _files_of(module: Path) -> Iterable[Path]:
    return filter(Path.is_file, (module / "__init__.py", module.with_suffix(".py")))


def _digest_of_kernels() -> str:
    """Return what changes with the sources of kernels and with the packages that compile them."""
    digest = hashlib.sha256()
    for package in (numba, llvmlite, numpy):
        digest.update(f"{package.__name__} {package.__version__}".encode())
    for source in kernel_sources():
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


class Compilations(event.Listener):
    """Counts the wall time in which kernels are compiled; reading them from the cache is not.

    Attributes
    ----------
    seconds : float
        Of all compilations that have ended.
    watcher : callable or None
        Called with the seconds so far whenever the compilation of a function begins.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.watcher: Callable[[float], None] | None = None
        self._start, self._depth = 0.0, 0

    def on_start(self, event: Any) -> None:
        """Note the start of a compilation, which may be inside that of a caller."""
        if self._depth == 0:
            self._start = perf_counter()
        self._depth += 1
        if self.watcher is not None:
            self.watcher(self.seconds + perf_counter() - self._start)

    def on_end(self, event: Any) -> None:
        """Add the time of a compilation that is not inside another."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += perf_counter() - self._start


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


KERNELS = _digest_of_kernels()
PROCESSOR = get_host_cpu_name()
CACHE_DIRECTORIES = places(f"kernels-{KERNELS}")
"""Kernels are read from all, and written into the last; without any each process compiles."""
THREADING_LAYER = _threading_layer()
numba.config.THREADING_LAYER = THREADING_LAYER
COMPILATIONS = Compilations()
event.register("numba:compile", COMPILATIONS)

# A loop that writes an array while it reads others is compiled twice, for arrays that may overlap
# and for others, which round differently; a look at the addresses, which are never the same twice,
# decides.  So loops that need that look are not vectorized, and the bits are the same on every run.
set_option("debrisflow", "-vectorize-memory-check-threshold=0")


def _with_own_bodies(optimize: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return the step that optimizes a library of machine code, whose loops are then its own.

    Numba compiles the body of a parallel loop by itself, and again within the function that it
    belongs to, where it may round differently.  Both have one name, and the process that compiles
    runs the first, those that read the cache the second: a run would not have the bits of the same
    run resumed.  If nothing outside refers to the second, its function runs it always.
    """

    def optimized(library: Any) -> None:
        if not library.name.startswith(BODIES):
            for function in library._final_module.functions:
                if BODY in function.name and not function.is_declaration:
                    function.linkage = "internal"
        optimize(library)

    return optimized


# names that Numba gives to the body of a loop, and to the libraries that hold it alone
BODY = "gufunc"
BODIES = ("__numba_parfor_gufunc", "<numba.np.ufunc.wrappers", "parallelgufuncwrapper")
JITCodeLibrary._optimize_final_module = _with_own_bodies(JITCodeLibrary._optimize_final_module)

# Sums may be reassociated, the same way on every run; NaN stays detectable by comparisons, not by
# np.isfinite, which these flags make true.
_MATH = {"reassoc", "contract", "arcp", "nsz"}

OPTIONS = {"error_model": "numpy", "fastmath": _MATH}
"""Of Numba, for whatever is compiled."""

KERNEL_OPTIONS = OPTIONS | {"forceinline": True, "_nrt": False}
"""Of kernels.

Their records hold tens of arrays.  A call copies all of them and counts a reference to each, up and
down, atomically: for a particle near a wall that took three times as long as the sums themselves.
So kernels become part of the loop that calls them, and count nothing: their arrays are those of
that loop, which outlive them.  Such a kernel makes no array, which the compiler refuses, and
returns none, which it would not notice: the caller would free it."""


def _kept(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function for each signature, once for all processes."""
    compile_ = numba.njit(**options)

    def decorate(function: Callable[..., Any]) -> Any:
        compiled: Any = compile_(function)
        if not numba.config.DISABLE_JIT:
            compiled._cache = KernelCache(function, CACHE_DIRECTORIES)
        return compiled

    return decorate


kernel = _kept(**KERNEL_OPTIONS)
allocating_kernel = _kept(forceinline=True, **OPTIONS)
"""Compiles a kernel that makes arrays, or that Python code calls with arrays for arrays.

What a kernel calls is compiled as the kernel is, so that it calls none of these with arrays."""
loop = _kept(parallel=True, **OPTIONS)


def set_threads(count: int) -> int:
    """Use ``count`` threads, or as many as there are, and return how many are used."""
    count = max(1, min(count, numba.config.NUMBA_NUM_THREADS))
    numba.set_num_threads(count)
    return count


def threads() -> int:
    """Return how many threads are used."""
    return int(numba.get_num_threads())


def cores() -> int:
    """Return the number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS and Windows
        return os.cpu_count() or 1
