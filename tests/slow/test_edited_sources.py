"""No source that is edited leaves its old machine code in use, wherever kernels reach it from."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from debrisflow._jit import PACKAGE

ANSWERS = """
import sys
from typing import NamedTuple
from debrisflow._jit import COMPILATIONS, kernel
from debrisflow.neighbors.pairs import weight
from debrisflow.physics.rheology import harmonic_mean, ramp, yield_strength
from debrisflow.physics.rheology.bingham import Bingham

class Near(NamedTuple):
    effective_radius: float

LAW = Bingham(
    yield_stress=7.0, ramp_start=0.2, ramp_end=0.6, smallest_shear_rate=1.0, largest_viscosity=9.0
)

@kernel
def answers(law, near):
    strength = yield_strength(1.0, 0.4, 1.0, law)
    return strength, ramp(0.4, law), harmonic_mean(1.0, 3.0), weight(1.0, near)

radius = {"3": 3, "3.0": 3.0}[sys.argv[1]]
print(COMPILATIONS.seconds > 0.0, *(round(x, 6) for x in answers(LAW, Near(radius))))
print(COMPILATIONS.seconds > 0.0)
"""
# file, what is there, what takes its place, and what is answered from then on
EDITS = (
    ("", "", "", "7.0 0.5 1.5 2.0"),
    # a helper in another file
    ("neighbors/pairs.py", "* inverse - 1.0", "* inverse - 2.0", "7.0 0.5 1.5 1.0"),
    # a formula of physics
    ("physics/rheology/__init__.py", "return 2.0 * a * b", "return 4.0 * a * b", "7.0 0.5 3.0 1.0"),
    # the usual formula of all records
    ("physics/rheology/__init__.py", "(risen, 0.0), 1.0", "(risen, 0.0), 0.25", "7.0 0.25 3.0 1.0"),
    # the formula of one record, which is found by its type
    ("physics/rheology/bingham.py", "return law", "return 3.0 * law", "21.0 0.25 3.0 1.0"),
    # the order of the fields of a record, which machine code knows by their places
    (
        "physics/rheology/bingham.py",
        "    yield_stress: float\n    ramp_start: float\n",
        "    ramp_start: float\n    yield_stress: float\n",
        "21.0 0.25 3.0 1.0",
    ),
    # the choice by record: from here on the usual formula always
    (
        "dispatch.py",
        "getattr(sys.modules[record.__module__], name, fallback)",
        "fallback",
        "0.0 0.25 3.0 1.0",
    ),
)


def copied(folder: Path) -> Path:
    """Copy the package into a folder, with the script beside it, and return the copy."""
    (folder / "answers.py").write_text(ANSWERS)
    ignored = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(PACKAGE, folder / "debrisflow", ignore=ignored))


def start(folder: Path, radius: str = "3.0") -> subprocess.Popen[str]:
    """Start the script with the package in a folder and the cache beside it."""
    return subprocess.Popen(
        [sys.executable, "-c", "import answers", radius],
        env=os.environ | {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")},
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )


def told(process: subprocess.Popen[str]) -> list[str]:
    """Return the lines that a process prints, when it has ended well."""
    lines = process.communicate()[0].splitlines()
    assert process.returncode == 0
    return lines


def test_an_edited_source_never_serves_old_machine_code(tmp_path):
    package = copied(tmp_path)
    for name, old, new, expected in EDITS:
        if name:
            source = (package / name).read_text()
            assert old in source
            (package / name).write_text(source.replace(old, new))
        assert told(start(tmp_path)) == [f"False {expected}", "True"]
    assert len(list((tmp_path / "cache" / "debrisflow").iterdir())) == len(EDITS)


def test_processes_that_compile_at_once_leave_a_sound_cache(tmp_path):
    copied(tmp_path)
    running = [start(tmp_path, radius) for radius in ("3.0", "3", "3.0", "3")]
    assert {told(one)[0] for one in running} == {"False 7.0 0.5 1.5 2.0"}
    for radius in ("3.0", "3"):
        assert told(start(tmp_path, radius)) == ["False 7.0 0.5 1.5 2.0", "False"]
