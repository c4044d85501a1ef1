"""Slurries that yield, and dams, in three dimensions: against closed forms and budgets.

The coarse runs only; finer ones and their figures: scripts/validate.py film3d deposit3d dams.
"""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.dam_breaks import dams3d
from debrisflow.validation.viscous import deposit3d, film3d

COARSE = {"particles": {"spacing": 0.01}}


SLURRIES = {
    "Bingham, a quarter of the bed stress": film3d.bingham(0.25),
    "Bingham, half": film3d.bingham(0.5),
    "Herschel-Bulkley, a quarter": film3d.herschel_bulkley(0.25),
}


@pytest.mark.parametrize("slurry", SLURRIES.values(), ids=SLURRIES)
def test_a_film_of_slurry_has_the_profile_of_the_closed_form(slurry):
    found = film3d.run(slurry, rows=10)
    assert found.rms < 0.03
    assert np.abs(found.error).max() < 0.04
    assert np.ptp(found.speed[-3:]) < 0.01 * found.surface  # it moves as a plug


def test_a_film_below_yield_holds():
    assert film3d.displacement(1.3).max() < 0.1


def test_a_block_of_slurry_stops_in_the_shape_of_the_closed_form():
    # as a Bingham slurry it comes to rest ever more slowly: at 2 s it still creeps by 1.5 mm
    found = deposit3d.run(0.01, end=3.0)
    assert found.crept < 0.001
    for step in (0.0, deposit3d.STEP):
        assert found.error(deposit3d.front_by_volume(step), step) < 0.10
        assert found.error(found.fitted_front(step), step) < 0.10


def test_still_water_presses_on_a_dam_by_its_depth():
    assert dams3d.backwater(end=1.0) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("thickness", [1.0, 0.5])
def test_a_plate_wet_on_both_sides_takes_what_the_depths_differ_by(thickness):
    assert dams3d.wet_plate(thickness) == pytest.approx(1.0, abs=0.03)


def test_a_dam_takes_the_momentum_of_a_jet():
    """No momentum along the floor is left in what leaves, so that the wall takes all of it."""
    assert dams3d.jet(rows=8, end=1.2) == pytest.approx(1.0, abs=0.05)


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
