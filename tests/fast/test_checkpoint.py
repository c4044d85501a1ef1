"""Checkpoints: what is loaded is what was saved, to the bit."""

from dataclasses import fields

import h5py
import numpy as np
import pytest

from debrisflow.errors import OutputError
from debrisflow.particles.layers import Layers
from debrisflow.particles.maxima import Maxima, no_maxima
from debrisflow.particles.record import blank
from debrisflow.particles.state import State
from debrisflow.run import checkpoint
from debrisflow.run.checkpoint import Checkpoints, Origin

ORIGIN = Origin("debrisflow 1, kernels 0a", "zen", '{"time": {"end": 2.0}, "title": "a"}')


@pytest.fixture
def state():
    """Return a state in which no field has its default."""
    rng = np.random.default_rng(3)
    particles = blank(50)
    for value in particles.arrays().values():
        value[...] = rng.uniform(-100, 100, value.shape)
    particles.pressure[:4] = [np.nan, -0.0, np.inf, 5e-324]
    particles.fluid_count, particles.inflow_count, particles.wall_count = 20, 5, 15
    counts = [np.array([i, i + 1, 2**40]) for i in range(3)]
    maxima = Maxima(*rng.uniform(0.0, 9.0, (5, 30)), rested=rng.random(30) < 0.5)
    maxima.arrival_time[::4] = np.nan
    layers = Layers(*rng.uniform(0.0, 9.0, (6, 4, 3)))
    sediment = [rng.uniform(0.0, 9.0, 3) for _ in range(3)]
    sums = {"section": rng.uniform(-9.0, 9.0, (2, 3)), "wall": np.array([1 / 3, -0.0, 5e-324])}
    counters = *counts, *sediment, 2**41, 13, 11, -1 / 3, np.array([7]), 2**40, 0.7, 0.6, layers
    return State(particles, maxima, 0.1 + 0.2, 7, 1e-3 / 3, *counters, sums)


def identical(one, other):
    """Return whether two records hold the same bits in the same types."""
    for field in fields(one):
        if field.name == "escaped":  # only until somebody has told of them
            continue
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            same = a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        elif isinstance(a, dict):
            same = a.keys() == b.keys() and all(a[key].tobytes() == b[key].tobytes() for key in a)
        elif isinstance(a, tuple):
            pairs = zip(a, b, strict=True)
            same = all(np.asarray(x).tobytes() == np.asarray(y).tobytes() for x, y in pairs)
        elif isinstance(a, int | float):
            same = type(a) is type(b) and a == b
        else:
            same = identical(a, b)
        if not same:
            return False
    return True


