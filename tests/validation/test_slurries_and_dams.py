"""Slurries that yield, and dams, in three dimensions: against closed forms and budgets.

The coarse runs only; finer ones and their figures: scripts/validate.py film3d deposit3d dams.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation import dams3d, deposit3d, film3d

COARSE = {"particles": {"spacing": 0.01}}


@pytest.mark.parametrize(
    "slurry", [film3d.bingham(0.25), film3d.herschel_bulkley(0.25)], ids=["bingham", "herschel"]
)
def test_a_film_of_slurry_has_the_profile_of_the_closed_form(slurry):
    assert film3d.run(slurry, end=2.0 if slurry["mixture"]["viscosity"] else 2.5).rms < 0.03


def test_a_film_with_a_thick_plug_shears_at_its_bed_and_moves_as_one_above():
    """Five rows yield, of which the upper ones shear too fast: the plug is 13 % too fast.

    The 3 % are missed, with ten rows that yield by 6 % rms; with 15 they are just met, 2.98 % rms
    at 1.2 s.
    """
    found = film3d.run(film3d.bingham(0.5), rows=10, end=1.5)
    assert np.abs(found.error[:3]).max() < 0.03
    assert np.ptp(found.speed[-3:]) < 0.01 * found.surface


def test_a_film_below_yield_holds():
    assert film3d.displacement(1.3).max() < 0.1


def test_a_block_of_slurry_stops_in_the_shape_of_the_closed_form():
    found = deposit3d.run(0.01, end=2.0)
    assert found.crept < 0.001
    for step in (0.0, deposit3d.STEP):
        assert found.error(deposit3d.front_by_volume(step), step) < 0.10
        assert found.error(found.fitted_front(step), step) < 0.10


def test_still_water_presses_on_a_dam_by_its_depth():
    assert dams3d.backwater(end=1.0) == pytest.approx(1.0, abs=0.05)


def test_a_dam_takes_the_momentum_of_a_jet():
    """The force read from the particles is too great: 10 % at five rows of particles, 8 % here.

    No momentum along the floor is left in what leaves, so that the wall itself takes all of it.
    """
    assert dams3d.jet(rows=8, end=1.2) == pytest.approx(1.0, abs=0.10)


@pytest.fixture(scope="module")
def dams() -> dict[bool, dams3d.CheckDam]:
    return {slit: dams3d.check_dam(slit, COARSE) for slit in (False, True)}


@pytest.mark.parametrize("slit", [False, True])
def test_a_dam_loses_no_particle(dams, slit):
    found = dams[slit]
    assert found.through_wall == 0
    assert found.entered == found.trapped + found.passed
    assert found.passed == found.below + found.left


def test_a_slit_lets_more_through_and_sooner(dams):
    closed, slit = dams[False], dams[True]
    assert slit.passed > closed.passed
    assert slit.overtopped < closed.overtopped
    assert slit.most_trapped < closed.most_trapped
