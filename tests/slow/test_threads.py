"""The case and the machine decide every byte of a run, whatever the number of threads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from debrisflow._jit import set_threads
from debrisflow.case import ResolvedCase, load_case
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.run.names import CHECKPOINT, CHECKPOINT_BEFORE, STATUS
from debrisflow.run.simulation import simulate
from tests.fast.test_checkpoint import identical

CASES = Path(__file__).parents[2] / "cases"
NAMES = sorted(
    path.relative_to(CASES).with_suffix("").as_posix()
    for path in (*CASES.glob("*.toml"), *CASES.glob("experiments/*.toml"))
)
THREADS = (1, 2, 3)
WALL_TIMES = {"run.log", "summary.json", STATUS, CHECKPOINT, CHECKPOINT_BEFORE}
"""Files that tell the time of day."""
# cases of so many particles that ten steps take seconds: their spacing, m
COARSER = {"check_dam3d": 0.01, "flume3d": 0.01, "runout3d": 0.01}
# cases that begin without a particle: their steps until there are some
AFTER_THE_SUPPLY = {"channelled_fan": 100}


def run_on_each(path: Path, changes: tuple[str, ...], folder: Path) -> list[Path]:
    """Run a case on one, two and three threads, and return the folders of the runs."""
    folders = [folder / str(threads) for threads in THREADS]
    try:
        for threads, run in zip(THREADS, folders, strict=True):
            assert simulate(load_case(path, changes), run, threads=threads)["threads"] == threads
    finally:
        set_threads(1)
    return folders


def differing(one: Path, other: Path) -> list[str]:
    """Return the names of the files that two runs do not have alike."""
    files = [
        {f.relative_to(run).as_posix(): f.read_bytes() for f in run.rglob("*") if f.is_file()}
        for run in (one, other)
    ]
    names = {name for found in files for name in found if Path(name).name not in WALL_TIMES}
    assert len(names) > 5
    return sorted(name for name in names if files[0].get(name) != files[1].get(name))


@pytest.mark.parametrize("name", NAMES)
def test_ten_steps_of_a_shipped_case_have_the_bytes_of_one_thread(name, tmp_path, ends):
    path = CASES / f"{name}.toml"
    spacing = (f"particles.spacing={COARSER[name]}",) if name in COARSER else ()
    step = load_case(path, spacing).time.largest_step
    steps = AFTER_THE_SUPPLY.get(name, 10)
    times = f"time.end={steps * step}", f"output.interval={5 * step}", "time.settling=0.0"
    rows = f"output.history_interval={step}", f"output.deposit_interval={2 * step}"
    alone, *others = run_on_each(path, (*spacing, *times, *rows), tmp_path)
    for other in others:
        assert differing(alone, other) == []
    assert len(ends) == len(THREADS)
    assert ends[0].particles.fluid_count > 0
    assert identical(ends[0], ends[1])
    assert identical(ends[0], ends[2])


def test_a_long_run_with_inflow_erosion_and_outflow_has_the_bytes_of_one_thread(tmp_path, ends):
    path = CASES / "flume2d.toml"
    shorter = "geometry.length=3.0", "geometry.bed_start=1.0", "geometry.bed_end=2.96"
    near = "probe.0.x=2.9", "time.end=5.0", "time.settling=0.2", "output.interval=0.5"
    alone, *others = run_on_each(path, (*shorter, *near), tmp_path)
    state = ends[0]
    assert state.entered.sum() > 100
    assert state.left.sum() > 50
    assert moved(load_case(path, (*shorter, *near)), state, by=0.2) > 20
    assert all(identical(state, end) for end in ends[1:])
    for other in others:
        assert differing(alone, other) == []


def moved(case: ResolvedCase, state: State, by: float) -> int:
    """Return how many particles of the bed have gone a distance, m, or farther, or out."""
    bed, now = initial_state(case).particles, state.particles
    start = dict(zip(bed.id[bed.fluid].tolist(), bed.position[bed.fluid, 0].tolist(), strict=True))
    end = dict(zip(now.id[now.fluid].tolist(), now.position[now.fluid, 0].tolist(), strict=True))
    return sum(end.get(one, np.inf) - x >= by for one, x in start.items())
