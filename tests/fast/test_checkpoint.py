"""Checkpoints: what is loaded is what was saved, to the bit."""

from dataclasses import fields

import h5py
import numpy as np
import pytest

from debrisflow.errors import OutputError
from debrisflow.particles.layers import Layers
from debrisflow.particles.maxima import Maxima
from debrisflow.particles.record import blank
from debrisflow.particles.state import State
from debrisflow.run import checkpoint


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
    checkpoint.save(tmp_path / "c.h5", state)
    assert identical(state, checkpoint.load(tmp_path / "c.h5"))


def test_a_newer_checkpoint_replaces_the_older(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state)
    state.time = 9.0
    checkpoint.save(tmp_path / "c.h5", state)
    assert checkpoint.load(tmp_path / "c.h5").time == 9.0
    assert [file.name for file in tmp_path.iterdir()] == ["c.h5"]


def test_a_checkpoint_that_fails_leaves_the_older_one(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state)
    step, state.step = state.step, object()
    with pytest.raises(TypeError):
        checkpoint.save(tmp_path / "c.h5", state)
    assert checkpoint.load(tmp_path / "c.h5").step == step


def test_a_missing_or_damaged_checkpoint_is_told(tmp_path, state):
    file = tmp_path / "c.h5"
    with pytest.raises(OutputError, match="there is no checkpoint"):
        checkpoint.load(file)
    checkpoint.save(file, state)
    file.write_bytes(file.read_bytes()[:1000])
    with pytest.raises(OutputError, match="damaged"):
        checkpoint.load(file)


@pytest.mark.parametrize("name", ["entered", "particles/grain_pressure", "maxima/depth", "sums"])
def test_a_field_that_is_missing_is_no_default(tmp_path, state, name):
    checkpoint.save(tmp_path / "c.h5", state)
    with h5py.File(tmp_path / "c.h5", "a") as file:
        del file[name]
    with pytest.raises(OutputError, match=f"another version .* it lacks {name.split('/')[-1]};"):
        checkpoint.load(tmp_path / "c.h5")


def test_a_field_of_another_version_is_told(tmp_path, state):
    checkpoint.save(tmp_path / "c.h5", state)
    with h5py.File(tmp_path / "c.h5", "a") as file:
        file["crossed"] = np.zeros(3)
    with pytest.raises(OutputError, match=r"another version .* it has crossed; start"):
        checkpoint.load(tmp_path / "c.h5")
