"""A pool behind a dam on a terrain: force of still water, and a ledger to the particle."""

from __future__ import annotations

import pytest

from debrisflow.validation.at_rest.backwater import run_backwater


@pytest.mark.parametrize(
    ("spacing", "turn"), [(1.0, 0.0), (1.0, 20.0), (0.5, 20.0)], ids=["1 m", "turned", "0.5 m"]
)
def test_still_water_behind_a_dam_pushes_as_it_must(tmp_path, spacing, turn):
    found = run_backwater(tmp_path, spacing, turn)
    assert found.force == pytest.approx(found.expected_force, rel=0.03)
    # it lies a little low: some of the thrust at the foot goes into the ground
    assert found.moment == pytest.approx(found.expected_moment, rel=0.05)
    assert abs(found.aside) < 0.03 * found.force
    assert found.speed < 0.1
    assert found.in_front == found.released
    assert found.passed == found.left == found.through == 0


def test_what_flows_over_a_dam_is_counted(tmp_path):
    found = run_backwater(tmp_path, 1.0, 20.0, crest=98.5)
    assert found.passed > 0
    assert found.left > 0
    assert found.through == 0
    assert found.in_front + found.passed + found.left == found.released
