"""Kernels return no arrays: they count no references, and the caller would free it.

What a kernel returns is known once it is compiled, and loops that come out of the cache compile
none of theirs; so a process with an empty cache takes a step in two and in three dimensions.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from numba import types
from numba.core.dispatcher import Dispatcher

from debrisflow.validation.marching import advance
from tests.building import bed_case, started, tank3d_case

ROOT = Path(__file__).parents[2]
FEWEST = 100  # parts of what kernels return, so that there is something to look at


def parts_of(kind):
    """Return a type, or the types that a tuple or a record is made of."""
    if isinstance(kind, types.BaseTuple):
        return [part for member in kind for part in parts_of(member)]
    return [kind]


def returned():
    """Return the types of all parts of what the kernels of this process return, by the kernel."""
    kernels = {
        value
        for name, module in sys.modules.items()
        if name.startswith("debrisflow.")
        for value in vars(module).values()
        if isinstance(value, Dispatcher) and value.targetoptions.get("_nrt") is False
    }
    return [
        (kernel.py_func.__name__, part)
        for kernel in kernels
        for compiled in kernel.overloads.values()
        for part in parts_of(compiled.signature.return_type)
    ]


def main():
    """Take steps, and print how many parts there are and which kernels return an array."""
    for case in (bed_case(), tank3d_case()):
        advance(*started(case), steps=1)
    found = returned()
    print(len(found), *(name for name, part in found if isinstance(part, types.Array)))


def test_no_kernel_returns_an_array(tmp_path):
    command = [sys.executable, "-m", __name__]
    empty = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=ROOT, env=empty, capture_output=True, text=True, check=True)
    count, *arrays = done.stdout.split()
    assert int(count) > FEWEST
    assert arrays == []


if __name__ == "__main__":
    main()
