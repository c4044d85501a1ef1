"""Install the project into fresh environments, and try it: each Python, lowest and newest packages.

python scripts/install_matrix.py [--python 3.11] [--resolution lowest] [--brief] [--table]

For each Python that is found (``python3.11`` and so on, on the path or among those of pyenv) and
each resolution, a wheel is built of the files of the project and installed with the lowest, or the
newest, packages that ``pyproject.toml`` allows and that have wheels for this Python.  There, with
an empty kernel cache and from a copy of the tests that holds no source of the package:

- ``debrisflow --version``;
- ``debrisflow run``, twice, of a small dam break in two dimensions and of one in three; the second
  run must compile nothing and have the same bytes as the first;
- ``debrisflow validate`` of an experiment, in a folder without the project;
- the fast tests, or with ``--brief`` those of readers, tables, pictures and maps, by which packages
  are used most and which compile little.

With the newest packages warnings are errors.  With the lowest they are not: old packages warn of
their own use of newer ones.  ``--table`` writes the table of results into ``docs/install.md``.
Needs ``uv``, which is installed with the extra ``test``.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import click

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "install.md"
EXPERIMENT = "martin_moyce"  # its case and its table are in the wheel
BEGIN, END = "<!-- matrix:begin -->\n", "<!-- matrix:end -->\n"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
RESOLUTIONS = {"lowest": "lowest-direct", "newest": "highest"}
EXTRAS = ("terrain", "xarray")
SHOWN = ("numpy", "numba", "scipy", "pydantic", "h5py", "pyvista", "matplotlib", "shapely")
SMALL = {
    "dam_break2d": ("particles.spacing=0.0057", "time.end=0.02", "output.interval=0.01"),
    "dam_break3d": ("particles.spacing=0.2", "time.end=0.05", "output.interval=0.05"),
}
BRIEF = (
    *("api", "arrays", "bad_cases", "case", "cli", "data_table", "deposition", "kernel_cache"),
    *("maps", "measures", "output", "plots", "point_probe", "rasters", "run_reader", "surface"),
    *("terrain_case", "terrain_check", "vectors"),
)
# of the sources, which are not beside the tests here
ABOUT_SOURCES = ("tests/fast/test_notation.py", "tests/fast/test_jit.py")


class FailedError(Exception):
    """A command that did not do what it should; its end is the message."""


class Tried(NamedTuple):
    """One environment.

    Attributes
    ----------
    python, resolution : str
    versions : mapping of str to str
        Of the packages shown, by name.
    failure : str
        Empty if all went well.
    tests : str
        The last line of the tests.
    seconds : float, s
        Wall time of all.
    """

    python: str
    resolution: str
    versions: Mapping[str, str]
    failure: str
    tests: str
    seconds: float


def interpreter(version: str) -> Path | None:
    """Return the Python of a version, such as 3.11, if there is one."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    found = sorted(pyenv.glob(f"{version}.*/bin/python"))
    on_path = shutil.which(f"python{version}")
    for path in (*reversed(found), *([Path(on_path)] if on_path else [])):
        if succeeds(path):
            return path
    return None


def succeeds(path: Path) -> bool:
    """Return whether a Python starts: a shim of pyenv may stand for a version that is not set."""
    return subprocess.run([path, "-c", ""], capture_output=True, check=False).returncode == 0


def call(*words: str | Path, cwd: Path, **variables: str) -> str:
    """Return what a command prints.

    Raises
    ------
    FailedError
        If it fails.
    """
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        last = "\n".join(done.stdout.splitlines()[-40:])
        raise FailedError(f"{' '.join(map(str, words[:6]))}: exit {done.returncode}\n{last}")
    return done.stdout


