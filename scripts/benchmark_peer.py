"""Measure the same dam break in SPlisHSPlasH, in a throw-away environment.

Its method is weakly compressible SPH with the speed of sound, the time step and the spacing of our
case, walls of particles (Akinci et al. 2012) and its own radius of influence of 2 spacings.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from debrisflow.case import tables

PACKAGE = "pysplishsplash"
EXPONENT = 7.0
DENSITY = 1000.0
VISCOSITY = 0.01
CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
SIDES = ((1, 2, 4, 3), (1, 2, 6, 5), (3, 4, 8, 7), (1, 3, 7, 5), (2, 4, 8, 6))


def _finish(command: list[str | Path], failure: str, **options: object) -> None:
    """Run a command to its end, or fail with a message and the end of what it said."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        said = (done.stdout + done.stderr).strip().splitlines()[-5:]
        lines = [f"{failure} (exit status {done.returncode}):", *said]
        raise click.ClickException("\n    ".join(lines))


@contextmanager
def environment() -> Iterator[Path]:
    """Give the Python of a virtual environment with the peer, which is removed afterwards."""
    with TemporaryDirectory(prefix="peer_") as folder:
        _finish([sys.executable, "-m", "venv", folder], "no virtual environment could be made")
        python = Path(
            folder, *(("Scripts", "python.exe") if os.name == "nt" else ("bin", "python"))
        )
        release = f"{sys.version_info.major}.{sys.version_info.minor}"
        _finish(
            [python, "-m", "pip", "install", "--only-binary", ":all:", PACKAGE],
            f"--peer needs a Python that {PACKAGE} has a wheel for, and access to a package index; "
            f"pip could not install it for Python {release} on {sys.platform}",
        )
        yield python


def tank_mesh() -> str:
    """Return a unit box without a lid as an OBJ file."""
    corners = [f"v {x} {y} {z}" for x, y, z in CORNERS]
    triangles = [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in SIDES]
    return "\n".join([*corners, *triangles, ""])


def scene_of(case: tables.Case) -> dict[str, object]:
    """Return the scene of a dam break in a three-dimensional tank.

    The first fluid particles are half a spacing from the walls, as ours; the wall particles are on
    the mesh and must be one spacing from them, so the mesh is half a spacing outside of the walls.
    The peer leaves the two outermost half spacings of a block empty, which is as much larger.
    """
    spacing, tank, (block,) = case.particles.spacing, case.geometry, case.fill
    half = 0.5 * spacing
    sound = case.scheme.sound_speed
    ends = (block.x, block.y, block.z)
    return {
        "Configuration": {
            "particleRadius": half,
            "simulationMethod": 0,
            "boundaryHandlingMethod": 0,
            "gravitation": [0.0, 0.0, -9.81],
            "cflMethod": 0,
            "timeStepSize": case.time.largest_step,
            "WCSPH": {"stiffness": DENSITY * sound**2 / EXPONENT, "exponent": EXPONENT},
        },
        "Materials": [
            {
                "id": "Fluid",
                "density0": DENSITY,
                "viscosityMethod": 1,
                "Standard viscosity": {"viscosity": VISCOSITY},
            }
        ],
        "RigidBodies": [
            {
                "geometryFile": "tank.obj",
                "translation": [-half] * 3,
                "scale": [side + spacing for side in (tank.length, tank.width, tank.height)],
                "isDynamic": False,
                "isWall": True,
                "samplingMode": 1,
            }
        ],
        "FluidBlocks": [
            {
                "start": [least - half for least, _ in ends],
                "end": [greatest + half for _, greatest in ends],
            }
        ],
    }


def measure_peer(python: Path, case: tables.Case, threads: int, steps: int) -> dict[str, object]:
    """Return the peer's seconds per step, numbers of particles and version for a case.

    Its idle threads sleep: that costs it nothing on a quiet machine and spares it a lot on a busy
    one.
    """
    with TemporaryDirectory(prefix="peer_run_") as folder:
        scene, result = Path(folder, "scene.json"), Path(folder, "result.json")
        scene.write_text(json.dumps(scene_of(case)))
        Path(folder, "tank.obj").write_text(tank_mesh())
        _finish(
            [python, Path(__file__).with_name("peer_steps.py"), scene, str(steps), result],
            f"{PACKAGE} did not finish its run",
            env=os.environ | {"OMP_NUM_THREADS": str(threads), "OMP_WAIT_POLICY": "passive"},
        )
        return json.loads(result.read_text())
