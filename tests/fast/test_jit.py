"""The cache of machine code: what its name depends on, where it is, and what compiling takes."""

from __future__ import annotations

import ast
import gc
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from debrisflow import _jit
from debrisflow._jit import COMPILATIONS, PACKAGE, kernel_sources
from debrisflow.validation.marching import advance
from tests.building import bed_case, started, tank3d_case

DECORATORS = {"allocating_kernel", "kernel", "loop"}
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.py")}
ONE_KERNEL = """
from debrisflow import _jit
from debrisflow.physics.kinetic_theory import radial_distribution
radial_distribution(0.5, 0.55)
print(_jit.COMPILATIONS.seconds > 0.0, _jit.CACHE_DIRECTORIES[-1])
"""
# the superuser may write anywhere, so that a folder is made to refuse
READ_ONLY = """
import tempfile
from pathlib import Path
temporary_file = tempfile.TemporaryFile

def refused(*args, dir=None, **options):
    if str(dir).startswith({folder!r}):
        raise PermissionError
    return temporary_file(*args, dir=dir, **options)

tempfile.TemporaryFile = refused
"""


def file_of(module: str) -> Path | None:
    """Return the file of a module of the package."""
    place = PACKAGE.joinpath(*module.split(".")[1:])
    return next(filter(Path.is_file, (place.with_suffix(".py"), place / "__init__.py")), None)


def imports_of(path: Path) -> dict[str, set[str]]:
    """Return what a file imports from the package: names by module, as the interpreter reads it."""
    found: dict[str, set[str]] = {}
    for node in ast.walk(TREES[path]):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("debrisflow"):
            found.setdefault(node.module, set()).update(name.name for name in node.names)
        elif isinstance(node, ast.Import):
            found |= {n.name: set() for n in node.names if n.name.startswith("debrisflow")}
    return found


def test_every_file_with_a_kernel_is_among_the_sources():
    decorated = {
        path
        for path, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and any(isinstance(d, ast.Name) and d.id in DECORATORS for d in node.decorator_list)
    }
    assert len(decorated) > 15
    assert decorated <= set(kernel_sources())