def tree(folder: Path, strict: bool) -> Path:
    """Copy what is tested with, without the package, and return the copy."""
    names = call("git", "ls-files", cwd=ROOT).splitlines()
    for name in (name for name in names if not name.startswith("debrisflow/")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    if not strict:
        options = folder / "pyproject.toml"
        lenient = re.sub(r"(?m)^filterwarnings = .*$", "filterwarnings = []", options.read_text())
        options.write_text(lenient)
    return folder


def environment(folder: Path, python: Path, version: str, resolution: str) -> Path:
    """Make an environment with the wheel of the project, and return its folder of programs."""
    wanted = folder / "requirements.txt"
    extras = [word for extra in EXTRAS for word in ("--extra", extra)]
    binary = ("--only-binary", ":all:")
    how = ("--python-version", version, "--resolution", RESOLUTIONS[resolution], "-q")
    pyproject = ROOT / "pyproject.toml"
    call("uv", "pip", "compile", *binary, *how, *extras, pyproject, "-o", wanted, cwd=folder)
    call("uv", "venv", "-q", "--python", python, "env", cwd=folder)
    call("uv", "build", "-q", "--wheel", ROOT, "-o", folder / "wheel", cwd=folder)
    (wheel,) = (folder / "wheel").glob("*.whl")
    programs = folder / "env" / ("Scripts" if sys.platform == "win32" else "bin")
    into = ("uv", "pip", "install", "-q", "--python", programs / "python")
    call(*into, *binary, "--no-deps", "-r", wanted, cwd=folder)
    call(*into, "--no-deps", wheel, cwd=folder)
    call(*into, *binary, "pytest", "pytest-xdist", "-c", wanted, cwd=folder)
    return programs


def smoke(programs: Path, cwd: Path, cache: Path) -> None:
    """Run small cases twice, and compare; run an experiment.

    Raises
    ------
    FailedError
        If a command fails, a second run compiles, its bytes differ, or an experiment is not
        reproduced.
    """
    program = programs / "debrisflow"
    call(program, "--version", cwd=cwd, XDG_CACHE_HOME=str(cache))
    for name, changes in SMALL.items():
        sets = [word for change in changes for word in ("--set", change)]
        before, files = None, []
        for run in (f"{name}-1", f"{name}-2"):
            case = f"cases/{name}.toml"
            call(program, "run", case, "-o", run, *sets, cwd=cwd, XDG_CACHE_HOME=str(cache))
            kernels = sorted(cache.rglob("*.nbc"))
            files.append([f.read_bytes() for f in sorted((cwd / run).glob("vtu/*.vtu"))])
            if before is not None and kernels != before:
                raise FailedError(f"the second run of {name} compiled {len(kernels) - len(before)}")
            before = kernels
        if not files[0] or files[0] != files[1]:
            raise FailedError(f"the second run of {name} has other bytes")
    outside = cwd.parent  # the copy of the tree has cases
    call(program, "validate", EXPERIMENT, "--quick", cwd=outside, XDG_CACHE_HOME=str(cache))


def tested(programs: Path, cwd: Path, cache: Path, brief: bool) -> str:
    """Run the tests and return their last line.

    Raises
    ------
    FailedError
        If one fails.
    """
    files = [f"tests/fast/test_{name}.py" for name in BRIEF] if brief else ["tests/fast"]
    left = [word for name in ABOUT_SOURCES for word in ("--ignore", name)]
    many = ("-n", "2", "--dist", "loadfile", "-q", "-p", "no:cacheprovider")
    words = (programs / "python", "-P", "-m", "pytest", *many, *left, *files)
    return call(*words, cwd=cwd, XDG_CACHE_HOME=str(cache)).splitlines()[-1].strip("= ")


def versions(programs: Path, cwd: Path) -> dict[str, str]:
    """Return the versions of the packages shown, by name."""
    lines = call("uv", "pip", "freeze", "--python", programs / "python", cwd=cwd).splitlines()
    found = dict(line.lower().split("==") for line in lines if "==" in line)
    return {name: found[name] for name in SHOWN}


def tried(python: Path, version: str, resolution: str, brief: bool) -> Tried:
    """Install and try the project in one environment."""
    start, found, tests, failure = perf_counter(), {}, "", ""
    with tempfile.TemporaryDirectory(prefix="debrisflow-install-") as name:
        folder = Path(name)
        try:
            programs = environment(folder, python, version, resolution)
            found = versions(programs, folder)
            cwd = tree(folder / "tree", strict=resolution == "newest")
            smoke(programs, cwd, folder / "cache")
            tests = tested(programs, cwd, folder / "cache", brief)
        except FailedError as error:
            failure = str(error)
    return Tried(version, resolution, found, failure, tests, perf_counter() - start)


def table(results: list[Tried]) -> str:
    """Return the results as a table of Markdown."""
    head = ["Python", "packages", *SHOWN, "result"]
    rows = [
        [
            one.python,
            one.resolution,
            *(one.versions.get(name, "") for name in SHOWN),
            "failed" if one.failure else re.sub(r"(passed).*", r"\1", one.tests),
        ]
        for one in results
    ]
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


@click.command(help=__doc__)
@click.option("--python", "only", multiple=True, type=click.Choice(PYTHONS))
@click.option("--resolution", multiple=True, type=click.Choice(list(RESOLUTIONS)))
@click.option("--brief", is_flag=True, help="A part of the fast tests alone.")
@click.option("--table", "write", is_flag=True, help="Write the table into docs/install.md.")
def main(only: tuple[str, ...], resolution: tuple[str, ...], brief: bool, write: bool) -> None:
    """Try all environments asked for, print the table, and exit with 1 if one failed."""
    results = []
    for version in only or PYTHONS:
        python = interpreter(version)
        if python is None:
            click.echo(f"Python {version}: not found, not run")
            continue
        for how in resolution or RESOLUTIONS:
            one = tried(python, version, how, brief)
            results.append(one)
            said = one.failure or one.tests
            click.echo(f"Python {version}, {how} packages, {one.seconds:.0f} s: {said}")
    click.echo(table(results))
    if write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        after = rest.split(END)[1]
        PAGE.write_text(f"{before}{BEGIN}\n{table(results)}\n{END}{after}", encoding="utf-8")
    if not results or any(one.failure for one in results):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
