"""Particle simulation (MPS) of debris flows from TOML case files.

From Python::

    from debrisflow import load_case, open_run, simulate

    case = load_case("cases/flume2d.toml", ["particles.spacing=0.01"])
    simulate(case, "runs/fine")

    run = open_run("runs/fine")
    front = run.history["time"], run.history["front_all"]
    last = run.frame()
    water = last.position[last.kind == 0]
    moving = {frame.time: frame.speed.max() for frame in run.frames()}
"""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version

__all__ = ["Sweep", "__version__", "build_case", "load_case", "open_run", "simulate"]
# imported when they are asked for, so that the command line answers at once
_WHERE = {
    "Sweep": "debrisflow.study.sweep",
    "build_case": "debrisflow.case",
    "load_case": "debrisflow.case",
    "open_run": "debrisflow.results",
    "simulate": "debrisflow.run.simulation",
}

try:
    __version__ = version("debrisflow")
except PackageNotFoundError:  # a source tree that was never installed
    __version__ = "0+unknown"


def __getattr__(name: str) -> object:
    """Return what the package offers to Python."""
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module {__name__} has no attribute {name}")
