"""What must be so of dams and gates, though no experiment has measured how much."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.dam_breaks import check_dam, gate
from debrisflow.validation.dam_breaks.wet_bed import HIGH, LOW, stoker

SPACING = 0.01


def test_a_gate_drawn_ever_faster_comes_to_none():
    fronts = [gate.front_after(speed, SPACING) for speed in (1.0, 4.0, 64.0)]
    none = gate.front_after(None, SPACING)
    assert fronts[0] < fronts[1] < fronts[2] < none
    assert none - fronts[2] < 0.5 * SPACING


def test_a_slit_lets_more_through_and_sooner():
    closed, slit = (check_dam.run(has_slit, SPACING) for has_slit in (False, True))
    assert slit.passed > closed.passed
    assert slit.overtopped < closed.overtopped
    assert slit.held["volume"].max() < closed.held["volume"].max()


def test_the_bore_of_the_closed_form_keeps_mass_and_momentum():
    form = stoker(HIGH, LOW)
    assert form.depth * (form.bore - form.speed) == pytest.approx(LOW * form.bore)
    thrust = 0.5 * 9.81 * (form.depth**2 - LOW**2)
    assert LOW * form.bore * form.speed == pytest.approx(thrust)
    assert form.speed == pytest.approx(2.0 * (np.sqrt(9.81 * HIGH) - np.sqrt(9.81 * form.depth)))
