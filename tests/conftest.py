"""Case files, and ways to end a run, that several tests start from."""

import os
import signal
import tempfile
from pathlib import Path

import pytest

# Before Numba is imported: some tests compare the bits of two and three threads with those of one,
# which one core can run too.
if int(os.environ.get("NUMBA_NUM_THREADS", os.cpu_count() or 1)) < 3:
    os.environ["NUMBA_NUM_THREADS"] = "3"

# What runs of the tests measure is no forecast for anybody's own runs.
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="debrisflow-tests-")

RUNGS = ("slow", "validation")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by the folder that they stand in; what stands in none of these is fast."""
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            folder = item.path.relative_to(here).parts[0]
            if folder in RUNGS:
                item.add_marker(folder)


TANK = """
title = "a column of water"
particles = { spacing = 0.01 }
geometry = { type = "tank", length = 0.4, height = 0.3 }
time = { end = 1.0 }
output = { interval = 0.1 }

[[fill]]
type = "block"
x = [0, 0.2]
y = [0.0, 0.1]
material = "water"
"""

CHANNEL = """
title = "a flume with a bed"
particles = { spacing = 0.02 }
gravity = { slope = 15.0 }
time = { end = 1.0 }
output = { interval = 0.1 }

[geometry]
type = "channel"
length = 4.0
height = 0.4
bed_start = 1.0
bed_thickness = 0.1

[[fill]]
type = "bed"

[inflow]
depth = 0.04
discharge = 0.02
"""


@pytest.fixture
def tank(tmp_path: Path) -> Path:
    path = tmp_path / "tank.toml"
    path.write_text(TANK)
    return path


@pytest.fixture
def channel(tmp_path: Path) -> Path:
    path = tmp_path / "channel.toml"
    path.write_text(CHANNEL)
    return path


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> list:
    """Return a list that takes the last state of every run."""
    from debrisflow.run.folder import RunFolder

    kept, write = [], RunFolder.write_maxima

    def write_and_keep(folder, state):
        if not (kept and kept[-1] is state):  # written with every frame
            kept.append(state)
        write(folder, state)

    monkeypatch.setattr(RunFolder, "write_maxima", write_and_keep)
    return kept


@pytest.fixture
def interrupt(monkeypatch: pytest.MonkeyPatch):
    """Return a function: from now on runs are interrupted at step 30, as by Ctrl-C."""
    from debrisflow.run.progress import Progress

    count = Progress.count

    def count_and_interrupt(progress, state):
        count(progress, state)
        if state.step == 30:
            signal.raise_signal(signal.SIGINT)

    return lambda: monkeypatch.setattr(Progress, "count", count_and_interrupt)
