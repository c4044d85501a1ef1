"""Negative controls of beds: what moves if one part of their mechanics is as it must not be."""

from __future__ import annotations

from debrisflow.validation.beds import endless_bed
from tests.slow.bed_controls import FrictionBeforeProjection


def test_a_bed_is_not_at_rest_where_friction_comes_before_the_projection():
    other = endless_bed.rest(15.0, 35.0, 0.02, scheme=FrictionBeforeProjection)
    assert other.mean > 0.1
    assert other.mean > 10.0 * endless_bed.rest(15.0, 35.0, 0.02).mean
