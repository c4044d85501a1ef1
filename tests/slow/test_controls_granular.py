"""Granular temperatures that are no closed form's: what they make of a uniform shear."""

from __future__ import annotations

import pytest

from debrisflow.validation.granular.plane_shear import plane_shear


def test_the_temperature_of_the_neighborhood_shrinks_with_the_spacing_squared():
    coarse, fine = (plane_shear(rows, temperature="neighborhood") for rows in (10, 20))
    assert fine.temperature_ratio / coarse.temperature_ratio == pytest.approx(0.25, rel=0.1)


def test_the_fluctuation_temperature_sees_no_shear():
    assert 0.0 < plane_shear(temperature="fluctuation").temperature_ratio < 0.01
