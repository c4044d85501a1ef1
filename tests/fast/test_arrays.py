"""The table of output arrays agrees with the particles, and frames have what it lists."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

from debrisflow.particles.arrays import ARRAYS, COLORED
from debrisflow.particles.record import blank
from debrisflow.results.frames import Frame
from debrisflow.results.pictures.coloring import values


@pytest.mark.parametrize("array", ARRAYS, ids=lambda array: array.name)
def test_each_array_is_one_of_the_particles(array):
    held = getattr(blank(2), array.name)
    assert held.shape == ((2,) if array.components == 1 else (2, array.components))
    assert np.can_cast(held.dtype, array.storage, "same_kind") or array.storage == "uint8"
    assert array.meaning
    assert bool(array.magnitude) == (array.components > 1 and bool(array.label))


def test_names_stand_once():
    for names in ([a.name for a in ARRAYS], [a.color_key for a in ARRAYS if a.label]):
        assert len(set(names)) == len(names)


def test_labels_carry_the_unit():
    assert COLORED["speed"].color_label == "speed (m/s)"
    assert COLORED["granular_temperature"].color_label == "granular temperature (m²/s²)"
    assert COLORED["concentration"].color_label == "sediment concentration"


@pytest.fixture
def frame():
    particles = blank(3)
    particles.velocity[:] = [[3.0, 4.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]
    particles.pressure[:] = [1.0, 2.0, 3.0]
    arrays = {array.name: getattr(particles, array.name) for array in ARRAYS}
    return Frame(0.5, particles.position, arrays)


def test_a_frame_has_each_array_as_an_attribute(frame):
    for name in frame.arrays:
        assert getattr(frame, name) is frame.arrays[name]
        assert name in dir(frame)
    with pytest.raises(AttributeError, match="hold no wall_depth, but velocity, pressure"):
        _ = frame.wall_depth
    assert np.array_equal(deepcopy(frame).pressure, frame.pressure)


def test_some_particles_of_a_frame_keep_all_arrays(frame):
    part = frame.of(np.array([True, False, True]))
    assert part.arrays.keys() == frame.arrays.keys()
    assert part.pressure.tolist() == [1.0, 3.0]
    assert part.position.shape == (2, 3)


def test_vectors_are_colored_by_their_length(frame):
    assert values(frame, "speed").tolist() == frame.speed.tolist() == [5.0, 0.0, 2.0]
    assert values(frame, "pressure").tolist() == [1.0, 2.0, 3.0]