def test_the_compiler_is_reached_by_the_decorators_alone():
    # by another way a kernel would be in no digest
    for path, tree in TREES.items():
        # dispatch.py picks a kernel by the type of a record
        if path.name in ("_jit.py", "_kernel_cache.py", "dispatch.py"):
            continue
        names = {name for module in imports_of(path).values() for name in module}
        assert "_jit" not in names, path
        roots = [name.name for n in ast.walk(tree) if isinstance(n, ast.Import) for name in n.names]
        modules = [n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
        imported = {str(name).split(".")[0] for name in (*roots, *modules)}
        from_numba = {
            name.name
            for n in ast.walk(tree)
            if isinstance(n, ast.ImportFrom) and n.module == "numba"
            for name in n.names
        }
        assert "numba" not in imported or from_numba == {"prange"}, path


def test_no_import_is_relative():
    # the search for what a source imports reads whole names only
    nodes = [node for tree in TREES.values() for node in ast.walk(tree)]
    assert all(node.level == 0 for node in nodes if isinstance(node, ast.ImportFrom))


def test_the_sources_hold_all_that_they_import():
    sources = set(kernel_sources())
    for path in sources - {PACKAGE / "_jit.py"}:
        for module, names in imports_of(path).items():
            for name in (module, *(f"{module}.{name}" for name in names)):
                assert file_of(name) is None or file_of(name) in sources, (path, name)


def test_the_file_that_picks_kernels_by_record_is_in_the_digest():
    assert PACKAGE / "dispatch.py" in kernel_sources()


def test_what_a_user_or_a_writer_changes_compiles_nothing():
    parts = {path.relative_to(PACKAGE).parts[0] for path in kernel_sources()}
    assert parts == {
        "__init__.py",
        "_jit.py",
        "_kernel_cache.py",
        "dispatch.py",
        "errors.py",
        "neighbors",
        "physics",
        "schemes",
    }


def test_records_that_kernels_take_are_defined_among_the_sources():
    # Numba finds the machine code of a record by its class, and its fields by their places
    advance(*started(bed_case()), steps=1)
    advance(*started(tank3d_case(collision_stress={"enabled": True})), steps=1)
    kernels = [item for item in gc.get_objects() if issubclass(type(item), Dispatcher)]
    ours = [k for k in kernels if k.py_func.__module__.startswith("debrisflow")]
    modules = {
        argument.instance_class.__module__
        for kernel in ours
        for signature in kernel.signatures
        for argument in signature
        if isinstance(argument, numba.types.NamedTuple | numba.types.NamedUniTuple)
    }
    assert len(modules) > 5
    assert {file_of(module) for module in modules} <= set(kernel_sources())


def test_no_kernel_is_compiled_for_signed_and_unsigned_indices():
    advance(*started(bed_case()), steps=1)
    kernels = [item for item in gc.get_objects() if issubclass(type(item), Dispatcher)]
    twice = [
        kernel.py_func.__qualname__
        for kernel in kernels
        if kernel.py_func.__module__.startswith("debrisflow")
        and {numba.types.int64, numba.types.uint64} <= {s[0] for s in kernel.signatures if s}
    ]
    assert twice == []


def run(script: str, tmp_path: Path) -> tuple[str, Path]:
    """Return what a fresh process tells of one kernel: whether it was compiled, and where it is."""
    spare = tmp_path / "spare"
    spare.mkdir(exist_ok=True)
    done = subprocess.run(
        [sys.executable, "-c", script + ONE_KERNEL],
        env=os.environ | {"XDG_CACHE_HOME": str(tmp_path / "home"), "TMPDIR": str(spare)},
        capture_output=True,
        text=True,
        check=True,
    )
    compiled, folder = done.stdout.split(maxsplit=1)
    return compiled, Path(folder.strip())


def test_a_prepared_folder_that_cannot_be_written_is_used(tmp_path):
    home = tmp_path / "home"
    compiled, folder = run("", tmp_path)
    assert compiled == "True"
    assert home in folder.parents
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    compiled, spare = run(READ_ONLY.format(folder=str(home)), tmp_path)
    assert compiled == "False"
    assert tmp_path / "spare" in spare.parents
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before


def test_without_a_prepared_folder_kernels_are_compiled_elsewhere(tmp_path):
    compiled, spare = run(READ_ONLY.format(folder=str(tmp_path / "home")), tmp_path)
    assert compiled == "True"
    assert tmp_path / "spare" in spare.parents


def test_the_seconds_of_compiling_are_those_of_the_outermost_function(monkeypatch):
    times = iter([1.0, 1.0, 2.0, 5.0])
    monkeypatch.setattr(_jit, "perf_counter", lambda: next(times))
    clock, seen = _jit.Compilations(), []
    clock.watcher = seen.append
    clock.on_start(None)
    clock.on_start(None)
    clock.on_end(None)
    clock.on_end(None)
    assert clock.seconds == pytest.approx(4.0)
    assert seen == [0.0, 1.0]


def test_compiling_is_noticed():
    @numba.njit
    def double(x):
        return 2.0 * x

    before = COMPILATIONS.seconds
    double(1.0)
    once = COMPILATIONS.seconds
    double(2.0)
    assert before < once == COMPILATIONS.seconds


def test_no_loop_lets_addresses_choose_how_it_rounds():
    @numba.njit(**_jit.OPTIONS)
    def multiply(one, other, product):
        for i in range(product.size):
            product[i] = one[i] * other[i] + 1.0

    multiply(np.ones(9), np.ones(9), np.ones(9))
    assert "vector.memcheck" not in "".join(multiply.inspect_llvm().values())
