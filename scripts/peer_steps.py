"""Take the steps of a scene in SPlisHSPlasH.

    python peer_steps.py SCENE STEPS RESULT

`benchmark_peer.py` runs it in an environment that has the peer but not our packages.  Writes the
seconds per step and the numbers of particles to the JSON file RESULT.  Two steps are taken before
the clock starts.
"""

from __future__ import annotations

import ctypes
import json
import sys
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from time import perf_counter

# the wheel brings part of the graphics library: importing it crashes unless the whole is loaded
with suppress(OSError):
    ctypes.CDLL("libGL.so.1", mode=ctypes.RTLD_GLOBAL)

import pysplishsplash

WARM = 2
NEVER, AT_ONCE = 1e6, 1e-9


def main(scene: Path, steps: int, result: Path) -> None:
    """Take the steps of a scene and write what they cost."""
    base = pysplishsplash.Exec.SimulatorBase()
    base.init(
        sceneFile=str(scene),
        useCache=False,
        useGui=False,
        initialPause=False,
        stopAt=NEVER,
        outputDir=str(scene.parent / "output"),
    )
    base.initSimulation()
    ends: list[float] = []

    def note_end_of_step() -> None:
        ends.append(perf_counter())
        if len(ends) == WARM + steps:
            base.setValueFloat(base.STOP_AT, AT_ONCE)

    base.setTimeStepCB(note_end_of_step)
    base.runSimulation()
    simulation = pysplishsplash.Simulation.getCurrent()
    fluid = simulation.getFluidModel(0).numActiveParticles()
    boundary = simulation.getBoundaryModel(0).numberOfParticles()
    measured = {
        "version": version("pysplishsplash"),
        "seconds_per_step": (ends[-1] - ends[WARM - 1]) / steps,
        "particles": fluid + boundary,
        "fluid": fluid,
    }
    result.write_text(json.dumps(measured))
    base.cleanup()


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