def test_a_state_comes_back_bit_for_bit(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    assert identical(state, checkpoint.load(tmp_path / "c.h5").state)


def test_a_newer_checkpoint_replaces_the_older(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    state.time = 9.0
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    assert checkpoint.load(tmp_path / "c.h5").state.time == 9.0
    assert [file.name for file in tmp_path.iterdir()] == ["c.h5"]


def test_a_checkpoint_that_fails_leaves_the_older_one(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    step, state.step = state.step, object()
    with pytest.raises(TypeError):
        checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    assert checkpoint.load(tmp_path / "c.h5").state.step == step


def test_a_missing_or_damaged_checkpoint_is_told(tmp_path, state):
    file = tmp_path / "c.h5"
    with pytest.raises(OutputError, match="there is no checkpoint"):
        checkpoint.load(file)
    checkpoint.save(file, state, ORIGIN)
    file.write_bytes(file.read_bytes()[:1000])
    with pytest.raises(OutputError, match="damaged"):
        checkpoint.load(file)


@pytest.mark.parametrize("name", ["entered", "particles/grain_pressure", "maxima/depth", "sums"])
def test_a_field_that_is_missing_is_no_default(tmp_path, state, name):
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    with h5py.File(tmp_path / "c.h5", "a") as file:
        del file[name]
    with pytest.raises(OutputError, match=f"another version .* it lacks {name.split('/')[-1]};"):
        checkpoint.load(tmp_path / "c.h5")


def test_a_field_of_another_version_is_told(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state, ORIGIN)
    with h5py.File(tmp_path / "c.h5", "a") as file:
        file["crossed"] = np.zeros(3)
    with pytest.raises(OutputError, match=r"another version .* it has crossed; start"):
        checkpoint.load(tmp_path / "c.h5")


def test_a_changed_byte_is_seen(tmp_path, state):
    file = tmp_path / "c.h5"
    checkpoint.save(file, state, ORIGIN)
    with h5py.File(file, "a") as opened:
        opened["particles/density"][7] *= 1.0 + 1e-15
    with pytest.raises(OutputError, match="damaged: its contents do not have its checksum"):
        checkpoint.load(file)


@pytest.mark.parametrize("trick", ["soft", "external", "virtual", "hollow", "outside", "text"])
def test_an_array_lies_in_the_file_or_is_refused(tmp_path, state, trick):
    file, other = tmp_path / "c.h5", tmp_path / "other.h5"
    for path in (file, other):
        checkpoint.save(path, state, ORIGIN)
    with h5py.File(file, "a") as opened:
        particles = opened["particles"]
        del particles["density"]
        if trick == "soft":
            particles["density"] = h5py.SoftLink("/particles/pressure")
        elif trick == "external":
            particles["density"] = h5py.ExternalLink(other, "/particles/density")
        elif trick == "virtual":
            layout = h5py.VirtualLayout((50,), float)
            layout[:] = h5py.VirtualSource(other, "particles/density", (50,))
            particles.create_virtual_dataset("density", layout)
        elif trick == "hollow":
            particles.create_dataset("density", (10**13,), chunks=(10**4,), dtype=float)
        elif trick == "outside":
            raw = tmp_path / "raw"
            raw.write_bytes(bytes(400))
            particles.create_dataset("density", (50,), float, external=[(raw, 0, 400)])
        else:
            particles["density"] = np.full(50, "x", dtype=object)
    with pytest.raises(OutputError, match="damaged: density"):
        checkpoint.load(file)


def test_the_last_two_are_kept_and_one_stands_in_for_the_other(tmp_path, state, caplog):
    kept = Checkpoints(tmp_path)
    assert kept.load() is None
    for state.step in (40, 80, 120):
        kept.save(state, ORIGIN)
    assert kept.load().state.step == 120
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "checkpoint.h5",
        "checkpoint_before.h5",
    ]
    kept.last.write_bytes(kept.last.read_bytes()[:-3000])
    again = Checkpoints(tmp_path)
    assert again.load().state.step == 80
    assert "checkpoint.h5 is damaged" in caplog.text
    assert "goes on from" in caplog.text
    state.step = 160
    again.save(state, ORIGIN)  # the sound one is not dropped for the damaged one
    assert checkpoint.load(kept.before).state.step == 80
    assert checkpoint.load(kept.last).state.step == 160
    kept.last.unlink()  # as by a crash between two renames
    assert Checkpoints(tmp_path).load().state.step == 80
    kept.before.write_bytes(b"")
    with pytest.raises(OutputError, match=r"checkpoint_before.h5 is damaged"):
        Checkpoints(tmp_path).load()


def test_what_has_changed_is_listed_but_for_the_end():
    now = Origin("debrisflow 2, kernels 0a", "zen", '{"time": {"end": 3.0}, "title": "b"}')
    assert ORIGIN.changes(now) == [
        "the program: debrisflow 1, kernels 0a, now debrisflow 2, kernels 0a",
        "title: a, now b",
    ]


def test_a_state_of_another_case_is_refused(state):
    checkpoint.check_fits(state, state)
    other = State(blank(50), state.maxima, layers=state.layers, released=np.zeros(2, int))
    other.particles.pore_pressure = np.zeros(0)
    with pytest.raises(OutputError, match="does not fit the case: pore_pressure, released;"):
        checkpoint.check_fits(state, other)


def test_a_run_that_starts_without_particles_can_go_on():
    start, state = (State(blank(count), no_maxima(3)) for count in (0, 5))
    checkpoint.check_fits(state, start)
    state.particles.density = state.particles.density[:4]
    with pytest.raises(OutputError, match="does not fit the case: density;"):
        checkpoint.check_fits(state, start)
